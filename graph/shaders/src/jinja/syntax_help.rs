//! Syntax errors of templates: the cause and the way out.
//!
//! The engine reports where parsing stopped. For a block or a tag without an end that is the end of the text; here it
//! is the tag that opens it. A misspelt statement is compared with the known ones, including those that may stand in
//! the innermost open block.

use std::ops::Range;

use minijinja::Error;

use super::scan::{Tag, TagKind};
use super::template::Template;
use crate::codes;
use umbragraph_text::diagnostic::{Diagnostic, list_of};
use umbragraph_text::source::Span;

/// The template statements, such as `if`, that are allowed everywhere in a template.
const STATEMENTS: &[&str] = &[
    "autoescape",
    "block",
    "call",
    "do",
    "extends",
    "filter",
    "for",
    "from",
    "if",
    "import",
    "include",
    "macro",
    "raw",
    "set",
    "with",
];

/// A block, such as an `if`, whose end tag has not been found.
#[derive(Clone)]
struct Open<'t> {
    keyword: &'t str,
    tag: Range<usize>,
}

impl Open<'_> {
    fn end(&self) -> String {
        format!("end{}", self.keyword)
    }

    fn branches(&self) -> &'static [&'static str] {
        match self.keyword {
            "if" => &["elif", "else"],
            "for" => &["else"],
            _ => &[],
        }
    }
}

/// Returns the diagnostic for a template that minijinja cannot compile.
pub(crate) fn syntax(template: &Template, error: &Error) -> Diagnostic {
    let detail = error.detail().map_or_else(|| error.kind().to_string(), str::to_owned);
    diagnostic(template, &detail, range(template, error))
}

pub(crate) fn range(template: &Template, error: &Error) -> Option<Range<usize>> {
    let prepared = &template.prepared;
    if let Some(range) = error.range() {
        let start = prepared.original(range.start).min(template.text.len());
        let end = prepared.original(range.end).min(template.text.len());
        return Some(start..end.max(start));
    }
    // Some errors know their line only; insertions contain no line break, so lines are the same in both texts.
    let mut start = 0;
    for _ in 1..error.line()? {
        start += template.text[start..].find('\n')? + 1;
    }
    let length = template.text[start..].find('\n').unwrap_or(template.text.len() - start);
    let indent =
        template.text[start..start + length].len() - template.text[start..start + length].trim_start().len();
    Some(start + indent..start + length)
}

/// Returns the diagnostic for a template that minijinja rejects. `detail` is minijinja's message, and `place` the byte
/// range of the error.
pub(crate) fn diagnostic(template: &Template, detail: &str, place: Option<Range<usize>>) -> Diagnostic {
    let span = |range: Range<usize>| Span::new(template.file, range);
    let error = |range: Range<usize>, message: &str| {
        Diagnostic::error(codes::TEMPLATE_SYNTAX, span(range), format!("template syntax: {message}"))
    };
    let text = &template.text;
    let end = text.trim_end().len();
    let is_at_the_end = detail.starts_with("unexpected end of input");
    if let Some((tag, closer)) = unclosed_tag(template, detail)
        && (is_at_the_end || place.as_ref().is_some_and(|place| tag.start <= place.start))
    {
        let opener = &text[tag.start..tag.start + 2];
        return error(tag.start..tag.start + 2, &format!("{opener} is never closed"))
            .help(format!("close it with {closer}"));
    }
    if is_at_the_end && let Some(open) = open_blocks(template, text.len()).pop() {
        return error(open.tag.clone(), &format!("{{% {} %}} has no end", open.keyword))
            .related(span(end..text.len()), "the text ends here")
            .help(format!("close it with {{% {} %}}", open.end()));
    }
    let place = place.unwrap_or(0..0);
    let diagnostic = error(place.clone(), detail);
    if let Some(name) = detail.strip_prefix("unknown statement ") {
        let written = Some(span(place.clone())).filter(|_| text.get(place.clone()) == Some(name));
        return statement(diagnostic, name, written, open_blocks(template, place.start).pop(), &span);
    }
    if let Some(name) = detail.strip_prefix("block '").and_then(|rest| rest.strip_suffix("' defined twice")) {
        let mut tags = template.scan.tags.iter();
        let first = tags.find(|tag| tag.keyword(text) == Some("block") && tag.word(text, 1) == Some(name));
        let first = first.map(|tag| span(tag.range.clone()));
        let diagnostic =
            diagnostic.help("give one of the two another name, or put both texts into one block");
        return first.into_iter().fold(diagnostic, |diagnostic, at| diagnostic.related(at, "the first"));
    }
    if let Some((tag, condition)) = else_if(template, &place) {
        return error(tag, "{% else if %} does not exist").help(format!("write {{% elif {condition} %}}"));
    }
    let help = if detail.starts_with("unexpected `=`") {
        "compare with =="
    } else if detail.ends_with("expected assignment operator") {
        "write {% set NAME = VALUE %}"
    } else if detail.ends_with("expected in") {
        "write {% for NAME in LIST %}"
    } else if detail.starts_with("unexpected end of") {
        "an expression is missing in front of it"
    } else if detail.ends_with("expected end of variable block") {
        "the expression ends here: close it with }}"
    } else if detail.ends_with("expected end of block") {
        "the tag ends here: close it with %}"
    } else {
        "tags are {% if sscs %}, {{ taps }} and {# a comment #}"
    };
    diagnostic.help(help)
}

