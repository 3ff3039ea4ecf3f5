//! Prints the tree as canonical text.

use serde_json::Value;

use super::tree::{Comment, Container, Gap, Item, Node, Text, quoted, width};
use super::{INDENT, WIDTH};

/// Prints a document, with its comments, in the canonical layout.
pub(super) fn print(text: &Text<'_>) -> String {
    let mut printer = Printer { out: String::new(), line_start: 0 };
    printer.leading(&text.leading, text.gap, 0);
    printer.node(&text.root, 0, 0);
    for comment in &text.trailing {
        printer.separate(comment.gap, 0);
        printer.comment(comment);
    }
    printer.out.push('\n');
    printer.out
}

/// Prints a value, or the member `key` with it, to be placed at a column of a line with the given indentation. `tail`
/// is the number of characters that will follow on its last line. All numbers are in characters.
pub(crate) fn print_value(
    key: Option<&str>,
    value: &Value,
    column: usize,
    indent: usize,
    tail: usize,
) -> String {
    let mut printer = Printer { out: " ".repeat(column), line_start: 0 };
    printer.key(key.map(quoted).as_deref());
    printer.node(&Node::of(value), indent, tail);
    printer.out.split_off(column)
}

struct Printer {
    out: String,
    /// The byte offset in `out` of the start of the last line.
    line_start: usize,
}

impl Printer {
    fn column(&self) -> usize {
        width(&self.out[self.line_start..])
    }

    fn write(&mut self, text: &str) {
        self.out.push_str(text);
        if let Some(at) = text.rfind('\n') {
            self.line_start = self.out.len() - text.len() + at + 1;
        }
    }

    fn line(&mut self, indent: usize) {
        self.write("\n");
        self.out.extend(std::iter::repeat_n(' ', indent));
    }

    /// Writes a space if `gap` has no line ends, a line break for one, and a blank line for more. The new line is
    /// indented by `indent` spaces.
    fn separate(&mut self, gap: Gap, indent: usize) {
        if gap.is_blank_line() {
            self.write("\n");
        }
        if gap.is_line_end() { self.line(indent) } else { self.write(" ") }
    }

    /// Returns `true` if this many further characters fit on the current line.
    fn fits(&self, characters: usize) -> bool {
        characters <= WIDTH && self.column() + characters <= WIDTH
    }

    /// Prints a comment. If a block comment begins a line, its further lines are moved by as many columns as the first.
    fn comment(&mut self, comment: &Comment) {
        let begins_line = self.out[self.line_start..].bytes().all(|byte| byte == b' ');
        let (from, to) = match comment.column {
            Some(column) if begins_line => (column, self.column()),
            _ => (0, 0),
        };
        for (at, line) in comment.text.split('\n').enumerate() {
            if at == 0 {
                self.write(line);
                continue;
            }
            self.write("\n");
            let space = line.chars().take_while(|character| character.is_whitespace()).count();
            let cut = line.chars().take(space.min(from.saturating_sub(to))).map(char::len_utf8).sum();
            if !line.is_empty() {
                self.out.extend(std::iter::repeat_n(' ', to.saturating_sub(from)));
            }
            self.write(&line[cut..]);
        }
    }

    /// Prints the comments before a member or value; `gap` has the line ends after the last comment.
    fn leading(&mut self, comments: &[Comment], gap: Gap, indent: usize) {
        for (at, comment) in comments.iter().enumerate() {
            self.comment(comment);
            let next = comments.get(at + 1).map_or(gap, |comment| comment.gap);
            self.separate(if comment.is_line() { Gap(next.0.max(1)) } else { next }, indent);
        }
    }

    fn behind(&mut self, comments: &[Comment]) {
        for comment in comments {
            self.write(" ");
            self.comment(comment);
        }
    }

    /// Prints a value; `tail` is the number of characters that will follow on its last line. Returns `true` if it takes
    /// several lines.
    fn node(&mut self, node: &Node<'_>, indent: usize, tail: usize) -> bool {
        if let Some(flat) = node.flat()
            && self.fits(width(flat) + tail)
        {
            self.write(flat);
            return false;
        }
        match node {
            Node::Scalar(text) => {
                self.write(text);
                node.flat().is_none()
            }
            Node::Container(container) => self.container(container, indent, tail),
        }
    }

    fn container(&mut self, container: &Container<'_>, indent: usize, tail: usize) -> bool {
        let [open, close] = container.brackets();
        self.write(open);
        if container.items.is_empty() && container.opening.is_empty() && container.closing.is_empty() {
            self.write(close);
            return false;
        }
        if let Some(Item { key, value: value @ Node::Container(inner), .. }) = container.only_item()
            && !inner.items.is_empty()
        {
            let space = if container.is_object { " " } else { "" };
            self.write(space);
            self.key(key.as_deref());
            self.node(value, indent, tail + width(space) + width(close));
            self.write(space);
            self.write(close);
            return true;
        }
        self.behind(&container.opening);
        self.items(container, indent + INDENT);
        for (at, comment) in container.closing.iter().enumerate() {
            let first = container.items.is_empty() && at == 0;
            self.separate(if first { Gap(1) } else { comment.gap }, indent + INDENT);
            self.comment(comment);
        }
        self.line(indent);
        self.write(close);
        true
    }

    fn items(&mut self, container: &Container<'_>, indent: usize) {
        let one_per_line = !container.broken && !container.is_list();
        let mut ends_line = true;
        for (at, item) in container.items.iter().enumerate() {
            let is_last = at + 1 == container.items.len();
            let comma = if is_last { "" } else { "," };
            let start = item.start();
            let same_line = !ends_line
                && !start.is_line_end()
                && item.flat().is_some_and(|flat| self.fits(1 + width(&flat) + comma.len()));
            if same_line {
                self.write(" ");
            } else {
                let max = if at == 0 { 1 } else { 2 };
                self.separate(Gap(start.0.clamp(1, max)), indent);
            }
            self.leading(&item.leading, item.gap, indent);
            self.key(item.key.as_deref());
            let before_comma =
                item.before_comma.iter().map(|comment| 1 + width(&comment.text)).sum::<usize>();
            let broken = self.node(&item.value, indent, before_comma + comma.len());
            self.behind(&item.before_comma);
            self.write(comma);
            self.behind(&item.trailing);
            ends_line = broken || one_per_line || !item.trailing.is_empty();
        }
    }

    fn key(&mut self, key: Option<&str>) {
        if let Some(key) = key {
            self.write(key);
            self.write(": ");
        }
    }
}
