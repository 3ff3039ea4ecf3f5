//! Meaning of the names and strings of a document, resolved once.
//!
//! A [`Model`] is made of a composed document. Every string is read once, by its sign ([`Text`]), so node kinds of any
//! author are understood without code of theirs; every name is resolved once, to the [`Declaration`] that it means
//! where it stands ([`Use`]). `why`, the warnings about names that nothing uses, the configurations of a pipeline and
//! editors ask it, and search no text.
//!
//! Names are seen as the language says: a pass of a subgraph sees the subgraph's parameters, inputs, derived values,
//! resources and passes, and after them those of the pipeline, unless the subgraph is a file of its own. A variable of
//! a loop stands before all of them. Published data has no declaration: the first pass that names it stands for one.
//!
//! A document that is broken has a model as far as it is understood; what does not resolve is no use of anything.
//!
//! Limits: groups of shared settings are read where passes take them over, as settings of those.

mod content;
mod declare;
mod resolve;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

pub use content::Content;

use crate::document::{Document, Value};
use crate::expression::{Expression, ExpressionKind};
use crate::source::{FileId, Span};

/// The identifier of a declaration, valid within one [`Model`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(usize);

/// The kind of a [`Declaration`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DeclarationKind {
    /// A parameter, of the pipeline or of a subgraph.
    Parameter,
    /// A feature: a boolean or an enumeration that chooses shader variants and passes.
    Feature,
    /// A derived value, which an expression computes from parameters, features and other derived values.
    Derived,
    /// A constraint: a condition that parameters, features and derived values have to meet.
    Constraint,
    /// A texture or buffer.
    Resource,
    /// Data that a pass publishes; the first use of its name counts as the declaration.
    Data,
    /// A pass.
    Pass,
    /// A subgraph: a reusable group of passes.
    Subgraph,
    /// An input of a subgraph: a resource that each use of the subgraph provides.
    Input,
    /// The variable of a loop (`for_each`) of a pass.
    Variable,
    /// A runtime toggle, which the host application can switch in each frame.
    Toggle,
    /// A contract for draws: the vertex inputs and bindings that the host application provides.
    Geometry,
    /// A preset: a named set of values of parameters and features.
    Preset,
    /// An extension point, at which extension files insert passes.
    ExtensionPoint,
    /// A group of settings that passes share.
    SharedSettings,
}

/// A named item that a document declares, such as a pass or a parameter.
#[derive(Clone, Debug)]
pub struct Declaration {
    /// The kind of the declared item.
    pub kind: DeclarationKind,
    /// The name as it is declared.
    pub name: String,
    /// The span of the name where it is declared.
    pub place: Span,
    /// The subgraph that contains the declaration, or for a loop variable its pass. `None` at the top level.
    pub owner: Option<Id>,
    /// The JSON pointer of the declared value; for published data, of the declaration that names the data first.
    pub pointer: String,
}

/// A string value of a document.
#[derive(Clone, Debug)]
pub struct Text {
    /// The span of the string, quotes included.
    pub place: Span,
    /// The declaration that contains the string.
    pub within: Id,
    /// The keys and array indices that lead from the value of the declaration to the string.
    pub keys: Vec<String>,
    /// The string, unescaped.
    pub text: String,
    /// The parsed meaning of the string.
    pub content: Content,
    /// The uses in the string, as a range of indices into the uses of the model.
    uses: Range<usize>,
}

impl Text {
    /// Returns `true` if one of the keys that lead from the declaration to the string is `key`.
    pub fn is_under(&self, key: &str) -> bool {
        self.keys.iter().any(|one| one == key)
    }
}

/// A place in a document where a declared name is used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Use {
    /// The span of the name where it is used.
    pub place: Span,
    /// The declaration that the name refers to.
    pub declaration: Id,
    /// The declaration that contains the use.
    pub within: Id,
}

