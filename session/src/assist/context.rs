//! The context of a cursor: document of its file, composed document, model, plan, schema.

use std::sync::Arc;

use serde_json::Value as Json;

use super::rules::Rules;
use super::site::{Site, Spot};
use crate::choice::Choice;
use crate::files::FileTable;
use crate::graph::compose::{Composed, Layer};
use crate::graph::document::{Document, Value, pointer_join};
use crate::graph::language::node_kind;
use crate::graph::model::{Declaration, DeclarationKind, Id, Model};
use crate::graph::pipeline::FileKind;
use crate::graph::shader::{AxisValues, ShaderModule};
use crate::graph::source::{FileId, Sources, Span};
use crate::loaded::{Loaded, Planned};

/// The data for answers about a cursor: the loaded pipeline, the JSON schema and the file of the cursor.
pub(super) struct Context<'a> {
    pub(super) loaded: &'a Loaded,
    pub(super) choice: &'a Choice,
    pub(super) composed: &'a Composed,
    pub(super) model: &'a Model,
    pub(super) sources: &'a Sources,
    pub(super) files: &'a FileTable,
    pub(super) schema: &'a Arc<Json>,
    pub(super) kind: FileKind,
    pub(super) file: FileId,
    pub(super) text: &'a str,
    /// The parsed document of the cursor's file, not composed with other files.
    pub(super) document: &'a Document,
    pub(super) offset: usize,
}

/// The location of a cursor in the pipeline or in one of its subgraphs.
pub(super) struct Position<'s> {
    /// The subgraph that contains the cursor; `None` in the pipeline itself.
    pub(super) owner: Option<Id>,
    /// The keys from the pipeline or subgraph to the cursor. Passes of extensions are under `passes`.
    pub(super) way: Vec<&'s str>,
}

/// A pass of the composed document.
pub(super) struct PassAt<'a> {
    pub(super) id: Id,
    pub(super) pointer: &'a str,
    pub(super) value: &'a Value,
}

impl<'a> Context<'a> {
    /// Returns the plan of the pipeline. It is made when it is first asked for: much can be said without one.
    pub(super) fn planned(&self) -> Planned {
        self.loaded.plan(self.choice)
    }

    pub(super) fn site(&self) -> Site<'a> {
        Site::find(&self.document.root, self.text, self.offset)
    }

    /// Returns the schema rules for the value at the cursor; for a key, those of the object that contains it.
    pub(super) fn rules(&self, site: &Site<'_>) -> Rules<'a> {
        Rules::of(self.schema).below(site.way.iter().map(String::as_str))
    }

    pub(super) fn span(&self, range: std::ops::Range<usize>) -> Span {
        Span::new(self.file, range)
    }

    pub(super) fn position<'s>(&self, site: &'s Site<'_>) -> Position<'s> {
        let way: Vec<&str> = site.way.iter().map(String::as_str).collect();
        let subgraph = |name: &str| self.model.find(DeclarationKind::Subgraph, name);
        match (self.composed.layers.get(&self.file), way.as_slice()) {
            (Some(Layer::Used), _) => {
                let name = self.sources.get(self.file).map_or("", |file| file.name());
                Position { owner: subgraph(name), way }
            }
            (_, ["subgraphs", name, rest @ ..]) => Position { owner: subgraph(name), way: rest.to_vec() },
            (_, ["inserts", _, rest @ ..]) if self.kind == FileKind::Extension => {
                Position { owner: None, way: [&["passes"], rest].concat() }
            }
            _ => Position { owner: None, way },
        }
    }

    /// Returns the declarations of the given kinds that can be named at the cursor: first those of its file, then those
    /// of other files, each sorted by name.
    pub(super) fn visible(
        &self,
        position: &Position<'_>,
        kinds: &[DeclarationKind],
    ) -> Vec<(Id, &'a Declaration)> {
        let sees_pipeline = position
            .owner
            .is_none_or(|owner| !crate::graph::compose::is_path(&self.model.declaration(owner).name));
        let pass = self.pass(position).map(|pass| pass.id);
        let is_seen = |one: &Declaration| {
            let is_near = one.owner == position.owner || one.owner.is_none() && sees_pipeline;
            kinds.contains(&one.kind)
                && if one.kind == DeclarationKind::Variable { one.owner == pass } else { is_near }
        };
        let mut found: Vec<_> = self.model.declarations().filter(|(_, one)| is_seen(one)).collect();
        found.sort_by(|(_, a), (_, b)| a.name.cmp(&b.name));
        found.dedup_by(|(_, a), (_, b)| a.name == b.name);
        found.sort_by_key(|(_, one)| one.place.file != self.file);
        found
    }

    /// Returns the value of a declaration in the composed document; `None` if it has none there.
    pub(super) fn value_of(&self, declaration: &Declaration) -> Option<&'a Value> {
        self.at(&declaration.pointer)
    }

    fn at(&self, pointer: &str) -> Option<&'a Value> {
        let unescaped = |key: &str| key.replace("~1", "/").replace("~0", "~");
        pointer
            .split('/')
            .skip(1)
            .try_fold(&self.composed.document.root, |value, key| value.get(&unescaped(key)))
    }

    /// Returns the pass that contains the cursor; in shared settings, the first pass that uses them.
    pub(super) fn pass(&self, position: &Position<'_>) -> Option<PassAt<'a>> {
        let find = |kind: DeclarationKind, name: &str| {
            let is_it =
                |one: &Declaration| one.kind == kind && one.owner == position.owner && one.name == name;
            self.model.declarations().find(|(_, one)| is_it(one)).map(|(id, _)| id)
        };
        let id = match position.way.as_slice() {
            ["passes", name, ..] => find(DeclarationKind::Pass, name)?,
            ["shared_settings", name, ..] => {
                let group = find(DeclarationKind::SharedSettings, name)?;
                self.model.uses_of(group).next()?.within
            }
            _ => return None,
        };
        let pointer = self.model.declaration(id).pointer.as_str();
        Some(PassAt { id, pointer, value: self.at(pointer)? })
    }

    /// Returns the name of the shader template of a pass; `None` if it has none.
    pub(super) fn template(&self, pass: &PassAt<'a>) -> Option<&'a str> {
        node_kind(pass.value)?.value.get("shader")?.text()
    }

    /// Returns the shader modules of a planned pass. For other passes, returns the module of the template with default
    /// axis values.
    pub(super) fn modules(&self, pass: &PassAt<'a>) -> Vec<Arc<ShaderModule>> {
        let pipeline = self.planned().report.pipeline;
        let of_pipeline = pipeline.as_deref().and_then(|pipeline| {
            let found = pipeline.passes.iter().find(|one| one.pointer == pass.pointer)?;
            let program = pipeline.program(found.work().program()?);
            Some(program.variants.iter().map(|variant| variant.module.clone()).collect())
        });
        of_pipeline.unwrap_or_else(|| {
            let shaders = self.loaded.kept_templates().shaders(&self.choice.profile);
            let module = self.template(pass).map(|name| shaders.module(name, AxisValues::new()));
            module.and_then(Result::ok).into_iter().collect()
        })
    }

    /// Returns the JSON pointer of the key or value at the cursor, and the schema rules for it.
    pub(super) fn named(&self, site: &Site<'a>) -> (String, Rules<'a>) {
        match site.spot {
            Spot::Key { entry: Some(entry), .. } => {
                (pointer_join(&site.pointer(), &entry.key), self.rules(site).below([entry.key.as_str()]))
            }
            _ => (site.pointer(), self.rules(site)),
        }
    }
}
