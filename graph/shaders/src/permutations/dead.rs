//! Dead axes and template text: axes on which no text depends, text that no variant contains.
//!
//! Both are known once every path of a template has been rendered, independent of how the texts are validated. A file
//! that several templates include is dead only if none of them needs it, so files that unexplored templates share are
//! left out.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use super::explore::{Exploration, Explorer};
use super::request::{Request, space_of};
use crate::axes::Axes;
use crate::axes::AxisMode;
use crate::codes;
use crate::jinja::scan::{Piece, TagKind};
use crate::jinja::template::Template;
use crate::rendering::templates::TemplateSet;
use crate::written::text_map::Origin;
use umbragraph_text::diagnostic::{AxisValue, Diagnostic};
use umbragraph_text::source::{FileId, Span};

/// The maximum number of paths through a template that are compared in pairs. With more paths, every axis that is read
/// counts as used.
const MAX_COMPARED: usize = 1 << 10;
/// The maximum number of paths that are rendered again with markers, to find literal text inside macros and blocks.
const MAX_MARKED: usize = 1 << 11;

/// The maximum number of paths through a template that [`dead`] explores.
const MAX_LOOKED_AT: usize = 1 << 10;

/// An explored template to search for axes without effect and unused text.
pub(super) struct Examined<'a> {
    pub(super) template: &'a str,
    pub(super) exploration: &'a Exploration,
    /// The axes without effect on the generated WGSL; `None` if a variant is invalid, since an error may hide an
    /// effect.
    pub(super) dead_axes: Option<&'a [String]>,
}

/// Finds axes without effect and template text in no variant, over all configurations of the named templates.
///
/// Nothing is validated. Returns no diagnostics if one of the templates has invalid axes or more than 1,024 paths. A
/// failed rendering suppresses diagnostics about text and about axes of its template. Files in `shared` are skipped,
/// since other templates use them.
pub fn dead(templates: &TemplateSet, names: &BTreeSet<String>, shared: &BTreeSet<FileId>) -> Vec<Diagnostic> {
    let mut explored = Vec::new();
    for name in names {
        let (Ok(space), Some(axes)) = (space_of(templates, &Request::all(name, &[])), templates.axes(name))
        else {
            return Vec::new();
        };
        let mut explorer = Explorer::new(templates, name, &Arc::new(space), true);
        if !explorer.take_all(MAX_LOOKED_AT) {
            return Vec::new();
        }
        let exploration = explorer.finish();
        let effective = effective_axes(&exploration);
        // Whether a module declares an override takes its parsing.
        let is_dead = |axis: &&crate::axes::Axis| {
            axis.mode == AxisMode::Template && axis.kind.count() > 1 && !effective.contains(&axis.name)
        };
        let dead_axes: Vec<String> = axes.iter().filter(is_dead).map(|axis| axis.name.clone()).collect();
        explored.push((name, exploration, dead_axes));
    }
    let examined = explored.iter().map(|(template, exploration, dead_axes)| Examined {
        template,
        exploration,
        dead_axes: Some(dead_axes),
    });
    diagnostics(templates, &examined.collect::<Vec<_>>(), shared)
}

