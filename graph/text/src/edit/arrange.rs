//! Members of a container put in, taken out and put elsewhere.
//!
//! All three come down to one: the members that are wanted, each kept or new, in their order ([`arrange`]). Between two
//! that are kept, what stood there is removed and what is new is put. A removed member takes along the space on one
//! side: of the two gaps around it the one with more line ends stays, so that groups stay apart and comments end their
//! lines. A new one takes the gap of the neighbour that it is put before, else of the one that it follows.

use std::ops::Range;

use serde_json::Value as Json;

use super::layout::{Layout, ends_in_line_comment, line_end, line_start, step};
use super::{Edit, EditError, Edits};
use crate::document::Value;
use crate::document::format::{self, WIDTH};

/// A member or an element to insert into an object or array.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    key: Option<String>,
    content: Content,
}

#[derive(Clone, Debug, PartialEq)]
enum Content {
    Value(Json),
    /// A member copied from a source text, with the comments before and after it.
    Written {
        head: String,
        tail: String,
        indentation: String,
    },
}

impl Item {
    /// Creates an element of an array.
    pub fn element(value: Json) -> Self {
        Self { key: None, content: Content::Value(value) }
    }

    /// Creates a member of an object.
    pub fn member(key: impl Into<String>, value: Json) -> Self {
        Self { key: Some(key.into()), content: Content::Value(value) }
    }

    /// Copies the member or element with index `at` of an object or array, with its comments.
    ///
    /// # Errors
    /// A value that is not an array or object of the text, or an index beyond its last member.
    pub fn copied(text: &str, container: &Value, at: usize) -> Result<Self, EditError> {
        let layout = Layout::of(text, container)?;
        let count = layout.members.len();
        let member = layout.members.get(at).ok_or(EditError::NoPosition { at, count })?;
        let before_comma = &text[member.value_end..member.comma.unwrap_or(member.value_end)];
        let behind = &text[member.comma.map_or(member.value_end, |comma| comma + 1)..member.end];
        let before_comma = if behind.is_empty() { before_comma.trim_end() } else { before_comma };
        Ok(Self {
            key: container.entries().map(|entries| entries[at].key.clone()),
            content: Content::Written {
                head: text[member.start..member.value_end].to_owned(),
                tail: [before_comma, behind].concat(),
                indentation: layout.indentation(member.start).to_owned(),
            },
        })
    }

    /// Returns `true` if the item starts with a comment and has several lines, so that it must begin a line.
    fn begins_line(&self) -> bool {
        matches!(&self.content, Content::Written { head, .. } if head.starts_with('/') && head.contains('\n'))
    }

    fn ends_in_line_comment(&self) -> bool {
        matches!(&self.content, Content::Written { tail, .. } if ends_in_line_comment(tail))
    }

    /// Returns the item's source text, to be placed at `column` (in characters) of a line with the given indentation.
    /// `comma` is inserted after the value, before trailing comments.
    fn written(&self, text: &str, column: usize, indentation: &str, comma: &str) -> String {
        match &self.content {
            Content::Value(value) => laid_out(text, self.key.as_deref(), value, column, indentation) + comma,
            Content::Written { head, tail, indentation: old } => {
                let written = format!("{head}{comma}{tail}");
                let mut lines = written.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line));
                let first = lines.next().unwrap_or_default().to_owned();
                lines.fold(first, |written, line| match line.strip_prefix(old.as_str()) {
                    Some(rest) => written + line_end(text) + indentation + rest,
                    None => written + line_end(text) + line,
                })
            }
        }
    }
}

/// Prints a JSON value, as an object member if `key` is given, to be placed at `column` (in characters) of a line with
/// the given indentation. Line ends and indentation steps are those that `text` uses.
pub(super) fn laid_out(
    text: &str,
    key: Option<&str>,
    value: &Json,
    column: usize,
    indentation: &str,
) -> String {
    let printed = format::print_value(key, value, column, indentation.len(), 1);
    let mut lines = printed.split('\n');
    let first = lines.next().unwrap_or_default().to_owned();
    lines.fold(first, |laid_out, line| {
        let inside = line.trim_start_matches(' ');
        let depth = (line.len() - inside.len()).saturating_sub(indentation.len()) / format::INDENT;
        laid_out + line_end(text) + indentation + &step(text).repeat(depth) + inside
    })
}

