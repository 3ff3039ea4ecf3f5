//! A schema made ready: references followed, types as sets, words and keys at hand, so that a check looks nothing up.

use std::collections::HashMap;

use serde_json::Value as Json;

use super::{Kind, Signs, Value, first_sentence};
use crate::diagnostic::list_of;

/// A compiled JSON Schema, which can check any number of documents.
#[derive(Debug)]
pub struct Schema {
    rules: Vec<Rules>,
    /// The node of the schema's root.
    pub(super) start: Node,
}

/// A JSON Schema or a `$ref` to one, with the description that is written beside the keywords.
#[derive(Clone, Debug, Default)]
pub(super) struct Node {
    /// The description of this schema itself, not of a schema that it refers to.
    pub(super) description: Option<String>,
    /// The index of the schema's rules in [`Schema`], with all `$ref`s followed. `None` if the schema is not an object,
    /// or a `$ref` does not resolve.
    rules: Option<usize>,
}

/// The rules of one schema, by JSON Schema keyword.
#[derive(Debug, Default)]
pub(super) struct Rules {
    /// Lists of keys (`oneOf` or `anyOf` beside `properties`). An object must have exactly one key of each list.
    pub(super) one_key: Vec<Vec<String>>,
    pub(super) alternatives: Option<Alternatives>,
    pub(super) all_of: Vec<Node>,
    pub(super) types: Option<Wanted>,
    pub(super) words: Option<Vec<Json>>,
    /// The sign (`=` or `&`) that a string must begin with.
    pub(super) signs: Option<Signs>,
    pub(super) minimum: Option<f64>,
    pub(super) maximum: Option<f64>,
    pub(super) above: Option<f64>,
    pub(super) min_items: Option<u64>,
    pub(super) max_items: Option<u64>,
    pub(super) prefix: Vec<Node>,
    pub(super) items: Option<Node>,
    /// The known keys of an object, in the order of the schema.
    pub(super) properties: Vec<(String, Node)>,
    pub(super) additional: Additional,
    pub(super) required: Vec<Required>,
}

/// The types that a value may have, and their names for messages.
#[derive(Debug)]
pub(super) struct Wanted {
    pub(super) types: Types,
    pub(super) names: String,
}

/// The rule for keys of an object that are not in `properties`.
#[derive(Debug, Default)]
pub(super) enum Additional {
    #[default]
    Any,
    None,
    Like(Node),
}

/// A required key of an object.
#[derive(Debug)]
pub(super) struct Required {
    pub(super) key: String,
    /// The first sentence of the key's description in the schema; `None` if there is none.
    pub(super) description: Option<String>,
}

/// Alternative schemas, one of which a value must match.
#[derive(Debug)]
pub(super) struct Alternatives {
    /// Whether a string that begins with `=` (an expression) is allowed instead.
    pub(super) takes_expressions: bool,
    pub(super) branches: Vec<Branch>,
    /// The types of all alternatives, for messages.
    pub(super) wanted: String,
}

/// One of several alternative schemas.
#[derive(Debug)]
pub(super) struct Branch {
    pub(super) node: Node,
    /// The types that a value must have to match the branch.
    pub(super) could_be: Types,
    /// The words of the branch if it is an enumeration of strings; otherwise empty.
    pub(super) words: Vec<String>,
    /// The one key that the branch requires if it is an externally tagged variant; otherwise `None`.
    pub(super) tag: Option<String>,
}

/// A set of JSON types, as bits; integers and other numbers are different types.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Types(u8);

impl Schema {
    /// Compiles a JSON Schema.
    pub fn new(schema: &Json) -> Self {
        let mut maker = Maker { root: schema, rules: Vec::new(), known: HashMap::new() };
        let start = maker.node(schema);
        Self { rules: maker.rules, start }
    }

    pub(super) fn rules(&self, node: &Node) -> Option<&Rules> {
        self.rules.get(node.rules?)
    }
}

impl Rules {
    pub(super) fn property(&self, key: &str) -> Option<&Node> {
        self.properties.iter().find(|(known, _)| known == key).map(|(_, node)| node)
    }
}

impl Types {
    const ALL: Types = Types(0x7f);
    const WHOLE: Types = Types(1);
    const FRACTION: Types = Types(2);

