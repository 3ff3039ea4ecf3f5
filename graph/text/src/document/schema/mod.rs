//! Checks a spanned tree against a JSON Schema and reports every diagnostic at its place.
//!
//! The schemas come from `schemars`, that is, from the very types that the tree is decoded into afterwards; so what an
//! editor is told, what is checked here and what the decoder accepts are one thing. The dialect is the part of JSON
//! Schema 2020-12 that such schemas use: `type`, `properties`, `required`, `additionalProperties`,
//! `propertyNames.pattern` (names only), `pattern` (signs of strings only), `items`, `prefixItems`, `minItems`,
//! `maxItems`, `enum`, `const`, `minimum`, `maximum`, `exclusiveMinimum`, `anyOf`, `oneOf`, `allOf`, `$ref` into
//! `$defs`.
//!
//! Alternatives (`oneOf`, `anyOf`) give poor messages when every branch reports. Here the value chooses its branch
//! first: by its JSON type, then by the one key that the branch requires, then by the fewest diagnostics; only the
//! chosen branch reports.
//!
//! A [`Schema`] looks its rules up once, when it is made; a document that fits costs no allocation.
//!
//! Limits: it stops after [`MAX_DIAGNOSTICS`] diagnostics.

mod messages;
mod rules;

pub use messages::{unknown_key, unknown_word};
pub use rules::Schema;

use serde_json::Value as Json;

use super::{Entry, Kind, Pointer, Signs, Value, Written};
use crate::diagnostic::{Diagnostic, Diagnostics, MAX_DIAGNOSTICS, codes, list_of, suggested_name};
use messages::{KNOWN_ARE, joined, same_key, with_wrapper, wrong_type};
use rules::{Additional, Alternatives, Branch, Node, Required, Rules};

impl Schema {
    /// Checks `value` against the schema, and adds a diagnostic for each violation. `pointer` is the JSON pointer of
    /// the value.
    pub fn check(&self, value: &Value, pointer: &str, diagnostics: &mut Diagnostics) {
        let mut checker =
            Checker { schema: self, diagnostics, description: None, misplaced: Vec::new(), is_trial: false };
        checker.value(value, &self.start, &Pointer::Text(pointer), 0);
    }
}

struct Checker<'a, 'd> {
    schema: &'a Schema,
    diagnostics: &'d mut Diagnostics,
    /// The schema's description of the current value, or of the closest enclosing value with a description. `None` if
    /// there is none.
    description: Option<&'a str>,
    /// The unknown keys beside the current value, one of which may be meant for it.
    misplaced: Vec<String>,
    /// Whether the check only tries if a value would fit, so that nothing is suggested.
    is_trial: bool,
}

const MAX_REFERENCES: usize = 600;

