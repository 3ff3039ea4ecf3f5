//! Positions, ranges and addresses as the protocol writes them.
//!
//! A position is a line and a count of code units before it on that line: bytes or UTF-16, as client and server agree.

use std::path::{Path, PathBuf};
use std::str::FromStr as _;

use lsp_types::{Position, Range, Uri};

use umbragraph_graph::source::{SourceFile, Span};

/// The unit in which the protocol's positions count columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Bytes.
    Utf8,
    /// UTF-16 code units, the protocol's default.
    Utf16,
}

impl Encoding {
    fn units(self, text: &str) -> u32 {
        let units = match self {
            Encoding::Utf8 => text.len(),
            Encoding::Utf16 => text.chars().map(char::len_utf16).sum(),
        };
        u32::try_from(units).unwrap_or(u32::MAX)
    }

    /// Converts a byte offset in a file to the protocol's position: zero-based line and column.
    pub(crate) fn position(self, file: &SourceFile, offset: u32) -> Position {
        let line = file.line_column(offset).line - 1;
        let start = file.line_range(line as usize).map_or(0, |range| range.start);
        let mut end = (offset as usize).min(file.text().len());
        while !file.text().is_char_boundary(end) {
            end -= 1;
        }
        Position { line, character: self.units(file.text().get(start..end).unwrap_or_default()) }
    }

    /// Converts a source range to the protocol's range.
    pub(crate) fn range(self, file: &SourceFile, place: Span) -> Range {
        Range { start: self.position(file, place.start), end: self.position(file, place.end) }
    }

    /// Converts the protocol's position to a byte offset in a file. A column beyond its line gives the end of the line,
    /// a line beyond the last the end of the file.
    pub(crate) fn offset(self, file: &SourceFile, position: Position) -> usize {
        let Some(line) = file.line_range(position.line as usize) else { return file.text().len() };
        let text = file.text()[line.clone()].trim_end_matches(['\n', '\r']);
        let mut units = 0;
        for (at, character) in text.char_indices() {
            if units >= position.character {
                return line.start + at;
            }
            units += self.units(character.encode_utf8(&mut [0; 4]));
        }
        line.start + text.len()
    }
}

/// Returns the path of a `file:` URI, percent-decoded; `None` for other URIs.
pub(crate) fn path_of(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.as_str().strip_prefix("file://")?;
    let path = rest.find('/').map(|at| &rest[at..])?;
    let mut bytes = Vec::new();
    let mut left = path.as_bytes();
    while let Some((first, rest)) = left.split_first() {
        let code = rest.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        match (first, code.and_then(|code| u8::from_str_radix(code, 16).ok())) {
            (b'%', Some(byte)) => {
                bytes.push(byte);
                left = &rest[2..];
            }
            _ => {
                bytes.push(*first);
                left = rest;
            }
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // A drive: "/C:/folder".
    let is_drive = path.as_bytes().get(2) == Some(&b':');
    Some(PathBuf::from(if is_drive { &path[1..] } else { &path }))
}

/// Returns `true` if a path is absolute, and so is not the name of a file bundled with the module. In a browser, where
/// Rust counts no path as absolute, a path that begins with `/` is absolute.
pub(crate) fn is_whole(path: &Path) -> bool {
    path.is_absolute() || cfg!(target_family = "wasm") && path.has_root()
}

/// Returns the `file:` URI of an absolute path; `None` if the path is not valid UTF-8.
pub(crate) fn uri_of(path: &Path) -> Option<Uri> {
    let mut uri = "file://".to_owned();
    let text = path.to_str()?.replace('\\', "/");
    if !text.starts_with('/') {
        uri.push('/');
    }
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(byte as char);
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    Uri::from_str(&uri).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_graph::source::Sources;

    #[test]
    fn positions_count_units_and_end_with_their_line() {
        let mut sources = Sources::new();
        let id = sources.add("t", "a\u{1f600}b\r\nc");
        let file = sources.get(id).unwrap();
        for (encoding, b) in [(Encoding::Utf8, 5), (Encoding::Utf16, 3)] {
            assert_eq!(encoding.position(file, 5), Position { line: 0, character: b });
            assert_eq!(encoding.offset(file, Position { line: 0, character: b }), 5);
            assert_eq!(encoding.offset(file, Position { line: 0, character: 90 }), 6);
            assert_eq!(encoding.offset(file, Position { line: 1, character: 1 }), 9);
            assert_eq!(encoding.offset(file, Position { line: 7, character: 0 }), 9);
        }
    }

    #[test]
    fn addresses_lead_to_paths_and_back() {
        for path in ["/a b/ü.json", "/x/100%.json"] {
            assert_eq!(path_of(&uri_of(Path::new(path)).unwrap()).unwrap(), Path::new(path));
        }
        let uri = Uri::from_str("file:///c%3A/a.json").unwrap();
        assert_eq!(path_of(&uri).unwrap(), Path::new("c:/a.json"));
        assert!(path_of(&Uri::from_str("untitled:Untitled-1").unwrap()).is_none());
    }
}
