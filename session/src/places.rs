//! Diagnostics with the places that they have in the current texts, in the order of the files.

use std::collections::HashMap;

use crate::files::FileTable;
use crate::graph::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::graph::source::FileId;

/// Moves the places of diagnostics to the current texts; `None` if a place has no counterpart in the current text.
pub(crate) fn moved(diagnostics: &Diagnostics, files: &FileTable) -> Option<Diagnostics> {
    diagnostics.iter().map(|diagnostic| moved_one(diagnostic.clone(), files)).collect()
}

fn moved_one(mut diagnostic: Diagnostic, files: &FileTable) -> Option<Diagnostic> {
    let related = diagnostic.related.iter_mut().map(|related| &mut related.place);
    for place in std::iter::once(&mut diagnostic.place).chain(related) {
        if let Place::Span(span) = place {
            *span = files.place(*span)?;
        }
    }
    for edit in diagnostic.fix.iter_mut().flat_map(|fix| &mut fix.edits) {
        edit.span = files.place(edit.span)?;
    }
    Some(diagnostic)
}

/// Sorts diagnostics by place, with the files in the given order. Files that are not listed come last.
pub(crate) fn sort(diagnostics: &mut Diagnostics, files: impl Iterator<Item = FileId>) {
    let mut ranks: HashMap<FileId, usize> = HashMap::new();
    for file in files {
        let rank = ranks.len();
        ranks.entry(file).or_insert(rank);
    }
    diagnostics.sort_files(|file| ranks.get(&file).copied().unwrap_or(usize::MAX));
}
