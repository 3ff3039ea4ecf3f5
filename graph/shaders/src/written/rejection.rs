//! Reasons to reject a generated text, in terms of that text, and their diagnostics in the template.

use std::ops::Range;

use naga::Span;

use super::stages;
use super::text_map::TextMap;
use crate::codes;
use umbragraph_text::diagnostic::{AxisValues, Code, Diagnostic, Place};
use umbragraph_text::source::{self, FileId};

/// The reason to reject generated WGSL, with places in the generated code.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rejection {
    pub(crate) code: Code,
    pub(crate) message: String,
    /// The byte range in the generated WGSL; `None` if the place is unknown.
    pub(crate) range: Option<Range<usize>>,
    /// Further byte ranges in the generated WGSL, each with a note.
    pub(crate) labels: Vec<(Range<usize>, String)>,
    pub(crate) help: Option<String>,
    /// The text to write in place of the range; `None` if no single text is sure to be meant.
    pub(crate) replacement: Option<String>,
    /// Whether this is a warning: the WGSL is valid, but better avoided.
    pub(crate) warning: bool,
    /// The exceeded limit; `None` for other causes.
    pub(crate) excess: Option<Excess>,
    /// The override values that cause the rejection; empty if it does not depend on overrides.
    pub(crate) overrides: AxisValues,
    pub(crate) scope: Scope,
    /// The member, of the structure at `range`, that is the place; naga knows no places of members.
    pub(crate) member: Option<String>,
}

/// The part of a WGSL module that is rejected: every module with the same part is rejected as well.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The declaration at the place of the rejection, including what it depends on.
    #[default]
    Declaration,
    /// The entry point with this name, including the functions that it calls.
    EntryPoint(String),
    /// All entry points together, with the resources that they use.
    Interface,
    /// The whole module, since the cause cannot be attributed to a part.
    Text,
}

/// An exceeded limit of a target profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Excess {
    /// A key that names the limited quantity. Excesses with the same key and place have one root cause, whatever their
    /// amounts.
    pub(crate) of: String,
    pub(crate) found: u64,
}

impl Rejection {
    pub(crate) fn new(code: Code, message: impl Into<String>, span: Span) -> Self {
        Self {
            code,
            message: message.into(),
            range: span.to_range(),
            labels: Vec::new(),
            help: None,
            replacement: None,
            warning: code == codes::UNIFORM_BRANCH,
            excess: None,
            overrides: AxisValues::new(),
            scope: Scope::default(),
            member: None,
        }
    }

    pub(crate) fn of(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Creates the diagnostic at the place in the template that `map` gives. `text` is the generated WGSL; `template`
    /// is the file to use if the range cannot be mapped.
    pub(crate) fn to_diagnostic(&self, text: &str, map: &TextMap, template: FileId) -> Diagnostic {
        let narrowed = self
            .member
            .as_ref()
            .zip(self.range.as_ref())
            .and_then(|(name, range)| declaration(text.get(..range.end)?, range.start, name));
        let span = narrowed.or_else(|| self.range.clone()).and_then(|range| map.span(range));
        let span = span.unwrap_or(source::Span::new(template, 0..0));
        let make = if self.warning { Diagnostic::warning } else { Diagnostic::error };
        let mut diagnostic = make(self.code, span, self.message.clone());
        for (range, label) in &self.labels {
            if let Some(span) = map.span(range.clone()) {
                diagnostic = diagnostic.related(span, label.clone());
            }
        }
        if let Some(range) = &self.range {
            diagnostic = diagnostic.related(Place::Nowhere, generated_line(text, range.start));
        }
        diagnostic.help = self.help.clone();
        match (&self.replacement, self.range.clone().filter(|range| map.is_verbatim(range.clone()))) {
            (Some(replacement), Some(_)) => diagnostic.fix(span, replacement),
            _ => diagnostic,
        }
    }
}

/// The byte range of a declaration `NAME: TYPE` behind a place in WGSL; `None` if there is none.
pub(crate) fn declaration(text: &str, from: usize, name: &str) -> Option<Range<usize>> {
    let rest = text.get(from..)?;
    let range = stages::words(rest, name).find(|range| rest[range.end..].trim_start().starts_with(':'))?;
    let mut depth = 0_i32;
    let is_end = |each: char| {
        depth += i32::from(each == '<') - i32::from(each == '>');
        depth <= 0 && matches!(each, ',' | ';' | '=' | ')' | '}' | '{' | '\n')
    };
    let end = rest[range.end..].find(is_end).map_or(rest.len(), |end| range.end + end);
    let length = rest[range.start..end].trim_end().len();
    Some(from + range.start..from + range.start + length)
}

/// The line of generated WGSL at a byte offset, as a message: `generated line 12: let x = 1;`.
pub(crate) fn generated_line(text: &str, offset: usize) -> String {
    let bytes = text.as_bytes();
    let offset = offset.min(bytes.len());
    let start = bytes[..offset].iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let end = bytes[offset..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |at| at + offset);
    let number = bytes[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
    let line: String = text.get(start..end).unwrap_or_default().trim().chars().take(160).collect();
    format!("generated line {number}: {line}")
}

/// Joins a message of naga into one line without handle indices: `Expression [12] is invalid` becomes
/// `Expression is invalid`.
pub(crate) fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('[') {
        let (before, after) = rest.split_at(at);
        let digits = after[1..].bytes().take_while(u8::is_ascii_digit).count();
        let is_handle = digits > 0 && after[1 + digits..].starts_with(']');
        if is_handle && before.ends_with(" Some(") {
            line.push_str(before.trim_end_matches(" Some("));
            rest = after[digits + 2..].trim_start_matches(')');
        } else if is_handle && before.ends_with(' ') {
            line.push_str(before.trim_end());
            rest = &after[digits + 2..];
        } else {
            line.push_str(before);
            line.push('[');
            rest = &after[1..];
        }
    }
    line.push_str(rest);
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}
