//! The keys of documents, the node kinds, and the types of their settings, from the schema.

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json};
use umbragraph::data::DataShape;
use umbragraph::low_level::pipeline::{FileKind, schema_of_composed};
use umbragraph::node::Registry;

use super::markdown::{sentence, table};
use super::page::{Entry, Page};

/// The name of the schema definition with the keys that every pass can have.
const PASS: &str = "Pass";

pub(super) struct Settings {
    registry: Registry,
    schema: Json,
}

impl Settings {
    pub(super) fn new() -> Self {
        let registry = umbragraph::registry();
        let schema = schema_of_composed(FileKind::Pipeline, &registry);
        Self { registry, schema }
    }

    /// Returns the page about the keys of a document.
    pub(super) fn document(&self) -> Page {
        let kinds: BTreeSet<&str> = self.registry.iter().map(|kind| kind.name()).collect();
        let pipeline = Entry {
            name: "pipeline".to_owned(),
            summary: "The keys of a pipeline.".to_owned(),
            text: properties(&self.schema, |_| true),
        };
        let pass = Entry {
            name: "pass".to_owned(),
            summary: "The keys that every pass can have.".to_owned(),
            text: format!(
                "One key that names its [node kind](nodes.md), or `use`, and of these what it wants.\n\n{}",
                self.definition(PASS)
                    .map_or_else(String::new, |pass| properties(pass, |key| !kinds.contains(key)))
            ),
        };
        let mut entries = vec![pipeline, pass];
        for (kind, name, what) in [
            (FileKind::Subgraph, "subgraph", "The keys of a file that a pass names under `use`."),
            (
                FileKind::Extension,
                "extension",
                "The keys of a file with passes for extension points (`--extension`).",
            ),
            (
                FileKind::Parameters,
                "parameters",
                "The keys of a file with values of parameters and features (`--params`).",
            ),
        ] {
            let schema = schema_of_composed(kind, &self.registry);
            let text = format!("{what}\n\n{}", properties(&schema, |_| true));
            entries.push(Entry { name: name.to_owned(), summary: what.to_owned(), text });
        }
        entries.push(axes());
        Page {
            name: "documents",
            title: "Documents",
            introduction: "The keys of files. The types are those of [types](types.md) and JSON's.",
            entries,
        }
    }

    /// Returns the page about the node kinds.
    pub(super) fn kinds(&self) -> Page {
        let entries = self.registry.iter().map(|kind| {
            let definition = self
                .definition(PASS)
                .and_then(|pass| pass["properties"][kind.name()]["$ref"].as_str())
                .and_then(|path| self.definition(last(path)));
            let mut text = format!("{}\n", kind.summary());
            if let Some(definition) = definition {
                text.push_str(&format!("\n{}", properties(definition, |_| true)));
            }
            for (when, shape) in kind.published() {
                text.push_str(&format!("\n{}\n\n{}", heading(when, &shape), published(&shape)));
            }
            Entry { name: kind.name().to_owned(), summary: kind.summary().to_owned(), text }
        });
        Page {
            name: "nodes",
            title: "Node kinds",
            introduction: "The kinds of passes: the settings of each, and the blackboard data that it publishes, \
                whose values a shader declares by name in a uniform or storage block (`array.member` is a member of the \
                structs of an array). The types are those of [types](types.md) and JSON's.",
            entries: entries.collect(),
        }
    }

    /// Returns the page about the types that documents and node kinds share.
    pub(super) fn types(&self) -> Page {
        let kinds: BTreeSet<&str> = self
            .definition(PASS)
            .and_then(|pass| pass["properties"].as_object())
            .into_iter()
            .flatten()
            .filter_map(|(_, property)| Some(last(property["$ref"].as_str()?)))
            .collect();
        let none = Map::new();
        let definitions = self.schema["$defs"].as_object().unwrap_or(&none);
        let entries = definitions
            .iter()
            .filter(|(name, _)| {
                *name != PASS && !name.ends_with("OrExpression") && !kinds.contains(name.as_str())
            })
            .map(|(name, definition)| {
                let summary = description(definition);
                let rows = properties(definition, |_| true);
                let text = if rows.is_empty() {
                    format!("{summary}\n\n{}", alternatives(definition))
                } else {
                    format!("{summary}\n\n{rows}")
                };
                Entry { name: name.clone(), summary, text }
            });
        let mut entries: Vec<Entry> = entries.collect();
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        Page {
            name: "types",
            title: "Types of settings",
            introduction: "The types that documents and node kinds name.",
            entries,
        }
    }

    fn definition(&self, name: &str) -> Option<&Json> {
        self.schema["$defs"].get(name)
    }
}

/// Returns the entry about the axes file of a template.
fn axes() -> Entry {
    let schema = umbragraph::low_level::shader::axes_schema();
    let mut file = schema.clone();
    // Both have tables of their own.
    file["properties"]["axes"]["additionalProperties"] = Json::Null;
    file["properties"]["constraints"]["items"] = Json::Null;
    let summary = "The keys of `NAME.axes.json`, which stands beside the template `NAME.wgsl.jinja`.";
    let text = format!(
        "{summary}\n\n{}\nAn axis:\n\n{}\nA constraint:\n\n{}\nFor example:\n\n```jsonc\n{}\n```\n",
        properties(&file, |_| true),
        properties(&schema["properties"]["axes"]["additionalProperties"], |_| true),
        properties(&schema["properties"]["constraints"]["items"], |_| true),
        "{ \"axes\": {\n  \"taps\": { \"type\": \"integer\", \"min\": 1, \"max\": 8, \"default\": 4 },\n  \
         \"mode\": { \"type\": \"enum\", \"values\": [\"sharp\", \"soft\"], \"default\": \"soft\" },\n  \
         \"fog\": { \"type\": \"bool\", \"default\": false }\n} }",
    );
    Entry { name: "axes".to_owned(), summary: summary.to_owned(), text }
}

