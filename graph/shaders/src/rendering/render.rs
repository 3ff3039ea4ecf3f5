//! Templates to WGSL.
//!
//! The engine gets a context object instead of a map. The object returns the values of axes and records each read, so
//! that a module is identified by the axes that its text depends on; it also records undeclared names. The sink builds
//! the text and its [`TextMap`] in one pass and stops at the size limit.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use minijinja::value::{Object, Value};

use super::context::{fixed_context, to_template_value};
use super::placement::Placement;
use super::templates::TemplateSet;
use super::{aside, template_error, undeclared};
use crate::axes::{Axes, AxisMode};
use crate::codes;
use crate::jinja::{filters, guard};
use crate::written::complexity;
use crate::written::text_map::{Origin, Segment, Source, TextMap};
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};
use umbragraph_text::source::{FileId, Span};

/// Renders a template to WGSL with values for all its template axes. Also returns the names of the axes that were read.
///
/// # Errors
/// Diagnostics of the template, placed in its source.
pub(crate) fn render(
    set: &TemplateSet,
    name: &str,
    values: &AxisValues,
) -> Result<(Source, BTreeSet<String>), Vec<Diagnostic>> {
    let context = Arc::new(Context {
        values: values.iter().map(|(name, value)| (name.clone(), to_template_value(value))).collect(),
        reads: Mutex::default(),
    });
    let result = render_with(set, name, Value::from_dyn_object(context.clone()));
    let reads = std::mem::take(&mut *context.reads.lock().unwrap_or_else(PoisonError::into_inner));
    let unknown = undeclared_names(set, name, &reads.unknown);
    match result {
        Ok(source) if unknown.is_empty() => Ok((source, reads.axes)),
        Ok(_) => Err(unknown),
        // An undefined name fails the rendering as well; the diagnostic that knows the name is the better one.
        Err(diagnostic) if diagnostic.code == codes::UNDECLARED_NAME && !unknown.is_empty() => Err(unknown),
        Err(diagnostic) => {
            let follows = calls_one_of(&unknown, &diagnostic);
            let mut diagnostics = unknown;
            diagnostics.extend(Some(*diagnostic).filter(|_| !follows));
            Err(diagnostics)
        }
    }
}

/// Returns `true` if a diagnostic starts at the place of one of the diagnostics about undeclared names. It then only
/// repeats that the name is unknown.
pub(crate) fn calls_one_of(undeclared: &[Diagnostic], diagnostic: &Diagnostic) -> bool {
    let start = |diagnostic: &Diagnostic| diagnostic.span().map(|span| (span.file, span.start));
    undeclared.iter().any(|name| start(name) == start(diagnostic))
}

/// Renders a template to WGSL with only these axis values; `None` on an error.
pub(crate) fn render_fixed(set: &TemplateSet, name: &str, values: &AxisValues) -> Option<Source> {
    render_with(set, name, fixed_context(values)).ok()
}

/// Renders a template to WGSL with a minijinja context that provides the axis values.
pub(crate) fn render_with(set: &TemplateSet, name: &str, context: Value) -> Result<Source, Box<Diagnostic>> {
    let Some(template) = set.templates.get(name) else {
        return Err(Box::new(set.unknown(name, umbragraph_text::diagnostic::Place::Nowhere)));
    };
    if let Some(diagnostic) = &template.broken {
        return Err(Box::new(diagnostic.clone()));
    }
    let compiled = set
        .environment
        .get_template(name)
        .map_err(|error| Box::new(template_error::explain(set, name, &error, None)))?;
    let mut sink = Sink::new(set.placement());
    guard::begin();
    let result = compiled.render_captured_to(context, &mut sink).map(drop);
    match result {
        Ok(()) => Ok(aside::move_aside(set, sink.finish())),
        Err(error) => {
            let last = sink.last.map(|(at, offset)| {
                let template = set.placement().template(at);
                let offset = template.prepared.original(offset);
                Span::new(template.file, offset..offset)
            });
            let diagnostic = template_error::explain(set, name, &error, last);
            Err(Box::new(match sink.overflow {
                Some(overflow) if diagnostic.code == codes::TEMPLATE_LIMIT => {
                    overflow.explain(set, diagnostic)
                }
                _ => diagnostic,
            }))
        }
    }
}