/// Returns the edits that insert a member or element at index `at` of an object or array. An index equal to the number
/// of members appends the item.
///
/// # Errors
/// A value that is not an array or object of the text, or an index beyond its end. An item without a key for an object,
/// with a key for an array, or with a key that exists already.
pub fn insert(text: &str, container: &Value, at: usize, item: &Item) -> Result<Edits, EditError> {
    let layout = Layout::of(text, container)?;
    let count = layout.members.len();
    if at > count {
        return Err(EditError::NoPosition { at, count: count + 1 });
    }
    match &item.key {
        key if key.is_some() != layout.is_object => return Err(EditError::Key),
        Some(key) if container.get(key).is_some() => return Err(EditError::KeyTaken(key.clone())),
        _ => {}
    }
    let mut wanted: Vec<Wanted<'_>> = (0..count).map(Wanted::Kept).collect();
    wanted.insert(at, Wanted::New(item));
    Edits::new(arrange(&layout, &wanted))
}

/// Returns the edits that remove the member or element with index `at`, with its comma and comments.
///
/// # Errors
/// A value that is not an array or object of the text, or an index beyond its last member.
pub fn remove(text: &str, container: &Value, at: usize) -> Result<Edits, EditError> {
    let layout = Layout::of(text, container)?;
    let count = layout.members.len();
    let mut wanted: Vec<Wanted<'_>> = (0..count).map(Wanted::Kept).collect();
    if at >= count {
        return Err(EditError::NoPosition { at, count });
    }
    wanted.remove(at);
    Edits::new(arrange(&layout, &wanted))
}

/// Returns the edits that move the member or element with index `from` of an object or array, with its comments, to
/// index `to`.
///
/// # Errors
/// A value that is not an array or object of the text, or an index beyond its last member.
pub fn reorder(text: &str, container: &Value, from: usize, to: usize) -> Result<Edits, EditError> {
    let item = Item::copied(text, container, from)?;
    let layout = Layout::of(text, container)?;
    let count = layout.members.len();
    if to >= count {
        return Err(EditError::NoPosition { at: to, count });
    }
    if from == to {
        return Ok(Edits::default());
    }
    let mut wanted: Vec<Wanted<'_>> = (0..count).map(Wanted::Kept).collect();
    wanted.remove(from);
    wanted.insert(to, Wanted::New(&item));
    Edits::new(arrange(&layout, &wanted))
}

/// A member or element that an object or array has after an edit.
pub(super) enum Wanted<'i> {
    /// An existing member, by its index. Existing members keep their order.
    Kept(usize),
    New(&'i Item),
}

/// Returns the edits that give an object or array exactly the wanted members, in that order.
pub(super) fn arrange(layout: &Layout<'_>, wanted: &[Wanted<'_>]) -> Vec<Edit> {
    let mut edits = Vec::new();
    let (mut before, mut new) = (None, Vec::new());
    for one in wanted {
        match one {
            Wanted::New(item) => new.push(*item),
            Wanted::Kept(at) => {
                Slot { layout, before, behind: Some(*at), new: std::mem::take(&mut new) }.fill(&mut edits);
                before = Some(*at);
            }
        }
    }
    Slot { layout, before, behind: None, new }.fill(&mut edits);
    edits
}

/// The gap between two kept members, or between a kept member and a bracket.
struct Slot<'s, 't> {
    layout: &'s Layout<'t>,
    before: Option<usize>,
    behind: Option<usize>,
    new: Vec<&'s Item>,
}

