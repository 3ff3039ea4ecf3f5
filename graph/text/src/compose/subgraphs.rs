//! Subgraphs in files of their own.
//!
//! `"use": "parts/blur.json"` names a file that is one subgraph, where `"use": "blur"` names one of the document's
//! `subgraphs`. What names a file ends with `.json` or has a folder in it. Once a document is composed, each file that
//! its passes use is read, once however often it is used, and becomes a member of `subgraphs` under its path; that is
//! what `use` says from there on. Files can use further files, by paths relative to their own folder.
//!
//! A file that uses itself, through others too, is found where it is used. What a subgraph is, the schema says, which
//! knows neither `extends` nor `include` here.

use std::collections::{BTreeSet, VecDeque};
use std::path::Path;

use super::{Composer, Files, Layer, MAX_FILES, TOP, merge, path_in};
use crate::diagnostic::{Diagnostic, codes};
use crate::document::{Entry, Kind, Value};
use crate::source::Span;

/// Returns `true` if the value of a pass's `use` key is the path of a subgraph file, and not a name under `subgraphs`.
pub fn is_path(used: &str) -> bool {
    used.ends_with(".json") || used.ends_with(".jsonc") || used.contains(['/', '\\'])
}

/// Rewrites the paths of subgraph files in a file's passes. They are written relative to the folder of the file, and
/// become relative to the same folder as `path`, the path of the file.
pub(super) fn resolve(files: &dyn Files, root: &mut Value, path: &Path) {
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    let resolve_passes = |passes: &mut Value| resolve_passes(files, passes, folder);
    for section in members_mut(root) {
        match section.key.as_str() {
            "passes" | "shared_settings" => resolve_passes(&mut section.value),
            "subgraphs" => {
                let subgraphs = members_mut(&mut section.value).iter_mut();
                subgraphs.for_each(|subgraph| resolve(files, &mut subgraph.value, path));
            }
            "inserts" => {
                let points = members_mut(&mut section.value).iter_mut();
                points.for_each(|point| resolve_passes(&mut point.value));
            }
            _ => {}
        }
    }
}

fn resolve_passes(files: &dyn Files, passes: &mut Value, folder: &Path) {
    let keys = members_mut(passes).iter_mut().flat_map(|pass| members_mut(&mut pass.value));
    for used in keys.filter(|entry| entry.key == "use") {
        if let Kind::Text(text) = &mut used.value.kind
            && is_path(text)
        {
            *text = path_in(files, folder, text).to_string_lossy().replace('\\', "/");
        }
    }
}

fn members_mut(value: &mut Value) -> &mut [Entry] {
    match &mut value.kind {
        Kind::Object(entries) => entries,
        _ => &mut [],
    }
}

/// The subgraph files that passes, or groups of shared settings, name under `use`, each with the span of its path.
fn files_of(passes: &[Entry]) -> impl Iterator<Item = (String, Span)> + '_ {
    passes.iter().filter_map(|pass| {
        let used = pass.value.get("use")?;
        Some((used.text().filter(|text| is_path(text))?.to_owned(), used.span))
    })
}

/// The subgraph files that a pipeline or subgraph uses directly.
fn own_files(owner: &Value) -> impl Iterator<Item = (String, Span)> + '_ {
    ["passes", "shared_settings"].into_iter().flat_map(|section| files_of(owner.entries_of(section)))
}

/// All subgraph files that a document uses: in its passes, subgraphs, shared settings and inserts.
fn used_files(root: &Value) -> VecDeque<(String, Span)> {
    let subgraphs = root.entries_of("subgraphs").iter().flat_map(|subgraph| own_files(&subgraph.value));
    let inserts = root.entries_of("inserts").iter().filter_map(|point| point.value.entries());
    own_files(root).chain(subgraphs).chain(inserts.flat_map(files_of)).collect()
}

impl Composer<'_> {
    /// Reads the subgraph files that passes use, and adds them to the document's `subgraphs`. Returns the paths of the
    /// files, or `None` if a file could not be read.
    pub(super) fn use_files(&mut self, root: &mut Value) -> Option<BTreeSet<String>> {
        let mut fine = true;
        let mut known = BTreeSet::new();
        let mut read: Vec<Entry> = Vec::new();
        let mut waiting = used_files(root);
        while let Some((name, place)) = waiting.pop_front() {
            if !known.insert(name.clone()) {
                continue;
            }
            // Files that are not there count, too, so that looking for them comes to an end.
            if known.len() > MAX_FILES {
                self.too_many_files(place);
                fine = false;
                break;
            }
            match self.used_file(&name, place) {
                Some(subgraph) => {
                    waiting.extend(own_files(&subgraph));
                    read.push(Entry { key: name, key_span: place, value: subgraph });
                }
                None => fine = false,
            }
        }
        if let (Kind::Object(sections), Some(first)) = (&mut root.kind, read.first())
            && !sections.iter().any(|section| section.key == "subgraphs")
        {
            let value = Value { span: first.value.span, kind: Kind::Object(Vec::new()) };
            sections.push(Entry { key: "subgraphs".to_owned(), key_span: first.key_span, value });
        }
        if let Some(members) = root.entries_of_mut("subgraphs") {
            members.append(&mut read);
        }
        (fine || self.is_lenient).then_some(known)
    }

    fn used_file(&mut self, name: &str, place: Span) -> Option<Value> {
        let path = Path::new(name);
        if self.paths.contains(path) {
            let message = format!("\"{name}\" is a file of the pipeline itself");
            let diagnostic = Diagnostic::error(codes::FILE_CYCLE, place, message);
            self.diagnostics
                .push(diagnostic.help("a subgraph is a file of its own, with \"inputs\" and \"passes\""));
            return None;
        }
        if self.seen.len() >= MAX_FILES {
            self.too_many_files(place);
            return None;
        }
        let file = self.read(path, place)?;
        self.layers.insert(file, Layer::Used);
        self.seen.push(file);
        let mut root = self.parse(file)?;
        if self.is_lenient && root.entries().is_none() {
            return None;
        }
        let what = match (root.get("passes"), root.get("inserts"), root.get("parameters")) {
            (None, Some(_), _) => Some("an extension: `--extension FILE` puts it into a pipeline"),
            (None, None, Some(_)) => Some("a parameter file: `--params FILE` gives its values"),
            _ => None,
        };
        if let Some(what) = what {
            let message = format!("\"{name}\" is no subgraph, but {what}");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SUBGRAPH, place, message);
            self.diagnostics.push(diagnostic.help("a subgraph is a file with \"inputs\" and \"passes\""));
            return None;
        }
        let all = TOP.key("subgraphs");
        merge::reject_deletions(&mut root, &all.key(name), &self.changes, self.diagnostics);
        resolve(self.files, &mut root, path);
        Some(root)
    }
}
