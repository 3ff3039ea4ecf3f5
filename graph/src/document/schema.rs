//! Checks a spanned tree against a JSON Schema and reports every finding at its place.
//!
//! The schemas come from `schemars`, that is, from the very types that the tree is decoded into afterwards; so what an
//! editor is told, what is checked here and what the decoder accepts are one thing. The dialect is the part of JSON
//! Schema 2020-12 that such schemas use: `type`, `properties`, `required`, `additionalProperties`,
//! `propertyNames.pattern` (names only), `items`, `prefixItems`, `minItems`, `maxItems`, `enum`, `const`, `minimum`,
//! `maximum`, `exclusiveMinimum`, `anyOf`, `oneOf`, `allOf`, `$ref` into `$defs`.
//!
//! Alternatives (`oneOf`, `anyOf`) give poor messages when every branch reports. Here the value chooses its branch
//! first: by its JSON type, then by the one key that the branch requires, then by the fewest findings; only the
//! chosen branch reports.
//!
//! Limits: it stops after [`MAXIMUM_FINDINGS`] findings.

use serde_json::Value as Json;

use super::{Kind, Value, pointer_join};
use crate::diagnostic::{Diagnostic, Diagnostics, MAXIMUM_FINDINGS, codes, did_you_mean};

/// Checks `value`, which stands at `pointer`, against `schema`; `$ref`s are looked up in `root`.
pub fn check<'a>(
    value: &Value,
    schema: &'a Json,
    root: &'a Json,
    pointer: &str,
    diagnostics: &mut Diagnostics,
) {
    Checker { root, diagnostics, descriptions: Vec::new() }.value(value, schema, pointer, 0);
}

struct Checker<'a, 'd> {
    root: &'a Json,
    diagnostics: &'d mut Diagnostics,
    /// What the schema says of the place at hand, and of those around it.
    descriptions: Vec<&'a str>,
}

const MAXIMUM_REFERENCES: usize = 600;

