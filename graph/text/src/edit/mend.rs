//! The fixes of diagnostics as edits of their files.
//!
//! A fix is made as a whole or not at all. The same edit of two diagnostics is made once; of two fixes that overlap the
//! first is made, and the other is left to the next round: after a round the texts are checked again, until nothing
//! changes.

use std::collections::BTreeMap;

use super::rename::in_files;
use super::{EditError, Edits};
use crate::diagnostic::Diagnostic;
use crate::source::Sources;

/// Returns the edits that apply the fixes of diagnostics, grouped by file name. Several source texts with one name
/// count as the same file. A fix is skipped if it overlaps an earlier fix, or changes a file for whose name
/// `is_writable` returns `false`.
pub fn mend<'a>(
    diagnostics: impl IntoIterator<Item = &'a Diagnostic>,
    sources: &Sources,
    is_writable: impl Fn(&str) -> bool,
) -> BTreeMap<String, Edits> {
    let mut made: BTreeMap<String, Edits> = BTreeMap::new();
    for fix in diagnostics.into_iter().filter_map(|diagnostic| diagnostic.fix.as_ref()) {
        let changes = |one: &&crate::diagnostic::Replacement| sources.text(one.span) != one.replacement;
        let replacements = fix.edits.iter().map(|one| (one.span, one.replacement.clone()));
        let Ok(edits) = in_files(sources, replacements) else { continue };
        if !edits.keys().all(|name| is_writable(name)) || !fix.edits.iter().all(|one| changes(&one)) {
            continue;
        }
        let with_known = |(name, edits): (String, Edits)| -> Result<(String, Edits), EditError> {
            let known = made.get(&name).cloned().unwrap_or_default();
            let new = edits.iter().filter(|edit| !known.iter().any(|one| one == *edit)).cloned();
            Ok((name, known.and(&Edits::new(new)?)?))
        };
        if let Ok(edits) = edits.into_iter().map(with_known).collect::<Result<Vec<_>, _>>() {
            made.extend(edits);
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::codes;
    use crate::source::Span;

    #[test]
    fn edits_are_made_once_and_overlapping_fixes_wait() {
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
        let text = |(name, edits): (&String, &Edits)| {
            let file = sources.find(name).and_then(|file| sources.get(file)).unwrap();
            edits.apply(file.text()).unwrap()
        };
        let made = mend(&diagnostics, &sources, |_| true);
        assert_eq!(made.iter().map(text).collect::<Vec<_>>(), ["1 2 three", "4"]);
        assert!(mend(&diagnostics[..1], &sources, |name| name != "b").is_empty());
    }
}
