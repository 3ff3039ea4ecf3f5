//! The parameter file that is written: the values of the command line, overridden by the values found.

use std::fmt::Write as _;

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::source::Sources;

use super::table::{Found, value};
use crate::arguments::TuneArguments;
use crate::session::Session;
use crate::shadow_term;
use umbragraph::low_level::camera_path::CameraArgument;

/// Returns the text of the parameter file.
///
/// # Errors
/// Never expected for the values of a checked pipeline.
pub(super) fn text(
    found: &Found,
    arguments: &TuneArguments,
    session: &mut Session,
    document: &Document,
) -> Result<String, Diagnostics> {
    let mut settings = arguments.choices.settings.clone();
    // A preset that the command line names stays one; among files its values are written out.
    let preset = if settings.params.is_empty() { settings.preset.take() } else { None };
    let given = session.overrides(&settings, document);
    let mut parameters: Vec<(String, String)> = Vec::new();
    let mut put = |name: &str, value: String| match parameters.iter_mut().find(|(known, _)| known == name) {
        Some((_, known)) => *known = value,
        None => parameters.push((name.to_owned(), value)),
    };
    for setting in given.parameters.iter().filter(|setting| setting.name != shadow_term::PARAMETER) {
        put(&setting.name, setting.value.to_json().to_string());
    }
    for name in &found.names {
        put(name, value(&found.after, name));
    }
    let mut features: Vec<(String, String)> = Vec::new();
    for setting in &given.features {
        features.retain(|(known, _)| *known != setting.name);
        features.push((setting.name.clone(), setting.value.to_json().to_string()));
    }
    let mut text = comment(found, arguments);
    let json = |text: &str| serde_json::Value::from(text).to_string();
    text.push_str("{\n\"format\": 1");
    if let Some(preset) = preset {
        let _ = write!(text, ",\n\"preset\": {}", json(&preset));
    }
    for (section, values) in [("parameters", &parameters), ("features", &features)] {
        if !values.is_empty() {
            let values: Vec<String> =
                values.iter().map(|(name, value)| format!("{}: {value}", json(name))).collect();
            let _ = write!(text, ",\n\"{section}\": {{\n{}\n}}", values.join(",\n"));
        }
    }
    text.push_str("\n}\n");
    let mut sources = Sources::new();
    let file = sources.add("parameters", text.as_str());
    Ok(document::format::format(&sources, file)?.apply(&text).unwrap_or(text))
}

/// Returns the comment of the parameter file: the scenes used for tuning, and the scores before and after.
fn comment(found: &Found, arguments: &TuneArguments) -> String {
    let name = |path: &std::path::Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [width, height] = arguments.choices.size;
    let over: Vec<&str> = arguments.over.iter().map(|over| over.name.as_str()).collect();
    let shots = match (&arguments.shots.film.camera, arguments.shots.frames) {
        (None, 1) => String::new(),
        (None, frames) => format!(", {frames} frames"),
        (Some(camera), frames) => {
            let camera = match camera {
                CameraArgument::Orbit => "orbit".to_owned(),
                CameraArgument::Walk => "walk".to_owned(),
                CameraArgument::Random(seed) => format!("random:{seed}"),
                CameraArgument::File(path) => name(path),
            };
            format!(", {frames} frames of the camera {camera}")
        }
    };
    let [before, after] = [&found.before, &found.after].map(|tried| found.score(tried.outcome.loss));
    let lines = [
        format!("{}, tuned by `umbragraph tune` over {}", name(&arguments.pipeline), over.join(", ")),
        format!(
            "on {} at {width} by {height}{shots}; {} sets of values, seed {}, on {}.",
            found.scenes.join(", "),
            found.trials,
            arguments.seed,
            found.adapter
        ),
        format!("{} {before:.4} before, {after:.4} after.", found.score_name()),
    ];
    // What a file is called must not end the comment.
    lines.iter().fold(String::new(), |text, line| text + "// " + &line.replace(char::is_control, " ") + "\n")
}