impl<'a> Checker<'a, '_> {
    fn value(&mut self, value: &Value, schema: &'a Json, pointer: &str, depth: usize) {
        let described = self.descriptions.len();
        self.descriptions.extend(schema.get("description").and_then(Json::as_str));
        self.checked(value, schema, pointer, depth);
        self.descriptions.truncate(described);
    }

    fn checked(&mut self, value: &Value, schema: &'a Json, pointer: &str, depth: usize) {
        let Some(schema) = resolve(schema, self.root) else { return };
        let Json::Object(rules) = schema else { return };
        if depth > MAXIMUM_REFERENCES || self.diagnostics.len() >= MAXIMUM_FINDINGS {
            return;
        }
        for word in ["oneOf", "anyOf"] {
            match rules.get(word) {
                Some(Json::Array(branches)) if rules.contains_key("properties") => {
                    self.exactly_one_key(value, rules, branches, pointer);
                }
                Some(Json::Array(branches)) => {
                    self.alternatives(value, branches, pointer, depth);
                    return;
                }
                _ => {}
            }
        }
        if let Some(Json::Array(all)) = rules.get("allOf") {
            for part in all {
                self.value(value, part, pointer, depth + 1);
            }
        }
        if let Some(types) = rules.get("type")
            && !type_matches(value, types)
        {
            let wanted = type_names(types);
            self.push(
                Diagnostic::error(
                    codes::WRONG_TYPE,
                    value.span,
                    format!("{wanted} is wanted here, this is {}", value.kind_name()),
                ),
                pointer,
            );
            return;
        }
        self.words(value, rules, pointer);
        match &value.kind {
            Kind::Number(number) => self.bounds(value, number.as_f64().unwrap_or(0.0), rules, pointer),
            Kind::Array(elements) => {
                self.length(value, elements.len(), rules, pointer);
                let prefix = rules.get("prefixItems").and_then(Json::as_array);
                for (at, element) in elements.iter().enumerate() {
                    let rule = prefix.and_then(|prefix| prefix.get(at)).or_else(|| rules.get("items"));
                    if let Some(rule) = rule {
                        self.value(element, rule, &format!("{pointer}/{at}"), depth + 1);
                    }
                }
            }
            Kind::Object(_) => self.object(value, rules, pointer, depth),
            _ => {}
        }
    }

    fn object(
        &mut self,
        value: &Value,
        rules: &'a serde_json::Map<String, Json>,
        pointer: &str,
        depth: usize,
    ) {
        let entries = value.entries().unwrap_or_default();
        let properties = rules.get("properties").and_then(Json::as_object);
        let additional = rules.get("additionalProperties");
        for entry in entries {
            if self.diagnostics.len() >= MAXIMUM_FINDINGS {
                return;
            }
            let at = pointer_join(pointer, &entry.key);
            if let Some(rule) = properties.and_then(|properties| properties.get(&entry.key)) {
                self.value(&entry.value, rule, &at, depth + 1);
            } else if additional == Some(&Json::Bool(false)) {
                let known: Vec<&str> =
                    properties.map(|map| map.keys().map(String::as_str).collect()).unwrap_or_default();
                // A key that is there already is not what was meant: the fix would make it stand twice.
                let free: Vec<&str> =
                    known.iter().copied().filter(|name| value.get(name).is_none()).collect();
                let mut finding = unknown_key(entry, &known);
                finding.fix = unknown_key(entry, &free).fix.filter(|fix| Some(fix) == finding.fix.as_ref());
                self.push(finding, &at);
            } else if let Some(rule @ Json::Object(_)) = additional {
                self.value(&entry.value, rule, &at, depth + 1);
            }
        }
        for required in
            rules.get("required").and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str)
        {
            // A misspelt key is reported as such; that the right one is missing only follows from it.
            let misspelt = entries.iter().any(|entry| {
                properties.is_some_and(|properties| !properties.contains_key(&entry.key))
                    && did_you_mean(&entry.key, [required]).is_some()
            });
            if value.get(required).is_none() && !misspelt {
                let description = properties
                    .and_then(|properties| properties.get(required))
                    .and_then(|property| resolve(property, self.root).or(Some(property)))
                    .and_then(|property| property.get("description"))
                    .and_then(Json::as_str)
                    .and_then(|text| text.lines().next())
                    .map(|text| format!("\"{required}\": {text}"));
                let mut finding = Diagnostic::error(
                    codes::MISSING_KEY,
                    value.span,
                    format!("the key \"{required}\" is missing here"),
                );
                finding.help = description;
                self.push(finding, pointer);
            }
        }
    }

    /// Alternatives beside `properties` that each require one key: exactly one of them is there. Where a key is unknown
    /// it is probably the one, misspelt, and reported as such.
    fn exactly_one_key(
        &mut self,
        value: &Value,
        rules: &serde_json::Map<String, Json>,
        branches: &[Json],
        pointer: &str,
    ) {
        let Some(entries) = value.entries() else { return };
        let keys: Vec<&str> = branches
            .iter()
            .filter_map(|branch| branch.get("required")?.as_array()?.first()?.as_str())
            .collect();
        let found: Vec<&super::Entry> =
            entries.iter().filter(|entry| keys.contains(&entry.key.as_str())).collect();
        let properties = rules.get("properties").and_then(Json::as_object);
        let all_known = entries
            .iter()
            .all(|entry| properties.is_some_and(|properties| properties.contains_key(&entry.key)));
        let known = format!("the keys that it can be are {}", keys.join(", "));
        match found.as_slice() {
            [_] => {}
            [] if all_known => {
                let message = "the key that says what this is is missing here";
                self.push(Diagnostic::error(codes::MISSING_KEY, value.span, message).help(known), pointer);
            }
            [] => {}
            [first, second, ..] => {
                let message = format!("\"{}\" and \"{}\" exclude one another", first.key, second.key);
                let finding = Diagnostic::error(codes::UNKNOWN_KEY, second.key_span, message);
                let finding =
                    finding.related(first.key_span, "the first of the two").help("make it two, one for each");
                self.push(finding, &pointer_join(pointer, &second.key));
            }
        }
    }

    fn unknown_key(&mut self, entry: &super::Entry, known: &[&str], pointer: &str) {
        self.push(unknown_key(entry, known), pointer);
    }

    fn words(&mut self, value: &Value, rules: &serde_json::Map<String, Json>, pointer: &str) {
        let words: Vec<&Json> = match (rules.get("enum"), rules.get("const")) {
            (Some(Json::Array(words)), _) => words.iter().collect(),
            (_, Some(word)) => vec![word],
            _ => return,
        };
        if words.contains(&&value.to_json()) {
            return;
        }
        self.push(
            unknown_word(value, &words.iter().filter_map(|word| word.as_str()).collect::<Vec<_>>()),
            pointer,
        );
    }

    fn bounds(&mut self, value: &Value, number: f64, rules: &serde_json::Map<String, Json>, pointer: &str) {
        let limit = |name: &str| rules.get(name).and_then(Json::as_f64);
        let broken = match (limit("minimum"), limit("maximum"), limit("exclusiveMinimum")) {
            (Some(least), _, _) if number < least => Some(format!("at least {least}")),
            (_, Some(most), _) if number > most => Some(format!("at most {most}")),
            (_, _, Some(least)) if number <= least => Some(format!("above {least}")),
            _ => None,
        };
        if let Some(limit) = broken {
            self.push(
                Diagnostic::error(
                    codes::OUT_OF_BOUNDS,
                    value.span,
                    format!("{number} is out of bounds: {limit} is wanted"),
                ),
                pointer,
            );
        }
    }

    fn length(&mut self, value: &Value, length: usize, rules: &serde_json::Map<String, Json>, pointer: &str) {
        let limit = |name: &str| rules.get(name).and_then(Json::as_u64);
        let broken = match (limit("minItems"), limit("maxItems")) {
            (Some(least), _) if (length as u64) < least => Some(format!("at least {least}")),
            (_, Some(most)) if length as u64 > most => Some(format!("at most {most}")),
            _ => None,
        };
        if let Some(limit) = broken {
            let message = format!("this list has {length} elements: {limit} are wanted");
            self.push(Diagnostic::error(codes::OUT_OF_BOUNDS, value.span, message), pointer);
        }
    }

    fn alternatives(&mut self, value: &Value, branches: &'a [Json], pointer: &str, depth: usize) {
        let mut flat = Vec::new();
        flatten(branches, self.root, &mut flat, 0);
        let is_expression = |branch: &&Json| branch.get("pattern").and_then(Json::as_str) == Some("^=");
        if flat.iter().any(is_expression) && value.text().is_some_and(|text| text.starts_with('=')) {
            return;
        }
        let branches: Vec<&Json> = flat.into_iter().filter(|branch| !is_expression(branch)).collect();
        let typed: Vec<&Json> =
            branches.iter().copied().filter(|branch| could_be(value, branch, self.root, 0)).collect();
        if typed.is_empty() {
            let mut names: Vec<String> = Vec::new();
            branches.iter().for_each(|branch| collect_type_names(branch, self.root, &mut names, 0));
            let wanted = join_or(&names);
            self.push(
                Diagnostic::error(
                    codes::WRONG_TYPE,
                    value.span,
                    format!("{wanted} is wanted here, this is {}", value.kind_name()),
                ),
                pointer,
            );
            return;
        }
        if let Kind::Text(_) = value.kind {
            let words: Vec<&str> = typed.iter().flat_map(|branch| branch_words(branch)).collect();
            if words.len() >= typed.len() && !words.is_empty() {
                if !words.iter().any(|word| Some(*word) == value.text()) {
                    self.push(unknown_word(value, &words), pointer);
                }
                return;
            }
        }
        if let Some(entries) = value.entries() {
            let tagged: Vec<(&str, &Json)> =
                typed.iter().filter_map(|branch| Some((tag(branch)?, *branch))).collect();
            if tagged.len() == typed.len() && !tagged.is_empty() {
                let chosen: Vec<_> = tagged.iter().filter(|(tag, _)| value.get(tag).is_some()).collect();
                if let [(_, branch)] = chosen.as_slice() {
                    self.value(value, branch, pointer, depth + 1);
                } else if chosen.is_empty()
                    && let Some(entry) = entries.first()
                {
                    let known: Vec<&str> = tagged.iter().map(|(tag, _)| *tag).collect();
                    self.unknown_key(entry, &known, &pointer_join(pointer, &entry.key));
                } else {
                    let names: Vec<String> = tagged.iter().map(|(tag, _)| format!("\"{tag}\"")).collect();
                    let message = format!("exactly one of {} is wanted here", names.join(", "));
                    self.push(Diagnostic::error(codes::MISSING_KEY, value.span, message), pointer);
                }
                return;
            }
        }
        let mut best: Option<Diagnostics> = None;
        for branch in typed {
            let mut findings = Diagnostics::new();
            Checker { root: self.root, diagnostics: &mut findings, descriptions: self.descriptions.clone() }
                .value(value, branch, pointer, depth + 1);
            if findings.is_empty() {
                return;
            }
            if best.as_ref().is_none_or(|best| findings.len() < best.len()) {
                best = Some(findings);
            }
        }
        self.diagnostics.extend(best.into_iter().flatten());
    }

    /// Reports a finding; one without a help of its own gets the first line of what the schema says of the place.
    fn push(&mut self, diagnostic: Diagnostic, pointer: &str) {
        let mut diagnostic = diagnostic.pointer(pointer);
        if diagnostic.help.is_none() {
            let description = self.descriptions.last().and_then(|text| text.lines().next());
            diagnostic.help = Some(match description {
                Some(text) => format!("what belongs here: {}", text.trim_end_matches('.')),
                None => "the schema says what belongs here".to_owned(),
            });
        }
        self.diagnostics.push(diagnostic);
    }
}

