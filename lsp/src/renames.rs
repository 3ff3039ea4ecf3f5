//! Renames in documents and templates, over all pipelines of the workspace that they concern.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use lsp_types::{PrepareRenameResponse, RenameParams, TextDocumentPositionParams, WorkspaceEdit};

use crate::answers::{Asked, Changes, edit_of, text_edits};
use crate::position::is_whole;
use crate::templates::Template;
use crate::workspace::{Workspace, is_template, range};
use umbragraph_graph::compose::read_bytes;
use umbragraph_graph::edit::{Edit, Edits};
use umbragraph_graph::model::{Declaration, DeclarationKind};
use umbragraph_graph::source::{FileId, Span};
use umbragraph_session::{Session, Target};

/// The maximum size, in bytes, of a test of shader functions that is searched for a name.
const MAX_TEST_BYTES: u64 = 1 << 20;

/// Returns the place of a name of a template that is to be renamed: at the cursor in the template, or declared for the
/// key of a binding at the cursor. Also returns the place of the name at the cursor, for a key.
fn of_template(
    workspace: &mut Workspace,
    at: &TextDocumentPositionParams,
) -> Option<(FileId, usize, Option<Span>)> {
    match Template::at(workspace, at) {
        Some((Template::Wgsl(file), offset)) => return Some((file, offset, None)),
        Some((Template::Axes(_), _)) => return None,
        None => {}
    }
    let asked = Asked::of(workspace, at.clone())?;
    let (key, declared) = workspace.sure(|session| session.binding_at(&asked.cursor()))?;
    Some((declared.file, declared.start as usize, Some(key)))
}

/// Returns the range and text of the name at a position; an error says why it cannot be changed.
pub(crate) fn prepare(
    workspace: &mut Workspace,
    at: TextDocumentPositionParams,
) -> Result<Option<PrepareRenameResponse>, String> {
    let found = match of_template(workspace, &at) {
        Some((file, offset, key)) => {
            let found = workspace.session.template_renamable(file, offset).transpose();
            found.map_err(|error| error.to_string())?.map(|(place, name)| (key.unwrap_or(place), name))
        }
        None => Asked::of(workspace, at)
            .and_then(|asked| workspace.sure(|session| session.renamable(&asked.cursor()))),
    };
    Ok(found.and_then(|(place, placeholder)| {
        let range = range(workspace, place)?;
        Some(PrepareRenameResponse::RangeWithPlaceholder { range, placeholder })
    }))
}

pub(crate) fn rename(
    workspace: &mut Workspace,
    params: RenameParams,
) -> Result<Option<WorkspaceEdit>, String> {
    workspace.refresh();
    let at = params.text_document_position;
    let renamed = match of_template(workspace, &at) {
        Some((file, offset, _)) => in_templates(workspace, (file, offset), &params.new_name)?,
        None => in_documents(workspace, at, &params.new_name)?,
    };
    if renamed.is_empty() {
        return Ok(None);
    }
    let mut changes = Changes::default();
    for (name, edits) in renamed {
        let path = PathBuf::from(&name);
        if !is_whole(&path) {
            return Err(format!("\"{name}\" comes with the module and cannot be changed"));
        }
        let sources = workspace.session.sources();
        let Some(file) = sources.find(&name).and_then(|id| sources.get(id)) else { continue };
        changes.entry(path).or_default().extend(text_edits(workspace, file, edits.values()));
    }
    Ok(Some(edit_of(workspace, changes)))
}

/// The edits of a rename in several pipelines, without duplicates, by file name and byte range.
type Renamed = BTreeMap<String, BTreeMap<(usize, usize), Edit>>;

fn add(renamed: &mut Renamed, edits: BTreeMap<String, Edits>) {
    for (file, edits) in edits {
        let places = edits.iter().map(|edit| ((edit.range.start, edit.range.end), edit.clone()));
        renamed.entry(file).or_default().extend(places);
    }
}

fn in_templates(
    workspace: &mut Workspace,
    (file, offset): (FileId, usize),
    new: &str,
) -> Result<Renamed, String> {
    let named = workspace.session.template_renamable(file, offset);
    let targets = workspace.pipelines();
    let edits = workspace.sure(|session| session.template_rename(file, offset, new, &targets));
    let edits = edits.transpose().map_err(|error| error.to_string())?;
    let mut renamed = Renamed::new();
    add(&mut renamed, edits.unwrap_or_default());
    if let Some(Ok((_, old))) = named {
        let tests = tests_with(renamed.keys().map(Path::new), &old);
        warn(workspace, &old, &tests, "tests of shader functions are not renamed");
    }
    Ok(renamed)
}

