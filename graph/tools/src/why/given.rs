//! Sources of the value of a parameter or feature, the lowest first.

use serde::Serialize;

use super::origin::{self, Location, as_json, json, location};
use super::subject::{Kind, Subject};
use umbragraph_pipeline::compose::Layer;
use umbragraph_pipeline::document::{Entry, Value, pointer_join};
use umbragraph_pipeline::pipeline::{self, Lacking, Override};
use umbragraph_pipeline::shader::TargetProfile;

/// One value given to a parameter, feature, derived value or input, with its source.
#[derive(Clone, Debug, Serialize)]
pub struct Given {
    /// The source of the value: `default`, `profile NAME`, `preset NAME`, `parameter file`, `--set`, `--feature`,
    /// `with of PASS` or `its expression`. A profile switches off a feature whose requirements the target does not
    /// meet; `with` belongs to a use of a subgraph.
    pub by: String,
    /// The value as JSON text.
    #[serde(serialize_with = "as_json")]
    pub value: String,
    /// The place of the value in a file.
    pub at: Location,
    /// The role of the file in the composed document; `None` for a parameter file or a command-line option.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<Layer>,
}

/// Returns the sources of the value of a parameter or feature, in increasing precedence.
pub(super) fn given(subject: &Subject<'_>, kind: Kind, entry: &Entry, pointer: &str) -> Vec<Given> {
    let (section, settings, option) = match kind {
        Kind::Feature => ("features", &subject.overrides.features, "--feature"),
        _ => ("parameters", &subject.overrides.parameters, "--set"),
    };
    let mut list = Vec::new();
    if let Some(value) = entry.value.get("default") {
        of_document(subject, "default", value, &format!("{pointer}/default"), &mut list);
    }
    if let Some((profile, lacking)) = lacking_in(subject, kind, entry)
        && let Ok(declaration) = entry.value.decode()
    {
        list.push(Given {
            by: format!("profile {}", profile.name),
            value: json(&pipeline::off(&declaration, lacking.place)),
            at: location(subject.sources, lacking.place),
            layer: Some(origin::layer(subject, lacking.place)),
        });
    }
    for setting in settings.iter().filter(|setting| setting.name == entry.key) {
        let preset = preset_of(subject, section, setting);
        if let Some(preset) = preset {
            let at = pointer_join(&format!("{}/{section}", pointer_join("/presets", &preset)), &entry.key);
            of_document(subject, &format!("preset {preset}"), &setting.value, &at, &mut list);
            continue;
        }
        let at = location(subject.sources, setting.place);
        let by = if at.file.starts_with('<') { option } else { "parameter file" };
        list.push(Given {
            by: by.to_owned(),
            value: json(&setting.value),
            at: location(subject.sources, setting.value.span),
            layer: None,
        });
    }
    list
}

/// Returns the target profile and the requirement of a feature that it does not meet. `None` if the profile meets all,
/// or for a parameter.
pub(super) fn lacking_in<'a>(
    subject: &Subject<'a>,
    kind: Kind,
    entry: &Entry,
) -> Option<(&'a TargetProfile, Lacking)> {
    let profile = &subject.checked.pipeline.as_deref()?.profile;
    let features = subject.composed.document.root.get("features").and_then(Value::entries)?;
    let lacking = (kind == Kind::Feature).then(|| pipeline::lacking(entry, features, profile)).flatten()?;
    Some((profile, lacking))
}

/// Adds a value of the document to `list`, after the earlier values that it replaced.
pub(super) fn of_document(
    subject: &Subject<'_>,
    by: &str,
    value: &Value,
    pointer: &str,
    list: &mut Vec<Given>,
) {
    for older in origin::older(subject, pointer).into_iter().rev() {
        list.push(Given { by: by.to_owned(), value: older.value, at: older.at, layer: Some(older.layer) });
    }
    list.push(Given {
        by: by.to_owned(),
        value: json(value),
        at: location(subject.sources, value.span),
        layer: Some(origin::layer(subject, value.span)),
    });
}

/// The name of the preset that contains a setting; `None` if no preset contains it.
fn preset_of(subject: &Subject<'_>, section: &str, setting: &Override) -> Option<String> {
    let presets = subject.composed.document.root.entries_of("presets");
    let stands_in = |preset: &&Entry| {
        let values = preset.value.entries_of(section);
        values.iter().any(|entry| entry.key_span == setting.place)
    };
    presets.iter().find(stands_in).map(|preset| preset.key.clone())
}
