//! Layout of the members of a container in a text: the comments, the comma and the line of each.
//!
//! Only the text between the values is read, and that holds space, comments and commas alone: the cost is that of one
//! container however long the text is, and errors elsewhere in the text do no harm.
//!
//! Comments are shared out as the formatter does it (see [`crate::document::format`]): those behind a member on its
//! line are the member's, and those before the next one the next one's. Those that a blank line separates from what
//! follows are nobody's, such as the title of a section.

use std::ops::Range;

use super::EditError;
use crate::document::{Kind, Value};

/// The layout of an array or an object in its source text. Positions are byte offsets.
pub(super) struct Layout<'t> {
    pub(super) text: &'t str,
    pub(super) is_object: bool,
    /// The byte offset of the end of the opening bracket.
    pub(super) start: usize,
    /// The byte offset of the end of the opening bracket and of the comments after it on its line.
    pub(super) open: usize,
    /// The byte offset of the start of the closing bracket.
    pub(super) close: usize,
    pub(super) members: Vec<Member>,
}

/// The byte offsets of a member or an element, with its comments and comma.
pub(super) struct Member {
    /// The byte offset of the start of the member's first comment, or of the member itself if it has none.
    pub(super) start: usize,
    /// The byte offset of the end of the value.
    pub(super) value_end: usize,
    /// The byte offset of the comma; `None` if there is none.
    pub(super) comma: Option<usize>,
    /// The byte offset of the end of the member with its comma and the comments after it on the line.
    pub(super) end: usize,
}

impl<'t> Layout<'t> {
    /// Finds the comments and the comma of each member of an array or object.
    ///
    /// # Errors
    /// A value that is no array or object, or is not in this text.
    pub(super) fn of(text: &'t str, value: &Value) -> Result<Self, EditError> {
        let (is_object, places) = match &value.kind {
            Kind::Array(elements) => (false, elements.iter().map(|one| (one.span, one.span)).collect()),
            Kind::Object(entries) => {
                (true, entries.iter().map(|entry| (entry.key_span, entry.value.span)).collect::<Vec<_>>())
            }
            _ => return Err(EditError::NoContainer),
        };
        let whole = value.span.range();
        let last = text.get(whole.clone()).ok_or(EditError::Outside(whole.clone()))?;
        let close = whole.end - usize::from(last.len() > 1 && last.ends_with(['}', ']']));
        let start = whole.start + 1;
        let mut layout = Self { text, is_object, start, open: start, close, members: Vec::new() };
        let mut at = start;
        for (first, last) in places {
            let is_here = (first.file, last.file) == (value.span.file, value.span.file);
            let (start, value_end) = (first.start as usize, last.end as usize);
            if !is_here || start < at || value_end > close {
                return Err(EditError::NoContainer);
            }
            let start = layout.share_out(at..start, false)?;
            layout.members.push(Member { start, value_end, comma: None, end: value_end });
            at = value_end;
        }
        layout.share_out(at..close, true)?;
        Ok(layout)
    }

    /// Assigns the comments and the comma in the byte range `between` to the members before and after it. Returns the
    /// byte offset at which the next member begins, comments included.
    fn share_out(&mut self, between: Range<usize>, is_last: bool) -> Result<usize, EditError> {
        let Range { start, end } = between.clone();
        let gap = self.text.get(between.clone()).ok_or(EditError::Outside(between))?;
        let (mut comma, mut before_comma) = (None, 0);
        let (mut comments, mut at, mut line_ends): (Vec<(Range<usize>, usize)>, _, _) = (Vec::new(), 0, 0);
        while let Some(first) = gap.as_bytes().get(at) {
            let length = comment_length(gap, at);
            match first {
                b',' => (comma, before_comma) = (Some(start + at), comments.len()),
                _ if length > 0 => {
                    comments.push((start + at..start + at + length, std::mem::take(&mut line_ends)));
                }
                _ => line_ends += usize::from(ends_line(gap, at)),
            }
            at += length.max(1);
        }
        let on_line = comments.iter().position(|(_, line_ends)| *line_ends > 0);
        let ends_here = if line_ends > 0 || is_last { comments.len() } else { 0 };
        let trailing = on_line.unwrap_or(ends_here).max(before_comma);
        let mut own_end = comma.map_or(start, |comma| comma + 1);
        if let Some((comment, _)) = comments[..trailing].last() {
            own_end = own_end.max(comment.end);
        }
        match self.members.last_mut() {
            Some(member) => (member.comma, member.end) = (comma, own_end),
            None => self.open = own_end,
        }
        let (mut next, mut distance) = (end, line_ends);
        for (comment, line_ends) in comments[trailing..].iter().rev() {
            if distance > 1 || is_last {
                break;
            }
            (next, distance) = (comment.start, *line_ends);
        }
        Ok(next)
    }