/// Returns the diagnostics about axes without effect and template text in no variant.
pub(super) fn diagnostics(
    templates: &TemplateSet,
    examined: &[Examined<'_>],
    shared: &BTreeSet<FileId>,
) -> Vec<Diagnostic> {
    let sound =
        |each: &Examined<'_>| each.exploration.failures.is_empty() && each.exploration.diagnostics.is_empty();
    // An axis is dead where no template that has it depends on it; a template with other diagnostics says nothing.
    let mut axes: BTreeMap<Span, (String, bool)> = BTreeMap::new();
    for each in examined {
        for axis in templates.axes(each.template).into_iter().flat_map(Axes::iter) {
            let entry = axes.entry(axis.span).or_insert_with(|| (axis.name.clone(), true));
            let is_dead = each.dead_axes.is_some_and(|dead| dead.contains(&axis.name));
            entry.1 &= sound(each) && is_dead;
        }
    }
    let mut diagnostics = Vec::new();
    for (span, (name, dead)) in axes {
        if dead && !shared.contains(&span.file) {
            let message = format!("no text depends on the axis \"{name}\"");
            diagnostics
                .push(Diagnostic::warning(codes::AXIS_DEAD, span, message).help("remove it, or use it"));
        }
    }
    let mut coverage = Coverage { written: BTreeSet::new(), shared };
    for each in examined {
        coverage.add(templates, each.template, each.exploration);
    }
    if examined.iter().all(sound) {
        diagnostics.extend(coverage.dead(templates).into_iter().map(|span| {
            Diagnostic::warning(codes::LINES_DEAD, span, "no variant contains this text")
                .help("its condition can never hold under the declared axes and constraints; remove it")
        }));
    }
    diagnostics
}

/// Returns the template axes that change the generated WGSL. An axis counts if it is in a minimal difference between
/// two paths with different WGSL.
pub(super) fn effective_axes(exploration: &Exploration) -> BTreeSet<String> {
    let leaves = &exploration.leaves;
    if leaves.len() > MAX_COMPARED {
        return exploration.read.clone();
    }
    // What has one value everywhere tells no two paths apart.
    let mut values: BTreeMap<&str, BTreeMap<&AxisValue, u32>> = BTreeMap::new();
    for (name, value) in leaves.iter().flat_map(|leaf| leaf.decided.iter()) {
        let known = values.entry(name).or_default();
        let next = known.len() as u32 + 1;
        known.entry(value).or_insert(next);
    }
    values.retain(|_, known| known.len() > 1);
    if values.len() > u128::BITS as usize {
        return exploration.read.clone();
    }
    // The number of each value, and 0 where the path does not read the axis.
    let rows: Vec<Vec<u32>> = leaves
        .iter()
        .map(|leaf| {
            let number = |(name, known): (&&str, &BTreeMap<&AxisValue, u32>)| {
                leaf.decided.get(name).and_then(|value| known.get(value)).copied().unwrap_or_default()
            };
            values.iter().map(number).collect()
        })
        .collect();
    // A constraint may tie axes together, so that no two paths differ in one alone. Those that differ in the fewest
    // tell which axes have an effect: a difference that contains a smaller one says nothing more.
    let mut min: Vec<u128> = Vec::new();
    for (at, (one, row)) in leaves.iter().zip(&rows).enumerate() {
        if min.len() == values.len() && min.iter().all(|axes| axes.count_ones() == 1) {
            break;
        }
        for (two, other) in leaves.iter().zip(&rows).skip(at + 1) {
            if one.text == two.text {
                continue;
            }
            let mut differing = 0_u128;
            for (bit, (one, two)) in row.iter().zip(other).enumerate() {
                differing |= u128::from(*one != *two && *one != 0 && *two != 0) << bit;
            }
            if !min.iter().any(|axes| axes & differing == *axes) {
                min.retain(|axes| axes & differing != differing);
                min.push(differing);
            }
        }
    }
    let effective = min.into_iter().fold(0, |all, axes| all | axes);
    let names = values.keys().enumerate().filter(|(bit, _)| effective >> bit & 1 == 1);
    names.map(|(_, name)| (*name).to_owned()).collect()
}

/// The pieces of template text that some variant contains, each as file and byte offset.
#[derive(Debug)]
struct Coverage<'s> {
    written: BTreeSet<(FileId, u32)>,
    /// Files for which no dead text is reported.
    shared: &'s BTreeSet<FileId>,
}

impl Coverage<'_> {
    /// Adds the text that the paths of one template write.
    fn add(&mut self, set: &TemplateSet, template: &str, exploration: &Exploration) {
        self.written.extend(&exploration.literals);
        if self.dead(set).is_empty() {
            return;
        }
        for leaf in exploration.leaves.iter().take(MAX_MARKED) {
            let text = leaf.text.and_then(|at| exploration.source(set, template, at));
            let Some(text) = text else { continue };
            let Some(found) = set.marked().map(template, &leaf.decided.values(), &text.wgsl) else {
                continue;
            };
            let before = self.written.len();
            for segment in &found.map.segments {
                if let Some(Origin::Literal(file, offset)) = segment.origin {
                    self.written.insert((file, offset));
                }
            }
            if self.written.len() > before && self.dead(set).is_empty() {
                return;
            }
        }
    }

    /// Returns the literal text that no variant contains, in templates of which some text is used. Adjacent pieces
    /// form one span.
    fn dead(&self, set: &TemplateSet) -> Vec<Span> {
        let is_written = |file: FileId, range: Range<usize>| {
            self.written.range((file, range.start as u32)..(file, range.end as u32)).next().is_some()
        };
        let is_touched = |template: &&Arc<Template>| {
            !self.shared.contains(&template.file) && is_written(template.file, 0..template.text.len())
        };
        let mut dead = Vec::new();
        for template in set.templates.values().filter(is_touched) {
            let mut run: Option<Span> = None;
            for piece in template.scan.pieces() {
                let range = match piece {
                    Piece::Literal(range) => range.clone(),
                    // A block tag after dead text may begin another branch.
                    Piece::Tag(tag) => {
                        dead.extend(run.take_if(|_| tag.kind == TagKind::Block));
                        continue;
                    }
                };
                let Some(piece) = template.text.get(range.clone()) else { continue };
                let blank = piece.trim().is_empty();
                if !blank && !is_written(template.file, range.clone()) {
                    let text_start = range.start + (piece.len() - piece.trim_start().len());
                    let text_end = range.start + piece.trim_end().len();
                    let begin = run.map_or(text_start, |run| run.start as usize);
                    run = Some(Span::new(template.file, begin..text_end));
                } else if !blank {
                    dead.extend(run.take());
                }
            }
            dead.extend(run);
        }
        dead
    }
}
