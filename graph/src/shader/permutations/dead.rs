//! What no variant needs: axes on which no text depends, template text that no variant contains.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::explore::Exploration;
use crate::shader::TemplateSet;
use crate::shader::markers::MarkedTemplates;
use crate::shader::render::Placement;
use crate::shader::scan::TagKind;
use crate::shader::text_map::Origin;
use crate::shader::value::AxisValue;
use crate::source::{FileId, Span};

/// The most paths whose pairs are compared; with more, every axis that is read counts as alive.
const MAXIMUM_COMPARED: usize = 1 << 10;
/// The most paths that are rendered again with markers, to see text that macros and blocks captured.
const MAXIMUM_MARKED: usize = 1 << 11;

/// The template axes on which the text depends: two paths that are told apart by nothing else have different texts.
pub(super) fn effective_axes(exploration: &Exploration) -> BTreeSet<String> {
    let leaves = &exploration.leaves;
    if leaves.len() > MAXIMUM_COMPARED {
        return exploration.read.clone();
    }
    // What has one value everywhere tells no two paths apart.
    let mut first: BTreeMap<&String, &AxisValue> = BTreeMap::new();
    let mut varied: BTreeSet<&String> = BTreeSet::new();
    for (name, value) in leaves.iter().flat_map(|leaf| leaf.decided.iter()) {
        if *first.entry(name).or_insert(value) != value {
            varied.insert(name);
        }
    }
    let mut effective = BTreeSet::new();
    for (at, one) in leaves.iter().enumerate() {
        if effective.len() == varied.len() {
            break;
        }
        for two in &leaves[at + 1..] {
            if one.text == two.text {
                continue;
            }
            let mut differing = one
                .decided
                .iter()
                .filter(|(name, value)| two.decided.get(*name).is_some_and(|other| other != *value));
            let (Some((name, _)), None) = (differing.next(), differing.next()) else { continue };
            effective.insert(name.clone());
        }
    }
    effective
}

/// The pieces of template text that were written so far.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    written: HashSet<(FileId, u32)>,
}

impl Coverage {
    /// Adds the text of one template's paths.
    pub(super) fn add(
        &mut self,
        set: &TemplateSet,
        template: &str,
        exploration: &Exploration,
        placement: &Placement<'_>,
        marked: &mut Marked<'_>,
    ) {
        self.written.extend(&exploration.literals);
        if self.dead(set).is_empty() {
            return;
        }
        for leaf in exploration.leaves.iter().take(MAXIMUM_MARKED) {
            let text = leaf.text.and_then(|at| exploration.source(set, placement, template, at));
            let Some(text) = text else { continue };
            let Some(found) = marked.get(set).map(template, &leaf.decided, &text.wgsl) else { continue };
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

    /// The pieces of literal text in the touched templates that nobody wrote, each run of neighbours as one span.
    pub(super) fn dead(&self, set: &TemplateSet) -> Vec<Span> {
        let touched: BTreeSet<FileId> = self.written.iter().map(|(file, _)| *file).collect();
        let mut offsets: BTreeMap<FileId, Vec<usize>> = BTreeMap::new();
        for (file, offset) in &self.written {
            offsets.entry(*file).or_default().push(*offset as usize);
        }
        offsets.values_mut().for_each(|offsets| offsets.sort_unstable());
        let mut dead = Vec::new();
        for template in set.templates.values().filter(|template| touched.contains(&template.file)) {
            let written = offsets.get(&template.file).map_or(&[][..], Vec::as_slice);
            let ends = template.tags.iter().map(|tag| tag.range.end);
            let starts = template.tags.iter().map(|tag| (tag.range.start, Some(tag.kind)));
            let mut run: Option<Span> = None;
            for (start, (end, next)) in
                [0].into_iter().chain(ends).zip(starts.chain([(template.text.len(), None)]))
            {
                let Some(piece) = template.text.get(start..end) else { continue };
                let blank = piece.trim().is_empty();
                let first = written.partition_point(|offset| *offset < start);
                let alive = written.get(first).is_some_and(|offset| *offset < end);
                if !blank && !alive {
                    let text_start = start + (piece.len() - piece.trim_start().len());
                    let text_end = start + piece.trim_end().len();
                    let begin = run.map_or(text_start, |run| run.start as usize);
                    run = Some(Span::new(template.file, begin..text_end));
                } else if !blank {
                    dead.extend(run.take());
                }
                // A block tag after dead text may begin another branch.
                if next == Some(TagKind::Block) {
                    dead.extend(run.take());
                }
            }
            dead.extend(run);
        }
        dead
    }
}

/// Marked templates, made when first wanted.
pub(super) struct Marked<'m>(pub(super) &'m mut Option<MarkedTemplates>);

impl Marked<'_> {
    pub(super) fn get(&mut self, set: &TemplateSet) -> &MarkedTemplates {
        self.0.get_or_insert_with(|| MarkedTemplates::new(set))
    }
}
