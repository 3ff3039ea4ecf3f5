//! The texts of all templates of a session, kept for as long as they stay.

pub(crate) mod scan;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use self::scan::{Scan, Text};
use crate::graph::shader::TemplateSet;
use crate::graph::source::{FileId, Sources, Span};

/// The templates of a session with their tags and declarations.
#[derive(Debug)]
pub(crate) struct Texts {
    pub(crate) set: Arc<TemplateSet>,
    all: BTreeMap<String, (FileId, Arc<Text>)>,
    by_file: BTreeMap<FileId, String>,
    /// The templates that each template names, and those that name it.
    uses: Steps,
    used_by: Steps,
}

type Steps = BTreeMap<String, BTreeSet<String>>;

impl Texts {
    /// Reads the texts of a set. What `before` knows of texts that stay is taken over.
    pub(crate) fn new(set: Arc<TemplateSet>, sources: &Sources, before: Option<&Self>) -> Self {
        let mut all = BTreeMap::new();
        for name in set.names() {
            let Some((file, source)) = set.file(name).and_then(|file| Some((file, sources.get(file)?)))
            else {
                continue;
            };
            let known = before.and_then(|before| before.all.get(name));
            let known = known.filter(|(_, known)| Arc::ptr_eq(&known.text, source.text()));
            let new = || Arc::new(Text::new(source.text().clone()));
            all.insert(name.to_owned(), (file, known.map_or_else(new, |(_, text)| text.clone())));
        }
        let (mut uses, mut used_by) = (Steps::new(), Steps::new());
        for (name, (_, one)) in &all {
            for (used, _) in one.tags.templates(&one.text).filter(|(used, _)| all.contains_key(*used)) {
                uses.entry(name.clone()).or_default().insert(used.to_owned());
                used_by.entry(used.to_owned()).or_default().insert(name.clone());
            }
        }
        let by_file = all.iter().map(|(name, (file, _))| (*file, name.clone())).collect();
        Self { set, all, by_file, uses, used_by }
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.all.keys().map(String::as_str)
    }

    pub(crate) fn name(&self, file: FileId) -> Option<&str> {
        self.by_file.get(&file).map(String::as_str)
    }

    pub(crate) fn scan(&self, name: &str) -> Option<(FileId, Scan<'_>)> {
        self.all.get(name).map(|(file, text)| (*file, text.scan()))
    }

    /// The templates that a template is part of, itself among them, and all whose texts meet in one module with it.
    /// Near ones come first: what it includes, then what meets with it elsewhere.
    pub(crate) fn met<'a>(&'a self, own: &'a str) -> (BTreeSet<&'a str>, Vec<&'a str>) {
        let roots: BTreeSet<&str> = reached([own], &self.used_by).into_iter().collect();
        let mut names = reached([own], &self.uses);
        let mut known: BTreeSet<&str> = names.iter().copied().collect();
        let others = reached(roots.iter().copied(), &self.uses);
        names.extend(others.into_iter().filter(|name| known.insert(name)));
        (roots, names)
    }

    /// A template and all that it includes.
    pub(crate) fn included<'a>(&'a self, own: &'a str) -> Vec<&'a str> {
        reached([own], &self.uses)
    }

    /// The places at which tags name a template.
    pub(crate) fn naming(&self, name: &str) -> Vec<Span> {
        let mut places = Vec::new();
        for (file, one) in self.all.values() {
            let named = one.tags.templates(&one.text).filter(|(known, _)| *known == name);
            places.extend(named.map(|(_, range)| Span::new(*file, range)));
        }
        places
    }
}

/// All names that are reached, those of few steps first.
fn reached<'a>(from: impl IntoIterator<Item = &'a str>, steps: &'a Steps) -> Vec<&'a str> {
    let mut all: Vec<&str> = from.into_iter().collect();
    let mut known: BTreeSet<&str> = all.iter().copied().collect();
    let mut at = 0;
    while let Some(name) = all.get(at).copied() {
        all.extend(
            steps.get(name).into_iter().flatten().map(String::as_str).filter(|next| known.insert(next)),
        );
        at += 1;
    }
    all
}