fn in_documents(
    workspace: &mut Workspace,
    at: TextDocumentPositionParams,
    new: &str,
) -> Result<Renamed, String> {
    let mut next = Asked::of(workspace, at);
    let declared =
        next.as_ref().and_then(|asked| workspace.sure(|session| session.declared(&asked.cursor())));
    let (mut renamed, mut done, mut tried) = (Renamed::new(), BTreeSet::new(), BTreeSet::new());
    while let (Some(asked), Some(one)) = (next, &declared) {
        let edits = workspace.sure(|session: &mut Session| session.rename(&asked.cursor(), new));
        let edits = edits.transpose().map_err(|error| {
            let path = asked.target.path.display();
            if done.is_empty() { error.to_string() } else { format!("in the pipeline \"{path}\": {error}") }
        })?;
        add(&mut renamed, edits.unwrap_or_default());
        done.insert(asked.target);
        next = further(workspace, one, &renamed, (&done, &mut tried));
    }
    let section = |one: &Declaration| match one.kind {
        DeclarationKind::Parameter if one.owner.is_none() => Some("parameters"),
        DeclarationKind::Feature => Some("features"),
        DeclarationKind::Preset => Some("preset"),
        _ => None,
    };
    if let Some((one, section)) = declared.as_ref().and_then(|one| Some((one, section(one)?)))
        && !renamed.is_empty()
    {
        let files = workspace.parameter_files(section, &one.name);
        warn(workspace, &one.name, &files, "parameter files name no pipeline and are not renamed");
    }
    Ok(renamed)
}

/// Finds a pipeline that reads an edited file and is not in `done`. Returns the position of an edit at which that
/// pipeline has the same name, and at which to repeat the rename; `None` if no such pipeline is left. What another file
/// replaces there is in no pipeline, so an edit may lead nowhere; those that do are added to `tried`.
fn further(
    workspace: &mut Workspace,
    declared: &Declaration,
    renamed: &Renamed,
    (done, tried): (&BTreeSet<Target>, &mut BTreeSet<(Target, String, usize)>),
) -> Option<Asked> {
    for (name, edits) in renamed {
        let path = PathBuf::from(name);
        for target in workspace.readers_of(&path).into_iter().map(Target::new) {
            // An insertion names nothing.
            for (start, _) in edits.keys().filter(|(start, end)| start < end) {
                if done.contains(&target) || !tried.insert((target.clone(), name.clone(), *start)) {
                    continue;
                }
                let choice = workspace.choice(&target);
                let (path, target, offset) = (path.clone(), target.clone(), *start);
                let asked = Asked { path, offset, target, choice };
                let found = workspace.sure(|session| session.declared(&asked.cursor()));
                if found.is_some_and(|one| (one.kind, &one.name) == (declared.kind, &declared.name)) {
                    return Some(asked);
                }
            }
        }
    }
    None
}

/// Adds a message to the user about files that keep a name; none if there are no such files.
fn warn(workspace: &mut Workspace, old: &str, files: &[PathBuf], reason: &str) {
    if !files.is_empty() {
        let list: Vec<String> = files.iter().map(|path| format!("\"{}\"", path.display())).collect();
        workspace
            .warnings
            .push(format!("\"{old}\" stays in {}: {reason}. Change it by hand.", list.join(", ")));
    }
}

/// Returns the tests of shader functions beside templates in which a name is a word.
fn tests_with<'p>(templates: impl Iterator<Item = &'p Path>, name: &str) -> Vec<PathBuf> {
    let folders: BTreeSet<&Path> =
        templates.filter(|path| is_template(path)).filter_map(Path::parent).collect();
    let files = folders.into_iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    let mut found: Vec<PathBuf> = files.map(|file| file.path()).collect();
    found.retain(|path| {
        let is_test = path.to_str().is_some_and(|path| path.ends_with(".test.wgsl"));
        let text = || read_bytes(path, MAX_TEST_BYTES).ok().flatten().unwrap_or_default();
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        is_test && String::from_utf8_lossy(&text()).split(|c| !is_of_name(c)).any(|word| word == name)
    });
    found.sort();
    found
}
