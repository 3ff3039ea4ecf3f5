//! The values of the window, saved: as a parameter file, or as defaults in the pipeline's own document.
//!
//! Nothing that somebody else wrote is lost. A file in use is edited, so that comments and other values stay; a file
//! that only has the name which a new one would get is left alone. Toggles have defaults in documents only.

use std::path::{Path, PathBuf};

use serde_json::Value;
use umbragraph::Plan;
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::edit;
use umbragraph::low_level::files::{replace, replace_if};
use umbragraph::low_level::source::Sources;

use crate::files;
use crate::values::{Values, to_json};

/// A parameter file that the window has written, and the text that it wrote.
pub(crate) type Written = (PathBuf, String);

/// Writes the values as a new parameter file, at `path` or, if another file is there, at the next free name beside it.
/// `own` is the file that the window wrote before, which is replaced unless somebody else has changed it. Returns the
/// file and a notice for the user.
///
/// # Errors
/// An error message if the file cannot be written, or only toggles were changed.
pub(crate) fn new_parameter_file(
    values: &Values,
    [folder, name]: [&Path; 2],
    own: Option<&Written>,
) -> Result<(Written, String), String> {
    let unsaved = unsaved(values)?;
    let text = values.file();
    let mut sources = Sources::new();
    let file = sources.add("parameters", text.as_str());
    let edits = document::format::format(&sources, file).ok();
    let text = edits.and_then(|edits| edits.apply(&text).ok()).unwrap_or(text);
    let wanted = folder.join(name);
    let is_own = |path: &Path| {
        own.is_some_and(|(known, text)| {
            known == path && files::read(path).is_ok_and(|present| present == *text)
        })
    };
    let mut said = String::new();
    let path = match own.filter(|(known, _)| is_own(known)) {
        Some((known, _)) => known.clone(),
        None if wanted.exists() => {
            said = format!(", since {} is another file", wanted.display());
            let base = name.to_string_lossy();
            files::free(folder, base.trim_end_matches(".params.json"), "params.json")
        }
        None => wanted,
    };
    replace(&path, &text).map_err(|found| found.message)?;
    let said = format!("saved {}{said}{unsaved}", path.display());
    Ok(((path, text), said))
}

/// Writes the values into a parameter file that is in use. Its comments and its other values stay. Returns a notice for
/// the user.
///
/// # Errors
/// An error message if the file cannot be read or written, is no JSON, or only toggles were changed.
pub(crate) fn into_parameter_file(values: &Values, path: &Path) -> Result<String, String> {
    let unsaved = unsaved(values)?;
    let text = files::read(path)?;
    let root = parsed(&text, "the parameter file")?.root;
    let mut saved = root.to_json();
    let members = saved.as_object_mut().ok_or("the parameter file is no object; mend it first")?;
    if let Some(preset) = &values.preset {
        members.insert("preset".to_owned(), preset.as_str().into());
    }
    for (section, values) in [("parameters", &values.parameters), ("features", &values.features)] {
        if values.is_empty() {
            continue;
        }
        let section = members.entry(section).or_insert_with(|| Value::Object(Default::default()));
        let section =
            section.as_object_mut().ok_or("a section of the parameter file is no object; mend it first")?;
        section.extend(values.iter().map(|(name, value)| (name.clone(), value.clone())));
    }
    let edits = edit::set(&text, &root, &saved).map_err(|error| error.to_string())?;
    let saved = edits.apply(&text).map_err(|error| error.to_string())?;
    replace_if(path, &text, &saved).map_err(|found| found.message)?;
    Ok(format!("saved into {}{unsaved}", path.display()))
}