    fn named(name: &str) -> Self {
        match name {
            "integer" => Self::WHOLE,
            "number" => Self::WHOLE.or(Self::FRACTION),
            "null" => Types(4),
            "boolean" => Types(8),
            "string" => Types(16),
            "array" => Types(32),
            "object" => Types(64),
            _ => Types(0),
        }
    }

    /// Returns the types that the JSON Schema keyword `type` lists, without null; all types if the keyword's value is
    /// invalid.
    fn listed(types: &Json) -> Self {
        match types {
            Json::String(name) => Self::named(name),
            // An option's null stands for a key that is left out; written null is not meant.
            Json::Array(names) => names
                .iter()
                .filter(|name| name.as_str() != Some("null"))
                .fold(Types(0), |all, name| all.or(Self::listed(name))),
            _ => Self::ALL,
        }
    }

    fn or(self, other: Self) -> Self {
        Types(self.0 | other.0)
    }

    /// Returns `true` if the value has one of the types.
    pub(super) fn have(self, value: &Value) -> bool {
        let found = match &value.kind {
            Kind::Null | Kind::Missing => Self::named("null"),
            Kind::Bool(_) => Self::named("boolean"),
            Kind::Number(number) if number.as_f64().is_some_and(|number| number.fract() == 0.0) => {
                Self::WHOLE
            }
            Kind::Number(_) => Self::FRACTION,
            Kind::Text(_) => Self::named("string"),
            Kind::Array(_) => Self::named("array"),
            Kind::Object(_) => Self::named("object"),
        };
        self.0 & found.0 != 0
    }
}

struct Maker<'a> {
    root: &'a Json,
    rules: Vec<Rules>,
    /// The index of a schema's rules, by the address of the schema in memory.
    known: HashMap<*const Json, usize>,
}

impl<'a> Maker<'a> {
    fn node(&mut self, schema: &'a Json) -> Node {
        let description = schema.get("description").and_then(Json::as_str).map(str::to_owned);
        let rules = resolve(schema, self.root).filter(|schema| schema.is_object());
        let rules = rules.map(|schema| self.rules_of(schema));
        Node { description, rules }
    }

    fn rules_of(&mut self, schema: &'a Json) -> usize {
        if let Some(known) = self.known.get(&std::ptr::from_ref(schema)) {
            return *known;
        }
        let at = self.rules.len();
        self.known.insert(schema, at);
        // Schemas can contain themselves.
        self.rules.push(Rules::default());
        self.rules[at] = self.make(schema);
        at
    }

    fn make(&mut self, json: &'a Json) -> Rules {
        let mut rules = Rules::default();
        for word in ["oneOf", "anyOf"] {
            match json.get(word) {
                Some(Json::Array(branches)) if json.get("properties").is_some() => {
                    rules.one_key.push(branches.iter().filter_map(first_required).collect());
                }
                Some(Json::Array(branches)) if rules.alternatives.is_none() => {
                    rules.alternatives = Some(self.alternatives(branches));
                }
                _ => {}
            }
        }
        let number = |name: &str| json.get(name).and_then(Json::as_f64);
        let count = |name: &str| json.get(name).and_then(Json::as_u64);
        rules.types =
            json.get("type").map(|types| Wanted { types: Types::listed(types), names: type_names(types) });
        rules.words = words(json).map(<[Json]>::to_vec);
        rules.signs = json.get("pattern").and_then(Json::as_str).and_then(Signs::of_pattern);
        (rules.minimum, rules.maximum) = (number("minimum"), number("maximum"));
        rules.above = number("exclusiveMinimum");
        (rules.min_items, rules.max_items) = (count("minItems"), count("maxItems"));
        rules.all_of = self.nodes(json.get("allOf"));
        rules.prefix = self.nodes(json.get("prefixItems"));
        rules.items = json.get("items").map(|items| self.node(items));
        let properties = json.get("properties").and_then(Json::as_object);
        let listed = properties.into_iter().flatten();
        rules.properties = listed.map(|(key, schema)| (key.clone(), self.node(schema))).collect();
        rules.additional = match json.get("additionalProperties") {
            Some(Json::Bool(false)) => Additional::None,
            Some(schema @ Json::Object(_)) => Additional::Like(self.node(schema)),
            _ => Additional::Any,
        };
        let required = json.get("required").and_then(Json::as_array).into_iter().flatten();
        rules.required = required
            .filter_map(Json::as_str)
            .map(|key| Required {
                key: key.to_owned(),
                description: properties
                    .and_then(|properties| properties.get(key))
                    .and_then(|property| {
                        let named = resolve(property, self.root)?;
                        property.get("description").or_else(|| named.get("description"))
                    })
                    .and_then(Json::as_str)
                    .map(first_sentence),
            })
            .collect();
        rules
    }

