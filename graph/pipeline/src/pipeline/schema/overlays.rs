//! The schema that editors read: documents over others say as little as they like, all others everything.
//!
//! A document that `extends` another is laid over it: it names only what it changes, and null deletes. What is missing
//! can be told once the files are put together, which the loader does; an editor sees one file. So what a schema says
//! is taken apart here:
//!
//! - what can stand somewhere, with its description, for every document, with null for whatever has a name;
//! - what has to be there, and that nothing is null, under `else` of `"if": { "required": ["extends"] }`.
//!
//! A pass that `extends` shared settings is taken apart in the same way, and a group of those is a pass of which
//! nothing has to be there.
//!
//! Only definitions in which something is required appear a second time, and there only the way to it. Elements of
//! lists have to be whole wherever they stand, since a list is replaced as a whole.

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json, json};

/// The name of the definition of a pass, under `$defs` of the JSON Schema.
pub(crate) const PASS: &str = "Pass";
/// The name of the definition of a group of shared settings, under `$defs`.
const GROUP: &str = "SharedSettings";
/// The prefix of the names of definitions under `$defs` that state required keys.
const WHOLE: &str = "Whole";
/// The name of the definition of values that contain no null, under `$defs`.
const NOTHING_DELETED: &str = "NothingDeleted";

/// Converts the schema of composed documents to one of files that can extend others.
pub(crate) fn for_overlays(schema: &Json) -> Json {
    let definitions = schema.get("$defs").and_then(Json::as_object).cloned().unwrap_or_default();
    let parts = Parts { demanding: demanding(&definitions) };
    let mut relaxed = parts.relaxed(schema);
    let mut result = Map::new();
    for (name, definition) in &definitions {
        let mut definition = parts.relaxed(definition);
        parts.allow_null(&mut definition);
        result.insert(name.clone(), definition);
    }
    for (name, definition) in &definitions {
        if let Some(mut whole) = parts.whole(definition) {
            if name == PASS {
                whole = json!({ "if": extends(), "else": whole });
            }
            result.insert(format!("{WHOLE}{name}"), whole);
        }
    }
    let this = json!({ "$ref": format!("#/$defs/{NOTHING_DELETED}") });
    let nothing_deleted = json!({
        "description": "Nothing is deleted here: null stands only in a file, or a pass, that extends another.",
        "not": { "type": "null" },
        "if": extends(),
        "else": { "additionalProperties": this, "items": this },
    });
    result.insert(NOTHING_DELETED.to_owned(), nothing_deleted);
    if let Some(mut group) = result.get(PASS).cloned() {
        let description = "Settings for the node kind of the pass, whichever that is.";
        group["description"] = "A part of passes, which they take over with \"extends\".".into();
        group["properties"]["settings"] = json!({ "description": description, "type": ["object", "null"] });
        result.insert(GROUP.to_owned(), group);
    }
    if let Json::Object(rules) = &mut relaxed {
        rules.insert("if".to_owned(), extends());
        let whole = parts.whole(schema);
        rules.insert("else".to_owned(), json!({ "allOf": [this, whole.unwrap_or_else(|| json!({}))] }));
        rules.insert("$defs".to_owned(), Json::Object(result));
    }
    for owner in ["", "/$defs/SubgraphDeclaration"] {
        if let Some(groups) = relaxed.pointer_mut(&format!("{owner}/properties/shared_settings")) {
            groups["additionalProperties"] = json!({ "$ref": format!("#/$defs/{GROUP}") });
        }
    }
    relaxed
}

/// The schema condition for a file or pass that extends others: it has the key `extends`.
fn extends() -> Json {
    json!({ "required": ["extends"] })
}

struct Parts {
    /// The names of the definitions in which a key is required.
    demanding: BTreeSet<String>,
}

impl Parts {
    /// Returns the part of a schema that states possible keys. Keys are required only in elements of lists.
    fn relaxed(&self, schema: &Json) -> Json {
        let Json::Object(rules) = schema else { return schema.clone() };
        if let Some(variants) = tagged(rules) {
            return self.one_object(rules, &variants);
        }
        let mut relaxed = Map::new();
        for (keyword, value) in rules {
            let value = match (keyword.as_str(), value) {
                ("required" | "$defs", _) => continue,
                // Which of several keys is there can be said by the file below.
                ("oneOf" | "anyOf", Json::Array(_)) if rules.contains_key("properties") => continue,
                ("oneOf" | "anyOf", Json::Array(branches)) => {
                    let branches = branches.iter().map(|branch| self.relaxed(branch)).collect();
                    relaxed.insert("anyOf".to_owned(), Json::Array(branches));
                    continue;
                }
                ("properties", Json::Object(members)) => {
                    let member = |(key, member): (&String, &Json)| (key.clone(), self.member(member));
                    Json::Object(members.iter().map(member).collect())
                }
                ("additionalProperties", Json::Object(_)) => self.member(value),
                ("items", Json::Object(_)) => self.element(value),
                ("prefixItems", Json::Array(list)) => {
                    Json::Array(list.iter().map(|element| self.element(element)).collect())
                }
                _ => value.clone(),
            };
            relaxed.insert(keyword.clone(), value);
        }
        Json::Object(relaxed)
    }

    /// Returns the schema of a named entry, which a file may delete with null.
    fn member(&self, schema: &Json) -> Json {
        let mut relaxed = self.relaxed(schema);
        self.allow_null(&mut relaxed);
        relaxed
    }

    /// Returns the schema of an element of a list, which must have all required keys.
    fn element(&self, schema: &Json) -> Json {
        match self.whole(schema) {
            Some(whole) => json!({ "allOf": [self.relaxed(schema), whole] }),
            None => self.relaxed(schema),
        }
    }

