//! Names of templates in pipelines: keys under `bind`, and words under `entry_points`.
//!
//! A pass names a binding if its template includes a text that has the name, in any variant.

use std::collections::BTreeSet;

use super::rename::{InJson, Places, is_free, places};
use super::{Texts, Unit};
use crate::assist::rename::{RenameError, Renamed};
use crate::cancel::Cancelled;
use crate::choice::Target;
use crate::graph::compose::Layer;
use crate::graph::document::{Value, parse, pointer_join};
use crate::graph::edit::rename;
use crate::graph::language::node_kind;
use crate::graph::model::DeclarationKind;
use crate::graph::source::{FileId, Sources, Span};
use crate::loaded::Loaded;
use crate::session::Session;

/// The names of stages under `entry_points`.
const STAGES: [&str; 3] = ["vertex", "fragment", "compute"];

/// The places of a name in the files of a pipeline.
#[derive(Default)]
struct Found {
    spans: BTreeSet<Span>,
    /// A reason not to rename.
    obstacle: Option<String>,
}

fn at<'v>(root: &'v Value, pointer: &str) -> Option<&'v Value> {
    let unescaped = |key: &str| key.replace("~1", "/").replace("~0", "~");
    pointer.split('/').skip(1).try_fold(root, |value, key| value.get(&unescaped(key)))
}

impl Found {
    /// The places in a pipeline of a name of its templates. `new` is looked for as a key that is there already.
    fn of(loaded: &Loaded, sources: &Sources, texts: &Texts, named: &Places<'_>, new: Option<&str>) -> Self {
        let mut found = Self::default();
        let Some((composed, model)) = loaded.understood().zip(loaded.model()) else { return found };
        let old = named.old;
        let root = &composed.document.root;
        let (mut others, mut pointers) = (BTreeSet::new(), Vec::new());
        for (_, one) in model.declarations() {
            let Some(value) = at(root, &one.pointer) else { continue };
            if one.kind == DeclarationKind::Geometry && named.in_json == InJson::Binding {
                let groups = ["material", "object"].iter().filter_map(|key| value.get(key));
                if groups.into_iter().any(|group| group.get(old).is_some()) {
                    found.obstacle = Some(format!("the geometry \"{}\" has a binding \"{old}\"", one.name));
                }
            }
            let Some(kind) = node_kind(value).filter(|_| one.kind == DeclarationKind::Pass) else { continue };
            let Some(template) = kind.value.get("shader").and_then(Value::text) else { continue };
            let is_seen = texts.included(template).iter().any(|name| named.holders.contains(name));
            match named.in_json {
                InJson::Nowhere => {}
                InJson::EntryPoint => {
                    let stages = kind.value.get("entry_points");
                    let words = STAGES.iter().filter_map(|stage| stages?.get(stage));
                    for word in words.filter(|word| is_seen && word.text() == Some(old)) {
                        found.push(word.span, old);
                    }
                }
                InJson::Binding => {
                    let Some(bind) = kind.value.get("bind") else { continue };
                    let taken = new.filter(|new| is_seen && bind.get(new).is_some());
                    if let Some(new) = taken {
                        found.obstacle = Some(format!("the pass \"{}\" binds \"{new}\" already", one.name));
                    }
                    match bind.entry(old) {
                        Some(entry) if is_seen => {
                            found.push(entry.key_span, old);
                            pointers.push(pointer_join(&one.pointer, &kind.key) + "/bind");
                        }
                        Some(entry) => drop(others.insert(entry.key_span)),
                        None => {}
                    }
                }
            }
        }
        // The same keys in files that others lie over.
        for file in composed.files.iter().filter(|_| !pointers.is_empty()) {
            let prefix = match composed.layers.get(file) {
                Some(Layer::Used) => {
                    pointer_join("/subgraphs", sources.get(*file).map_or("", |file| file.name()))
                }
                _ => String::new(),
            };
            let document = parse(sources, *file).document;
            for pointer in pointers.iter().filter_map(|pointer| pointer.strip_prefix(prefix.as_str())) {
                if let Some(entry) = at(&document.root, pointer).and_then(|bind| bind.entry(old)) {
                    found.push(entry.key_span, old);
                }
            }
        }
        let is_shared =
            |span: &Span| span.of_quoted(old, 0..old.len()).is_some_and(|span| found.spans.contains(&span));
        if others.iter().any(is_shared) {
            found.obstacle =
                Some(format!("passes with other templates share the key \"{old}\" under \"bind\""));
        }
        found
    }