/// The words `else if` of the tag at a place, with the condition behind them; `None` for other tags.
fn else_if<'t>(template: &'t Template, place: &Range<usize>) -> Option<(Range<usize>, &'t str)> {
    let text = &template.text;
    let mut tags = template.scan.tags.iter();
    let tag = tags.find(|tag| tag.range.start <= place.start && place.start < tag.range.end)?;
    let is_it = tag.keyword(text) == Some("else") && tag.word(text, 1) == Some("if") && tag.words.len() > 2;
    let (first, last) = (tag.words.first()?, tag.words.last()?);
    let condition = text.get(tag.words.get(2)?.range.start..last.range.end)?;
    is_it.then(|| (first.range.start..tag.words[1].range.end, condition))
}

fn statement(
    diagnostic: Diagnostic,
    name: &str,
    written: Option<Span>,
    open: Option<Open<'_>>,
    span: &dyn Fn(Range<usize>) -> Span,
) -> Diagnostic {
    let is_end = name.strip_prefix("end").is_some_and(|rest| STATEMENTS.contains(&rest));
    let is_branch = matches!(name, "else" | "elif");
    let Some(open) = open else {
        if is_end || is_branch {
            let opener = name.strip_prefix("end").unwrap_or("if");
            return diagnostic
                .help(format!("no block is open here: remove it, or open one with {{% {opener} %}}"));
        }
        return diagnostic.suggest(name, STATEMENTS.iter().copied(), written, |names| {
            format!("the statements are {}", list_of(names))
        });
    };
    let end = open.end();
    let inside = [&[end.as_str()], open.branches()].concat();
    let ends =
        || format!("the block that is open here is {{% {} %}}, and ends with {{% {end} %}}", open.keyword);
    let opened = span(open.tag.clone());
    if is_end || is_branch {
        return diagnostic.related(opened, "the block").help(ends());
    }
    let known = STATEMENTS.iter().chain(&inside).copied();
    match name.starts_with("end") {
        true => diagnostic.related(opened, "the block").suggest(name, inside, written, |_| ends()),
        false => diagnostic
            .suggest(name, known, written, |names| format!("the statements here are {}", list_of(names))),
    }
}

/// The byte range of an unclosed last tag or comment, with its closing delimiter; `None` if all are closed.
fn unclosed_tag(template: &Template, detail: &str) -> Option<(Range<usize>, &'static str)> {
    if detail == "unexpected end of comment" {
        let start = template.text.rfind("#}").map_or(0, |end| end + 2);
        return Some((start + template.text[start..].find("{#")?..template.text.len(), "#}"));
    }
    let tag = template.scan.tags.last().filter(|tag| tag.is_open)?;
    Some((tag.range.clone(), if tag.kind == TagKind::Block { "%}" } else { "}}" }))
}

/// Returns the blocks that are open at byte offset `before`, the outermost first.
fn open_blocks(template: &Template, before: usize) -> Vec<Open<'_>> {
    let mut open: Vec<Open<'_>> = Vec::new();
    for tag in template.scan.tags.iter().take_while(|tag| tag.range.end <= before) {
        let Some(keyword) = tag.keyword(&template.text) else { continue };
        match keyword {
            "autoescape" | "block" | "call" | "filter" | "for" | "if" | "macro" | "raw" | "with" => {
                open.push(Open { keyword, tag: tag.range.clone() });
            }
            "set" if !assigns(template, tag) => open.push(Open { keyword, tag: tag.range.clone() }),
            _ => {
                if open.last().is_some_and(|last| last.end() == keyword) {
                    open.pop();
                }
            }
        }
    }
    open
}

/// Returns `true` if a `set` tag assigns a value, and does not start a block.
fn assigns(template: &Template, tag: &Tag) -> bool {
    (0..tag.words.len()).any(|at| tag.word(&template.text, at) == Some("="))
}
