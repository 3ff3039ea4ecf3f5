//! One diagnostic for one cause: what only follows from others is left out, and several with one cause become one.

use std::collections::BTreeMap;
use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, codes, list_of};
use umbragraph::low_level::shader::codes::TEMPLATE_UNKNOWN;
use umbragraph::low_level::source::Span;

use crate::codes::BUDGET;

/// The maximum number of places of one cause that are shown.
const MAX_PLACES: usize = 8;
/// The maximum number of entries of a folder that are looked through for a template.
const MAX_ENTRIES: usize = 1000;

/// Leaves out diagnostics that only follow from others. `is_cut` says whether a diagnostic is of a file of a pipeline of
/// which a part is not read.
pub(super) fn first(all: Diagnostics, is_cut: &dyn Fn(&Diagnostic) -> bool) -> Diagnostics {
    let is_error = |one: &Diagnostic| one.severity == Severity::Error;
    let errors: Vec<&Diagnostic> = all.iter().filter(|one| is_error(one)).collect();
    let is_of_shader = |one: &&Diagnostic| one.code.id.starts_with("UG05");
    let has_shader_error = errors.iter().any(is_of_shader);
    let has_no_folder =
        errors.iter().any(|one| one.code == codes::FILE_UNREADABLE && one.message.starts_with("the folder"));
    let has = |id: &str| all.iter().any(|one| one.code.id == id);
    let has_no_light = has("UG0624");
    let follows = |one: &Diagnostic| match one.code.id {
        // The part with the error may use the setting.
        _ if one.code == codes::UNUSED_SETTING => is_cut(one),
        // The templates are missing because their folder is.
        _ if one.code == TEMPLATE_UNKNOWN => has_no_folder,
        // A device says of an invalid shader what the check of shaders said.
        "UG0803" | "UG0804" => has_shader_error && pass_of(one).is_some(),
        // What a pass with an error reads is unknown.
        _ if one.code == codes::NEVER_WRITTEN && is_error(one) => {
            let others = errors.iter().filter(|other| other.code != codes::NEVER_WRITTEN);
            pass_of(one).is_some_and(|pass| others.into_iter().any(|other| pass_of(other) == Some(pass)))
        }
        "UG0811" => has_no_light,
        _ => false,
    };
    all.iter().filter(|one| !follows(one)).cloned().collect()
}

/// Moves a diagnostic about a missing name to the `null` that deletes what has the name.
pub(super) fn of_deleted(one: Diagnostic, deleted: &BTreeMap<String, Span>) -> Diagnostic {
    let name = one.message.strip_prefix("there is no ").and_then(|rest| rest.split('"').nth(1));
    let is_it = |pointer: &str| pointer.matches('/').count() == 2 && pointer.rsplit('/').next() == name;
    let Some((name, (pointer, null))) = name.zip(deleted.iter().find(|(pointer, _)| is_it(pointer))) else {
        return one;
    };
    let message = format!("\"{name}\" is deleted here, but it is used");
    let mut moved = Diagnostic::error(one.code, *null, message).pointer(pointer.as_str());
    moved.related = one.related.clone();
    moved.related(one.place.clone(), "used here").help(format!("remove \"{name}\": null"))
}

/// The JSON pointer of the pass that a diagnostic is about; `None` if it is about none.
fn pass_of(diagnostic: &Diagnostic) -> Option<&str> {
    let pointer = diagnostic.pointer.as_str();
    let start = pointer.find("/passes/")? + "/passes/".len();
    let end = pointer[start..].find('/').map_or(pointer.len(), |end| start + end);
    Some(&pointer[..end])
}

/// Joins errors with one cause: the first keeps the places of the others as related places. `beside` finds the folder of a
/// template beside a pipeline, for a command without a folder of templates (`has_no_folder`).
pub(super) fn joined(
    all: Diagnostics,
    has_no_folder: bool,
    beside: &dyn Fn(&str, &Diagnostic) -> Option<String>,
) -> Diagnostics {
    let mut kept: Vec<Diagnostic> = Vec::new();
    let mut templates: Vec<String> = Vec::new();
    for mut one in all {
        let name = one.message.split('"').nth(1).unwrap_or_default().to_owned();
        let folder = beside(&name, &one).filter(|_| has_no_folder && one.code == TEMPLATE_UNKNOWN);
        if let Some(folder) = folder {
            templates.push(name);
            let lie = if templates.len() == 1 { "lies" } else { "lie" };
            one.help = Some(format!(
                "{} {lie} in \"{folder}\": give it with --templates {folder}",
                list_of(&templates)
            ));
            one.fix = None;
        }
        match kept.iter_mut().find(|first| is_of_cause(first, &one)) {
            Some(first) => {
                let places = first.related.iter().filter(|related| related.place != Place::Nowhere).count();
                if places < MAX_PLACES {
                    let at = first.related.iter().position(|related| related.place == Place::Nowhere);
                    let at = at.unwrap_or(first.related.len());
                    let label = umbragraph::diagnostic::Related { place: one.place, message: one.message };
                    first.related.insert(at, label);
                }
                if first.code == TEMPLATE_UNKNOWN {
                    first.help = one.help;
                }
            }
            None => kept.push(one),
        }
    }
    kept.into_iter().collect()
}

/// Returns `true` if two errors have one cause: one way out for one declaration, one missing name, templates in one folder,
/// or data that fits none of those that read it.
fn is_of_cause(first: &Diagnostic, other: &Diagnostic) -> bool {
    let is_plain = |one: &Diagnostic| one.severity == Severity::Error && one.fix.is_none();
    // Each budget has a figure of its own.
    if !is_plain(first) || !is_plain(other) || first.code == BUDGET {
        return false;
    }
    let cause = |one: &Diagnostic| {
        one.related.first().map(|related| (related.place.clone(), related.message.clone()))
    };
    let has_cause = cause(first).is_some() && cause(first) == cause(other);
    let is_published = cause(first).is_some_and(|(_, label)| label.ends_with("is published here"));
    let is_named = [codes::UNKNOWN_RESOURCE, codes::EXPRESSION_NAME].contains(&first.code);
    let is_folder =
        |one: &Diagnostic| one.help.as_ref().is_some_and(|help| help.contains("give it with --templates"));
    if first.code != other.code {
        return has_cause && is_published;
    }
    let is_same = first.help == other.help && (has_cause || is_named && first.message == other.message);
    is_same || first.code == TEMPLATE_UNKNOWN && is_folder(first) && is_folder(other)
}

/// The folder of a template in the folder of a pipeline, or in one of its folders, as a path; `None` if there is none.
pub(super) fn folder_with(pipeline: &Path, template: &str) -> Option<String> {
    let folder = pipeline.parent()?;
    let here = if folder == Path::new("") { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(here).ok()?.take(MAX_ENTRIES).flatten();
    let mut folders: Vec<_> = entries.map(|entry| folder.join(entry.file_name())).collect();
    folders.sort();
    let found = [here.to_owned()].into_iter().chain(folders).find(|one| one.join(template).is_file())?;
    Some(found.display().to_string())
}