    /// Combines variants that are distinguished by their one key into one object that may have any of the keys.
    fn one_object(&self, rules: &Map<String, Json>, variants: &[(&str, &Map<String, Json>)]) -> Json {
        let members = variants.iter().map(|(key, variant)| {
            let mut member = self.member(&variant["properties"][*key]);
            if let (Json::Object(member), Some(text)) = (&mut member, variant.get("description")) {
                member.entry("description").or_insert_with(|| text.clone());
            }
            ((*key).to_owned(), member)
        });
        let members: Map<String, Json> = members.collect();
        let mut object = json!({ "type": "object", "properties": members, "additionalProperties": false });
        if let (Json::Object(object), Some(text)) = (&mut object, rules.get("description")) {
            object.insert("description".to_owned(), text.clone());
        }
        object
    }

    /// Allows null for a value. Definitions that the schema refers to allow null themselves.
    fn allow_null(&self, schema: &mut Json) {
        let Json::Object(rules) = schema else { return };
        match rules.get_mut("type") {
            Some(Json::Array(types)) if !types.contains(&"null".into()) => types.push("null".into()),
            Some(one @ Json::String(_)) if one != "null" => *one = json!([one, "null"]),
            _ => {}
        }
        if let Some(Json::Array(words)) = rules.get_mut("enum")
            && !words.contains(&Json::Null)
        {
            words.push(Json::Null);
        }
        if let Some(Json::Array(branches)) = rules.get_mut("anyOf") {
            let refers = |branch: &Json| branch.get("$ref").is_some() || branch["type"] == "null";
            if !branches.iter().any(refers) {
                branches.push(json!({ "type": "null" }));
            }
        }
    }

    /// Returns the part of a schema that states required keys; `None` if the schema requires none.
    fn whole(&self, schema: &Json) -> Option<Json> {
        let rules = schema.as_object()?;
        if let Some(name) = definition_of(rules) {
            return self
                .demanding
                .contains(name)
                .then(|| json!({ "$ref": format!("#/$defs/{WHOLE}{name}") }));
        }
        if let Some(variants) = tagged(rules) {
            let one: Vec<Json> = variants.iter().map(|(key, _)| json!({ "required": [key] })).collect();
            let members = variants.iter().filter_map(|(key, variant)| {
                Some(((*key).to_owned(), self.whole(&variant["properties"][*key])?))
            });
            let members: Map<String, Json> = members.collect();
            return Some(match members.is_empty() {
                true => json!({ "oneOf": one }),
                false => json!({ "properties": members, "oneOf": one }),
            });
        }
        let mut whole = Map::new();
        for (keyword, value) in rules {
            let said = match (keyword.as_str(), value) {
                ("required", _) => Some(value.clone()),
                ("oneOf" | "anyOf", Json::Array(_)) if rules.contains_key("properties") => {
                    Some(value.clone())
                }
                ("oneOf" | "anyOf", Json::Array(branches)) => {
                    let branches: Vec<&Json> =
                        branches.iter().filter(|branch| branch["type"] != "null").collect();
                    let demands: Vec<Option<Json>> =
                        branches.iter().map(|branch| self.whole(branch)).collect();
                    match (&*demands, demands.iter().any(Option::is_some)) {
                        (_, false) => None,
                        ([Some(one)], true) => return Some(one.clone()),
                        (_, true) => {
                            let either = demands
                                .into_iter()
                                .zip(&branches)
                                .map(|(demand, branch)| typed(demand.unwrap_or_else(|| json!({})), branch));
                            whole.insert("anyOf".to_owned(), either.collect());
                            None
                        }
                    }
                }
                ("properties", Json::Object(members)) => {
                    let members: Map<String, Json> = members
                        .iter()
                        .filter_map(|(key, member)| Some((key.clone(), self.whole(member)?)))
                        .collect();
                    (!members.is_empty()).then_some(Json::Object(members))
                }
                ("additionalProperties", Json::Object(_)) => self.whole(value),
                _ => None,
            };
            whole.extend(said.map(|said| (keyword.clone(), said)));
        }
        (!whole.is_empty()).then_some(Json::Object(whole))
    }
}

/// Limits the required keys of a branch to values of the branch's type.
fn typed(demand: Json, branch: &Json) -> Json {
    match (demand, branch.get("type")) {
        (Json::Object(mut rules), Some(types)) => {
            rules.insert("type".to_owned(), types.clone());
            Json::Object(rules)
        }
        (demand, _) => demand,
    }
}

/// The variants of a `oneOf`, each with the one key that it requires; `None` if the branches are not of this form.
fn tagged(rules: &Map<String, Json>) -> Option<Vec<(&str, &Map<String, Json>)>> {
    let branches = rules.get("oneOf")?.as_array()?;
    branches
        .iter()
        .map(|branch| {
            let branch = branch.as_object()?;
            let properties = branch.get("properties")?.as_object()?;
            match branch.get("required")?.as_array()?.as_slice() {
                [key] if properties.len() == 1 => Some((key.as_str()?, branch)),
                _ => None,
            }
        })
        .collect()
}

/// The name of the definition that a schema refers to; `None` if it is not a reference.
fn definition_of(rules: &Map<String, Json>) -> Option<&str> {
    rules.get("$ref")?.as_str()?.strip_prefix("#/$defs/")
}

/// The names of the definitions that require a key, directly or through definitions that they refer to outside of
/// lists.
fn demanding(definitions: &Map<String, Json>) -> BTreeSet<String> {
    let mut demanding = BTreeSet::new();
    loop {
        let before = demanding.len();
        let parts = Parts { demanding: demanding.clone() };
        for (name, definition) in definitions {
            if parts.whole(definition).is_some() {
                demanding.insert(name.clone());
            }
        }
        if demanding.len() == before {
            return demanding;
        }
    }
}
