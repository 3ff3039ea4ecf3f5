//! The strings of a document, and what the names in them mean.

use std::collections::BTreeMap;
use std::ops::Range;

use super::content::{Content, Named};
use super::declare::{SECTIONS, Scope, add_at};
use super::{Declaration, DeclarationKind as K, Id, Model, Text, Use, section};
use crate::document::{Entry, Kind, Value, pointer_join};
use crate::language::Written;
use crate::source::Span;

/// Adds the strings of all declarations to the model, and resolves the names in them.
pub(super) fn resolve(model: &mut Model, scopes: Vec<Scope>, root: &Value) {
    let (top, below) = scopes.split_first().map_or((None, [].as_slice()), |(top, below)| (Some(top), below));
    let Some(top) = top else { return };
    let mut resolver = Resolver { model, top, scopes: &scopes, data: BTreeMap::new() };
    resolver.owner(root, top);
    for (entry, scope) in section(root, "subgraphs").iter().zip(below) {
        resolver.owner(&entry.value, scope);
    }
}

struct Resolver<'m, 's> {
    model: &'m mut Model,
    top: &'s Scope,
    scopes: &'s [Scope],
    /// Published data by its subgraph (`None` for the pipeline) and name.
    data: BTreeMap<(Option<Id>, String), Id>,
}

/// The context in which the names of a string are resolved.
struct Site<'s> {
    scope: &'s Scope,
    within: Id,
    /// The loop variables of the pass, by name.
    variables: BTreeMap<String, Id>,
}