#[derive(Debug)]
struct Context {
    values: BTreeMap<String, Value>,
    reads: Mutex<Reads>,
}

#[derive(Debug, Default)]
struct Reads {
    axes: BTreeSet<String>,
    unknown: BTreeSet<String>,
}

impl Object for Context {
    fn get_value(self: &Arc<Self>, key: &Value) -> Option<Value> {
        self.get_value_by_str(key.as_str()?)
    }

    fn get_value_by_str(self: &Arc<Self>, key: &str) -> Option<Value> {
        let mut reads = self.reads.lock().unwrap_or_else(PoisonError::into_inner);
        let value = self.values.get(key);
        let seen = if value.is_some() { &mut reads.axes } else { &mut reads.unknown };
        if !seen.contains(key) {
            seen.insert(key.to_owned());
        }
        value.cloned()
    }
}

struct Sink<'p> {
    placement: &'p Placement,
    text: Vec<u8>,
    segments: Vec<Segment>,
    /// The template that wrote the last literal text, as an index in `placement`, and the byte offset after this text.
    /// `None` before the first literal text.
    last: Option<(usize, usize)>,
    /// The number of pieces that template expressions have written since the last literal text.
    written: usize,
    overflow: Option<Overflow>,
}

/// The template that wrote the largest share of a WGSL module that exceeds the size limit, with the number of bytes.
struct Overflow {
    /// The place in the template of the piece that exceeded the limit, or else of the template's largest piece.
    span: Span,
    bytes: usize,
}

impl Overflow {
    fn explain(self, set: &TemplateSet, mut diagnostic: Diagnostic) -> Diagnostic {
        let mut templates = set.templates.iter();
        let name = templates.find(|(_, template)| template.file == self.span.file);
        let name = name.map_or("the template", |(name, _)| name.as_str());
        let help = format!(
            "{} bytes come from {name}: let a loop or a function of WGSL do what is written out, and put tables into a buffer",
            self.bytes
        );
        diagnostic.place = self.span.into();
        diagnostic.help(help)
    }
}

impl<'p> Sink<'p> {
    fn new(placement: &'p Placement) -> Self {
        let (text, segments) = (Vec::with_capacity(1 << 14), Vec::with_capacity(1 << 8));
        Self { placement, text, segments, last: None, written: 0, overflow: None }
    }

    fn origin_of_expression(&mut self) -> Option<Origin> {
        let (at, offset) = self.last?;
        let template = self.placement.template(at);
        let offset = template.prepared.original(offset);
        let first = template.scan.tags.partition_point(|tag| tag.range.start < offset);
        let expressions = template.scan.tags[first..]
            .iter()
            .filter(|tag| tag.kind == crate::jinja::scan::TagKind::Expression);
        let tag = expressions.clone().nth(self.written).or_else(|| expressions.clone().next());
        self.written += 1;
        Some(Origin::Tag(match tag {
            Some(tag) => Span::new(template.file, tag.range.clone()),
            None => Span::new(template.file, offset..offset),
        }))
    }

    /// Returns the origin of a piece that minijinja writes: literal text or an expression tag. `None` if unknown.
    fn origin(&mut self, bytes: &[u8]) -> Option<Origin> {
        let Some((at, offset)) = self.placement.locate(bytes) else { return self.origin_of_expression() };
        let template = self.placement.template(at);
        self.last = Some((at, offset + bytes.len()));
        self.written = 0;
        // Guards are inside tags, so a literal piece never straddles an insertion.
        Some(Origin::Literal(template.file, template.prepared.original(offset) as u32))
    }

