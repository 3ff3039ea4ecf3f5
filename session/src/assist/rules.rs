//! The parts of a JSON schema that hold at a place: keys with their descriptions, words, types.

use serde_json::{Map, Value as Json};

use crate::graph::document::Signs;

/// The rules of a JSON schema for one value: its schema object, and all that it refers to or lists as alternatives.
#[derive(Clone, Debug)]
pub(super) struct Rules<'s> {
    root: &'s Json,
    all: Vec<&'s Map<String, Json>>,
}

/// The maximum nesting depth of references and alternatives in a schema.
const MAX_DEPTH: usize = 16;

impl<'s> Rules<'s> {
    /// Creates the rules for the root of a schema.
    pub(super) fn of(root: &'s Json) -> Self {
        Self { root, all: Vec::new() }.with([root])
    }

    /// Returns the rules for the value at a path of object keys and array positions.
    pub(super) fn below<'k>(self, way: impl IntoIterator<Item = &'k str>) -> Self {
        way.into_iter().fold(self, |rules, key| {
            let position = key.parse::<usize>().ok();
            let member = |one: &&'s Map<String, Json>| {
                let named = one.get("properties").and_then(|members| members.get(key));
                let element = || one.get("prefixItems").and_then(|list| list.get(position?));
                let any = |keyword: &str| one.get(keyword).filter(|rule| rule.is_object());
                let of_list = || position.and_then(|_| any("items"));
                named.or_else(element).or_else(of_list).or_else(|| any("additionalProperties"))
            };
            let found: Vec<&Json> = rules.all.iter().filter_map(member).collect();
            Self { root: rules.root, all: Vec::new() }.with(found)
        })
    }

    fn with(mut self, schemas: impl IntoIterator<Item = &'s Json>) -> Self {
        for schema in schemas {
            self.add(schema, 0);
        }
        self
    }

    fn add(&mut self, schema: &'s Json, depth: usize) {
        let Some(rules) = schema.as_object() else { return };
        if depth > MAX_DEPTH || self.all.iter().any(|known| std::ptr::eq(*known, rules)) {
            return;
        }
        self.all.push(rules);
        let target = rules.get("$ref").and_then(Json::as_str).and_then(|target| target.strip_prefix('#'));
        let target = target.and_then(|target| self.root.pointer(target));
        let parts =
            ["allOf", "anyOf", "oneOf"].into_iter().filter_map(|keyword| rules.get(keyword)?.as_array());
        for part in target.into_iter().chain(parts.flatten()) {
            self.add(part, depth + 1);
        }
    }

    /// Returns the object keys that the schema names, each with the rules for its value.
    pub(super) fn keys(&self) -> Vec<(&'s str, Self)> {
        let mut keys: Vec<&'s str> = Vec::new();
        for one in self.all.iter().filter_map(|one| one.get("properties")?.as_object()) {
            keys.extend(one.keys().map(String::as_str));
        }
        let mut known = std::collections::BTreeSet::new();
        keys.retain(|key| known.insert(*key));
        keys.into_iter().map(|key| (key, self.clone().below([key]))).collect()
    }

    /// Returns the constant strings that the value can be, each with its description; `None` for a string without one.
    pub(super) fn words(&self) -> Vec<(&'s str, Option<&'s str>)> {
        let mut words = Vec::new();
        for one in &self.all {
            let description = one.get("description").and_then(Json::as_str);
            let list = one.get("enum").and_then(Json::as_array).into_iter().flatten();
            let described = one.get("const").into_iter().filter_map(Json::as_str);
            words.extend(described.map(|word| (word, description)));
            words.extend(list.filter_map(Json::as_str).map(|word| (word, None)));
        }
        words.sort_by_key(|(word, description)| (*word, description.is_none()));
        words.dedup_by_key(|(word, _)| *word);
        words
    }

    /// Returns the description of the first rules that have one; `None` if there is none.
    pub(super) fn description(&self) -> Option<&'s str> {
        self.all.iter().find_map(|one| one.get("description")?.as_str())
    }

    /// Returns `true` if the value may have the JSON type `wanted`, such as `boolean`.
    pub(super) fn takes(&self, wanted: &str) -> bool {
        self.all.iter().filter_map(|one| one.get("type")).any(|types| match types {
            Json::Array(types) => types.iter().any(|one| one == wanted),
            one => one == wanted,
        })
    }

    /// Returns the leading signs of references and expressions that the string patterns of the rules allow.
    pub(super) fn signs(&self) -> impl Iterator<Item = Signs> {
        let patterns = self.all.iter().filter_map(|one| one.get("pattern")?.as_str());
        patterns.filter_map(Signs::of_pattern)
    }
}