impl Slot<'_, '_> {
    fn fill(&self, edits: &mut Vec<Edit>) {
        let Layout { text, members, start, open, close, .. } = self.layout;
        self.mend_comma(edits);
        let removed = self.before.map_or(0, |at| at + 1)..self.behind.unwrap_or(members.len());
        let blocks = self.blocks(removed);
        let mut rest = blocks.as_slice();
        match (self.new.is_empty(), rest) {
            (true, _) => {}
            (false, [first, others @ ..]) => {
                edits.push(self.in_place_of(first.clone()));
                rest = others;
            }
            (false, []) => match (self.before, self.behind) {
                (Some(before), _) => self.behind_member(before, edits),
                (None, Some(behind)) => edits.push(self.before_first(behind)),
                (None, None) => edits.push(self.in_empty()),
            },
        }
        for block in rest {
            let [before, behind] =
                [self.layout.space_before(block.start), self.layout.space_behind(block.end)];
            let [above, below] = [&before, &behind].map(|gap| self.layout.line_ends(gap.clone()));
            let is_last = behind.end == *close;
            let mut replacement = String::new();
            let range = match is_last {
                true if before.start == *start => *start..*close,
                true if below == 0 && self.layout.is_commented_out(before.start) => {
                    replacement = line_end(text).to_owned() + self.layout.indentation(*start);
                    before.start..behind.end
                }
                false if before.start <= *open || above > below => block.start..behind.end,
                _ => before.start..block.end,
            };
            edits.push(Edit { range, replacement });
        }
    }

    /// The byte ranges of removed members; members with only white space between them share one range.
    fn blocks(&self, removed: Range<usize>) -> Vec<Range<usize>> {
        let mut blocks: Vec<Range<usize>> = Vec::new();
        for member in &self.layout.members[removed] {
            match blocks.last_mut() {
                Some(last) if self.layout.space_before(member.start).start <= last.end => {
                    last.end = member.end;
                }
                _ => blocks.push(member.start..member.end),
            }
        }
        blocks
    }

    /// Adds or removes the comma after the member before the gap, so that there is a comma exactly if another member
    /// follows.
    fn mend_comma(&self, edits: &mut Vec<Edit>) {
        let Some(member) = self.before.map(|at| &self.layout.members[at]) else { return };
        let is_wanted = self.behind.is_some() || !self.new.is_empty();
        let range = match (member.comma, is_wanted) {
            (None, true) => member.value_end..member.value_end,
            (Some(comma), false) if self.layout.space_before(comma).start <= member.value_end => {
                member.value_end..comma + 1
            }
            (Some(comma), false) => comma..comma + 1,
            _ => return,
        };
        edits.push(Edit { range, replacement: if is_wanted { "," } else { "" }.to_owned() });
    }

    /// Returns the edit that replaces the byte range of removed members with the new members.
    fn in_place_of(&self, range: Range<usize>) -> Edit {
        let lines = usize::from(self.layout.begins_line(range.start));
        let row = self.row(range.start, None, lines) + &self.line_end_before(range.end);
        Edit { range, replacement: row }
    }

    /// Adds the edit that inserts the new members after the kept member with index `before`. They are separated by as
    /// many line ends as the neighbouring members.
    fn behind_member(&self, before: usize, edits: &mut Vec<Edit>) {
        let Layout { text, members, .. } = self.layout;
        let at = members[before].end;
        let gaps = if before > 0 { before..before + 2 } else { 1..3 };
        let gaps = gaps.filter(|at| *at < members.len()).map(|at| self.lines_before(at));
        let lines = gaps.min().unwrap_or_else(|| self.lines_before(before).min(1));
        let row = self.row(at, Some(lines), lines) + &self.line_end_before(at);
        match (edits.last_mut().filter(|last| last.range == (at..at)), members[before].comma) {
            (Some(comma), _) => comma.replacement.push_str(&row),
            // Written again, so that no other edit removes it at the same time.
            (None, Some(comma)) => {
                edits.push(Edit { range: comma..at, replacement: text[comma..at].to_owned() + &row });
            }
            (None, None) => edits.push(Edit { range: at..at, replacement: row }),
        }
    }

    /// Returns the edit that inserts the new members before the first kept member, which has the index `behind`.
    fn before_first(&self, behind: usize) -> Edit {
        let at = self.layout.members[behind].start;
        let next = (behind + 1..self.layout.members.len()).take(2).map(|at| self.lines_before(at));
        let lines = next.min().unwrap_or_else(|| self.lines_before(behind).min(1));
        let is_commented = self.new.last().is_some_and(|item| item.ends_in_line_comment());
        let gap = self.gap(lines.max(usize::from(is_commented)));
        Edit { range: at..at, replacement: self.row(at, None, lines) + &gap }
    }

