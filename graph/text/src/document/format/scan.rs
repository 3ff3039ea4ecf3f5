//! Builds the tree from raw tokens, with each comment attached to its element.
//!
//! The text has been parsed before; nothing is checked again. What cannot be read nevertheless ends the tree early and
//! without a panic.

use jsonc_parser::Scanner;
use jsonc_parser::tokens::Token;

use super::super::tokens::STRICT_TOKENS;
use super::tree::{Comment, Container, Gap, Item, Node, Text, width};

/// Reads a valid source text into the formatter's tree.
pub(super) fn scan(text: &str) -> Text<'_> {
    let scanner = Scanner::new(text, &STRICT_TOKENS);
    let mut reader = Reader { text, scanner, next: Lexeme::End, gap: Gap(0) };
    reader.advance();
    let leading = reader.comments();
    let gap = reader.gap;
    let root = reader.node();
    let trailing = reader.comments();
    Text { leading, gap, root, trailing }
}

enum Lexeme<'a> {
    Open { is_object: bool },
    Close,
    Comma,
    Colon,
    Scalar(&'a str),
    Comment { text: &'a str, column: Option<usize> },
    End,
}

struct Reader<'a> {
    text: &'a str,
    scanner: Scanner<'a>,
    /// The next lexeme; `gap` is the number of line ends between the previous lexeme and this one.
    next: Lexeme<'a>,
    gap: Gap,
}

impl<'a> Reader<'a> {
    fn advance(&mut self) {
        let before = self.scanner.token_end();
        let token = self.scanner.scan().ok().flatten();
        let (start, end) = (self.scanner.token_start(), self.scanner.token_end());
        let space = self.text.get(before..start).unwrap_or("");
        self.gap = Gap(line_ends(space));
        let raw = self.text.get(start..end).unwrap_or("");
        self.next = match token {
            None => Lexeme::End,
            Some(Token::OpenBrace) => Lexeme::Open { is_object: true },
            Some(Token::OpenBracket) => Lexeme::Open { is_object: false },
            Some(Token::CloseBrace | Token::CloseBracket) => Lexeme::Close,
            Some(Token::Comma) => Lexeme::Comma,
            Some(Token::Colon) => Lexeme::Colon,
            Some(Token::CommentLine(_) | Token::CommentBlock(_)) => {
                let begins_line = before == 0 || self.gap.is_line_end();
                let indent = space.rsplit(['\n', '\r']).next().unwrap_or("");
                Lexeme::Comment { text: raw, column: begins_line.then(|| width(indent)) }
            }
            Some(_) => Lexeme::Scalar(raw),
        };
    }

    /// Reads the comments that come next; afterwards `next` is no comment.
    fn comments(&mut self) -> Vec<Comment> {
        let mut comments = Vec::new();
        while let Lexeme::Comment { text, column } = self.next {
            let lines: Vec<&str> = text.split('\n').map(str::trim_end).collect();
            comments.push(Comment { text: lines.join("\n"), gap: self.gap, column });
            self.advance();
        }
        comments
    }

    fn node(&mut self) -> Node<'a> {
        match self.next {
            Lexeme::Open { is_object } => {
                self.advance();
                Node::Container(self.container(is_object))
            }
            Lexeme::Scalar(text) => {
                self.advance();
                Node::Scalar(text.into())
            }
            _ => Node::Scalar("null".into()),
        }
    }

    fn container(&mut self, is_object: bool) -> Container<'a> {
        let comments = self.comments();
        let (opening, mut leading) = self.share_out(comments);
        let mut items: Vec<Item<'a>> = Vec::new();
        while matches!(self.next, Lexeme::Open { .. } | Lexeme::Scalar(_)) {
            let mut item = self.item(is_object, leading);
            let mut after = self.comments();
            if matches!(self.next, Lexeme::Comma) {
                let blocks = after.iter().take_while(|comment| !comment.is_line()).count();
                let rest = after.split_off(blocks);
                item.before_comma = std::mem::replace(&mut after, rest);
                // The line ends on both sides of a comma count as one gap.
                let gap = self.gap.0;
                self.advance();
                let mut more = self.comments();
                let next = more.first_mut().map_or(&mut self.gap, |comment| &mut comment.gap);
                next.0 += gap;
                after.append(&mut more);
            }
            (item.trailing, leading) = self.share_out(after);
            items.push(item);
        }
        let end = self.gap;
        self.advance();
        Container::new(is_object, opening, items, leading, end)
    }

    fn item(&mut self, is_object: bool, mut leading: Vec<Comment>) -> Item<'a> {
        let mut gap = self.gap;
        let mut key = None;
        if let Lexeme::Scalar(text) = self.next
            && is_object
        {
            key = Some(text.into());
            self.advance();
            let mut inside = self.comments();
            if matches!(self.next, Lexeme::Colon) {
                self.advance();
            }
            inside.append(&mut self.comments());
            if let Some(first) = inside.first_mut() {
                first.gap = std::mem::take(&mut gap);
                for comment in &mut inside[1..] {
                    comment.gap = Gap(0);
                }
                for comment in &mut inside {
                    comment.column = None;
                }
            }
            leading.append(&mut inside);
        }
        Item { leading, gap, key, value: self.node(), before_comma: Vec::new(), trailing: Vec::new() }
    }

    /// Splits comments into those on the line of the previous member, and those that belong to the next member.
    fn share_out(&self, mut comments: Vec<Comment>) -> (Vec<Comment>, Vec<Comment>) {
        let first = comments.iter().position(|comment| comment.gap.is_line_end());
        let first = first.or_else(|| {
            let ends =
                self.gap.is_line_end() || !matches!(self.next, Lexeme::Open { .. } | Lexeme::Scalar(_));
            ends.then_some(comments.len())
        });
        let following = comments.split_off(first.unwrap_or(0));
        (comments, following)
    }
}

/// The number of line ends (`\n`, `\r\n` or `\r`) in `space`.
fn line_ends(space: &str) -> usize {
    space.matches('\n').count() + space.matches('\r').count() - space.matches("\r\n").count()
}
