//! Diagnostics: what is wrong, where, why, and the way out.
//!
//! Every stage collects [`Diagnostic`]s into a [`Diagnostics`] and goes on as far as it can, so that a user sees all
//! diagnostics of a file at once. A diagnostic is plain data; turning it into terminal text, JSON or another format is
//! the business of [`render`]. A diagnostic that only follows from another one is not reported: a stage that cannot
//! know (a pass that failed to decode) leaves a gap instead of guessing.

mod code;
pub mod codes;
mod count;
pub mod render;
mod suggest;
mod values;

pub use code::Code;
pub use count::Count;
pub(crate) use suggest::{DID_YOU_MEAN, begun};
pub use suggest::{name_meant, suggested_name};
pub use values::{AxisValue, AxisValues, describe, select_axes};

use std::collections::{BTreeSet, HashMap, HashSet};
use std::hash::{Hash as _, Hasher as _};

use crate::source::{FileId, Span};

/// The severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The pipeline cannot be used.
    Error,
    /// The pipeline works, but probably not as meant.
    Warning,
    /// Additional information that needs no action.
    Note,
}

impl Severity {
    /// The severity as a lower-case word: `error`, `warning` or `note`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// The place that a diagnostic refers to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// A range of a source text.
    Span(Span),
    /// A position in a file that is not a registered source text, such as a binary or unreadable file.
    File {
        /// The path of the file as the user wrote it.
        path: String,
        /// The position in the file, such as a JSON pointer into a glTF document; empty for the entire file.
        locator: String,
    },
    /// No place, since the cause is in the machine, such as a missing graphics adapter, and not in an input file.
    Nowhere,
}

impl From<Span> for Place {
    fn from(span: Span) -> Self {
        Place::Span(span)
    }
}

/// A further place that belongs to a diagnostic, such as the first of two definitions.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Related {
    /// The place that the message refers to.
    pub place: Place,
    /// The message shown at the place.
    pub message: String,
}

/// A fix: replacements of source text that together remove the cause of a diagnostic. A diagnostic has a fix only if
/// there is exactly one sensible way to correct the source.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fix {
    /// The replacements, perhaps in several files; they do not overlap.
    pub edits: Vec<Replacement>,
}

/// A replacement of a part of a source text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Replacement {
    /// The bytes to replace; an empty span is an insertion.
    pub span: Span,
    /// The text to write instead; empty to remove the bytes.
    pub replacement: String,
}

/// The variants of one shader template that a diagnostic applies to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Extent {
    /// The name of the shader template.
    pub template: String,
    /// The number of variants of the template that the diagnostic applies to.
    pub variants: usize,
    /// The number of all variants of the template.
    pub of_variants: usize,
    /// The number of configurations (assignments of axis values) that the affected variants cover.
    pub configurations: Count,
    /// A minimal set of axis values (by inclusion) that causes the diagnostic; empty if all variants are affected.
    pub provoked_by: AxisValues,
    /// The names of the target profiles for which the diagnostic is reported.
    pub profiles: BTreeSet<String>,
}