impl<'s> Resolver<'_, 's> {
    fn owner(&mut self, owner: &Value, scope: &'s Scope) {
        for (name, kind, _) in SECTIONS {
            for entry in section(owner, name) {
                let found = match kind {
                    K::Pass => scope.passes.get(&entry.key),
                    _ => scope.others.get(&(kind, entry.key.clone())),
                };
                let found = found.or_else(|| scope.values.get(&entry.key));
                let Some(within) = found.copied() else { continue };
                self.entry(entry, kind, within, scope);
            }
        }
    }

    fn entry(&mut self, entry: &Entry, kind: K, within: Id, scope: &'s Scope) {
        let mut variables = BTreeMap::new();
        let mut used: Option<&Scope> = None;
        match kind {
            K::Pass => {
                for variable in entry.value.entries_of("for_each") {
                    let pointer = pointer_join(&self.model.declaration(within).pointer, "for_each");
                    let declaration = Declaration {
                        kind: K::Variable,
                        name: variable.key.clone(),
                        place: variable.key_span,
                        owner: Some(within),
                        pointer: pointer_join(&pointer, &variable.key),
                    };
                    variables.insert(variable.key.clone(), add_at(self.model, declaration));
                }
                let subgraph = entry.value.get("use").and_then(Value::text);
                let id = subgraph.and_then(|name| self.top.others.get(&(K::Subgraph, name.to_owned())));
                used = id.and_then(|id| self.scopes.iter().find(|scope| scope.owner == Some(*id)));
            }
            K::Preset => {
                for (section, kind) in [("parameters", K::Parameter), ("features", K::Feature)] {
                    for given in entry.value.entries_of(section) {
                        self.other(kind, &given.key, given.key_span, within, self.top);
                    }
                }
                return;
            }
            // What a group says is read where passes take it over.
            K::SharedSettings => {
                if let Some(names) = entry.value.get("extends") {
                    let site = Site { scope, within, variables };
                    self.strings(names, &mut vec!["extends".to_owned()], &site);
                }
                return;
            }
            K::Parameter | K::Toggle | K::Geometry => return,
            _ => {}
        }
        let site = Site { scope, within, variables };
        self.strings(&entry.value, &mut Vec::new(), &site);
        for key in ["with", "passthrough"].iter().filter(|_| kind == K::Pass) {
            for given in entry.value.entries_of(key) {
                let seen = if *key == "with" { used } else { Some(scope) };
                if let Some(id) = seen.and_then(|seen| seen.values.get(&given.key)).copied() {
                    self.push(id, given.key_span, within);
                }
            }
        }
    }

    /// Records all strings inside a value, except descriptions, and resolves the names in them.
    fn strings(&mut self, value: &Value, keys: &mut Vec<String>, site: &Site<'s>) {
        match &value.kind {
            Kind::Text(_) => self.string(value, keys.clone(), site),
            Kind::Array(elements) => {
                for (at, element) in elements.iter().enumerate() {
                    keys.push(at.to_string());
                    self.strings(element, keys, site);
                    keys.pop();
                }
            }
            Kind::Object(entries) => {
                for entry in entries.iter().filter(|entry| entry.key != "description") {
                    keys.push(entry.key.clone());
                    self.strings(&entry.value, keys, site);
                    keys.pop();
                }
            }
            Kind::Null | Kind::Bool(_) | Kind::Number(_) | Kind::Missing => {}
        }
    }

    fn string(&mut self, value: &Value, keys: Vec<String>, site: &Site<'s>) {
        let Some(text) = value.text() else { return };
        let kind = self.model.declaration(site.within).kind;
        let first = keys.first().map(String::as_str);
        // The keys that every pass, feature and extension point has name what they name.
        let named = match (kind, first) {
            (K::Pass | K::ExtensionPoint, Some("after" | "before")) => Some(K::Pass),
            (K::Pass, Some("toggle")) => Some(K::Toggle),
            (K::Pass, Some("use")) => Some(K::Subgraph),
            (K::Pass | K::SharedSettings, Some("extends")) => Some(K::SharedSettings),
            (K::Feature, Some("requires" | "excludes")) => Some(K::Feature),
            (K::Pass, Some(_))
                if keys.last().is_some_and(|key| key == "geometry")
                    && Written::of(text) == Written::Plain(text) =>
            {
                Some(K::Geometry)
            }
            _ => None,
        };
        let span = |range: Range<usize>| value.span_within(range).unwrap_or(value.span);
        let begin = self.model.uses.len();
        if let Some(named) = named {
            let from = usize::from(named == K::Toggle && text.starts_with('!'));
            let place = span(from..text.len());
            match named {
                K::Pass => {
                    self.pass_id(text, site).into_iter().for_each(|id| self.push(id, place, site.within));
                }
                _ => self.other(named, &text[from..], place, site.within, site.scope),
            }
            return self.read(value, keys, site, Content::Word, begin);
        }
        let content = Content::read(text);
        let names: Vec<(Id, Range<usize>)> = content
            .names(text)
            .into_iter()
            .flat_map(|(named, range)| {
                let found = self.resolve(&named, &range, value, site);
                found.into_iter().map(move |id| (id, range.clone()))
            })
            .collect();
        for (id, range) in names {
            let name = &self.model.declaration(id).name;
            let is_head = text[range.clone()].starts_with(name.as_str());
            let range = if is_head { range.start..range.start + name.len() } else { range };
            self.push(id, span(range), site.within);
        }
        self.read(value, keys, site, content, begin);
    }

    /// Records a string in the model; `begin` is the index of its first use.
    fn read(&mut self, value: &Value, keys: Vec<String>, site: &Site<'s>, content: Content, begin: usize) {
        let text = value.text().unwrap_or_default().to_owned();
        let uses = begin..self.model.uses.len();
        self.model.texts.push(Text { place: value.span, within: site.within, keys, text, content, uses });
    }

    /// Returns the declaration that a name in a string refers to; `None` if there is none.
    fn resolve(&mut self, named: &Named, range: &Range<usize>, value: &Value, site: &Site<'s>) -> Option<Id> {
        match named {
            Named::Value(name) => {
                let head = name.split_once('.').map_or(name.as_str(), |(head, _)| head);
                self.value(head, site)
            }
            Named::Version(pass) => self.pass_id(pass, site),
            Named::Resource(name) => {
                self.resource(name, site).or_else(|| self.published(name, range, value, site))
            }
        }
    }

    fn value(&self, name: &str, site: &Site<'s>) -> Option<Id> {
        let seen = || self.top.values.get(name).filter(|_| site.scope.sees_pipeline);
        let found = site.variables.get(name).or_else(|| site.scope.values.get(name)).or_else(seen);
        found.copied()
    }

    fn resource(&self, name: &str, site: &Site<'s>) -> Option<Id> {
        let of = |scope: &Scope| {
            let kinds = [K::Resource, K::Input];
            kinds.into_iter().find_map(|kind| scope.others.get(&(kind, name.to_owned())).copied())
        };
        of(site.scope).or_else(|| of(self.top).filter(|_| site.scope.sees_pipeline))
    }

    fn published(&mut self, name: &str, range: &Range<usize>, value: &Value, site: &Site<'s>) -> Option<Id> {
        if !is_name(name) || site.scope.others.contains_key(&(K::Geometry, name.to_owned())) {
            return None;
        }
        let key = (site.scope.owner, name.to_owned());
        if let Some(known) = self.data.get(&key) {
            return Some(*known);
        }
        let declaration = Declaration {
            kind: K::Data,
            name: name.to_owned(),
            place: value.span_within(range.clone()).unwrap_or(value.span),
            owner: site.scope.owner,
            pointer: self.model.declaration(site.within).pointer.clone(),
        };
        let id = add_at(self.model, declaration);
        self.data.insert(key, id);
        Some(id)
    }

    /// Returns the pass of this name. A dotted name, such as `blur.0` for an iteration of a loop, resolves to the
    /// longest prefix that names a pass. `None` if there is none.
    fn pass_id(&self, name: &str, site: &Site<'s>) -> Option<Id> {
        let mut ends: Vec<usize> = name.match_indices('.').map(|(at, _)| at).collect();
        ends.push(name.len());
        ends.into_iter().rev().find_map(|end| site.scope.passes.get(&name[..end])).copied()
    }

    fn other(&mut self, kind: K, name: &str, place: Span, within: Id, scope: &Scope) {
        let key = (kind, name.to_owned());
        let outer = || self.top.others.get(&key).filter(|_| scope.sees_pipeline || kind == K::Subgraph);
        if let Some(id) = scope.others.get(&key).or_else(outer).copied() {
            self.push(id, place, within);
        }
    }

    fn push(&mut self, declaration: Id, place: Span, within: Id) {
        self.model.uses.push(Use { place, declaration, within });
    }
}

/// Returns `true` if a string is an ASCII letter followed by ASCII letters, digits and underscores.
fn is_name(text: &str) -> bool {
    text.chars().next().is_some_and(|first| first.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
