//! Exact places in text that macros, `set` blocks and filters captured.
//!
//! Such text reaches the sink as a value, so its address says nothing. After an error that falls into it, the same
//! variant is rendered once more from marked templates: private-use characters before the first text of every line and
//! around every expression carry the place through captures, arguments and filters, and are stripped from the outcome
//! into a map. The map counts only if the stripped text is the plain one; a template that looks at its own text
//! (`|length`, a comparison) may see the markers, and then the place stays that of the writing tag.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::context::fixed_context;
use super::templates::TemplateSet;
use super::twice;
use crate::jinja::scan::{Piece, TagKind, scan};
use crate::jinja::template::Template;
use crate::jinja::{filters, guard, tree};
use crate::written::rejection::Rejection;
use crate::written::text_map::{Origin, Segment, TextMap};
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};
use umbragraph_text::source::{FileId, Span};

const OPEN: char = '\u{E000}';
const CLOSE: char = '\u{E001}';
/// The first of 256 private-use characters that encode the number of a marker in base 256. Template filters for case,
/// white space or digits leave these characters unchanged.
const FIRST_DIGIT: u32 = 0xE100;

/// A map from generated WGSL to templates, with the chain of template tags that wrote each piece, the outermost first.
#[derive(Clone, Debug, Default)]
pub(crate) struct MarkedMap {
    pub(crate) map: TextMap,
    trails: Vec<Arc<[Span]>>,
}

impl MarkedMap {
    /// Iterates over the template tags that wrote the byte at `offset` of the WGSL, the innermost first.
    pub(crate) fn trail(&self, offset: usize) -> impl Iterator<Item = Span> {
        self.map
            .index(offset)
            .and_then(|at| self.trails.get(at))
            .into_iter()
            .flat_map(|trail| trail.iter().rev().copied())
    }
}

