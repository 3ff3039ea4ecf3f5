//! Maps offsets in generated text back to templates.
//!
//! minijinja writes literal text to its sink as sub-slices of the template's own text, so the address of a slice gives
//! the template and the offset: exact for every literal byte, and free. That is an implementation detail of minijinja
//! (pinned by a test that fails loudly if it changes), not an unsafe trick: addresses are only compared. The output of
//! an expression has another address; it maps to its tag, the next `{{` after the literal text before it. Text captured
//! by a macro, a `set` block or a filter is also written by an expression, and maps to the place that writes it out.

use std::ops::Range;

use umbragraph_text::source::{FileId, Span};

/// Generated WGSL, with a map from its byte offsets to places in templates.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) wgsl: String,
    pub(crate) map: TextMap,
}

/// A piece of generated WGSL, with its origin in a template. It ends where the next piece starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Segment {
    /// The byte offset of the piece in the generated WGSL.
    pub(crate) start: u32,
    /// The place in a template that wrote the piece; `None` if unknown.
    pub(crate) origin: Option<Origin>,
}

/// The origin of a piece of generated WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Text copied literally from a template file, starting at this byte offset of the file.
    Literal(FileId, u32),
    /// Output of the template tag with this span.
    Tag(Span),
}

/// The map from byte offsets of generated WGSL to places in templates.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TextMap {
    pub(crate) segments: Vec<Segment>,
    pub(crate) length: u32,
}

impl TextMap {
    /// Returns the template span for a byte range of the generated WGSL; `None` if unknown. Literal text maps exactly;
    /// the output of an expression maps to the expression's tag.
    ///
    /// A range over several pieces maps to its part in the first piece. If first and last piece are literal text of the
    /// same file in order, the span reaches to the last byte.
    pub fn span(&self, range: Range<usize>) -> Option<Span> {
        let range = range.start.min(self.length as usize)..range.end;
        let at = self.index(range.start)?;
        let end = range.end.max(range.start + 1);
        match self.segments[at].origin? {
            Origin::Tag(span) => Some(span),
            Origin::Literal(file, offset) => {
                let into = range.start - self.segments[at].start as usize;
                let start = offset as usize + into;
                let length = end.min(self.end(at)) - range.start;
                let last = self.place(end - 1).filter(|last| {
                    last.file == file
                        && (start..start + 2 * (end - range.start)).contains(&(last.start as usize))
                });
                let stop = last.map_or(start + length, |last| last.end as usize);
                Some(Span::new(file, start..stop.max(start + length)))
            }
        }
    }

    /// Returns the place in a template that wrote the byte at `offset` of the generated WGSL; `None` if unknown. The
    /// place after the last byte is an empty span.
    pub fn place(&self, offset: usize) -> Option<Span> {
        let offset = offset.min(self.length as usize);
        let at = self.index(offset)?;
        match self.segments[at].origin? {
            Origin::Tag(span) => Some(span),
            Origin::Literal(file, start) => {
                let start = start as usize + (offset - self.segments[at].start as usize);
                Some(Span::new(file, start..start + usize::from(offset < self.end(at))))
            }
        }
    }

    /// Returns `true` if a byte range of the generated WGSL is one piece of literal text of a template.
    pub(crate) fn is_verbatim(&self, range: Range<usize>) -> bool {
        let is_literal = matches!(self.origin(range.start), Some(Origin::Literal(..)));
        is_literal && range.end <= self.length as usize && self.part(range).count() == 1
    }

    /// Iterates over the pieces of the generated WGSL in order: the byte range, and the template span (`None` if
    /// unknown).
    pub fn pieces(&self) -> impl Iterator<Item = (Range<usize>, Option<Span>)> {
        self.segments.iter().enumerate().map(|(at, segment)| {
            let range = segment.start as usize..self.end(at);
            let span = segment.origin.map(|origin| match origin {
                Origin::Tag(span) => span,
                Origin::Literal(file, start) => Span::new(file, start as usize..start as usize + range.len()),
            });
            (range, span)
        })
    }

    /// Iterates over the pieces of the generated WGSL in a byte range, clipped to this range, each with the origin of
    /// its first byte.
    pub(crate) fn part(&self, part: Range<usize>) -> impl Iterator<Item = (Range<usize>, Option<Origin>)> {
        let first = self.index(part.start).unwrap_or_default();
        let cut = move |at: usize| {
            let start = self.segments[at].start as usize;
            let piece = start.max(part.start)..self.end(at).min(part.end);
            let origin = match self.segments[at].origin {
                Some(Origin::Literal(file, offset)) => {
                    Some(Origin::Literal(file, offset + (piece.start - start) as u32))
                }
                other => other,
            };
            (piece, origin)
        };
        let pieces = (first..self.segments.len()).map(cut);
        pieces.take_while(|(piece, _)| piece.start <= piece.end).filter(|(piece, _)| !piece.is_empty())
    }

    pub(crate) fn origin(&self, offset: usize) -> Option<Origin> {
        self.segments[self.index(offset)?].origin
    }

    fn end(&self, at: usize) -> usize {
        self.segments.get(at + 1).map_or(self.length, |next| next.start) as usize
    }

    pub(crate) fn index(&self, offset: usize) -> Option<usize> {
        // One past the end belongs to the last piece: parsers point there when text is missing.
        let offset = offset.min(self.length.saturating_sub(1) as usize);
        self.segments.partition_point(|segment| segment.start as usize <= offset).checked_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_text::source::Sources;

    #[test]
    fn behind_the_last_byte_there_is_no_byte_of_the_file() {
        let mut sources = Sources::new();
        let file = sources.add("main.wgsl.jinja", "struct");
        let segments = vec![Segment { start: 0, origin: Some(Origin::Literal(file, 0)) }];
        let map = TextMap { segments, length: 6 };
        assert_eq!(map.span(6..6), Some(Span::new(file, 6..6)));
        assert_eq!(map.span(5..9), Some(Span::new(file, 5..6)));
        assert_eq!(map.span(9..12), Some(Span::new(file, 6..6)));
    }
}
