//! Applies the fixes of diagnostics to their texts.
//!
//! A fix is applied as a whole or not at all. The same edit of two diagnostics is made once; of two fixes that overlap
//! the first (by place) is made, and the other is left to the next round: after a round the texts are checked again,
//! until nothing changes.

use std::collections::BTreeMap;

use super::{Diagnostic, Edit};
use crate::source::{FileId, Sources, Span};

/// A text with its edits made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fixed {
    /// The name of the file.
    pub name: String,
    /// One of its registrations.
    pub file: FileId,
    /// The text with the edits.
    pub text: String,
    /// The edits, in the order of their places.
    pub edits: Vec<Edit>,
}

/// The texts that the fixes of diagnostics change, by the names of their files, which stand for their contents however
/// often they are registered. Files for which `is_writable` says no keep their texts, and fixes that need them wait.
pub fn apply<'a>(
    diagnostics: impl IntoIterator<Item = &'a Diagnostic>,
    sources: &Sources,
    is_writable: impl Fn(&str) -> bool,
) -> Vec<Fixed> {
    let mut made: BTreeMap<String, BTreeMap<Range, Edit>> = BTreeMap::new();
    for fix in diagnostics.into_iter().filter_map(|diagnostic| diagnostic.fix.as_ref()) {
        let placed: Option<Vec<(String, Range, &Edit)>> =
            fix.edits.iter().map(|edit| place(edit, sources, &is_writable)).collect();
        let Some(placed) = placed else { continue };
        let is_free = |(name, range, edit): &(String, Range, &Edit)| {
            let taken = made.get(name).into_iter().flatten();
            let mut clashes = taken.filter(|(other, _)| other.0 < range.1 && range.0 < other.1);
            clashes.all(|(other, known)| other == range && known.replacement == edit.replacement)
        };
        if placed.iter().all(is_free) {
            for (name, range, edit) in placed {
                made.entry(name).or_default().entry(range).or_insert_with(|| edit.clone());
            }
        }
    }
    made.into_iter().filter_map(|(name, edits)| rewrite(name, edits, sources)).collect()
}

/// The first byte and one past the last; an insertion of nothing long has the same twice.
type Range = (u32, u32);

fn place<'e>(
    edit: &'e Edit,
    sources: &Sources,
    is_writable: &impl Fn(&str) -> bool,
) -> Option<(String, Range, &'e Edit)> {
    let Span { file, start, end } = edit.span;
    let file = sources.get(file)?;
    let fits = file.text().get(edit.span.range()).is_some_and(|old| old != edit.replacement);
    (fits && is_writable(file.name())).then(|| (file.name().to_owned(), (start, end), edit))
}

fn rewrite(name: String, edits: BTreeMap<Range, Edit>, sources: &Sources) -> Option<Fixed> {
    let file = edits.values().next()?.span.file;
    let mut text = sources.get(file)?.text().to_string();
    for (range, edit) in edits.iter().rev() {
        text.replace_range(range.0 as usize..range.1 as usize, &edit.replacement);
    }
    Some(Fixed { name, file, text, edits: edits.into_values().collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::codes;

    #[test]
    fn edits_of_several_files_are_made_once_and_overlapping_fixes_wait() {
        let mut sources = Sources::new();
        let (a, b) = (sources.add("a", "one two three"), sources.add("b", "four"));
        let again = sources.add("a", "one two three");
        let diagnostic = |file, range, text: &str| {
            Diagnostic::error(codes::UNKNOWN_KEY, Span::new(file, 0..1), "x")
                .fix(Span::new(file, range), text)
        };
        let diagnostics = [
            diagnostic(a, 0..3, "1").fix(Span::new(b, 0..4), "4"),
            diagnostic(again, 0..3, "1"),
            diagnostic(a, 4..7, "2"),
            diagnostic(a, 5..9, "overlaps").fix(Span::new(b, 0..0), "no half of a fix is made: "),
        ];
        let fixed = apply(&diagnostics, &sources, |_| true);
        let texts: Vec<&str> = fixed.iter().map(|fixed| fixed.text.as_str()).collect();
        assert_eq!(texts, ["1 2 three", "4"]);
        assert!(apply(&diagnostics[..1], &sources, |name| name != "b").is_empty());
    }
}