/// Returns the sentence before a table of published values.
fn heading(when: &str, shape: &DataShape) -> String {
    let views = if shape.max_views > 0 { ", besides views" } else { "" };
    let sizes: Vec<String> = shape.sizes.iter().map(|(name, _)| format!("`{name}`")).collect();
    let sizes =
        if sizes.is_empty() { String::new() } else { format!(", and the sizes {}", sizes.join(", ")) };
    sentence(&format!("{when}{}publishes{views}{sizes}", if when.is_empty() { "" } else { " " }))
        .replace('.', ":")
}

fn published(shape: &DataShape) -> String {
    let rows: Vec<[String; 3]> = shape
        .values
        .iter()
        .map(|value| {
            let element = umbragraph::data::ValueType { count: None, ..value.value_type };
            let is_array = value.value_type.count.is_some();
            let value_type = if is_array { format!("`array<{element}>`") } else { format!("`{element}`") };
            [format!("`{}`", value.name), value_type, value.description.to_owned()]
        })
        .collect();
    table(["value", "type", "what"], &rows)
}

/// Returns a Markdown table of the properties of an object.
fn properties(schema: &Json, wanted: impl Fn(&str) -> bool) -> String {
    let required: BTreeSet<&str> =
        schema["required"].as_array().into_iter().flatten().filter_map(Json::as_str).collect();
    let rows: Vec<[String; 3]> = schema["properties"]
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(key, _)| wanted(key))
        .map(|(key, property)| {
            let mark = if required.contains(key.as_str()) { " (required)" } else { "" };
            [format!("`{key}`{mark}"), type_of(property), description(property)]
        })
        .collect();
    table(["key", "type", "what"], &rows)
}

/// Returns a table of the alternatives of a type that is no object with named keys.
fn alternatives(schema: &Json) -> String {
    let rows: Vec<[String; 2]> = ["anyOf", "oneOf"]
        .iter()
        .filter_map(|key| schema[key].as_array())
        .flatten()
        .map(|one| [type_of(one), description(one)])
        .collect();
    if rows.is_empty() {
        format!("A JSON value: {}.\n", type_of(schema))
    } else {
        table(["value", "what"], &rows)
    }
}

/// Describes a type, with links to types that have an entry.
fn type_of(schema: &Json) -> String {
    if let Some(path) = schema["$ref"].as_str() {
        return match last(path) {
            PASS => "[pass](documents.md#pass)".to_owned(),
            name => match name.strip_suffix("OrExpression") {
                Some("string") => "string, or `\"=…\"`".to_owned(),
                Some(word) => format!("[{word}](types.md#{}), or `\"=…\"`", word.to_lowercase()),
                None => format!("[{name}](types.md#{})", name.to_lowercase()),
            },
        };
    }
    if let Some(word) = schema["const"].as_str() {
        return format!("`\"{word}\"`");
    }
    if let Some(words) = schema["enum"].as_array() {
        return words
            .iter()
            .filter_map(Json::as_str)
            .map(|word| format!("`{word}`"))
            .collect::<Vec<_>>()
            .join(", ");
    }
    let types: Vec<&str> = match &schema["type"] {
        Json::String(one) => vec![one],
        Json::Array(all) => all.iter().filter_map(Json::as_str).filter(|one| *one != "null").collect(),
        _ => Vec::new(),
    };
    if let Some(properties) = schema["properties"].as_object() {
        let keys = properties.iter().map(|(key, value)| format!("`\"{key}\"`: {}", type_of(value)));
        return format!("{{ {} }}", keys.collect::<Vec<_>>().join(", "));
    }
    let words = types.iter().map(|one| match *one {
        "string" => "text".to_owned(),
        "array" => match schema["items"].as_object() {
            Some(_) => format!("list of {}", type_of(&schema["items"])),
            None => "list".to_owned(),
        },
        "object" => match schema["additionalProperties"].as_object() {
            Some(_) => format!("object of {}", type_of(&schema["additionalProperties"])),
            None => "object".to_owned(),
        },
        other => other.to_owned(),
    });
    let words: Vec<String> = words.collect();
    if !words.is_empty() {
        return words.join(", ");
    }
    let choices: Vec<String> = ["anyOf", "oneOf"]
        .iter()
        .filter_map(|key| schema[key].as_array())
        .flatten()
        .filter(|one| one["type"] != "null")
        .map(type_of)
        .collect();
    if choices.is_empty() { "any value".to_owned() } else { choices.join(" or ") }
}

fn description(schema: &Json) -> String {
    schema["description"]
        .as_str()
        .unwrap_or_default()
        .replace('\n', " ")
        .replace("[`", "`")
        .replace("`]", "`")
}

/// Returns the name at the end of a reference into the schema.
fn last(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