    fn push(&mut self, place: Span, text: &str) {
        match place.of_quoted(text, 0..text.len()) {
            Some(span) => drop(self.spans.insert(span)),
            None => self.obstacle = Some(format!("a file writes \"{text}\" with escapes")),
        }
    }
}

impl Session {
    /// Returns the place and the text of the name at a byte of a template; `None` if no declared name is there. The
    /// inner result is an error if the name cannot be changed.
    pub fn template_renamable(
        &mut self,
        file: FileId,
        offset: usize,
    ) -> Option<Result<(Span, String), RenameError>> {
        self.in_template(file, |unit| {
            let (_, range) = unit.spot(offset)?;
            let found = places(unit, offset)?;
            let named = |found: Places<'_>| (Span::new(file, range), found.old.to_owned());
            Some(found.map(named).map_err(RenameError::Refused))
        })
    }

    /// Returns the edits that rename the name at a byte of a template, in all templates whose texts meet with it. The
    /// name of a binding or of an entry point is renamed in the pipelines `targets`, too. Returns `None` if no declared
    /// name is there.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set). The inner result is an error if the new name is
    /// invalid or taken, or if it is not certain where the old name stands.
    pub fn template_rename(
        &mut self,
        file: FileId,
        offset: usize,
        name: &str,
        targets: &[Target],
    ) -> Result<Option<Renamed>, Cancelled> {
        let texts = self.template_texts();
        let Some(unit) = Unit::new(&texts, file) else { return Ok(None) };
        let named = match places(&unit, offset) {
            None => return Ok(None),
            Some(Err(reason)) => return Ok(Some(Err(RenameError::Refused(reason)))),
            Some(Ok(named)) => named,
        };
        if let Err(reason) = is_free(&unit, &named, offset, name) {
            return Ok(Some(Err(RenameError::Refused(reason))));
        }
        let own = self.own_templates();
        if let Some(place) = named.spans.iter().find(|place| !own.contains(&place.file)) {
            let template = texts.name(place.file).unwrap_or_default();
            let reason = format!("\"{template}\" comes with the module and cannot be changed");
            return Ok(Some(Err(RenameError::Refused(reason))));
        }
        let mut spans = named.spans.clone();
        match self.named_in(targets, &texts, &named, Some(name))? {
            Ok(found) => spans.extend(found),
            Err(reason) => return Ok(Some(Err(RenameError::Refused(reason)))),
        }
        Ok(Some(rename(self.sources(), spans, name).map_err(RenameError::Edit)))
    }

    /// Returns the keys under `bind` of the pipelines `targets` that bind the binding at a byte of a template. For an
    /// entry point, these are the words under `entry_points`. Empty elsewhere.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn template_bound(
        &mut self,
        file: FileId,
        offset: usize,
        targets: &[Target],
    ) -> Result<Vec<Span>, Cancelled> {
        let texts = self.template_texts();
        let named = Unit::new(&texts, file).and_then(|unit| places(&unit, offset)?.ok());
        match named {
            Some(named) => Ok(self.named_in(targets, &texts, &named, None)?.unwrap_or_default()),
            None => Ok(Vec::new()),
        }
    }

    fn named_in(
        &mut self,
        targets: &[Target],
        texts: &Texts,
        named: &Places<'_>,
        new: Option<&str>,
    ) -> Result<Result<Vec<Span>, String>, Cancelled> {
        let mut spans = BTreeSet::new();
        for target in targets.iter().filter(|_| named.in_json != InJson::Nowhere) {
            let loaded = self.load_exactly(target)?;
            let found = Found::of(&loaded, self.files.settled(), texts, named, new);
            if let Some(obstacle) = found.obstacle.filter(|_| new.is_some()) {
                return Ok(Err(format!("in the pipeline \"{}\", {obstacle}", target.path.display())));
            }
            spans.extend(found.spans);
        }
        Ok(Ok(spans.into_iter().collect()))
    }
}
