//! The file `NAME.axes.json` to [`Axes`].
//!
//! The spanned tree is read by hand, so that every diagnostic has its place and none hides another. Conditions are read
//! last, when all axes of the file are known; a condition on an inherited axis is kept as text until the inherited
//! templates are there (see [`Declaration::resolve`]).

use std::collections::BTreeSet;

use super::axis::{Axis, AxisKind, AxisMode};
use super::condition::Condition;
use super::constraint::{Constraint, Rule};
use super::set::{Axes, Lost};
use crate::codes;
use umbragraph_text::diagnostic::{AxisValue, Diagnostic, Diagnostics, list_of};
use umbragraph_text::document::schema::{unknown_key, unknown_word};
use umbragraph_text::document::{Entry, Value};
use umbragraph_text::language::parse_format;
use umbragraph_text::source::{FileId, Sources, Span};

/// One parsed file `NAME.axes.json`: its axes, and constraints whose conditions are still unparsed strings.
#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    pub(crate) file: FileId,
    pub(crate) axes: Axes,
    constraints: Vec<WrittenConstraint>,
}

#[derive(Clone, Debug)]
struct WrittenConstraint {
    span: Span,
    when: Option<WrittenCondition>,
    /// The rules of the constraint: a key (`requires`, `excludes` or `one_of`) with its conditions.
    rules: Vec<(&'static str, Vec<WrittenCondition>)>,
}

#[derive(Clone, Debug)]
struct WrittenCondition {
    text: String,
    span: Span,
}

/// Parses a file of axes. Returns everything that is valid, and adds all errors to `diagnostics`.
pub(crate) fn parse(sources: &Sources, file: FileId, diagnostics: &mut Diagnostics) -> Declaration {
    let document = match umbragraph_text::document::parse(sources, file).valid() {
        Ok(document) => document,
        Err(own_diagnostics) => {
            diagnostics.extend(own_diagnostics.iter().cloned());
            return Declaration::unreadable(file, own_diagnostics);
        }
    };
    let declaration = Declaration { file, axes: Axes::default(), constraints: Vec::new() };
    let mut reader = Reader { diagnostics, declaration };
    reader.root(&document.root);
    reader.declaration
}

impl Declaration {
    /// An empty declaration for a file that cannot be parsed; `why` holds the errors.
    pub(crate) fn unreadable(file: FileId, why: impl IntoIterator<Item = Diagnostic>) -> Self {
        let lost = Lost { names: BTreeSet::new(), diagnostics: why.into_iter().collect() };
        Self { file, axes: Axes { lost, ..Axes::default() }, constraints: Vec::new() }
    }

    /// Parses the conditions of this file's constraints, and puts these constraints before those in `axes`. `axes`
    /// holds the file's own and inherited axes.
    pub(crate) fn resolve(&self, axes: &mut Axes, diagnostics: &mut Vec<Diagnostic>) {
        let mut own = Vec::new();
        for written in &self.constraints {
            let mut complete = true;
            let mut read = |conditions: &[WrittenCondition]| -> Vec<Condition> {
                let mut sound = Vec::new();
                for written in conditions {
                    match read_condition(written, axes) {
                        Ok(condition) => sound.push(condition),
                        Err(diagnostic) => {
                            complete = false;
                            if !axes.lost.names.contains(Condition::split(&written.text).0) {
                                diagnostics.push(*diagnostic);
                            }
                        }
                    }
                }
                sound
            };
            let when = written.when.as_ref().map(|when| read(std::slice::from_ref(when)));
            let rules: Vec<_> = written.rules.iter().map(|(key, list)| (*key, read(list))).collect();
            if !complete {
                continue;
            }
            let when = when.and_then(|mut list| list.pop());
            own.extend(rules.into_iter().map(|(key, list)| {
                let rule = match key {
                    "requires" => Rule::Requires { when: when.clone(), all: list },
                    "excludes" => Rule::Excludes { when: when.clone(), none: list },
                    _ => Rule::OneOf(list),
                };
                Constraint { rule, span: written.span }
            }));
        }
        own.append(&mut axes.constraints);
        axes.constraints = own;
    }
}

fn read_condition(written: &WrittenCondition, axes: &Axes) -> Result<Condition, Box<Diagnostic>> {
    let (name, _, _) = Condition::split(&written.text);
    let Some(axis) = axes.get(name) else {
        let message = format!(
            "the condition \"{}\" is about \"{name}\", which is no axis of this template",
            written.text
        );
        let diagnostic = Diagnostic::error(codes::AXIS_DECLARATION, written.span, message);
        let at = written.text.find(name).unwrap_or_default();
        let span = written.span.of_quoted(&written.text, at..at + name.len());
        return Err(Box::new(diagnostic.suggest(name, axes.names(), span, |_| {
            "declare the axis here, or inherit the template that declares it".to_owned()
        })));
    };
    Condition::read(&written.text, axis)
        .map_err(|message| Box::new(Diagnostic::error(codes::AXIS_DECLARATION, written.span, message)))
}

struct Reader<'a> {
    diagnostics: &'a mut Diagnostics,
    declaration: Declaration,
}

