//! The file `NAME.axes.json` to [`Axes`].
//!
//! The spanned tree is read by hand, so that every diagnostic has its place and none hides another. Conditions are read
//! last, when all axes of the file are known; a condition on an inherited axis is kept as text until the inherited
//! templates are there (see [`Declaration::resolve`]).

use std::collections::BTreeSet;

use super::condition::Condition;
use super::{Axes, Axis, AxisKind, AxisMode, Constraint, Rule};
use crate::codes;
use crate::diagnostic::{AxisValue, Diagnostic, Diagnostics};
use crate::document::schema::{unknown_key, unknown_word};
use crate::document::{Entry, Value};
use crate::source::{FileId, Sources, Span};

/// One side file as it is written: axes, and constraints that are not yet tied to axes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Declaration {
    pub(crate) axes: Axes,
    constraints: Vec<WrittenConstraint>,
    pub(crate) lost: Lost,
}

/// Axes that are declared, but not so that anybody could tell what they are. A template that has them cannot be rendered,
/// and that its text knows nothing of them only follows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lost {
    names: BTreeSet<String>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

impl Lost {
    /// Adds those of an inherited template.
    pub(crate) fn inherit(&mut self, other: &Lost) {
        self.names.extend(other.names.iter().cloned());
        self.diagnostics.extend(other.diagnostics.iter().cloned());
    }
}

#[derive(Clone, Debug)]
struct WrittenConstraint {
    span: Span,
    when: Option<WrittenCondition>,
    requires: Option<Vec<WrittenCondition>>,
    excludes: Option<Vec<WrittenCondition>>,
    one_of: Option<Vec<WrittenCondition>>,
}

#[derive(Clone, Debug)]
struct WrittenCondition {
    text: String,
    span: Span,
}

/// Parses a side file. What can be understood is returned; every diagnostic is in `diagnostics`.
pub(crate) fn parse(sources: &Sources, file: FileId, diagnostics: &mut Diagnostics) -> Declaration {
    let document = match crate::document::parse(sources, file) {
        Ok(document) => document,
        Err(own_diagnostics) => {
            let lost =
                Lost { names: BTreeSet::new(), diagnostics: own_diagnostics.iter().cloned().collect() };
            diagnostics.extend(own_diagnostics);
            return Declaration { lost, ..Declaration::default() };
        }
    };
    let mut reader = Reader { diagnostics, declaration: Declaration::default() };
    reader.root(&document.root);
    reader.declaration
}

impl Declaration {
    /// A file that cannot be read.
    pub(crate) fn unreadable(diagnostic: Diagnostic) -> Self {
        let lost = Lost { names: BTreeSet::new(), diagnostics: vec![diagnostic] };
        Self { lost, ..Self::default() }
    }