/// An error, warning or note with a code, a place and a message, and perhaps a fix.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub struct Diagnostic {
    /// The stable code of the kind of diagnostic, such as `UG0101`.
    pub code: Code,
    /// The severity: error, warning or note.
    pub severity: Severity,
    /// The message: one sentence without a full stop, with the offending name in it.
    pub message: String,
    /// The place that the diagnostic points to.
    pub place: Place,
    /// The JSON pointer (RFC 6901) of the offending value if the place is in a document; otherwise empty.
    pub pointer: String,
    /// Further places that belong to the diagnostic, each with a message.
    pub related: Vec<Related>,
    /// The affected shader variants, one entry for each template; empty for diagnostics that are not about shader
    /// variants.
    pub extent: Vec<Extent>,
    /// The remedy in one sentence; `None` if none is known.
    pub help: Option<String>,
    /// The fix that a tool can apply; `None` if there is not exactly one.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// Creates a diagnostic of severity error at a place.
    pub fn error(code: Code, place: impl Into<Place>, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: message.into(),
            place: place.into(),
            pointer: String::new(),
            related: Vec::new(),
            extent: Vec::new(),
            help: None,
            fix: None,
        }
    }

    /// Creates a diagnostic of severity warning at a place.
    pub fn warning(code: Code, place: impl Into<Place>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, place, message) }
    }

    /// The code, place and message. [`Diagnostics::merge`] joins diagnostics in which all three are equal.
    pub fn key(&self) -> (Code, Place, String) {
        (self.code, self.place.clone(), self.message.clone())
    }

    fn said(&self) -> (Code, &Place, &str) {
        (self.code, &self.place, &self.message)
    }

    fn said_hash(&self) -> u64 {
        let mut hasher = std::hash::DefaultHasher::new();
        self.said().hash(&mut hasher);
        hasher.finish()
    }

    /// Sets the severity of the diagnostic.
    #[must_use]
    pub fn severity(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// Creates an error about a file that is not a registered source text, such as a binary file. `locator` is a JSON
    /// pointer or other position in the file, and may be empty.
    pub fn in_file(
        code: Code,
        path: impl Into<String>,
        locator: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Self::error(code, Place::File { path: path.into(), locator: locator.into() }, message)
    }

    /// The span of the place; `None` if the place is not in a registered source text.
    pub fn span(&self) -> Option<Span> {
        match self.place {
            Place::Span(span) => Some(span),
            Place::File { .. } | Place::Nowhere => None,
        }
    }

    /// Sets the help text, which describes a remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Sets the place and the JSON pointer of the offending value.
    #[must_use]
    pub fn at(mut self, place: impl Into<Place>, pointer: impl Into<String>) -> Self {
        self.place = place.into();
        self.pointer(pointer)
    }

    /// Sets the JSON pointer (RFC 6901) of the offending value.
    #[must_use]
    pub fn pointer(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = pointer.into();
        self
    }

    /// Adds a related place with a message.
    #[must_use]
    pub fn related(mut self, place: impl Into<Place>, message: impl Into<String>) -> Self {
        self.related.push(Related { place: place.into(), message: message.into() });
        self
    }

    /// Adds a related place with a message, if the place is known.
    #[must_use]
    pub fn labelled(self, place: Option<Span>, message: impl Into<String>) -> Self {
        match place {
            Some(place) => self.related(place, message),
            None => self,
        }
    }

    /// Adds a replacement to the machine-applicable fix. The first call creates the fix.
    #[must_use]
    pub fn fix(mut self, span: Span, replacement: impl Into<String>) -> Self {
        let edit = Replacement { span, replacement: replacement.into() };
        self.fix.get_or_insert_with(|| Fix { edits: Vec::new() }).edits.push(edit);
        self
    }
}

/// A list of diagnostics without duplicates, in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    /// Hashes of code, place and message of the diagnostics, so that most additions need no search of the list.
    seen: HashSet<u64>,
}

