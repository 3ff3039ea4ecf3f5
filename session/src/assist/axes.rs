//! Answers for editors in files of axes: keys and words of their schema, templates that can be inherited, descriptions.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value as Json;

use super::expected::key_text;
use super::rules::Rules;
use super::site::{Site, Spot};
use super::{Candidate, CandidateKind, Expected, Hover};
use crate::graph::document::Parsed;
use crate::graph::shader::axes_schema;
use crate::graph::source::{FileId, Span};
use crate::session::Session;

/// A file of axes, with the schema of its kind.
struct AxesFile {
    file: FileId,
    parsed: Arc<Parsed>,
    schema: Json,
}

impl Session {
    fn axes_at(&mut self, path: &Path) -> Option<AxesFile> {
        let (file, parsed) = self.parsed(path)?;
        Some(AxesFile { file, parsed, schema: axes_schema() })
    }

    /// Returns the completion candidates for a byte of a file of axes; `None` if the file cannot be read.
    pub fn axes_expected(&mut self, path: &Path, offset: usize) -> Option<Expected> {
        let AxesFile { file, parsed, schema } = self.axes_at(path)?;
        let set = self.templates();
        let text = self.sources().get(file)?.text();
        let site = Site::find(&parsed.document.root, text, offset);
        let rules = Rules::of(&schema).below(site.way.iter().map(String::as_str));
        let mut candidates = Vec::new();
        let mut add = |kind, label: &str, text, description: Option<&str>| {
            let (label, description) = (label.to_owned(), description.map(str::to_owned));
            candidates.push(Candidate { kind, label, text, detail: None, description });
        };
        match site.spot {
            Spot::Key { object, entry } => {
                let present = object.entries().unwrap_or_default().iter().map(|entry| entry.key.as_str());
                let own = entry.map(|entry| entry.key.as_str());
                let taken: BTreeSet<&str> = present.filter(|key| Some(*key) != own).collect();
                for (key, rules) in rules.keys().into_iter().filter(|(key, _)| !taken.contains(key)) {
                    let text = key_text(text, &site.replaced, key);
                    add(CandidateKind::Key, key, text, rules.description());
                }
            }
            Spot::Value(_) => {
                let quoted = |word: &str| Json::from(word).to_string();
                if matches!(site.way.first().map(String::as_str), Some("inherits")) {
                    let names = set.names().filter(|name| set.axes_file(name).is_some());
                    names.for_each(|name| add(CandidateKind::Template, name, quoted(name), None));
                }
                for (word, description) in rules.words() {
                    add(CandidateKind::Word, word, quoted(word), description);
                }
                if rules.takes("boolean") {
                    ["true", "false"].iter().for_each(|word| {
                        add(CandidateKind::Word, word, (*word).to_owned(), None);
                    });
                }
            }
        }
        Some(Expected { replaced: Span::new(file, site.replaced), candidates })
    }

    /// Returns the description of the key at a byte of a file of axes; `None` elsewhere.
    pub fn axes_hover(&mut self, path: &Path, offset: usize) -> Option<Hover> {
        let AxesFile { file, parsed, schema } = self.axes_at(path)?;
        let text = self.sources().get(file)?.text();
        let site = Site::find(&parsed.document.root, text, offset);
        let Spot::Key { entry: Some(entry), .. } = site.spot else { return None };
        let rules = Rules::of(&schema).below(site.way.iter().map(String::as_str)).below([entry.key.as_str()]);
        let text = rules.description()?.to_owned();
        Some(Hover { place: Span::new(file, site.replaced), text, is_preformatted: false })
    }
}