    /// Returns the edit that inserts the new members into an empty object or array.
    fn in_empty(&self) -> Edit {
        let Layout { text, start, close, is_object, .. } = *self.layout;
        let from = self.layout.space_before(close).start.max(start);
        let row = self.row(from, None, 0);
        let first = row.split('\n').next().unwrap_or_default().chars().count();
        let has_lines = self.layout.line_ends(start..close) > 0
            || ends_in_line_comment(&text[start..from])
            || self.new.iter().any(|item| item.begins_line() || item.ends_in_line_comment())
            || self.column(from, "") + first + 3 > WIDTH;
        let replacement = if has_lines {
            let end = line_end(text).to_owned() + self.layout.indentation(start);
            self.row(from, Some(1), 1) + &end
        } else {
            let space = if is_object || from > start { " " } else { "" };
            format!("{space}{row}{space}")
        };
        Edit { range: from..close, replacement }
    }

    /// Returns the source text of the new members with their commas, separated by `lines` line ends (0 for a space).
    /// `first` is the number of line ends before the first member; `None` for no gap at all.
    fn row(&self, at: usize, first: Option<usize>, lines: usize) -> String {
        let Layout { text, .. } = *self.layout;
        let is_broken = self.layout.members.iter().any(|member| self.layout.begins_line(member.start));
        let mut is_commented = self.layout.is_commented_out(at);
        let mut row = String::new();
        for (index, item) in self.new.iter().enumerate() {
            let is_last = self.behind.is_none() && index + 1 == self.new.len();
            let comma = if is_last { "" } else { "," };
            let written = |row: &str| {
                let own = self.layout.member_indentation();
                let indentation = if row.contains('\n') { &own } else { self.layout.indentation(at) };
                item.written(text, self.column(at, row), indentation, comma)
            };
            let gap = if index == 0 { first } else { Some(lines) };
            let has_to_begin = item.begins_line() && (index > 0 || !self.layout.begins_line(at));
            if gap.is_some() || has_to_begin {
                let is_too_wide = || {
                    let next = format!("{row} ");
                    let line = written(&next).split('\n').next().map_or(0, |line| line.chars().count());
                    is_broken && self.column(at, &next) + line > WIDTH
                };
                let lines = gap.unwrap_or_default();
                let breaks = lines == 0 && (has_to_begin || is_commented || is_too_wide());
                row.push_str(&self.gap(if breaks { 1 } else { lines }));
            }
            row.push_str(&written(&row));
            is_commented = item.ends_in_line_comment();
        }
        row
    }

    /// Returns a space if `lines` is 0, otherwise that many line ends and the indentation of the next line.
    fn gap(&self, lines: usize) -> String {
        match lines {
            0 => " ".to_owned(),
            _ => line_end(self.layout.text).repeat(lines) + &self.layout.member_indentation(),
        }
    }

    /// The number of line ends directly before the member with index `at`, at most two.
    fn lines_before(&self, at: usize) -> usize {
        let before = self.layout.space_before(self.layout.members[at].start);
        self.layout.line_ends(before).min(2)
    }

    /// Returns a line end if the new members end in a line comment and no line end follows at `at`; otherwise nothing.
    fn line_end_before(&self, at: usize) -> String {
        let Layout { text, start, .. } = *self.layout;
        let is_commented = self.new.last().is_some_and(|item| item.ends_in_line_comment());
        if !is_commented || self.layout.line_ends(self.layout.space_behind(at)) > 0 {
            return String::new();
        }
        match self.behind {
            Some(_) => self.gap(1),
            None => line_end(text).to_owned() + self.layout.indentation(start),
        }
    }

    /// The column, in characters, after `following` is written at the byte offset `at`.
    fn column(&self, at: usize, following: &str) -> usize {
        match following.rfind('\n') {
            Some(end) => following[end + 1..].chars().count(),
            None => {
                self.layout.text[line_start(self.layout.text, at)..at].chars().count()
                    + following.chars().count()
            }
        }
    }
}
