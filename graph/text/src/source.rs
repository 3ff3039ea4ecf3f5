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

/// The maximum size, in bytes, of a file that the loaders of this crate accept.
pub const MAX_FILE_BYTES: usize = 64 << 20;

/// The identifier of a source text registered in [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(u32);

/// A half-open byte range of one source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The source text that the byte range belongs to.
    pub file: FileId,
    /// The byte offset of the first byte.
    pub start: u32,
    /// The byte offset one past the last byte.
    pub end: u32,
}

impl Span {
    /// The span of the byte range `range` of `file`. Offsets beyond `u32::MAX` are clamped to it.
    pub fn new(file: FileId, range: Range<usize>) -> Self {
        let cut = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { file, start: cut(range.start), end: cut(range.end) }
    }

    /// Creates a span outside of all source texts, for a value that the host application passes. The host chooses
    /// `number` to identify the value.
    pub fn of_host(number: u32) -> Self {
        Self { file: FileId(u32::MAX), start: number, end: number }
    }

    /// The number passed to [`Self::of_host`]; `None` for a span of a source text.
    pub fn host_number(self) -> Option<u32> {
        (self.file == FileId(u32::MAX)).then_some(self.start)
    }

    /// The span of the bytes `range`, relative to the start of this span and clamped to its end.
    pub fn inside(self, range: Range<usize>) -> Self {
        let at = |offset: usize| {
            self.start.saturating_add(u32::try_from(offset).unwrap_or(u32::MAX)).min(self.end)
        };
        Self { file: self.file, start: at(range.start), end: at(range.end) }
    }

    /// Converts a byte range of a JSON string's contents to a span of the source. This span must cover the string with
    /// its quotes; `text` is the unescaped contents. `None` if the string has escapes, or if `range` exceeds the
    /// contents.
    pub fn of_quoted(self, text: &str, range: Range<usize>) -> Option<Self> {
        let is_verbatim = self.range().len() == text.len() + 2 && range.end <= text.len();
        is_verbatim.then(|| self.inside(range.start + 1..range.end + 1))
    }

    /// The byte range as `usize`, for slicing.
    pub fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A line and column in a source text, for display.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LineColumn {
    /// The line number, from 1.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
}

/// A source text with its name and the byte offsets at which its lines start.
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

    /// The name of the file in diagnostics: a path as the user wrote it, or `<command line>`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The contents of the file.
    pub fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// Returns the line and column of a byte offset. Offsets past the end or inside a character are moved back to the
    /// nearest start of a character.
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

    /// The byte range of the line with this index (from 0), line ending included. `None` beyond the last line.
    pub fn line_range(&self, index: usize) -> Option<Range<usize>> {
        let start = *self.line_starts.get(index)? as usize;
        Some(start..self.line_starts.get(index + 1).map_or(self.text.len(), |end| *end as usize))
    }

    /// The contents of a line (counted from 1) without its line ending; empty beyond the last line.
    pub fn line(&self, line: u32) -> &str {
        let range = self.line_range(line.saturating_sub(1) as usize);
        range.map_or("", |range| self.text[range].trim_end_matches(['\n', '\r']))
    }
}

/// The registered source texts: all files that diagnostics can point into.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<Arc<SourceFile>>,
}

impl Sources {
    /// Creates an empty set of source texts.
    pub fn new() -> Self {
        Self::default()
    }

    /// Registers a source text and returns its identifier. If the name is registered already, as for a file that
    /// changed on disk, the new text gets another identifier and the older text stays.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> FileId {
        self.files.push(Arc::new(SourceFile::new(name.into(), text.into())));
        FileId(self.files.len() as u32 - 1)
    }

    /// Replaces the contents of a registered file. Earlier spans into the file become invalid; earlier clones of this
    /// `Sources` keep the old contents.
    pub fn replace(&mut self, file: FileId, text: impl Into<Arc<str>>) {
        if let Some(known) = self.files.get_mut(file.0 as usize) {
            *known = Arc::new(SourceFile::new(known.name.clone(), text.into()));
        }
    }

    /// The file with this identifier; `None` if it is not registered here.
    pub fn get(&self, file: FileId) -> Option<&Arc<SourceFile>> {
        self.files.get(file.0 as usize)
    }

    /// The identifier of the file registered last under `name`; `None` for an unknown name.
    pub fn find(&self, name: &str) -> Option<FileId> {
        self.files.iter().rposition(|file| file.name == name).map(|at| FileId(at as u32))
    }

    /// The registered files with their identifiers, in the order of registration.
    pub fn iter(&self) -> impl Iterator<Item = (FileId, &Arc<SourceFile>)> {
        self.files.iter().enumerate().map(|(at, file)| (FileId(at as u32), file))
    }

    /// The part of the source text that a span covers; empty if the span lies outside of the text.
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