/// The known key that an unknown key is about.
#[derive(Clone, Copy, PartialEq)]
enum Meant<'a> {
    /// The key under another name.
    Key(&'a str),
    /// The key whose object has the unknown key.
    Within(&'a str),
}

impl<'a> Checker<'a, '_> {
    fn value(&mut self, value: &Value, node: &'a Node, pointer: &Pointer<'_>, depth: usize) {
        let outer = self.description;
        self.description = node.description.as_deref().or(outer);
        if let Some(rules) = self.schema.rules(node) {
            self.checked(value, rules, pointer, depth);
        }
        self.description = outer;
    }

    fn checked(&mut self, value: &Value, rules: &'a Rules, pointer: &Pointer<'_>, depth: usize) {
        if depth > MAX_REFERENCES || self.diagnostics.len() >= MAX_DIAGNOSTICS {
            return;
        }
        // One of two keys that exclude one another goes: whatever else it lacks.
        if rules.one_key.iter().any(|keys| self.excludes(value, rules, keys, pointer)) {
            return;
        }
        if let Some(alternatives) = &rules.alternatives {
            self.alternatives(value, alternatives, pointer, depth);
            return;
        }
        for part in &rules.all_of {
            self.value(value, part, pointer, depth + 1);
        }
        if let Some(wanted) = &rules.types
            && !wanted.types.have(value)
        {
            let diagnostic = wrong_type(value, &wanted.names);
            let is_wanted = diagnostic.help.is_none() && !self.is_trial;
            let wrapped = if is_wanted { self.wrapped(value, rules, pointer) } else { None };
            let is_list_of_named = is_wanted
                && matches!((&value.kind, &rules.additional), (Kind::Array(_), Additional::Like(_)));
            let diagnostic = match pointer.to_string().rsplit('/').next() {
                Some(section) if is_list_of_named => {
                    let name = value.elements().and_then(|list| list.first()?.get("name")?.text());
                    let name = name.unwrap_or("NAME");
                    diagnostic.help(format!("\"{section}\" stand by their names: {{ \"{name}\": {{ … }} }}"))
                }
                _ => with_wrapper(diagnostic, value, wrapped),
            };
            self.push(diagnostic, pointer);
            return;
        }
        if let Some(words) = &rules.words {
            self.words(value, words, pointer);
        }
        if let Some(diagnostic) = rules.signs.and_then(|signs: Signs| signs.check(value)) {
            self.push(diagnostic, pointer);
        }
        match &value.kind {
            Kind::Number(number) => self.bounds(value, number.as_f64().unwrap_or(0.0), rules, pointer),
            Kind::Array(elements) => {
                self.length(value, elements.len(), rules, pointer);
                for (at, element) in elements.iter().enumerate() {
                    if let Some(rule) = rules.prefix.get(at).or(rules.items.as_ref()) {
                        self.value(element, rule, &pointer.element(at), depth + 1);
                    }
                }
            }
            Kind::Object(entries) => self.object(value, entries, rules, pointer, depth),
            _ => {}
        }
    }

    fn object(
        &mut self,
        value: &Value,
        entries: &[Entry],
        rules: &'a Rules,
        pointer: &Pointer<'_>,
        depth: usize,
    ) {
        let is_closed = matches!(rules.additional, Additional::None);
        let unknown = entries.iter().filter(|entry| is_closed && rules.property(&entry.key).is_none());
        let unknown: Vec<String> = unknown.map(|entry| entry.key.clone()).collect();
        let misplaced = std::mem::replace(&mut self.misplaced, unknown);
        for entry in entries {
            if self.diagnostics.len() >= MAX_DIAGNOSTICS {
                return;
            }
            let at = pointer.key(&entry.key);
            if let Some(rule) = rules.property(&entry.key) {
                self.value(&entry.value, rule, &at, depth + 1);
                continue;
            }
            match &rules.additional {
                Additional::Any => {}
                Additional::Like(rule) => self.value(&entry.value, rule, &at, depth + 1),
                Additional::None => self.unknown(entry, entries, rules, &at),
            }
        }
        self.misplaced = misplaced;
        for required in rules.required.iter().filter(|required| value.get(&required.key).is_none()) {
            // A misspelt key is reported as such; that the right one is missing only follows from it.
            let misspelt = entries.iter().filter(|entry| rules.property(&entry.key).is_none()).any(|entry| {
                suggested_name(&entry.key, [required.key.as_str()]).is_some()
                    || self.meant(entry, entries, rules).is_some_and(|meant| {
                        let (Meant::Key(key) | Meant::Within(key)) = meant;
                        key == required.key
                    })
            });
            // A key that stands beside the object has a diagnostic there.
            if !misspelt && !self.misplaced.contains(&required.key) {
                let key = &required.key;
                let message = format!("the key \"{key}\" is missing here");
                let mut diagnostic = Diagnostic::error(codes::MISSING_KEY, value.span, message);
                let words = rules.property(key).map(|node| self.words_of(node)).unwrap_or_default();
                diagnostic.help = match &required.description {
                    Some(text) => Some(format!("\"{key}\": {text}")),
                    None if words.is_empty() => None,
                    None => Some(format!("add \"{key}\": one of {}", list_of(words))),
                };
                self.push(diagnostic, pointer);
            }
        }
    }

    /// Returns the known key that an unknown key is about; `None` if it is about none, or only misspelt.
    fn meant(&self, entry: &Entry, entries: &[Entry], rules: &'a Rules) -> Option<Meant<'a>> {
        let keys = || rules.properties.iter().map(|(key, _)| key.as_str());
        if let Some(same) = same_key(&entry.key, keys()) {
            return Some(Meant::Key(same));
        }
        let holds = |key: &&str| {
            let inner = rules.property(key).and_then(|node| self.schema.rules(node));
            let owner = entries.iter().find(|owner| owner.key == **key);
            let can_own = match owner {
                Some(owner) => owner.value.entries().is_some(),
                None => rules.required.iter().any(|required| required.key == **key),
            };
            can_own && inner.is_some_and(|inner| inner.property(&entry.key).is_some())
        };
        let owner = keys().find(holds)?;
        suggested_name(&entry.key, keys()).is_none().then_some(Meant::Within(owner))
    }

    /// Reports an unknown key. Several keys that are about one known key have one diagnostic, at the first of them.
    fn unknown(&mut self, entry: &Entry, entries: &[Entry], rules: &'a Rules, pointer: &Pointer<'_>) {
        let meant = self.meant(entry, entries, rules);
        let is_twin = |other: &&Entry| {
            let is_unknown = rules.property(&other.key).is_none();
            is_unknown && meant.is_some() && self.meant(other, entries, rules) == meant
        };
        let twins: Vec<&Entry> = entries.iter().filter(is_twin).collect();
        if twins.first().is_some_and(|first| first.key_span != entry.key_span) {
            return;
        }
        let known: Vec<&str> = rules.properties.iter().map(|(key, _)| key.as_str()).collect();
        let mut diagnostic = unknown_key(entry, &known, entries);
        for twin in twins.iter().skip(1) {
            diagnostic = diagnostic.related(twin.key_span, "this too");
        }
        let is_there = |key: &str| entries.iter().any(|entry| entry.key == key);
        let names = || list_of(twins.iter().map(|twin| format!("\"{}\"", twin.key)));
        match meant {
            Some(Meant::Key(key)) if diagnostic.has_suggestion() => {
                if let Some(value) = joined(&twins) {
                    diagnostic =
                        diagnostic.help(format!("\"{key}\" stands for {}: \"{key}\": {value}", names()));
                } else if twins.len() > 1 {
                    diagnostic = diagnostic.help(format!("\"{key}\" stands for {}", names()));
                }
                if let ([one], false) = (&twins[..], is_there(key))
                    && rules.property(key).is_some_and(|node| self.fits(&one.value, node, pointer))
                {
                    diagnostic = diagnostic.fix(one.key_span, format!("\"{key}\""));
                }
            }
            Some(Meant::Within(key)) if is_there(key) => {
                diagnostic = diagnostic.help(format!("{} stands within \"{key}\": move it there", names()));
            }
            Some(Meant::Within(key)) => {
                diagnostic = diagnostic.help(format!("{} stands within \"{key}\": {{ … }}", names()));
                if let ([first, .., last] | [first @ last], true) = (&twins[..], twins.len() == entries.len())
                {
                    let end = last.value.span.range().len();
                    diagnostic = diagnostic
                        .fix(first.key_span.inside(0..0), format!("\"{key}\": {{ "))
                        .fix(last.value.span.inside(end..end), " }");
                }
            }
            _ => {}
        }
        self.push(diagnostic, pointer);
    }

    /// Returns the words that a value can be; empty if it can be something else than a word.
    fn words_of(&self, node: &'a Node) -> Vec<&'a str> {
        let Some(rules) = self.schema.rules(node) else { return Vec::new() };
        let own = rules.words.iter().flatten().filter_map(Json::as_str);
        let branches = rules.alternatives.iter().flat_map(|alternatives| &alternatives.branches);
        own.chain(branches.flat_map(|branch| branch.words.iter().map(String::as_str))).collect()
    }

    /// Checks that an object has exactly one of the keys `keys`. If the object has none of them but an unknown key,
    /// nothing is reported here: the unknown key is probably misspelt, and is reported itself. Returns `true` if the
    /// object has several.
    fn excludes(&mut self, value: &Value, rules: &Rules, keys: &[String], pointer: &Pointer<'_>) -> bool {
        let Some(entries) = value.entries() else { return false };
        let mut found = entries.iter().filter(|entry| keys.contains(&entry.key));
        match (found.next(), found.next()) {
            (Some(_), None) => {}
            (Some(first), Some(second)) => {
                let message = format!("\"{}\" and \"{}\" exclude one another", first.key, second.key);
                let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, second.key_span, message);
                let diagnostic = diagnostic
                    .related(first.key_span, "the first of the two")
                    .help("make it two, one for each");
                self.push(diagnostic, &pointer.key(&second.key));
                return true;
            }
            (None, _) => {
                if entries.iter().all(|entry| rules.property(&entry.key).is_some()) {
                    let message = "the key that says what this is is missing here";
                    let diagnostic = Diagnostic::error(codes::MISSING_KEY, value.span, message);
                    let known = format!("the keys that it can be are {}", list_of(keys));
                    self.push(diagnostic.help(known), pointer);
                }
            }
        }
        false
    }

    /// Returns the text to put before and after a value of the wrong type, so that it fits: brackets of a list, or an
    /// object with the one required key. `None` if neither makes it fit.
    fn wrapped(
        &self,
        value: &Value,
        rules: &'a Rules,
        pointer: &Pointer<'_>,
    ) -> Option<(String, &'static str)> {
        if self.is_trial {
            return None;
        }
        if let Some(items) = rules.items.as_ref().filter(|_| rules.min_items.is_none_or(|count| count <= 1)) {
            return self.fits(value, items, pointer).then(|| ("[".to_owned(), "]"));
        }
        let [Required { key, .. }] = rules.required.as_slice() else { return None };
        let is_text = value.text().is_some();
        let fits = is_text && self.fits(value, rules.property(key)?, pointer);
        fits.then(|| (format!("{{ \"{key}\": "), " }"))
    }

    /// Returns `true` if a value has no diagnostics by the rules of a node.
    fn fits(&self, value: &Value, node: &'a Node, pointer: &Pointer<'_>) -> bool {
        let mut diagnostics = Diagnostics::new();
        let mut checker = Checker {
            schema: self.schema,
            diagnostics: &mut diagnostics,
            description: None,
            misplaced: Vec::new(),
            is_trial: true,
        };
        checker.value(value, node, pointer, 0);
        diagnostics.is_empty()
    }

    fn words(&mut self, value: &Value, words: &[Json], pointer: &Pointer<'_>) {
        let is_known = match value.text() {
            Some(text) => words.iter().any(|word| word.as_str() == Some(text)),
            None => words.contains(&value.to_json()),
        };
        if !is_known {
            let words: Vec<&str> = words.iter().filter_map(Json::as_str).collect();
            self.push(unknown_word(value, &words), pointer);
        }
    }

    fn bounds(&mut self, value: &Value, number: f64, rules: &Rules, pointer: &Pointer<'_>) {
        let broken = match (rules.minimum, rules.maximum, rules.above) {
            (Some(lower), _, _) if number < lower => Some(format!("at least {lower}")),
            (_, Some(max_items), _) if number > max_items => Some(format!("at most {max_items}")),
            (_, _, Some(lower)) if number <= lower => Some(format!("above {lower}")),
            _ => None,
        };
        if let Some(limit) = broken {
            let message = format!("{number} is out of bounds: {limit} is wanted");
            self.push(Diagnostic::error(codes::OUT_OF_BOUNDS, value.span, message), pointer);
        }
    }

    fn length(&mut self, value: &Value, length: usize, rules: &Rules, pointer: &Pointer<'_>) {
        let broken = match (rules.min_items, rules.max_items) {
            (Some(lower), _) if (length as u64) < lower => Some(format!("at least {lower}")),
            (_, Some(max_items)) if length as u64 > max_items => Some(format!("at most {max_items}")),
            _ => None,
        };
        if let Some(limit) = broken {
            let message = format!("this list has {length} elements: {limit} are wanted");
            let diagnostic = Diagnostic::error(codes::OUT_OF_BOUNDS, value.span, message);
            let ones = ", 1".repeat(3_usize.saturating_sub(length));
            let written = value.to_json().to_string().replace(',', ", ");
            let is_count = pointer.to_string().ends_with("/workgroups") && (1..3).contains(&length);
            let help = is_count.then(|| format!("write {}{ones}]", written.trim_end_matches(']')));
            self.push(Diagnostic { help, ..diagnostic }, pointer);
        }
    }

    fn alternatives(
        &mut self,
        value: &Value,
        alternatives: &'a Alternatives,
        pointer: &Pointer<'_>,
        depth: usize,
    ) {
        if alternatives.takes_expressions && value.text().is_some_and(is_expression) {
            return;
        }
        let typed = || alternatives.branches.iter().filter(|branch| branch.could_be.have(value));
        let count = typed().count();
        if count == 0 {
            self.push(wrong_type(value, &alternatives.wanted), pointer);
            return;
        }
        if let Some(text) = value.text() {
            let words = || typed().flat_map(|branch| &branch.words).map(String::as_str);
            if words().count() >= count {
                if !words().any(|word| word == text) {
                    let mut diagnostic = unknown_word(value, &words().collect::<Vec<&str>>());
                    if alternatives.takes_expressions && text.contains(['?', '(', '!', '=', '&', '|']) {
                        let help = format!("an expression begins with \"=\": write \"={text}\"");
                        diagnostic = diagnostic.help(help);
                    } else if alternatives.takes_expressions
                        && diagnostic.help.as_ref().is_some_and(|help| help.starts_with(KNOWN_ARE))
                        && is_name(text)
                    {
                        // It may be the name of a parameter or derived value.
                        let known = diagnostic.help.take().unwrap_or_default();
                        let help = format!("{known}; an expression begins with \"=\": \"={text}\"");
                        diagnostic = diagnostic.help(help);
                    }
                    self.push(diagnostic, pointer);
                }
                return;
            }
        }
        if let Some(entries) = value.entries()
            && typed().all(|branch| branch.tag.is_some())
        {
            let tagged: Vec<(&str, &Branch)> =
                typed().filter_map(|branch| Some((branch.tag.as_deref()?, branch))).collect();
            self.tagged(value, entries, &tagged, pointer, depth);
            return;
        }
        let mut best: Option<Diagnostics> = None;
        for branch in typed() {
            let mut own_diagnostics = Diagnostics::new();
            let mut checker = Checker {
                schema: self.schema,
                diagnostics: &mut own_diagnostics,
                description: self.description,
                misplaced: self.misplaced.clone(),
                is_trial: self.is_trial,
            };
            checker.value(value, &branch.node, pointer, depth + 1);
            if own_diagnostics.is_empty() {
                return;
            }
            if best.as_ref().is_none_or(|best| own_diagnostics.len() < best.len()) {
                best = Some(own_diagnostics);
            }
        }
        self.diagnostics.extend(best.into_iter().flatten());
    }

    /// Checks an object against alternatives that each require a different key, the tag. The tag that the object has
    /// selects the alternative.
    fn tagged(
        &mut self,
        value: &Value,
        entries: &[Entry],
        tagged: &[(&str, &'a Branch)],
        pointer: &Pointer<'_>,
        depth: usize,
    ) {
        let mut chosen = tagged.iter().filter(|(tag, _)| value.get(tag).is_some());
        match (chosen.next(), chosen.next(), entries.first()) {
            (Some((_, branch)), None, _) => self.value(value, &branch.node, pointer, depth + 1),
            (None, _, Some(entry)) => {
                let known: Vec<&str> = tagged.iter().map(|(tag, _)| *tag).collect();
                let mut diagnostic = unknown_key(entry, &known, entries);
                let of_any_name = tagged.iter().find(|(tag, branch)| {
                    let tagged = self.schema.rules(&branch.node).and_then(|rules| rules.property(tag));
                    let rules = tagged.and_then(|node| self.schema.rules(node));
                    rules.is_some_and(|rules| matches!(rules.additional, Additional::Like(_)))
                });
                let owner = tagged.iter().filter_map(|(tag, branch)| {
                    let property = self.schema.rules(&branch.node)?.property(tag)?;
                    let fits = |entry: &Entry| self.schema.rules(property)?.property(&entry.key);
                    entries.iter().all(|entry| fits(entry).is_some()).then_some(*tag)
                });
                let mut owners = owner.take(2);
                if let (Some(tag), None, None) = (owners.next(), owners.next(), &diagnostic.fix) {
                    let help = format!("\"{}\" stands within \"{tag}\": {{ \"{tag}\": {{ … }} }}", entry.key);
                    let end = value.span.range().len();
                    diagnostic = diagnostic
                        .help(help)
                        .fix(value.span.inside(0..0), format!("{{ \"{tag}\": "))
                        .fix(value.span.inside(end..end), " }");
                } else if let (Some((tag, _)), None) = (of_any_name, &diagnostic.fix) {
                    let help = diagnostic.help.take().unwrap_or_default();
                    diagnostic.help = Some(format!("{help}; other names stand under \"{tag}\""));
                }
                self.push(diagnostic, &pointer.key(&entry.key));
            }
            _ => {
                let names: Vec<String> = tagged.iter().map(|(tag, _)| format!("\"{tag}\"")).collect();
                let message = format!("exactly one of {} is wanted here", list_of(names));
                self.push(Diagnostic::error(codes::MISSING_KEY, value.span, message), pointer);
            }
        }
    }

    /// Reports a diagnostic. Without a help text of its own, the first sentence of the schema's description becomes the
    /// help text.
    fn push(&mut self, diagnostic: Diagnostic, pointer: &Pointer<'_>) {
        let mut diagnostic = diagnostic.pointer(pointer);
        if diagnostic.help.is_none() {
            diagnostic.help = Some(match self.description.map(first_sentence) {
                Some(text) => format!("what belongs here: {text}"),
                None => "the schema says what belongs here".to_owned(),
            });
        }
        self.diagnostics.push(diagnostic);
    }
}

/// Returns the first sentence of a description on one line, without its full stop.
fn first_sentence(description: &str) -> String {
    let paragraph = description.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    let sentence = paragraph.split(". ").next().unwrap_or_default();
    sentence.trim_end_matches('.').to_owned()
}

fn is_expression(text: &str) -> bool {
    matches!(Written::of(text), Written::Expression(_))
}

/// Returns `true` if a string could be a name in an expression.
fn is_name(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && text.chars().all(|each| each.is_ascii_alphanumeric() || each == '_')
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

    fn diagnostics(text: &str) -> Vec<String> {
        let schema = schemars::schema_for!(Resource);
        let mut sources = Sources::new();
        let file = sources.add("t", text);
        let document = crate::document::parse(&sources, file).valid().unwrap();
        let mut diagnostics = Diagnostics::new();
        Schema::new(schema.as_value()).check(&document.root, "", &mut diagnostics);
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
    fn a_fitting_value_has_no_diagnostics() {
        assert_eq!(
            diagnostics(r#"{"texture": {"format": "depth32float", "size": [1, 2], "layers": 4}}"#),
            Vec::<String>::new()
        );
        assert_eq!(
            diagnostics(r#"{"texture": {"format": "depth32float", "size": "=viewport"}}"#),
            Vec::<String>::new()
        );
    }

    #[test]
    fn all_errors_come_at_once_and_a_misspelt_key_is_not_missing() {
        assert_eq!(
            diagnostics(r#"{"texture": {"fromat": "depth32float", "size": true, "layers": 9}}"#),
            [
                "UG0102 /texture/fromat unknown key \"fromat\" did you mean \"format\"?",
                "UG0105 /texture/size a string or an array is wanted here, this is a boolean the schema says what belongs here",
                "UG0108 /texture/layers 9 is out of bounds: at most 4 is wanted the schema says what belongs here",
            ]
        );
    }

    #[test]
    fn a_schema_of_lists_in_lists_is_tried_once() {
        let mut sources = Sources::new();
        let file = sources.add("t", "{}");
        let document = crate::document::parse(&sources, file).valid().unwrap();
        let schema = serde_json::json!({ "type": "array", "items": { "$ref": "#" } });
        let mut diagnostics = Diagnostics::new();
        Schema::new(&schema).check(&document.root, "", &mut diagnostics);
        assert_eq!(diagnostics.len(), 1);
    }

    #[test]
    fn the_tag_chooses_the_branch() {
        assert_eq!(
            diagnostics(r#"{"textur": {}}"#),
            ["UG0102 /textur unknown key \"textur\" did you mean \"texture\"?"]
        );
        assert_eq!(
            diagnostics(r#"{"texture": {"format": "depth32flaot", "size": [1]}}"#),
            [
                "UG0107 /texture/format \"depth32flaot\" is not known here did you mean \"depth32float\"?",
                "UG0108 /texture/size this list has 1 elements: at least 2 are wanted the schema says what belongs here",
            ]
        );
    }
}