    fn nodes(&mut self, schemas: Option<&'a Json>) -> Vec<Node> {
        let schemas = schemas.and_then(Json::as_array).into_iter().flatten();
        schemas.map(|schema| self.node(schema)).collect()
    }

    fn alternatives(&mut self, branches: &'a [Json]) -> Alternatives {
        let mut flat = Vec::new();
        flatten(branches, self.root, &mut flat, 0);
        let is_expression = |branch: &&&Json| {
            let has = |keyword, value| branch.get(keyword).and_then(Json::as_str) == Some(value);
            has("pattern", "^=") && has("type", "string")
        };
        let takes_expressions = flat.iter().any(|branch| is_expression(&branch));
        flat.retain(|branch| !is_expression(&branch));
        let mut names: Vec<String> = Vec::new();
        for name in flat.iter().filter_map(|branch| branch.get("type")).map(type_names) {
            if !names.contains(&name) && name != "null" {
                names.push(name);
            }
        }
        let branch = |branch: &'a Json| Branch {
            node: self.node(branch),
            could_be: branch.get("type").map_or(Types::ALL, Types::listed),
            words: words(branch)
                .unwrap_or_default()
                .iter()
                .filter_map(Json::as_str)
                .map(str::to_owned)
                .collect(),
            tag: tag(branch).map(str::to_owned),
        };
        let branches = flat.into_iter().map(branch).collect();
        Alternatives { takes_expressions, branches, wanted: join_or(&names) }
    }
}

fn resolve<'a>(schema: &'a Json, root: &'a Json) -> Option<&'a Json> {
    let mut schema = schema;
    for _ in 0..32 {
        match schema.get("$ref").and_then(Json::as_str) {
            Some(reference) => schema = root.pointer(reference.trim_start_matches('#'))?,
            None => return Some(schema),
        }
    }
    None
}

/// Appends the branches of alternatives to `flat`, with nested alternatives flattened and references resolved.
fn flatten<'a>(branches: &'a [Json], root: &'a Json, flat: &mut Vec<&'a Json>, depth: usize) {
    for branch in branches.iter().filter_map(|branch| resolve(branch, root)) {
        let inner = ["oneOf", "anyOf"].iter().find_map(|word| branch.get(word).and_then(Json::as_array));
        match inner {
            Some(inner) if branch.get("properties").is_none() && depth < 32 => {
                flatten(inner, root, flat, depth + 1);
            }
            _ => flat.push(branch),
        }
    }
}

fn type_names(types: &Json) -> String {
    let names: Vec<String> = match types {
        Json::String(name) => vec![type_name(name).to_owned()],
        Json::Array(names) => names
            .iter()
            .filter_map(Json::as_str)
            .filter(|name| *name != "null")
            .map(|name| type_name(name).to_owned())
            .collect(),
        _ => Vec::new(),
    };
    join_or(&names)
}

fn type_name(name: &str) -> &'static str {
    match name {
        "null" => "null",
        "boolean" => "a boolean",
        "number" => "a number",
        "integer" => "a whole number",
        "string" => "a string",
        "array" => "an array",
        _ => "an object",
    }
}

fn join_or(names: &[String]) -> String {
    match names {
        [] => "another value".to_owned(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} or {last}", list_of(rest)),
    }
}

/// The values that a schema lists under `enum` or `const`; `None` if it lists none.
fn words(schema: &Json) -> Option<&[Json]> {
    match (schema.get("enum"), schema.get("const")) {
        (Some(Json::Array(words)), _) => Some(words),
        (_, Some(word)) => Some(std::slice::from_ref(word)),
        _ => None,
    }
}

/// The first key under `required`; `None` if there is none.
fn first_required(schema: &Json) -> Option<String> {
    Some(schema.get("required")?.as_array()?.first()?.as_str()?.to_owned())
}

/// The one key that a branch requires if it is an externally tagged variant; otherwise `None`.
fn tag(branch: &Json) -> Option<&str> {
    match branch.get("required")?.as_array()?.as_slice() {
        [one] if branch.get("properties")?.as_object()?.len() == 1 => one.as_str(),
        _ => None,
    }
}
