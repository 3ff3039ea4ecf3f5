//! The values of the window, saved: as a parameter file, or as defaults in the pipeline's own document.

use std::path::Path;

use serde_json::Value;
use umbragraph::Plan;
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::edit;
use umbragraph::low_level::files::{replace, replace_if};
use umbragraph::low_level::source::Sources;

use crate::files;
use crate::values::{Values, to_json};

/// Writes the values as a parameter file. Returns a notice for the user.
///
/// # Errors
/// An error message if the file cannot be written.
pub(crate) fn parameter_file(values: &Values, path: &Path) -> Result<String, String> {
    let text = values.file();
    let mut sources = Sources::new();
    let file = sources.add("parameters", text.as_str());
    let edits = document::format::format(&sources, file).ok();
    let text = edits.and_then(|edits| edits.apply(&text).ok()).unwrap_or(text);
    replace(path, text).map_err(|found| found.message)?;
    Ok(format!("saved {}", path.display()))
}

/// Writes the values into a pipeline file as defaults; comments and layout are kept. Returns a notice for the user.
///
/// # Errors
/// An error message if the pipeline is bundled, broken, or has changed since it was read.
pub(crate) fn into_document(
    values: &Values,
    path: &Path,
    composed: &Document,
    plan: &Plan,
) -> Result<String, String> {
    if crate::arguments::is_bundled(path) {
        return Err("the pipeline comes with the module: save a parameter file instead".to_owned());
    }
    let text = files::read(path)?;
    let saved = with_defaults(&text, &all(values, composed, plan))?;
    if saved == text {
        return Ok("nothing to save: the defaults are these values".to_owned());
    }
    replace_if(path, &text, &saved).map_err(|found| found.message)?;
    Ok(format!("saved into {}", path.display()))
}

/// The parameters and the features to be saved as defaults.
type Sections = [(&'static str, Vec<(String, Value)>); 2];

/// The values to save: values changed in the window, and for all others the values of the selected preset.
fn all(values: &Values, composed: &Document, plan: &Plan) -> Sections {
    let presets = composed.root.entries_of("presets");
    let preset = presets.iter().find(|entry| Some(&entry.key) == values.preset.as_ref());
    let section = |section: &'static str, given: &std::collections::BTreeMap<String, Value>| {
        let mut saved = given.clone();
        let entries = preset.map(|preset| preset.value.entries_of(section)).unwrap_or_default();
        for entry in entries {
            let value = match section {
                "parameters" => plan.pipeline.parameters.get(&entry.key).map(|one| &one.value),
                _ => plan.pipeline.features.get(&entry.key).map(|one| &one.value),
            };
            if let Some(value) = value {
                saved.entry(entry.key.clone()).or_insert_with(|| to_json(value));
            }
        }
        (section, saved.into_iter().collect())
    };
    [section("parameters", &values.parameters), section("features", &values.features)]
}

/// Returns the text of a document with its defaults replaced.
fn with_defaults(text: &str, sections: &Sections) -> Result<String, String> {
    let mut text = text.to_owned();
    for (section, values) in sections {
        let mut sources = Sources::new();
        let file = sources.add("pipeline", text.as_str());
        let document = document::parse(&sources, file).valid();
        let document =
            document.map_err(|_| "the pipeline is no JSON at the moment; mend it first".to_owned())?;
        let values = values.iter().map(|(name, value)| (name.as_str(), value.clone()));
        let edits = edit::save(&text, &document.root, section, values).map_err(|error| error.to_string())?;
        text = edits.apply(&text).map_err(|error| error.to_string())?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn saved_defaults_keep_comments_and_layout() {
        let text = "{\n  // about it\n  \"parameters\": {\n    \"far\": { \"type\": \"f32\", \"default\": 3 } // metres\n  }\n}\n";
        let sections: Sections =
            [("parameters", vec![("far".to_owned(), json!(4.5))]), ("features", Vec::new())];
        let saved = text.replace("\"default\": 3", "\"default\": 4.5");
        assert_eq!(with_defaults(text, &sections).unwrap(), saved);
        assert!(with_defaults("{", &sections).is_err());
    }
}
