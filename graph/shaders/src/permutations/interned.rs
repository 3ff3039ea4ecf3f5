//! Declarations by their texts, each taken apart once for all texts that hold it; names by numbers.

use std::collections::HashMap;
use std::sync::Arc;

use crate::written::complexity;
use crate::written::declarations::{Common, Declaration, Kind, Split};

/// The index of a declaration, a name, a unit or an interface in its table.
pub(super) type Id = u32;

#[derive(Debug, Default)]
pub(super) struct Declarations {
    by_text: HashMap<Arc<str>, Id>,
    by_name: HashMap<String, Id>,
    pub(super) names: Vec<String>,
    pub(super) all: Vec<Declared>,
}

#[derive(Debug)]
pub(super) struct Declared {
    pub(super) text: Arc<str>,
    pub(super) kind: Kind,
    pub(super) name: Option<Id>,
    pub(super) header: usize,
    /// The names in the header of a function, or all names in any other declaration.
    pub(super) visible: Vec<Id>,
    pub(super) mentions: Vec<Id>,
    pub(super) is_of_whole: bool,
    /// An upper bound on the number of statements in the declaration; `None` if the declaration exceeds a size limit by
    /// itself.
    pub(super) statements: Option<usize>,
}

impl Declarations {
    /// Interns the declarations of a module. `before` holds the declaration ids of the previous module. `common` are
    /// the numbers of equal declarations at the start and end of the two modules.
    ///
    /// Also returns whether the module can be validated by declarations. This requires unique names, directives only
    /// at the start, no declaration that affects the whole module, and a limited size.
    pub(super) fn of(&mut self, split: &Split, common: Common, before: &[Id]) -> (Arc<[Id]>, bool) {
        let new = split.ranges.len() - common.first - common.last;
        let ranges = split.ranges.iter().skip(common.first).take(new);
        let found: Arc<[Id]> = before[..common.first]
            .iter()
            .copied()
            .chain(ranges.map(|range| self.id(&split.text[range.clone()])))
            .chain(before[before.len() - common.last..].iter().copied())
            .collect();
        let known = |id: &Id| &self.all[*id as usize];
        let mut names: Vec<Id> = found.iter().filter_map(|id| known(id).name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        let is_of_parts = found.iter().all(|id| !known(id).is_of_whole);
        let mut kinds = found.iter().map(|id| known(id).kind).skip_while(|kind| *kind == Kind::Directive);
        let begins_with_directives = kinds.all(|kind| kind != Kind::Directive);
        let is_small = complexity::is_small(&split.text, found.iter().map(|id| known(id).statements));
        let can_be_taken_apart = names.len() == count && is_of_parts && begins_with_directives && is_small;
        (found, can_be_taken_apart)
    }

    fn id(&mut self, text: &str) -> Id {
        if let Some(id) = self.by_text.get(text) {
            return *id;
        }
        let Declaration { kind, name, header, in_header, mentions, is_of_whole } = Declaration::new(text);
        let mut intern = |name: String| {
            let next = self.names.len() as Id;
            *self.by_name.entry(name).or_insert_with_key(|name| {
                self.names.push(name.clone());
                next
            })
        };
        let declared = Declared {
            text: text.into(),
            kind,
            name: name.map(&mut intern),
            header,
            visible: in_header.into_iter().map(&mut intern).collect(),
            mentions: mentions.into_iter().map(&mut intern).collect(),
            is_of_whole,
            statements: complexity::statements(text),
        };
        let id = self.all.len() as Id;
        self.by_text.insert(declared.text.clone(), id);
        self.all.push(declared);
        id
    }

    pub(super) fn is_function(&self, id: Id) -> bool {
        matches!(self.all[id as usize].kind, Kind::Function | Kind::EntryPoint)
    }

    pub(super) fn name(&self, name: Id) -> &str {
        self.names.get(name as usize).map_or("", String::as_str)
    }

    /// Returns the id of a name, or `None` if no declaration contains it.
    pub(super) fn named(&self, name: &str) -> Option<Id> {
        self.by_name.get(name).copied()
    }

    pub(super) fn kind(&self, declaration: Id) -> Kind {
        self.all[declaration as usize].kind
    }

    pub(super) fn name_id(&self, declaration: Id) -> Option<Id> {
        self.all[declaration as usize].name
    }

    pub(super) fn name_of(&self, declaration: Id) -> &str {
        self.name_id(declaration).map_or("", |name| self.name(name))
    }
}