    /// Returns the template that wrote the most bytes, including the piece that exceeds the limit.
    fn find_overflow(&self, origin: Option<Origin>, bytes: usize) -> Option<Overflow> {
        let span = |origin: Origin| match origin {
            Origin::Literal(file, offset) => Span::new(file, offset as usize..offset as usize),
            Origin::Tag(span) => span,
        };
        let ends = self.segments.iter().skip(1).map(|segment| segment.start as usize);
        let lengths = self.segments.iter().zip(ends.chain([self.text.len()]));
        let pieces = lengths.map(|(segment, end)| (segment.origin, end - segment.start as usize));
        let mut written: BTreeMap<FileId, (usize, usize, Span)> = BTreeMap::new();
        for (at, length) in pieces.filter_map(|(at, length)| Some((span(at?), length))) {
            let (sum, max, place) = written.entry(at.file).or_insert((0, 0, at));
            *sum += length;
            if length > *max {
                (*max, *place) = (length, at);
            }
        }
        if let Some(last) = origin.map(span) {
            let (sum, _, place) = written.entry(last.file).or_insert((0, 0, last));
            *sum += bytes;
            *place = last;
        }
        let max = written.into_values().max_by_key(|(sum, ..)| *sum);
        max.map(|(bytes, _, span)| Overflow { span, bytes })
    }

    fn finish(self) -> Source {
        let length = self.text.len() as u32;
        // Every piece was a `str`, so the whole is; the lossy form only spares a panic.
        let wgsl = String::from_utf8(self.text)
            .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
        Source { wgsl, map: TextMap { segments: self.segments, length } }
    }
}

impl io::Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let origin = self.origin(bytes);
        if self.text.len() + bytes.len() > complexity::MAX_BYTES {
            self.overflow = self.find_overflow(origin, bytes.len());
            return Err(io::Error::from(io::ErrorKind::FileTooLarge));
        }
        let start = self.text.len() as u32;
        self.segments.push(Segment { start, origin });
        self.text.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns errors for those names in `unknown` that no template assigns. `unknown` holds names that were read, but are
/// no template axes.
pub(crate) fn undeclared_names(set: &TemplateSet, root: &str, unknown: &BTreeSet<String>) -> Vec<Diagnostic> {
    let candidates: Vec<&String> =
        unknown.iter().filter(|name| !filters::FUNCTIONS.contains(&name.as_str())).collect();
    if candidates.is_empty() {
        return Vec::new();
    }
    let order = set
        .templates
        .get_key_value(root)
        .into_iter()
        .chain(set.templates.iter().filter(|(name, _)| *name != root));
    let axes = set.axes(root);
    let mut diagnostics = Vec::new();
    for name in candidates {
        // The templates that know the name: their files, and where they read it.
        let mut uses: Vec<(FileId, Vec<Range<usize>>)> = Vec::new();
        let mut is_bound = false;
        for (_, template) in order.clone() {
            let names = &template.prepared.names;
            let found = names.uses.iter().filter(|(known, _)| known == name);
            let found: Vec<Range<usize>> = found.map(|(_, range)| range.clone()).collect();
            is_bound |= names.bound.contains(name);
            uses.extend((!found.is_empty()).then_some((template.file, found)));
        }
        let Some((file, range)) = uses.first().map(|(file, found)| (*file, found[0].clone())) else {
            continue;
        };
        if is_bound {
            continue;
        }
        let message = format!("\"{name}\" is no axis of \"{root}\" and is bound by nothing");
        let diagnostic = Diagnostic::error(codes::UNDECLARED_NAME, Span::new(file, range.clone()), message);
        if axes.and_then(|axes| axes.get(name)).is_some_and(|axis| axis.mode == AxisMode::Override) {
            let message = format!(
                "\"{name}\" is an override axis: a constant of the WGSL, no variable of the template"
            );
            diagnostics.push(Diagnostic::error(codes::AXIS_OVERRIDE, diagnostic.place, message));
            continue;
        }
        if let Some(way) = undeclared::way_out(set, root, file, name, &range) {
            diagnostics.push(diagnostic.help(way));
            continue;
        }
        let names = axes.into_iter().flat_map(Axes::names).chain(guard::PLAIN_FUNCTIONS);
        let mut diagnostic =
            diagnostic.suggest(name, names, Some(Span::new(file, range)), |_| set.way_to_axis(root, name));
        // Another template that has the word may mean an axis of its own, and this one only where it is included.
        let fix = diagnostic.fix.take().filter(|_| uses.len() == 1);
        let replacement = fix.and_then(|fix| Some(fix.edits.first()?.replacement.clone()));
        for range in uses.iter().flat_map(|(_, found)| found) {
            if let Some(replacement) = &replacement {
                diagnostic = diagnostic.fix(Span::new(file, range.clone()), replacement);
            }
        }
        diagnostics.push(diagnostic);
    }
    diagnostics
}