impl Diagnostics {
    /// Creates an empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a diagnostic unless the list contains an equal one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if self.seen.insert(diagnostic.said_hash()) || !self.list.contains(&diagnostic) {
            self.list.push(diagnostic);
        }
    }

    /// Adds a diagnostic unless the list has one with the same code, place and message. Returns `true` if it was added.
    pub fn push_new(&mut self, diagnostic: Diagnostic) -> bool {
        let is_new = !self.seen.contains(&diagnostic.said_hash())
            || !self.list.iter().any(|known| known.said() == diagnostic.said());
        if is_new {
            self.push(diagnostic);
        }
        is_new
    }

    /// Adds each of the given diagnostics, as [`Self::push`] does.
    pub fn extend(&mut self, other: impl IntoIterator<Item = Diagnostic>) {
        for diagnostic in other {
            self.push(diagnostic);
        }
    }

    /// Returns `true` if at least one of the diagnostics is an error.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// The number of diagnostics of severity error.
    pub fn error_count(&self) -> usize {
        self.list.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count()
    }

    /// Returns `true` if the list has no diagnostics.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of diagnostics.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The diagnostics in the order in which they were added.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Merges diagnostics with the same code, place and message: their related places and extents are joined, and the
    /// highest severity is kept.
    pub fn merge(&mut self) {
        let mut merged: Vec<Diagnostic> = Vec::new();
        let mut known: HashMap<(Code, Place, String), usize> = HashMap::new();
        for mut diagnostic in std::mem::take(&mut self.list) {
            let key = diagnostic.key();
            match known.get(&key).and_then(|at| merged.get_mut(*at)) {
                Some(first) => {
                    diagnostic.related.retain(|related| !first.related.contains(related));
                    first.related.append(&mut diagnostic.related);
                    diagnostic.extent.retain(|extent| !first.extent.contains(extent));
                    first.extent.append(&mut diagnostic.extent);
                    first.severity = first.severity.min(diagnostic.severity);
                    first.help = first.help.take().or(diagnostic.help);
                    first.fix = first.fix.take().or(diagnostic.fix);
                }
                None => {
                    known.insert(key, merged.len());
                    merged.push(diagnostic);
                }
            }
        }
        *self = Self::new();
        self.extend(merged);
    }

    /// Sorts by place (file, offset), then severity, code and message, so that output does not depend on the order
    /// of the checks.
    pub fn sort(&mut self) {
        self.sort_files(|file| file);
    }

    /// Sorts as [`Self::sort`] does, but orders files by the value of `rank` instead of by registration.
    pub fn sort_files<R: Ord>(&mut self, rank: impl Fn(FileId) -> R) {
        let file = |diagnostic: &Diagnostic| {
            (diagnostic.span().is_none(), diagnostic.span().map(|span| rank(span.file)))
        };
        self.list.sort_by(|a, b| {
            file(a).cmp(&file(b)).then_with(|| {
                (&a.place, a.severity, a.code.id, &a.message)
                    .cmp(&(&b.place, b.severity, b.code.id, &b.message))
            })
        });
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.iter()
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::from_iter([diagnostic])
    }
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(iter: I) -> Self {
        let mut diagnostics = Self::new();
        diagnostics.extend(iter);
        diagnostics
    }
}

/// The number of diagnostics after which a check stops. It bounds the cost of inputs with very many errors.
pub const MAX_DIAGNOSTICS: usize = 1_000;

/// Shortens a text for use in a message to its first 80 characters and an ellipsis; a shorter text is returned as it
/// is.
pub fn shorten(text: &str) -> std::borrow::Cow<'_, str> {
    match text.char_indices().nth(80) {
        Some((at, _)) => format!("{}…", &text[..at]).into(),
        None => text.into(),
    }
}

/// Returns a count with its noun, in the plural unless the count is 1, such as `2 passes`.
pub fn counted(number: usize, noun: &str) -> String {
    let ending = if number == 1 {
        ""
    } else if noun.ends_with('s') {
        "es"
    } else {
        "s"
    };
    format!("{number} {noun}{ending}")
}

/// Joins names with commas for a message: at most the first 24, then the number of the others.
pub fn list_of(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    joined(names, ", ")
}

/// Joins the names along a path, such as a dependency cycle, with arrows for a message: at most the first 24, then the
/// number of the others.
pub fn way_of(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    joined(names, " → ")
}

fn joined(names: impl IntoIterator<Item = impl AsRef<str>>, separator: &str) -> String {
    let mut names = names.into_iter();
    let first: Vec<_> = names.by_ref().take(24).map(|name| shorten(name.as_ref()).into_owned()).collect();
    match names.count() {
        0 => first.join(separator),
        more => format!("{} and {more} more", first.join(separator)),
    }
}