impl Reader<'_> {
    fn wrong(&mut self, span: Span, message: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(codes::AXIS_DECLARATION, span, message));
    }

    fn wrong_with(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.diagnostics.push(Diagnostic::error(codes::AXIS_DECLARATION, span, message).help(help));
    }

    fn entries<'v>(&mut self, value: &'v Value, what: &str) -> &'v [Entry] {
        value.entries().unwrap_or_else(|| {
            self.wrong(value.span, format!("{what} is an object, not {}", value.kind_name()));
            &[]
        })
    }

    /// Reports entries of an object with other keys than `keys`. Returns `None` if the value is not an object.
    fn known_keys(&mut self, value: &Value, what: &str, keys: &[&str]) -> Option<()> {
        let entries = self.entries(value, what);
        for entry in entries.iter().filter(|entry| !keys.contains(&entry.key.as_str())) {
            self.diagnostics.push(unknown_key(entry, keys, entries));
        }
        value.entries().map(|_| ())
    }

    fn elements<'v>(&mut self, value: &'v Value, what: &str) -> &'v [Value] {
        value.elements().unwrap_or_else(|| {
            self.wrong(value.span, format!("{what} is an array, not {}", value.kind_name()));
            &[]
        })
    }

    fn text<'v>(&mut self, value: &'v Value, what: &str) -> Option<&'v str> {
        if value.text().is_none() {
            self.wrong(value.span, format!("{what} is a string, not {}", value.kind_name()));
        }
        value.text()
    }

    /// Returns the string if it is one of `words`; otherwise reports an error and returns `None`.
    fn word<'v>(&mut self, value: &'v Value, words: &[&str]) -> Option<&'v str> {
        let word = value.text().filter(|word| words.contains(word));
        if word.is_none() {
            self.diagnostics.push(unknown_word(value, words));
        }
        word
    }

    fn root(&mut self, root: &Value) {
        const KEYS: &[&str] = &["$schema", "description", "inherits", "axes", "constraints"];
        for entry in self.entries(root, "a declaration of axes") {
            match entry.key.as_str() {
                "$schema" | "description" => {
                    self.text(&entry.value, &entry.key);
                }
                "inherits" => {
                    for element in self.elements(&entry.value, "\"inherits\"") {
                        if let Some(name) = self.text(element, "the name of a template") {
                            self.declaration.axes.inherits.push((name.to_owned(), element.span));
                        }
                    }
                }
                "axes" => {
                    for axis in self.entries(&entry.value, "\"axes\"") {
                        let before = self.diagnostics.len();
                        if self.axis(axis).is_none() {
                            let lost = &mut self.declaration.axes.lost;
                            lost.names.insert(axis.key.clone());
                            lost.diagnostics.extend(self.diagnostics.iter().skip(before).cloned());
                        }
                    }
                }
                "constraints" => {
                    for constraint in self.elements(&entry.value, "\"constraints\"") {
                        self.constraint(constraint);
                    }
                }
                _ => {
                    let mut unknown = unknown_key(entry, KEYS, root.entries().unwrap_or_default());
                    if entry.value.get("type").is_some() && !unknown.has_suggestion() {
                        let key = &entry.key;
                        unknown = unknown.help(format!(
                            "axes stand under \"axes\": {{ \"axes\": {{ \"{key}\": {{ \"type\": … }} }} }}"
                        ));
                        let lost = &mut self.declaration.axes.lost;
                        lost.names.insert(key.clone());
                        lost.diagnostics.push(unknown.clone());
                    }
                    self.diagnostics.push(unknown);
                }
            }
        }
    }

    /// Parses and stores one axis; `None` if its declaration is invalid.
    fn axis(&mut self, entry: &Entry) -> Option<()> {
        const KEYS: &[&str] = &[
            "type",
            "default",
            "description",
            "values",
            "min",
            "max",
            "prove",
            "as",
            "own_layout",
            "from",
            "requires",
            "excludes",
        ];
        let name = entry.key.as_str();
        if !is_identifier(name) {
            self.wrong(
                entry.key_span,
                format!("\"{name}\" is no identifier: a letter, then letters, digits and \"_\""),
            );
            return None;
        }
        self.known_keys(&entry.value, "an axis", KEYS)?;
        let kind = self.kind(entry)?;
        let mode = self.mode(entry, &kind);
        let ends = self.ends(entry);
        let own_layout = self.own_layout(entry, mode);
        let from_target = self.follows_target(entry, &kind, mode);
        let default = self.default(entry, &kind);
        let description =
            entry.value.get("description").and_then(|value| self.text(value, "\"description\""));
        let description = description.unwrap_or_default().to_owned();
        if entry.value.get("requires").is_some() || entry.value.get("excludes").is_some() {
            self.short_constraint(entry, &kind);
        }
        let (default, mode) = (default?, mode?);
        let span = entry.key_span;
        let name = name.to_owned();
        let axis = Axis { name, kind, default, description, mode, ends, own_layout, from_target, span };
        self.declaration.axes.axes.insert(axis.name.clone(), axis);
        Some(())
    }

    fn kind(&mut self, entry: &Entry) -> Option<AxisKind> {
        const TYPES: &[&str] = &["bool", "enum", "integer", "texture_format"];
        let written = self.required(entry, "axis", "type")?;
        let unknown = unknown_word(written, TYPES);
        if let Some(meant) = written.text().and_then(meant_type).filter(|_| !unknown.has_suggestion()) {
            let unknown = unknown.help(format!("did you mean \"{meant}\"?"));
            self.diagnostics.push(unknown.fix(written.span, format!("\"{meant}\"")));
            return None;
        }
        let kind = self.word(written, TYPES)?;
        let allowed: &[&str] = match kind {
            "enum" | "texture_format" => &["values"],
            "integer" => &["min", "max", "prove"],
            _ => &[],
        };
        for key in ["values", "min", "max", "prove"] {
            if let (false, Some(member)) = (allowed.contains(&key), entry.value.entry(key)) {
                let message = format!("\"{key}\" means nothing for an axis of type \"{kind}\"");
                self.wrong(member.key_span, message);
            }
        }
        match kind {
            "integer" => {
                let (min, max) = (self.integer(entry, "min")?, self.integer(entry, "max")?);
                let place = entry.value.get("min").map_or(entry.value.span, |min| min.span);
                if min > max {
                    let message = format!("\"min\" ({min}) is larger than \"max\" ({max})");
                    self.wrong_with(place, message, format!("write \"min\": {max}, \"max\": {min}"));
                    return None;
                }
                if max.abs_diff(min) >= 1 << 32 {
                    let message = format!("the range {min} to {max} has more than 2^32 values");
                    self.wrong_with(place, message, "raise \"min\" or lower \"max\"");
                    return None;
                }
                Some(AxisKind::Integer { min, max })
            }
            "enum" => self.values(entry, false).map(AxisKind::Enum),
            "texture_format" => self.values(entry, true).map(AxisKind::TextureFormat),
            _ => Some(AxisKind::Bool),
        }
    }

    fn required<'v>(&mut self, entry: &'v Entry, what: &str, key: &str) -> Option<&'v Value> {
        let value = entry.value.get(key);
        if value.is_none() {
            let help = match key {
                "type" => "write \"type\": \"bool\", \"enum\", \"integer\" or \"texture_format\"",
                "values" if entry.value.get("type").and_then(Value::text) == Some("texture_format") => {
                    "list the formats: \"values\": [\"rgba16float\", \"rgba8unorm\"]"
                }
                "values" => "list the words: \"values\": [\"low\", \"high\"]",
                _ => "write the range of the axis: \"min\": 1, \"max\": 8",
            };
            self.wrong_with(entry.key_span, format!("the {what} \"{}\" has no \"{key}\"", entry.key), help);
        }
        value
    }

    fn integer(&mut self, entry: &Entry, key: &str) -> Option<i64> {
        let value = self.required(entry, "integer axis", key)?;
        let number = value.decode().ok();
        if number.is_none() {
            self.wrong(value.span, format!("\"{key}\" is an integer of 64 bits"));
        }
        number
    }

    fn values(&mut self, entry: &Entry, formats: bool) -> Option<Vec<String>> {
        let list = self.required(entry, "axis", "values")?;
        let mut names: Vec<String> = Vec::new();
        for element in self.elements(list, "\"values\"") {
            let Some(name) = self.text(element, "a value") else { continue };
            if names.iter().any(|known| known == name) {
                self.wrong(element.span, format!("the value \"{name}\" stands twice"));
            } else if formats && parse_format(name).is_none() {
                self.wrong(element.span, format!("\"{name}\" is not a texture format of WebGPU"));
            } else if !formats && !is_word(name) {
                self.wrong(element.span, format!("\"{name}\" is no name: letters, digits, \"_\" and \"-\""));
            } else {
                names.push(name.to_owned());
            }
        }
        if names.is_empty() {
            self.wrong(list.span, format!("the axis \"{}\" has no values", entry.key));
            return None;
        }
        Some(names)
    }

    fn mode(&mut self, entry: &Entry, kind: &AxisKind) -> Option<AxisMode> {
        let Some(written) = entry.value.get("as") else { return Some(AxisMode::Template) };
        match (self.word(written, &["template", "override"])?, kind) {
            ("template", _) => Some(AxisMode::Template),
            (_, AxisKind::Bool | AxisKind::Integer { .. }) => Some(AxisMode::Override),
            _ => {
                let message = "an override is a boolean or an integer; names exist in templates only";
                self.wrong(written.span, message);
                None
            }
        }
    }

    fn ends(&mut self, entry: &Entry) -> bool {
        let written = entry.value.get("prove");
        written.and_then(|written| self.word(written, &["all", "ends"])) == Some("ends")
    }

    fn own_layout(&mut self, entry: &Entry, mode: Option<AxisMode>) -> bool {
        let Some(written) = entry.value.entry("own_layout") else { return false };
        if mode == Some(AxisMode::Override) {
            self.wrong(
                written.key_span,
                "\"own_layout\" means nothing for an override: no binding depends on it",
            );
            return false;
        }
        written.value.decode().unwrap_or_else(|_| {
            let kind = written.value.kind_name();
            self.wrong(written.value.span, format!("\"own_layout\" is a boolean, not {kind}"));
            false
        })
    }

    fn follows_target(&mut self, entry: &Entry, kind: &AxisKind, mode: Option<AxisMode>) -> bool {
        let Some(written) = entry.value.get("from") else { return false };
        if mode.is_some_and(|mode| mode != AxisMode::Override) || *kind != AxisKind::Bool {
            let message =
                "\"from\" is for boolean axes that are overrides: the target's format is known last";
            self.wrong(written.span, message);
            return false;
        }
        self.word(written, &["linear_target"]).is_some()
    }

    fn default(&mut self, entry: &Entry, kind: &AxisKind) -> Option<AxisValue> {
        let Some(written) = entry.value.get("default") else {
            let message = format!("the axis \"{}\" has no \"default\"", entry.key);
            let help =
                format!("give it the value with which the template is proven by itself: {}", kind.describe());
            self.diagnostics
                .push(Diagnostic::error(codes::AXIS_DECLARATION, entry.key_span, message).help(help));
            return None;
        };
        let value = written.decode().ok().filter(|value| kind.contains(value));
        if value.is_none() {
            let text = written.text();
            let unquoted = text.and_then(|text| match (kind, text) {
                (AxisKind::Bool, "true" | "false") => Some(text.to_owned()),
                (AxisKind::Integer { .. }, text) => {
                    let number = text.parse().ok().map(AxisValue::Integer);
                    number.filter(|number| kind.contains(number)).map(|number| number.to_string())
                }
                _ => None,
            });
            let beyond = written.decode::<i64>().ok().and_then(|number| match kind {
                AxisKind::Integer { min, .. } if number < *min => Some("raise it, or lower \"min\""),
                AxisKind::Integer { max, .. } if number > *max => Some("lower it, or raise \"max\""),
                _ => None,
            });
            let message =
                format!("the default of \"{}\" is none of its values ({})", entry.key, kind.describe());
            let diagnostic = Diagnostic::error(codes::AXIS_DECLARATION, written.span, message);
            self.diagnostics.push(match (unquoted, beyond, kind, text) {
                (Some(value), ..) => diagnostic.help(format!("write it without quotes: {value}")),
                (_, Some(way), ..) => diagnostic.help(way),
                (_, _, AxisKind::Enum(names) | AxisKind::TextureFormat(names), Some(text)) => {
                    let names = names.iter().map(String::as_str);
                    let others = format!("write one of {}, or add it to \"values\"", list_of(names.clone()));
                    let diagnostic = diagnostic.suggest(text, names, Some(written.span), |_| others.clone());
                    if diagnostic.fix.is_some() { diagnostic } else { diagnostic.help(others) }
                }
                _ => diagnostic.help(format!("write one of its values: {}", kind.describe())),
            });
        }
        value
    }

    fn short_constraint(&mut self, entry: &Entry, kind: &AxisKind) {
        if *kind != AxisKind::Bool {
            let message = "\"requires\" and \"excludes\" inside an axis are for boolean axes; write a constraint with \"when\"";
            self.wrong(entry.key_span, message);
            return;
        }
        let when = WrittenCondition { text: entry.key.clone(), span: entry.key_span };
        for key in ["requires", "excludes"] {
            let Some(value) = entry.value.get(key) else { continue };
            let rules = vec![(key, self.conditions(value, key))];
            let when = Some(when.clone());
            self.declaration.constraints.push(WrittenConstraint { span: value.span, when, rules });
        }
    }

    fn constraint(&mut self, value: &Value) {
        const KEYS: &[&str] = &["when", "requires", "excludes", "one_of", "description"];
        if self.known_keys(value, "a constraint", KEYS).is_none() {
            return;
        }
        let when = value.get("when").and_then(|value| {
            let text = self.text(value, "\"when\"")?.to_owned();
            Some(WrittenCondition { text, span: value.span })
        });
        let rules = ["requires", "excludes", "one_of"];
        let rules = rules.into_iter().filter_map(|key| Some((key, self.conditions(value.get(key)?, key))));
        let rules: Vec<_> = rules.collect();
        if rules.is_empty() {
            self.wrong(value.span, "a constraint has \"requires\", \"excludes\" or \"one_of\"");
        } else if let (Some(when), true) = (&when, rules.iter().any(|(key, _)| *key == "one_of")) {
            self.wrong(when.span, "\"one_of\" holds always and takes no \"when\"");
        }
        self.declaration.constraints.push(WrittenConstraint { span: value.span, when, rules });
    }

    fn conditions(&mut self, value: &Value, key: &str) -> Vec<WrittenCondition> {
        let mut conditions = Vec::new();
        for element in self.elements(value, &format!("\"{key}\"")) {
            if let Some(text) = self.text(element, "a condition") {
                conditions.push(WrittenCondition { text: text.to_owned(), span: element.span });
            }
        }
        conditions
    }
}

/// The type of axes that another language names in this way.
fn meant_type(word: &str) -> Option<&'static str> {
    match word {
        "int" | "uint" | "i32" | "u32" | "number" | "range" => Some("integer"),
        "boolean" | "switch" | "flag" => Some("bool"),
        "word" | "string" | "enumeration" | "choice" => Some("enum"),
        "format" => Some("texture_format"),
        _ => None,
    }
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|each| each.is_ascii_alphanumeric() || each == '_')
}

fn is_word(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|each| each.is_ascii_alphanumeric() || each == '_' || each == '-')
}
