//! The configuration of a pipeline that an editor shows: a lens at the top of documents and templates chooses it.
//!
//! Hover texts, inlay hints, generated WGSL and the diagnostics while an author types are those of one configuration:
//! the default one, until the client chooses another. A configuration is written as the contents of a parameter file
//! (`preset`, `features`, `parameters`). The lens carries the command [`CHOOSE`] of the client. The client asks the
//! server for a list by [`LIST`], lets the author pick one, and sends its configuration by [`CONFIGURE`].
//!
//! Limits: the list offers the presets, and each feature with another value; parameters are for clients that write a
//! configuration of their own. A choice lasts as long as the server.

use std::path::PathBuf;

use lsp_types::Uri;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json, json};

use crate::workspace::{Workspace, document_path};
use umbragraph_graph::diagnostic::{Diagnostic, Diagnostics, Severity};
use umbragraph_graph::document::{self, Document, parse};
use umbragraph_graph::expression::Value;
use umbragraph_graph::pipeline::{Overrides, ParameterFile, of_preset};
use umbragraph_session::Target;

/// The client's command that lets the author choose a configuration.
pub(crate) const CHOOSE: &str = "umbragraph.chooseConfiguration";
/// The server's command that lists configurations.
pub(crate) const LIST: &str = "umbragraph.configurations";
/// The server's command that chooses a configuration.
pub(crate) const CONFIGURE: &str = "umbragraph.configure";
/// The name of the text of a configuration, for diagnostics.
const NAME: &str = "chosen configuration";

/// The argument of the commands.
#[derive(Clone, Debug, Deserialize)]
struct Asked {
    /// The address of the pipeline.
    pipeline: Uri,
    /// The configuration to choose, for [`CONFIGURE`].
    #[serde(default)]
    configuration: Map<String, Json>,
}

/// A configuration in a list.
#[derive(Debug, Serialize)]
pub(crate) struct Listed {
    /// The preset or the changed feature, in a few words.
    label: String,
    /// The description of the preset or feature; empty if it has none.
    detail: String,
    /// The contents of a parameter file.
    configuration: Map<String, Json>,
}

/// A configuration in a few words, for the title of a lens.
pub(crate) fn title(configuration: Option<&Map<String, Json>>) -> String {
    let mut parts = Vec::new();
    for (key, value) in configuration.into_iter().flatten() {
        match (key.as_str(), value) {
            ("preset", Json::String(name)) => parts.insert(0, format!("preset {name}")),
            (_, Json::Object(values)) => {
                parts.extend(values.iter().map(|(name, value)| setting(name, value)));
            }
            _ => {}
        }
    }
    if parts.is_empty() { "defaults".to_owned() } else { parts.join(", ") }
}

fn setting(name: &str, value: &Json) -> String {
    match value {
        Json::Bool(true) => format!("{name} on"),
        Json::Bool(false) => format!("{name} off"),
        Json::String(word) => format!("{name} {word}"),
        other => format!("{name} {other}"),
    }
}

/// Returns `true` if a pipeline has presets or features to choose from.
pub(crate) fn has_choice(document: &Document) -> bool {
    ["presets", "features"].iter().any(|section| !document.root.entries_of(section).is_empty())
}

fn asked(command: &str, argument: Json) -> Result<(PathBuf, Map<String, Json>), String> {
    let asked: Asked =
        serde_json::from_value(argument).map_err(|error| format!("the argument of {command}: {error}"))?;
    let path = document_path(&asked.pipeline);
    let path = path.ok_or_else(|| format!("{} is not the address of a file", asked.pipeline.as_str()))?;
    Ok((path, asked.configuration))
}