    /// Ties the constraints to axes: those of this file and those already inherited into `axes`.
    pub(crate) fn resolve(&self, axes: &mut Axes, lost: &Lost, diagnostics: &mut Vec<Diagnostic>) {
        let mut own = Vec::new();
        for written in &self.constraints {
            let mut complete = true;
            let mut read = |conditions: &[WrittenCondition]| -> Vec<Condition> {
                conditions
                    .iter()
                    .filter_map(|written| {
                        read_condition(written, axes)
                            .map_err(|diagnostic| {
                                let (name, _, _) = Condition::split(&written.text);
                                if !lost.names.contains(name) {
                                    diagnostics.push(*diagnostic);
                                }
                                complete = false;
                            })
                            .ok()
                    })
                    .collect()
            };
            let when = written.when.as_ref().map(|when| read(std::slice::from_ref(when)));
            let requires = written.requires.as_ref().map(|list| read(list));
            let excludes = written.excludes.as_ref().map(|list| read(list));
            let one_of = written.one_of.as_ref().map(|list| read(list));
            if !complete {
                continue;
            }
            let when = when.and_then(|mut list| list.pop());
            let rules = [
                requires.map(|all| Rule::Requires { when: when.clone(), all }),
                excludes.map(|none| Rule::Excludes { when: when.clone(), none }),
                one_of.map(Rule::OneOf),
            ];
            own.extend(rules.into_iter().flatten().map(|rule| Constraint { rule, span: written.span }));
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

    fn entries<'v>(&mut self, value: &'v Value, what: &str) -> &'v [Entry] {
        value.entries().unwrap_or_else(|| {
            self.wrong(value.span, format!("{what} is an object, not {}", value.kind_name()));
            &[]
        })
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
                            let lost = &mut self.declaration.lost;
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
                _ => self.diagnostics.push(unknown_key(entry, KEYS, root.entries().unwrap_or_default())),
            }
        }
    }

    /// Reads an axis; `None` where it cannot be told what it is.
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
        for member in self.entries(&entry.value, "an axis") {
            if !KEYS.contains(&member.key.as_str()) {
                self.diagnostics.push(unknown_key(member, KEYS, entry.value.entries().unwrap_or_default()));
            }
        }
        entry.value.entries()?;
        let kind = self.kind(entry)?;
        let mode = self.mode(entry, &kind);
        let ends = self.ends(entry);
        let own_layout = self.own_layout(entry, mode);
        let default = self.default(entry, &kind);
        let description =
            entry.value.get("description").and_then(|value| self.text(value, "\"description\""));
        let description = description.unwrap_or_default().to_owned();
        if entry.value.get("requires").is_some() || entry.value.get("excludes").is_some() {
            self.short_constraint(entry, &kind);
        }
        let (default, mode) = (default?, mode?);
        let span = entry.key_span;
        let axis = Axis { name: name.to_owned(), kind, default, description, mode, ends, own_layout, span };
        self.declaration.axes.axes.insert(name.to_owned(), axis);
        Some(())
    }

    fn kind(&mut self, entry: &Entry) -> Option<AxisKind> {
        const TYPES: &[&str] = &["bool", "enum", "integer", "texture_format"];
        let Some(written) = entry.value.get("type") else {
            self.wrong(entry.key_span, format!("the axis \"{}\" has no \"type\"", entry.key));
            return None;
        };
        let allowed: &[&str] = match written.text() {
            Some("bool") => &[],
            Some("enum" | "texture_format") => &["values"],
            Some("integer") => &["min", "max", "prove"],
            _ => {
                self.diagnostics.push(unknown_word(written, TYPES));
                return None;
            }
        };
        for key in ["values", "min", "max", "prove"] {
            if let (false, Some(member)) = (allowed.contains(&key), entry.value.entry(key)) {
                let kind = written.text().unwrap_or_default();
                self.wrong(
                    member.key_span,
                    format!("\"{key}\" means nothing for an axis of type \"{kind}\""),
                );
            }
        }
        match written.text() {
            Some("integer") => {
                let (min, max) = (self.integer(entry, "min")?, self.integer(entry, "max")?);
                if min > max || max.abs_diff(min) >= 1 << 32 {
                    self.wrong(
                        entry.value.span,
                        format!("the range {min} to {max} is empty or spans over 2^32 values"),
                    );
                    return None;
                }
                Some(AxisKind::Integer { min, max })
            }
            Some("enum") => self.values(entry, false).map(AxisKind::Enum),
            Some("texture_format") => self.values(entry, true).map(AxisKind::TextureFormat),
            _ => Some(AxisKind::Bool),
        }
    }

    fn integer(&mut self, entry: &Entry, key: &str) -> Option<i64> {
        let Some(value) = entry.value.get(key) else {
            self.wrong(entry.key_span, format!("the integer axis \"{}\" has no \"{key}\"", entry.key));
            return None;
        };
        let number = as_integer(value);
        if number.is_none() {
            self.wrong(value.span, format!("\"{key}\" is an integer of 64 bits"));
        }
        number
    }

    fn values(&mut self, entry: &Entry, formats: bool) -> Option<Vec<String>> {
        let Some(list) = entry.value.get("values") else {
            self.wrong(entry.key_span, format!("the axis \"{}\" has no \"values\"", entry.key));
            return None;
        };
        let mut names: Vec<String> = Vec::new();
        for element in self.elements(list, "\"values\"") {
            let Some(name) = self.text(element, "a value") else { continue };
            if names.iter().any(|known| known == name) {
                self.wrong(element.span, format!("the value \"{name}\" stands twice"));
            } else if formats && texture_format(name).is_none() {
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
        match (written.text(), kind) {
            (Some("template"), _) => Some(AxisMode::Template),
            (Some("override"), AxisKind::Bool | AxisKind::Integer { .. }) => Some(AxisMode::Override),
            (Some("override"), _) => {
                self.wrong(
                    written.span,
                    "an override is a boolean or an integer; names exist in templates only",
                );
                None
            }
            _ => {
                self.diagnostics.push(unknown_word(written, &["template", "override"]));
                None
            }
        }
    }

    fn ends(&mut self, entry: &Entry) -> bool {
        const WORDS: &[&str] = &["all", "ends"];
        let written = entry.value.get("prove");
        if let Some(written) =
            written.filter(|written| !written.text().is_some_and(|word| WORDS.contains(&word)))
        {
            self.diagnostics.push(unknown_word(written, WORDS));
        }
        written.and_then(|written| written.text()) == Some("ends")
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
        match written.value.kind {
            crate::document::Kind::Bool(value) => value,
            _ => {
                let kind = written.value.kind_name();
                self.wrong(written.value.span, format!("\"own_layout\" is a boolean, not {kind}"));
                false
            }
        }
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
        let value = to_axis_value(written).filter(|value| kind.contains(value));
        if value.is_none() {
            self.wrong(
                written.span,
                format!("the default of \"{}\" is none of its values ({})", entry.key, kind.describe()),
            );
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
        let mut list =
            |key: &str| entry.value.get(key).map(|value| (value.span, self.conditions(value, key)));
        for (key, found) in [("requires", list("requires")), ("excludes", list("excludes"))] {
            let Some((span, conditions)) = found else { continue };
            let (requires, excludes) =
                if key == "requires" { (Some(conditions), None) } else { (None, Some(conditions)) };
            let when = Some(when.clone());
            self.declaration.constraints.push(WrittenConstraint {
                span,
                when,
                requires,
                excludes,
                one_of: None,
            });
        }
    }

    fn constraint(&mut self, value: &Value) {
        const KEYS: &[&str] = &["when", "requires", "excludes", "one_of", "description"];
        for entry in self.entries(value, "a constraint") {
            if !KEYS.contains(&entry.key.as_str()) {
                self.diagnostics.push(unknown_key(entry, KEYS, value.entries().unwrap_or_default()));
            }
        }
        if value.entries().is_none() {
            return;
        }
        let when = value.get("when").and_then(|value| {
            let text = self.text(value, "\"when\"")?.to_owned();
            Some(WrittenCondition { text, span: value.span })
        });
        let mut list = |key: &str| value.get(key).map(|value| self.conditions(value, key));
        let (requires, excludes, one_of) = (list("requires"), list("excludes"), list("one_of"));
        match (&requires, &excludes, &one_of, &when) {
            (None, None, None, _) => {
                self.wrong(value.span, "a constraint has \"requires\", \"excludes\" or \"one_of\"");
            }
            (_, _, Some(_), Some(when)) => {
                self.wrong(when.span, "\"one_of\" holds always and takes no \"when\"");
            }
            _ => {}
        }
        let span = value.span;
        self.declaration.constraints.push(WrittenConstraint { span, when, requires, excludes, one_of });
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

fn as_integer(value: &Value) -> Option<i64> {
    match &value.kind {
        crate::document::Kind::Number(number) => number.as_i64(),
        _ => None,
    }
}

/// A value of an axis from JSON, whatever its axis.
pub(crate) fn to_axis_value(value: &Value) -> Option<AxisValue> {
    match &value.kind {
        crate::document::Kind::Bool(value) => Some(AxisValue::Bool(*value)),
        crate::document::Kind::Text(name) => Some(AxisValue::Name(name.clone())),
        crate::document::Kind::Number(_) => as_integer(value).map(AxisValue::Integer),
        _ => None,
    }
}

fn texture_format(name: &str) -> Option<wgpu_types::TextureFormat> {
    serde_json::from_value(serde_json::Value::String(name.to_owned())).ok()
}

fn is_identifier(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|each| each.is_ascii_alphanumeric() || each == '_')
}

fn is_word(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|each| each.is_ascii_alphanumeric() || each == '_' || each == '-')
}