/// An index of a document: its declarations, its strings, and the resolved uses of names.
#[derive(Clone, Debug, Default)]
pub struct Model {
    declarations: Vec<Declaration>,
    texts: Vec<Text>,
    uses: Vec<Use>,
    /// The node kind of each pass that names one.
    kinds: BTreeMap<Id, String>,
    /// The strings in each declaration, as a range of indices into `texts`.
    read: BTreeMap<Id, Range<usize>>,
    /// The uses that refer to each declaration, as indices into `uses`.
    used: BTreeMap<Id, Vec<usize>>,
    /// The uses inside each declaration, as indices into `uses`.
    using: BTreeMap<Id, Vec<usize>>,
}

/// The maximum number of nodes of an expression that [`Model::closed`] expands.
const MAX_PARTS: usize = 2048;

impl Model {
    /// Builds the model of a composed document.
    pub fn new(document: &Document) -> Self {
        let mut model = Self::default();
        let scopes = declare::declare(&mut model, &document.root);
        resolve::resolve(&mut model, scopes, &document.root);
        for (at, text) in model.texts.iter().enumerate() {
            model.read.entry(text.within).or_insert(at..at).end = at + 1;
        }
        for (at, one) in model.uses.iter().enumerate() {
            model.used.entry(one.declaration).or_default().push(at);
            model.using.entry(one.within).or_default().push(at);
        }
        model
    }

    /// Iterates over all declarations with their identifiers.
    pub fn declarations(&self) -> impl Iterator<Item = (Id, &Declaration)> {
        self.declarations.iter().enumerate().map(|(at, one)| (Id(at), one))
    }

    /// The declaration with this identifier.
    pub fn declaration(&self, id: Id) -> &Declaration {
        &self.declarations[id.0]
    }

    /// The declaration of this kind and name at the top level of the document; `None` if there is none.
    pub fn find(&self, kind: DeclarationKind, name: &str) -> Option<Id> {
        let is_it = |one: &Declaration| one.kind == kind && one.owner.is_none() && one.name == name;
        self.declarations.iter().position(is_it).map(Id)
    }

    /// The strings in which names were resolved; descriptions, for example, are left out.
    pub fn texts(&self) -> &[Text] {
        &self.texts
    }

    /// The strings in a declaration; for a subgraph, the strings in all of its declarations.
    pub fn texts_in(&self, id: Id) -> impl Iterator<Item = &Text> {
        let parts = self.parts_of(id).filter_map(|id| self.read.get(&id).cloned());
        parts.flat_map(|range| &self.texts[range])
    }

    /// The declaration itself and, for a subgraph, the declarations in it.
    pub fn parts_of(&self, id: Id) -> impl Iterator<Item = Id> {
        let is_subgraph = self.declaration(id).kind == DeclarationKind::Subgraph;
        let parts = self.declarations().filter(move |(_, one)| is_subgraph && one.owner == Some(id));
        std::iter::once(id).chain(parts.map(|(id, _)| id))
    }

    /// The uses that refer to a declaration.
    pub fn uses_of(&self, id: Id) -> impl Iterator<Item = &Use> {
        self.used.get(&id).into_iter().flatten().map(|at| &self.uses[*at])
    }

    /// The uses inside a declaration; for a subgraph, without the uses inside its own declarations.
    pub fn uses_in(&self, id: Id) -> impl Iterator<Item = &Use> {
        self.using.get(&id).into_iter().flatten().map(|at| &self.uses[*at])
    }

    /// The declaration whose name is at a byte offset of a file, where it is declared or used. `None` if no name is
    /// there.
    pub fn declaration_at(&self, file: FileId, offset: u32) -> Option<Id> {
        let is_there = |place: Span| place.file == file && (place.start..=place.end).contains(&offset);
        let used = self.uses.iter().filter(|one| is_there(one.place));
        let used = used.min_by_key(|one| one.place.end - one.place.start).map(|one| one.declaration);
        used.or_else(|| self.declarations().find(|(_, one)| is_there(one.place)).map(|(id, _)| id))
    }

    /// The node kind of a pass; `None` if the pass names none.
    pub fn node_kind(&self, pass: Id) -> Option<&str> {
        self.kinds.get(&pass).map(String::as_str)
    }