/// Lists the default configuration, those of the presets, and the present one with another value of one feature.
pub(crate) fn list(workspace: &mut Workspace, argument: Json) -> Result<Vec<Listed>, String> {
    let (path, _) = asked(LIST, argument)?;
    let target = Target::new(&path);
    let loaded = workspace.sure(|session| session.load(&target));
    let missing = || format!("{} has no presets and no features at the moment", path.display());
    let document = loaded.document().filter(|document| has_choice(document)).ok_or_else(missing)?;
    let present = workspace.configurations.get(&path).cloned().unwrap_or_default();
    let described = |value: &document::Value| {
        value.get("description").and_then(|text| text.text()).unwrap_or_default().to_owned()
    };
    let group = |value: &document::Value| value.get("one_of").and_then(|name| name.text()).map(str::to_owned);
    let default = "the default of every parameter and feature".to_owned();
    let mut all = vec![Listed { label: "defaults".to_owned(), detail: default, configuration: Map::new() }];
    for preset in document.root.entries_of("presets") {
        let configuration = Map::from_iter([("preset".to_owned(), Json::from(preset.key.as_str()))]);
        let label = format!("preset {}", preset.key);
        all.push(Listed { label, detail: described(&preset.value), configuration });
    }
    let choice = workspace.choice(&target);
    let planned = workspace.sure(|session| session.plan(&target, &choice)).0.report.pipeline;
    for feature in document.root.entries_of("features") {
        let typed = planned.as_ref().and_then(|pipeline| pipeline.features.get(&feature.key));
        let values: Vec<Json> = match feature.value.elements_of("values") {
            [] => vec![Json::Bool(true), Json::Bool(false)],
            words => words.iter().filter_map(|word| Some(Json::from(word.text()?))).collect(),
        };
        let now = typed.map(|typed| match &typed.value {
            Value::Text(word) => Json::from(word.as_str()),
            _ => Json::Bool(typed.is_on()),
        });
        for value in values.into_iter().filter(|value| now.as_ref() != Some(value)) {
            let label = setting(&feature.key, &value);
            let mut configuration = present.clone();
            let features = configuration.entry("features").or_insert_with(|| json!({}));
            let Some(features) = features.as_object_mut() else { continue };
            if let Some(own) = group(&feature.value)
                && value == Json::Bool(true)
            {
                // One of a group is on: the others that were chosen go back to what they are by default.
                features.retain(|name, _| {
                    document
                        .root
                        .entries_of("features")
                        .iter()
                        .all(|other| other.key != *name || group(&other.value).as_ref() != Some(&own))
                });
            }
            features.insert(feature.key.clone(), value);
            all.push(Listed { label, detail: described(&feature.value), configuration });
        }
    }
    Ok(all)
}

/// Chooses the configuration of a pipeline; an empty one is the default. One that the pipeline cannot have is an error,
/// and the one before stays.
pub(crate) fn configure(workspace: &mut Workspace, argument: Json) -> Result<(), String> {
    let (path, configuration) = asked(CONFIGURE, argument)?;
    let before = workspace.configurations.remove(&path);
    if !configuration.is_empty() {
        workspace.configurations.insert(path.clone(), configuration);
    }
    let diagnostics = workspace.planned(&Target::new(&path));
    let is_wrong = |one: &&Diagnostic| one.severity == Severity::Error && workspace.is_of_configuration(one);
    let wrong = diagnostics.iter().filter(is_wrong);
    let messages: Vec<&str> = wrong.map(|one| one.message.as_str()).collect();
    if !messages.is_empty() {
        workspace.configurations.remove(&path);
        workspace.configurations.extend(before.map(|before| (path, before)));
        return Err(messages.join("; "));
    }
    workspace.reconfigured(&path);
    Ok(())
}

impl Workspace {
    /// Returns the values of the chosen configuration of a pipeline, and the diagnostics about its names and form.
    pub(crate) fn chosen(
        &mut self,
        target: &Target,
        document: Option<&Document>,
    ) -> (Overrides, Diagnostics) {
        let Some((configuration, document)) = self.configurations.get(&target.path).zip(document) else {
            return Default::default();
        };
        let text = format!("{:#}", Json::Object(configuration.clone()));
        let place = self.session.text(NAME, &text);
        let mut diagnostics = Diagnostics::new();
        match parse(self.session.sources(), place.file).valid() {
            Ok(written) => {
                let file = ParameterFile::read(&written, &mut diagnostics);
                let preset =
                    file.preset.map(|(name, place)| of_preset(document, &name, place, &mut diagnostics));
                (preset.unwrap_or_default().under(file.overrides), diagnostics)
            }
            Err(diagnostics) => (Overrides::default(), diagnostics),
        }
    }

    /// Returns `true` if a diagnostic is about the chosen configuration, and not about a file.
    pub(crate) fn is_of_configuration(&self, diagnostic: &Diagnostic) -> bool {
        let file = diagnostic.span().and_then(|span| self.session.sources().get(span.file));
        file.is_some_and(|file| file.name() == NAME)
    }
}