    /// The byte range of the white space directly before a byte offset.
    pub(super) fn space_before(&self, at: usize) -> Range<usize> {
        self.text[..at].trim_end_matches(SPACE).len()..at
    }

    /// The byte range of the white space directly after a byte offset.
    pub(super) fn space_behind(&self, at: usize) -> Range<usize> {
        let rest = &self.text[at..];
        at..at + rest.len() - rest.trim_start_matches(SPACE).len()
    }

    /// The number of line ends in a byte range.
    pub(super) fn line_ends(&self, range: Range<usize>) -> usize {
        let text = &self.text[range];
        (0..text.len()).filter(|at| ends_line(text, *at)).count()
    }

    /// Returns `true` if a byte offset is preceded by a line end, with only white space in between.
    pub(super) fn begins_line(&self, at: usize) -> bool {
        self.line_ends(self.space_before(at)) > 0
    }

    /// Returns `true` if a byte offset between members is inside or at the end of a line comment (`//`).
    pub(super) fn is_commented_out(&self, at: usize) -> bool {
        let before = self.members.iter().rev().find(|member| member.value_end <= at);
        let from = before.map_or(self.start, |member| member.value_end);
        ends_in_line_comment(&self.text[from..at])
    }

    /// The indentation of the line that contains a byte offset.
    pub(super) fn indentation(&self, at: usize) -> &'t str {
        let line = &self.text[line_start(self.text, at)..];
        &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
    }

    /// The indentation of members that begin a line, taken from the first member at the start of a line. If there is
    /// none, one level more than the line of the opening bracket.
    pub(super) fn member_indentation(&self) -> String {
        match self.members.iter().find(|member| self.begins_line(member.start)) {
            Some(member) => self.indentation(member.start).to_owned(),
            None => self.indentation(self.open).to_owned() + step(self.text),
        }
    }
}

pub(super) const SPACE: [char; 4] = [' ', '\t', '\n', '\r'];

/// The length, in bytes, of the comment that begins at a byte offset; 0 if none does.
fn comment_length(text: &str, at: usize) -> usize {
    let rest = || &text[at..];
    match &text.as_bytes()[at..] {
        [b'/', b'/', ..] => rest().find(['\n', '\r']).unwrap_or(text.len() - at),
        [b'/', b'*', ..] => rest().find("*/").map_or(text.len() - at, |end| end + 2),
        _ => 0,
    }
}

/// Returns `true` if a text of comments, commas and white space ends in a line comment (`//`).
pub(super) fn ends_in_line_comment(text: &str) -> bool {
    let mut at = 0;
    while at < text.len() {
        let length = comment_length(text, at);
        if length > 0 && at + length == text.len() {
            return text[at..].starts_with("//");
        }
        at += length.max(1);
    }
    false
}

fn ends_line(text: &str, at: usize) -> bool {
    match text.as_bytes() {
        bytes if bytes[at] == b'\n' => true,
        bytes => bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n'),
    }
}

/// The byte offset of the start of the line that contains the byte offset `at`.
pub(super) fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind(['\n', '\r']).map_or(0, |end| end + 1)
}

/// The line end that a text uses, `\n` or `\r\n`, taken from its first line.
pub(super) fn line_end(text: &str) -> &'static str {
    match text.find('\n') {
        Some(at) if text[..at].ends_with('\r') => "\r\n",
        _ => "\n",
    }
}

/// The indentation of one level in a text, taken from its first indented line; two spaces if there is none.
pub(super) fn step(text: &str) -> &str {
    let indentation = |line: &'_ str| line.len() - line.trim_start_matches([' ', '\t']).len();
    let mut lines = text.lines().filter(|line| !line.trim_start().starts_with(['/', '*']));
    lines.find_map(|line| line.get(..indentation(line)).filter(|space| !space.is_empty())).unwrap_or("  ")
}