    /// Returns the pipeline's parameters and features among the given declarations, and those on which the given
    /// derived values depend.
    pub fn settings_behind(&self, named: impl IntoIterator<Item = Id>) -> BTreeSet<Id> {
        use DeclarationKind as K;
        let (mut found, mut seen) = (BTreeSet::new(), BTreeSet::new());
        let mut open: Vec<Id> = named.into_iter().collect();
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            let one = &self.declarations[id.0];
            match one.kind {
                K::Parameter | K::Feature if one.owner.is_none() => drop(found.insert(id)),
                K::Derived => open.extend(self.uses_in(id).map(|one| one.declaration)),
                _ => {}
            }
        }
        found
    }

    /// The declarations that the names in a string refer to.
    pub fn named_in(&self, text: &Text) -> impl Iterator<Item = Id> {
        self.uses[text.uses.clone()].iter().map(|one| one.declaration)
    }

    /// Returns the expression of a string with derived values replaced by their expressions. Names other than the
    /// pipeline's parameters and features get the prefix `^`. `None` if the string is no expression, cannot be
    /// expanded, or expands to too large an expression.
    pub fn closed(&self, text: &Text) -> Option<Expression> {
        let mut parts = 0;
        self.close(text.content.expression()?, text, &mut parts, 0)
    }

    fn close(
        &self,
        expression: &Expression,
        text: &Text,
        parts: &mut usize,
        depth: usize,
    ) -> Option<Expression> {
        *parts += 1;
        if *parts > MAX_PARTS || depth > 64 {
            return None;
        }
        let mut one = |inner: &Expression| self.close(inner, text, parts, depth + 1);
        let kind = match &expression.kind {
            ExpressionKind::Name(name) => return self.close_name(name, expression, text, parts, depth),
            ExpressionKind::Literal(_) | ExpressionKind::Reference(_) => expression.kind.clone(),
            ExpressionKind::Unary(operator, a) => ExpressionKind::Unary(*operator, one(a)?.into()),
            ExpressionKind::Binary(operator, a, b) => {
                ExpressionKind::Binary(*operator, one(a)?.into(), one(b)?.into())
            }
            ExpressionKind::Conditional(a, b, c) => {
                ExpressionKind::Conditional(one(a)?.into(), one(b)?.into(), one(c)?.into())
            }
            ExpressionKind::Index(a, b) => ExpressionKind::Index(one(a)?.into(), one(b)?.into()),
            ExpressionKind::Call(name, list) => {
                ExpressionKind::Call(name.clone(), list.iter().map(one).collect::<Option<_>>()?)
            }
            ExpressionKind::List(list) => ExpressionKind::List(list.iter().map(one).collect::<Option<_>>()?),
        };
        Some(Expression { range: expression.range.clone(), kind })
    }

    fn close_name(
        &self,
        name: &str,
        expression: &Expression,
        text: &Text,
        parts: &mut usize,
        depth: usize,
    ) -> Option<Expression> {
        use DeclarationKind as K;
        let head = name.split_once('.').map_or(name, |(head, _)| head);
        let named = self.named_in(text).find(|id| self.declarations[id.0].name == head);
        let kind = named.map(|id| (id, self.declarations[id.0].kind, self.declarations[id.0].owner));
        match kind {
            Some((_, K::Parameter | K::Feature, None)) => Some(expression.clone()),
            Some((id, K::Derived, _)) => {
                // A derived value that is a list of strings has several.
                let own: Vec<&Text> = self.texts_in(id).collect();
                match own.as_slice() {
                    [own] if own.keys.is_empty() => {
                        self.close(own.content.expression()?, own, parts, depth + 1)
                    }
                    _ => None,
                }
            }
            _ => {
                let kind = ExpressionKind::Name(format!("^{name}"));
                Some(Expression { range: expression.range.clone(), kind })
            }
        }
    }
}

/// The entries of the section `name` of a pipeline or subgraph; empty if the section is missing.
fn section<'v>(owner: &'v Value, name: &str) -> &'v [crate::document::Entry] {
    owner.entries_of(name)
}
