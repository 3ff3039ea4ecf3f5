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
pub(crate) use suggest::DID_YOU_MEAN;
pub use suggest::suggested_name;
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
    /// Something worth knowing.
    Note,
}

impl Severity {
    /// The severity in a word.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// The place of a diagnostic.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// A range of a registered text.
    Span(Span),
    /// A file that has no text to point into (binary, or unreadable), and a JSON pointer or another locator in it.
    File {
        /// The path as the user wrote it.
        path: String,
        /// The place in the file: a JSON pointer into a glTF document, for one. Empty for the file as a whole.
        locator: String,
    },
    /// No place: the diagnostic is about the machine (no adapter), not about an input.
    Nowhere,
}

impl From<Span> for Place {
    fn from(span: Span) -> Self {
        Place::Span(span)
    }
}

/// A further place that belongs to a diagnostic.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Related {
    /// The place.
    pub place: Place,
    /// The message for that place.
    pub message: String,
}

/// Replacements of text that together mend a diagnostic, given only where there is exactly one sensible way.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fix {
    /// The replacements, perhaps in several files; they do not overlap.
    pub edits: Vec<Replacement>,
}

/// A replacement of a part of a registered text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Replacement {
    /// The text to replace.
    pub span: Span,
    /// The new text.
    pub replacement: String,
}

/// The extent of a diagnostic about shaders in one template.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Extent {
    /// The template.
    pub template: String,
    /// The number of its variants that show the diagnostic.
    pub variants: usize,
    /// The number of all its variants.
    pub of_variants: usize,
    /// The number of configurations that these variants stand for.
    pub configurations: Count,
    /// An inclusion-minimal set of values of axes that provokes it; empty where all variants show it.
    pub provoked_by: AxisValues,
    /// The names of the target profiles that show it.
    pub profiles: BTreeSet<String>,
}

/// One diagnostic.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub struct Diagnostic {
    /// Its stable code.
    pub code: Code,
    /// The severity.
    pub severity: Severity,
    /// The message: one sentence without a full stop, with the offending name in it.
    pub message: String,
    /// The place.
    pub place: Place,
    /// The JSON pointer of the offending value, where the place is in a document; else empty.
    pub pointer: String,
    /// Further places, each with what is to be seen there.
    pub related: Vec<Related>,
    /// The extent, for diagnostics that variants of shader templates show.
    pub extent: Vec<Extent>,
    /// The way out, one sentence.
    pub help: Option<String>,
    /// The one machine-applicable way out.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// An error at a place.
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

    /// A warning at a place.
    pub fn warning(code: Code, place: impl Into<Place>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, place, message) }
    }

    /// A key that is equal for diagnostics that say the same.
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

    /// Sets the severity.
    #[must_use]
    pub fn severity(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }

    /// An error about a file without a text to point into.
    pub fn in_file(
        code: Code,
        path: impl Into<String>,
        locator: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Self::error(code, Place::File { path: path.into(), locator: locator.into() }, message)
    }

    /// Its place, if that is in a registered text.
    pub fn span(&self) -> Option<Span> {
        match self.place {
            Place::Span(span) => Some(span),
            Place::File { .. } | Place::Nowhere => None,
        }
    }

    /// Adds the way out.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Sets the place: a value of a document, with its JSON pointer.
    #[must_use]
    pub fn at(mut self, place: impl Into<Place>, pointer: impl Into<String>) -> Self {
        self.place = place.into();
        self.pointer(pointer)
    }

    /// Adds the JSON pointer of the offending value.
    #[must_use]
    pub fn pointer(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = pointer.into();
        self
    }

    /// Adds a related place.
    #[must_use]
    pub fn related(mut self, place: impl Into<Place>, message: impl Into<String>) -> Self {
        self.related.push(Related { place: place.into(), message: message.into() });
        self
    }

    /// Adds the machine-applicable fix, or one more edit to it.
    #[must_use]
    pub fn fix(mut self, span: Span, replacement: impl Into<String>) -> Self {
        let edit = Replacement { span, replacement: replacement.into() };
        self.fix.get_or_insert_with(|| Fix { edits: Vec::new() }).edits.push(edit);
        self
    }
}

/// The diagnostics of one run, in the order in which they were made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
    /// Hashes of what the diagnostics say, so that most new ones need no comparison with the others.
    seen: HashSet<u64>,
}

impl Diagnostics {
    /// No diagnostics.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a diagnostic; the very same diagnostic twice is kept once.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if self.seen.insert(diagnostic.said_hash()) || !self.list.contains(&diagnostic) {
            self.list.push(diagnostic);
        }
    }

    /// Adds a diagnostic unless the same was said of the same place; whether it is new.
    pub fn push_new(&mut self, diagnostic: Diagnostic) -> bool {
        let is_new = !self.seen.contains(&diagnostic.said_hash())
            || !self.list.iter().any(|known| known.said() == diagnostic.said());
        if is_new {
            self.push(diagnostic);
        }
        is_new
    }

    /// Adds all diagnostics of another run.
    pub fn extend(&mut self, other: impl IntoIterator<Item = Diagnostic>) {
        for diagnostic in other {
            self.push(diagnostic);
        }
    }

    /// Whether there is an error among the diagnostics.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// The number of errors.
    pub fn error_count(&self) -> usize {
        self.list.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count()
    }

    /// Whether there are no diagnostics at all.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of diagnostics.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The diagnostics in the order in which they were made.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Makes diagnostics with the same code, place and message one, with everything that is related to any of them.
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

    /// Sorts as [`Self::sort`] does, with files in the order of their ranks.
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

/// The number of diagnostics after which a check stops to look for more: nobody reads on, and a text of a million
/// errors must not cost a million diagnostics.
pub const MAX_DIAGNOSTICS: usize = 1_000;

/// A text for a message: the first characters of a long one.
pub fn shorten(text: &str) -> std::borrow::Cow<'_, str> {
    match text.char_indices().nth(80) {
        Some((at, _)) => format!("{}…", &text[..at]).into(),
        None => text.into(),
    }
}

/// A number with its noun, for a message.
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

/// Names for a message: the first two dozen, and how many more there are.
pub fn list_of(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    joined(names, ", ")
}

/// The names along a cycle, or another way, for a message: as many, and how many more there are.
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