/// The part of a notice that names the changed toggles, for which a parameter file has no place; empty if there are
/// none.
///
/// # Errors
/// An error message if nothing but toggles was changed.
fn unsaved(values: &Values) -> Result<String, String> {
    let names: Vec<&str> = values.toggles.keys().map(String::as_str).collect();
    if names.is_empty() {
        return Ok(String::new());
    }
    let names = names.join(", ");
    if values.preset.is_none() && values.parameters.is_empty() && values.features.is_empty() {
        return Err(format!(
            "nothing saved: a parameter file has no toggles ({names}); \"Save into document\" keeps them"
        ));
    }
    Ok(format!(
        "; not the toggles ({names}), for which a parameter file has no place: \"Save into document\" keeps them"
    ))
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

/// The parameters, features and toggles to be saved as defaults.
type Sections = [(&'static str, Vec<(String, Value)>); 3];

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
    let toggles = values.toggles.iter().map(|(name, on)| (name.clone(), Value::Bool(*on))).collect();
    [section("parameters", &values.parameters), section("features", &values.features), ("toggles", toggles)]
}

/// Returns the text of a document with its defaults replaced.
fn with_defaults(text: &str, sections: &Sections) -> Result<String, String> {
    let mut text = text.to_owned();
    for (section, values) in sections {
        let document = parsed(&text, "the pipeline")?;
        let values = values.iter().map(|(name, value)| (name.as_str(), value.clone()));
        let edits = edit::save(&text, &document.root, section, values).map_err(|error| error.to_string())?;
        text = edits.apply(&text).map_err(|error| error.to_string())?;
    }
    Ok(text)
}

/// Parses the text of a file; `what` names the file in the error message.
fn parsed(text: &str, what: &str) -> Result<Document, String> {
    let mut sources = Sources::new();
    let file = sources.add(what, text);
    document::parse(&sources, file)
        .valid()
        .map_err(|_| format!("{what} is no JSON at the moment; mend it first"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn saved_defaults_keep_comments_and_layout() {
        let text = "{\n  // about it\n  \"parameters\": {\n    \"far\": { \"type\": \"f32\", \"default\": 3 } // metres\n  }\n}\n";
        let sections: Sections = [
            ("parameters", vec![("far".to_owned(), json!(4.5))]),
            ("features", Vec::new()),
            ("toggles", Vec::new()),
        ];
        let saved = text.replace("\"default\": 3", "\"default\": 4.5");
        assert_eq!(with_defaults(text, &sections).unwrap(), saved);
        assert!(with_defaults("{", &sections).is_err());
        let toggles = "{\n  \"toggles\": { \"veil\": { \"default\": false } } // one\n}\n";
        let sections: Sections = [
            ("parameters", Vec::new()),
            ("features", Vec::new()),
            ("toggles", vec![("veil".to_owned(), json!(true))]),
        ];
        assert_eq!(with_defaults(toggles, &sections).unwrap(), toggles.replace("false", "true"));
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("umbragraph-view-save-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn values() -> Values {
        let mut values = Values::default();
        values.parameters.insert("far".to_owned(), json!(4.5));
        values
    }

    #[test]
    fn a_parameter_file_in_use_keeps_the_rest_of_it() {
        let folder = folder("in-use");
        let path = folder.join("in-use.json");
        let text =
            "{\n  // mine\n  \"format\": 1,\n  \"parameters\": { \"far\": 3, \"near\": 1 } // metres\n}\n";
        std::fs::write(&path, text).unwrap();
        let mut values = values();
        values.features.insert("fxaa".to_owned(), json!(true));
        into_parameter_file(&values, &path).unwrap();
        let saved = std::fs::read_to_string(&path).unwrap();
        assert!(saved.starts_with("{\n  // mine\n") && saved.contains("// metres"), "{saved}");
        assert!(
            saved.contains("{ \"far\": 4.5, \"near\": 1 }") && saved.contains("\"fxaa\": true"),
            "{saved}"
        );
        std::fs::write(&path, "{").unwrap();
        assert!(into_parameter_file(&values, &path).unwrap_err().contains("no JSON"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "{");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_foreign_parameter_file_is_not_overwritten() {
        let folder = folder("foreign");
        let name = Path::new("own.params.json");
        std::fs::write(folder.join(name), "{}").unwrap();
        let (written, said) = new_parameter_file(&values(), [&folder, name], None).unwrap();
        assert_eq!(std::fs::read_to_string(folder.join(name)).unwrap(), "{}");
        assert!(
            said.contains("own-001.params.json") && said.contains("own.params.json is another file"),
            "{said}"
        );
        // The window's own file is written again, until somebody else changes it.
        let mut other = values();
        other.parameters.insert("far".to_owned(), json!(5));
        let (again, _) = new_parameter_file(&other, [&folder, name], Some(&written)).unwrap();
        assert_eq!(again.0, written.0);
        std::fs::write(&again.0, "{ }").unwrap();
        let (third, _) = new_parameter_file(&other, [&folder, name], Some(&again)).unwrap();
        assert!(third.0.ends_with("own-002.params.json"), "{third:?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn toggles_that_a_parameter_file_lacks_are_named() {
        let mut values = Values::default();
        values.toggles.insert("veil".to_owned(), true);
        assert!(unsaved(&values).unwrap_err().contains("veil"));
        values.preset = Some("high".to_owned());
        assert!(unsaved(&values).unwrap().contains("veil"));
    }
}
