//! Source texts and places in them.
//!
//! Every text that a diagnostic can point into (a pipeline file, a template, a parameter file, the command line)
//! is registered once in [`Sources`] and named by a [`FileId`] from then on. A [`Span`] is a half-open byte range
//! of one file. Lines and columns are computed only when a diagnostic is shown: a span is eight bytes of offsets,
//! and nothing else in the engine counts newlines.
//!
//! Limits: a file has at most 4 GiB (offsets are `u32`); [`Sources::add`] never fails, and the loaders that call it
//! reject larger texts first ([`MAX_FILE_BYTES`]).

use std::ops::Range;
use std::sync::Arc;

/// The largest text, in bytes, that the loaders of this crate accept.
pub const MAX_FILE_BYTES: usize = 64 << 20;

/// Names one registered source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(u32);

/// A half-open byte range of one source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The text that the range belongs to.
    pub file: FileId,
    /// The first byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The bytes `range` of `file`. Offsets beyond `u32` are cut off at its end.
    pub fn new(file: FileId, range: Range<usize>) -> Self {
        let cut = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { file, start: cut(range.start), end: cut(range.end) }
    }

    /// A place outside of all texts, which a host knows by a number: that of a value which it gives.
    pub fn of_host(number: u32) -> Self {
        Self { file: FileId(u32::MAX), start: number, end: number }
    }

    /// The number of a place that a host knows.
    pub fn host_number(self) -> Option<u32> {
        (self.file == FileId(u32::MAX)).then_some(self.start)
    }

    /// The bytes `range` counted from the start of this span, kept inside it.
    pub fn inside(self, range: Range<usize>) -> Self {
        let at = |offset: usize| {
            self.start.saturating_add(u32::try_from(offset).unwrap_or(u32::MAX)).min(self.end)
        };
        Self { file: self.file, start: at(range.start), end: at(range.end) }
    }

    /// The place of a `range` of `text`, if this span is that text in quotes; `None` if it has escapes there.
    pub fn of_quoted(self, text: &str, range: Range<usize>) -> Option<Self> {
        let is_verbatim = self.range().len() == text.len() + 2 && range.end <= text.len();
        is_verbatim.then(|| self.inside(range.start + 1..range.end + 1))
    }

    /// The byte range as `usize`, for slicing.
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A position as people count: lines and columns from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineColumn {
    /// The line, from 1.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
}

/// A registered text, with its name and the starts of its lines.
#[derive(Debug)]
pub struct SourceFile {
    name: String,
    text: Arc<str>,
    line_starts: Vec<u32>,
}

impl SourceFile {
    fn new(name: String, text: Arc<str>) -> Self {
        let mut line_starts = vec![0];
        line_starts.extend(text.match_indices('\n').map(|(at, _)| at as u32 + 1));
        Self { name, text, line_starts }
    }

    /// The name under which diagnostics show the file: a path as the user wrote it, or `<command line>`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text.
    pub fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// The position of a byte offset. An offset past the end, or inside a character, is moved back to the nearest
    /// start of a character.
    pub fn line_column(&self, offset: u32) -> LineColumn {
        let mut offset = (offset as usize).min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let line = self.line_starts.partition_point(|start| *start as usize <= offset).saturating_sub(1);
        let start = self.line_starts.get(line).map_or(0, |start| *start as usize);
        let column = self.text[start..offset].chars().count();
        LineColumn { line: line as u32 + 1, column: column as u32 + 1 }
    }

    /// The byte range of a line (from 0) with its line ending, or `None` beyond the end.
    pub fn line_range(&self, index: usize) -> Option<Range<usize>> {
        let start = *self.line_starts.get(index)? as usize;
        Some(start..self.line_starts.get(index + 1).map_or(self.text.len(), |end| *end as usize))
    }

    /// The text of a line (from 1), without its line ending; empty beyond the end.
    pub fn line(&self, line: u32) -> &str {
        let range = self.line_range(line.saturating_sub(1) as usize);
        range.map_or("", |range| self.text[range].trim_end_matches(['\n', '\r']))
    }
}

/// All texts that diagnostics can point into.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<Arc<SourceFile>>,
}

impl Sources {
    /// An empty set of texts.
    pub fn new() -> Self {
        Self::default()
    }

    /// Registers a text. The same name may be registered again (a file that changed on disk): both stay.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        self.files.push(Arc::new(SourceFile::new(name.into(), text.into())));
        FileId(self.files.len() as u32 - 1)
    }

    /// Exchanges the text of a registered file. Spans into the text before mean nothing then; clones made before keep
    /// it.
    pub fn replace(&mut self, file: FileId, text: impl Into<Arc<str>>) {
        if let Some(known) = self.files.get_mut(file.0 as usize) {
            *known = Arc::new(SourceFile::new(known.name.clone(), text.into()));
        }
    }

    /// A registered text, or `None` for an id of another `Sources`.
    pub fn get(&self, file: FileId) -> Option<&Arc<SourceFile>> {
        self.files.get(file.0 as usize)
    }

    /// The file registered last under `name`.
    pub fn find(&self, name: &str) -> Option<FileId> {
        self.files.iter().rposition(|file| file.name == name).map(|at| FileId(at as u32))
    }

    /// The texts in the order of their registration.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &Arc<SourceFile>)> {
        self.files.iter().enumerate().map(|(at, file)| (FileId(at as u32), file))
    }

    /// The text of a span; empty where the span does not fit the text.
    pub fn text(&self, span: Span) -> &str {
        self.get(span.file).and_then(|file| file.text.get(span.range())).unwrap_or("")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_characters_and_never_split_one() {
        let mut sources = Sources::new();
        let id = sources.add("a", "ab\nä€c\r\n");
        let file = sources.get(id).unwrap();
        assert_eq!(file.line_column(0), LineColumn { line: 1, column: 1 });
        assert_eq!(file.line_column(3), LineColumn { line: 2, column: 1 });
        assert_eq!(file.line_column(4), LineColumn { line: 2, column: 1 }, "inside ä");
        assert_eq!(file.line_column(8), LineColumn { line: 2, column: 3 });
        assert_eq!(file.line_column(900), LineColumn { line: 3, column: 1 });
        assert_eq!(file.line(2), "ä€c");
        assert_eq!(file.line(9), "");
    }
}