/// The finding for a key that is none of the known ones.
pub fn unknown_key(entry: &super::Entry, known: &[&str]) -> Diagnostic {
    let finding =
        Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, format!("unknown key \"{}\"", entry.key));
    match did_you_mean(&entry.key, known.iter().copied()) {
        Some(meant) => {
            let finding = finding.help(format!("did you mean \"{meant}\"?"));
            finding.fix_name(entry.key_span, &entry.key, known.iter().copied())
        }
        None if known.is_empty() => finding.help("no keys are known here"),
        None => finding.help(format!("the keys known here are {}", known.join(", "))),
    }
}

/// The finding for a text that is none of the known words.
pub fn unknown_word(value: &Value, words: &[&str]) -> Diagnostic {
    let found = value.text().map_or_else(|| value.kind_name().to_owned(), |text| format!("\"{text}\""));
    let finding = Diagnostic::error(codes::UNKNOWN_WORD, value.span, format!("{found} is not known here"));
    match value.text().and_then(|text| did_you_mean(text, words.iter().copied())) {
        Some(meant) => {
            let finding = finding.help(format!("did you mean \"{meant}\"?"));
            finding.fix_name(value.span, value.text().unwrap_or_default(), words.iter().copied())
        }
        None if words.len() <= 24 => finding.help(format!("known are {}", words.join(", "))),
        None => finding.help("see the schema for the words known here"),
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

/// The branches of alternatives, with alternatives inside them and references taken apart.
fn flatten<'a>(branches: &'a [Json], root: &'a Json, flat: &mut Vec<&'a Json>, depth: usize) {
    for branch in branches.iter().filter_map(|branch| resolve(branch, root)) {
        let inner = ["oneOf", "anyOf"].iter().find_map(|word| branch.get(word).and_then(Json::as_array));
        match inner {
            Some(inner)
                if !branch.as_object().is_some_and(|rules| rules.contains_key("properties"))
                    && depth < 32 =>
            {
                flatten(inner, root, flat, depth + 1);
            }
            _ => flat.push(branch),
        }
    }
}

fn type_matches(value: &Value, types: &Json) -> bool {
    match types {
        Json::String(name) => {
            matches!(
                (&value.kind, name.as_str()),
                (Kind::Null, "null")
                    | (Kind::Bool(_), "boolean")
                    | (Kind::Number(_), "number")
                    | (Kind::Text(_), "string")
                    | (Kind::Array(_), "array")
                    | (Kind::Object(_), "object")
            ) || (name == "integer"
                && matches!(&value.kind, Kind::Number(number) if number.as_f64().is_some_and(|n| n.fract() == 0.0)))
        }
        // An option's null stands for a key that is left out; written null is not meant.
        Json::Array(names) => {
            names.iter().filter(|name| name.as_str() != Some("null")).any(|name| type_matches(value, name))
        }
        _ => true,
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
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}

/// Whether a value's JSON type fits a branch, as far as its type says.
fn could_be(value: &Value, branch: &Json, root: &Json, depth: usize) -> bool {
    if depth > 32 {
        return true;
    }
    if let Some(types) = branch.get("type") {
        return type_matches(value, types);
    }
    for word in ["oneOf", "anyOf"] {
        if let Some(Json::Array(branches)) = branch.get(word) {
            return branches
                .iter()
                .filter_map(|branch| resolve(branch, root))
                .any(|branch| could_be(value, branch, root, depth + 1));
        }
    }
    match branch.get("const") {
        Some(constant) => std::mem::discriminant(constant) == std::mem::discriminant(&value.to_json()),
        None => true,
    }
}

fn collect_type_names(branch: &Json, root: &Json, names: &mut Vec<String>, depth: usize) {
    if let Some(types) = branch.get("type") {
        let name = type_names(types);
        if !names.contains(&name) && name != "null" {
            names.push(name);
        }
    }
    for word in ["oneOf", "anyOf"] {
        for inner in branch.get(word).and_then(Json::as_array).into_iter().flatten().filter(|_| depth < 32) {
            if let Some(inner) = resolve(inner, root) {
                collect_type_names(inner, root, names, depth + 1);
            }
        }
    }
}

/// The words that a branch accepts, if it is an enumeration of texts.
fn branch_words(branch: &Json) -> Vec<&str> {
    match (branch.get("enum"), branch.get("const")) {
        (Some(Json::Array(words)), _) => words.iter().filter_map(Json::as_str).collect(),
        (_, Some(Json::String(word))) => vec![word],
        _ => Vec::new(),
    }
}

/// The one key that a branch requires, if it is an externally tagged variant.
fn tag(branch: &Json) -> Option<&str> {
    match branch.get("required")?.as_array()?.as_slice() {
        [one] if branch.get("properties")?.as_object()?.len() == 1 => one.as_str(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;
    use schemars::JsonSchema;

    #[derive(JsonSchema)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Texture {
        format: Format,
        #[schemars(range(min = 1, max = 4))]
        layers: Option<u32>,
        size: Size,
    }

    #[derive(JsonSchema)]
    #[serde(untagged)]
    #[allow(dead_code)]
    enum Size {
        Text(String),
        Pair(#[schemars(length(min = 2, max = 2))] Vec<f64>),
    }

    #[derive(JsonSchema)]
    #[serde(rename_all = "lowercase")]
    #[allow(dead_code)]
    enum Format {
        Depth32float,
        Rgba8unorm,
    }

    #[derive(JsonSchema)]
    #[serde(rename_all = "lowercase")]
    #[allow(dead_code)]
    enum Resource {
        Texture(Texture),
        Buffer(Vec<u32>),
    }

    fn findings(text: &str) -> Vec<String> {
        let mut sources = Sources::new();
        let file = sources.add("t", text);
        let document = super::super::parse(&sources, file).unwrap();
        let schema = schemars::schema_for!(Resource);
        let mut diagnostics = Diagnostics::new();
        check(&document.root, schema.as_value(), schema.as_value(), "", &mut diagnostics);
        diagnostics
            .iter()
            .map(|d| {
                format!("{} {} {} {}", d.code, d.pointer, d.message, d.help.clone().unwrap_or_default())
                    .trim()
                    .to_owned()
            })
            .collect()
    }

    #[test]
    fn a_fitting_value_has_no_findings() {
        assert_eq!(
            findings(r#"{"texture": {"format": "depth32float", "size": [1, 2], "layers": 4}}"#),
            Vec::<String>::new()
        );
        assert_eq!(
            findings(r#"{"texture": {"format": "depth32float", "size": "viewport"}}"#),
            Vec::<String>::new()
        );
    }

    #[test]
    fn all_findings_are_reported_at_once_and_a_misspelt_key_is_not_also_missing() {
        assert_eq!(
            findings(r#"{"texture": {"fromat": "depth32float", "size": true, "layers": 9}}"#),
            [
                "UG0102 /texture/fromat unknown key \"fromat\" did you mean \"format\"?",
                "UG0105 /texture/size a string or an array is wanted here, this is a boolean the schema says what belongs here",
                "UG0108 /texture/layers 9 is out of bounds: at most 4 is wanted the schema says what belongs here",
            ]
        );
    }

    #[test]
    fn the_tag_chooses_the_branch() {
        assert_eq!(
            findings(r#"{"textur": {}}"#),
            ["UG0102 /textur unknown key \"textur\" did you mean \"texture\"?"]
        );
        assert_eq!(
            findings(r#"{"texture": {"format": "depth32flaot", "size": [1]}}"#),
            [
                "UG0107 /texture/format \"depth32flaot\" is not known here did you mean \"depth32float\"?",
                "UG0108 /texture/size this list has 1 elements: at least 2 are wanted the schema says what belongs here",
            ]
        );
    }
}