/// Returns the diagnostic for a rejection of WGSL that was generated from the file `template` of `set`. `exact` creates
/// a precise map; it is only called for places outside of literal text.
pub(crate) fn place(
    set: &TemplateSet,
    rejection: &Rejection,
    wgsl: &str,
    map: &TextMap,
    template: FileId,
    exact: impl FnOnce() -> Option<MarkedMap>,
) -> Diagnostic {
    let start = rejection.range.as_ref().map(|range| range.start);
    let hidden = start.filter(|start| !matches!(map.origin(*start), Some(Origin::Literal(..))));
    match hidden.and_then(|start| Some((start, exact()?))) {
        Some((start, exact)) => {
            let diagnostic = rejection.to_diagnostic(wgsl, &exact.map, template);
            exact
                .trail(start)
                .take(8)
                .fold(diagnostic, |diagnostic, span| diagnostic.related(span, "written out here"))
        }
        None => {
            let diagnostic = rejection.to_diagnostic(wgsl, map, template);
            twice::explain(set, template, rejection, map, diagnostic)
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Mark {
    /// The start of literal text: template file and byte offset.
    Text(FileId, u32),
    /// The start of the output of an expression that has an end marker.
    Begin(Span),
    /// The start of the output of an expression without an end marker, since its tag trims the following white space.
    Here(Span),
    /// The end of the output of an expression.
    End,
}

/// Copies of all templates with markers that record source positions through captures and filters.
#[derive(Debug)]
pub(crate) struct MarkedTemplates {
    environment: minijinja::Environment<'static>,
    marks: Vec<Mark>,
}

impl MarkedTemplates {
    /// Creates the marked copies. `fuel` limits minijinja's execution steps in one rendering; `None` means no limit.
    pub(crate) fn new(templates: &BTreeMap<String, Arc<Template>>, fuel: Option<u64>) -> Self {
        let mut marked = Self { environment: filters::environment(), marks: Vec::new() };
        marked.environment.set_fuel(fuel);
        for (name, template) in templates {
            // A template that uses the marker characters itself, or does not parse, is left out; what needs it then
            // fails to render, and the plain map stays.
            if template.broken.is_none() && !template.text.contains([OPEN, CLOSE]) {
                let text = marked.mark(template.file, &template.text);
                let prepared = tree::prepare(&text);
                let _ = marked.environment.add_template_owned(name.clone(), prepared.text);
            }
        }
        marked
    }

    /// Renders a variant with markers and returns the precise map. `None` if rendering fails, or if the WGSL without
    /// markers differs from `plain`.
    pub(crate) fn map(&self, template: &str, values: &AxisValues, plain: &str) -> Option<MarkedMap> {
        guard::begin();
        let marked = self.environment.get_template(template).ok()?.render(fixed_context(values)).ok()?;
        let (text, map) = self.strip(&marked);
        (text == plain).then_some(map)
    }

    fn push(&mut self, text: &mut String, mark: Mark) {
        let number = self.marks.len() as u32;
        self.marks.push(mark);
        text.push(OPEN);
        for shift in [16, 8, 0] {
            text.extend(char::from_u32(FIRST_DIGIT + ((number >> shift) & 0xff)));
        }
        text.push(CLOSE);
    }

    fn mark(&mut self, file: FileId, source: &str) -> String {
        let mut text = String::with_capacity(source.len() * 5 / 4);
        let mut copied = 0;
        for piece in scan(source).pieces() {
            let range = match piece {
                Piece::Literal(range) => range.clone(),
                Piece::Tag(tag) => tag.range.clone(),
            };
            // Comments, and white space that tags take away.
            text.push_str(&source[copied..range.start]);
            copied = range.end;
            let Piece::Tag(tag) = piece else {
                self.mark_literal(file, source, range, &mut text);
                continue;
            };
            let inner = source[tag.range.clone()].as_bytes();
            let span = Span::new(file, tag.range.clone());
            let trims_after = inner.len() > 5 && inner[inner.len() - 3] == b'-';
            if tag.kind == TagKind::Expression {
                // White space that the tag trims has to stay next to it, so the marker goes before.
                let trims_before = inner.get(2) == Some(&b'-');
                let kept = if trims_before { text.trim_end().len() } else { text.len() };
                let space = text.split_off(kept);
                self.push(&mut text, if trims_after { Mark::Here(span) } else { Mark::Begin(span) });
                text.push_str(&space);
            }
            text.push_str(&source[tag.range.clone()]);
            if tag.kind == TagKind::Expression && !trims_after {
                self.push(&mut text, Mark::End);
            }
        }
        text.push_str(&source[copied..]);
        text
    }

    fn mark_literal(&mut self, file: FileId, source: &str, range: std::ops::Range<usize>, text: &mut String) {
        let mut wanted = true;
        for (at, character) in source[range.clone()].char_indices() {
            if character == '\n' {
                wanted = true;
            } else if wanted && !character.is_whitespace() {
                self.push(text, Mark::Text(file, (range.start + at) as u32));
                wanted = false;
            }
            text.push(character);
        }
    }

    fn strip(&self, marked: &str) -> (String, MarkedMap) {
        let mut text = String::with_capacity(marked.len());
        let mut found = MarkedMap::default();
        let mut open: Vec<Span> = Vec::new();
        let mut rest = marked;
        while let Some(at) = rest.find(OPEN) {
            text.push_str(&rest[..at]);
            let digits = rest[at..].chars().skip(1);
            let number = digits.take_while(|digit| *digit != CLOSE).fold(0_u32, |number, digit| {
                (number << 8) | (u32::from(digit).wrapping_sub(FIRST_DIGIT) & 0xff)
            });
            let end = rest[at..].find(CLOSE).map_or(rest.len(), |end| at + end + CLOSE.len_utf8());
            rest = &rest[end..];
            let (origin, depth) = match self.marks.get(number as usize) {
                Some(Mark::Text(file, offset)) => (Some(Origin::Literal(*file, *offset)), open.len()),
                Some(Mark::Begin(span)) => {
                    open.push(*span);
                    (Some(Origin::Tag(*span)), open.len() - 1)
                }
                Some(Mark::Here(span)) => (Some(Origin::Tag(*span)), open.len()),
                Some(Mark::End) => {
                    open.pop();
                    (None, open.len())
                }
                None => (None, open.len()),
            };
            let start = text.len() as u32;
            found.map.segments.push(Segment { start, origin });
            found.trails.push(open[..depth].into());
        }
        text.push_str(rest);
        found.map.length = text.len() as u32;
        (text, found)
    }
}
