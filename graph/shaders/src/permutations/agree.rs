//! Whether the variants of a template agree about its bindings.
//!
//! The layout of a pass is the union over its variants, so that switching a feature changes a pipeline and nothing
//! else: bind groups stay. Variants may leave bindings out, but where two have one they have to mean the same by it, in
//! all passes and configurations. Some axes are there to choose between layouts: whether a texture has samples, whether
//! lights lie in a uniform block. Their declaration says so (`"own_layout": true`); variants with different values of
//! such an axis never stand for one another, and are compared with nobody but their own kind.
//!
//! Members of a block may differ: the block grows with the numbers that size it. Loading a pipeline compares the data
//! that fills the block with every variant. Variants that the meshes of one pass choose between must have identical
//! block layouts.
//!
//! A diagnostic names the two variants that differ in the fewest axes, by the values in which they differ.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::choices::Choices;
use super::proven::Explored;
use super::report::TemplateReport;
use crate::axes::Axes;
use crate::codes;
use crate::reflection::Reflection;
use crate::reflection::interface;
use crate::reflection::interface::InterfaceConflict;
use crate::rendering::templates::TemplateSet;
use crate::written::stages;
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Diagnostic, Place, describe};
use umbragraph_text::source::Span;

/// The maximum number of variants per conflicting binding that are searched for the most similar pair.
const MAX_CANDIDATES: usize = 256;

/// One variant of a template, with its reflection.
#[derive(Clone, Copy)]
struct Member<'a> {
    /// The index of the request, and the index of the WGSL module within the request.
    at: (usize, usize),
    values: &'a Choices,
    reflection: &'a Arc<Reflection>,
}

/// The values of the axes marked `own_layout`, in axis order; `None` if the module does not depend on the axis.
type Layout<'a> = Vec<Option<&'a AxisValue>>;

/// Returns a diagnostic for every binding that two variants of a template declare differently.
pub(super) fn disagreements(
    templates: &TemplateSet,
    explored: &[Explored<'_>],
    reports: &[TemplateReport],
) -> Vec<Diagnostic> {
    let mut by_template: BTreeMap<&str, Vec<Member<'_>>> = BTreeMap::new();
    for (request, report) in reports.iter().enumerate() {
        let members = by_template.entry(&report.template).or_default();
        members.extend(report.variants.iter().enumerate().filter_map(|(text, variant)| {
            let reflection = variant.reflection.as_ref()?;
            Some(Member { at: (request, text), values: &variant.axes, reflection })
        }));
    }
    let mut diagnostics = Vec::new();
    for (template, members) in by_template {
        let own: Vec<&str> = templates
            .axes(template)
            .into_iter()
            .flat_map(Axes::iter)
            .filter(|axis| axis.own_layout)
            .map(|axis| axis.name.as_str())
            .collect();
        let mut said = BTreeSet::new();
        for (conflict, one, other) in conflicts(&members, &own) {
            // Two layouts can show the same conflict, each from its side.
            let mut words: Vec<String> = conflict.message.split(' ').map(str::to_owned).collect();
            words.sort_unstable();
            if !said.insert(words) {
                continue;
            }
            let (one, other) = closest(&members, &own, &conflict, one, other);
            let place = |member: &Member<'_>, name: &str| {
                let each = explored.get(member.at.0);
                let source = each.and_then(|each| each.exploration.source(templates, template, member.at.1));
                let at = source.and_then(|source| {
                    declaration_of(&source.wgsl, name).and_then(|range| source.map.span(range))
                });
                at.or_else(|| templates.file(template).map(|file| Span::new(file, 0..0)))
                    .map_or(Place::Nowhere, Place::Span)
            };
            let (there, here) = (place(&one, &conflict.first_name), place(&other, &conflict.name));
            let (one, other) = (apart(one.values, other.values), apart(other.values, one.values));
            let message = format!("two variants of \"{template}\" disagree: {}", conflict.message);
            diagnostics.push(
                Diagnostic::error(codes::INTERFACE_CONFLICT, here.clone(), message)
                    .related(there, format!("the one is {}", describe(&one)))
                    .related(here, format!("the other is {}", describe(&other)))
                    .help("let all variants declare it alike, or at different bindings; an axis that is there to choose between layouts is declared with \"own_layout\": true"),
            );
        }
    }
    diagnostics
}

fn layout<'a>(member: &Member<'a>, own: &[&str]) -> Layout<'a> {
    own.iter().map(|name| member.values.get(name)).collect()
}

/// Returns `true` if two variants may use the same bind-group layout: no axis marked `own_layout` has different values
/// in them.
fn meet(one: &Layout<'_>, other: &Layout<'_>) -> bool {
    one.iter().zip(other).all(|pair| !matches!(pair, (Some(one), Some(other)) if one != other))
}

/// Returns the conflicts between variants that may share a layout, each with two conflicting variants.
fn conflicts<'a>(members: &[Member<'a>], own: &[&str]) -> Vec<(InterfaceConflict, Member<'a>, Member<'a>)> {
    // Equal reflections are one; the first variant stands for all of them.
    let mut layouts: BTreeMap<Layout<'a>, BTreeMap<*const Reflection, Member<'a>>> = BTreeMap::new();
    for member in members {
        let known = layouts.entry(layout(member, own)).or_default();
        known.entry(Arc::as_ptr(member.reflection)).or_insert(*member);
    }
    let in_order = |members: &BTreeMap<*const Reflection, Member<'a>>| {
        let mut members: Vec<Member<'a>> = members.values().copied().collect();
        members.sort_by_key(|member| member.at);
        members
    };
    // Layouts that leave the same axes open and are not the same differ in some value.
    let mut by_open: BTreeMap<Vec<bool>, Vec<&Layout<'a>>> = BTreeMap::new();
    let open = |layout: &Layout<'_>| layout.iter().map(Option::is_none).collect::<Vec<bool>>();
    layouts.keys().for_each(|layout| by_open.entry(open(layout)).or_default().push(layout));
    let mut found = Vec::new();
    for (layout, own_members) in &layouts {
        let mut together = in_order(own_members);
        let others = by_open.iter().filter(|(other, _)| **other != open(layout)).flat_map(|(_, each)| each);
        let others = others.filter(|other| meet(layout, other)).filter_map(|other| layouts.get(*other));
        together.extend(others.flat_map(in_order));
        let (_, conflicts) = interface::unite(together.iter().map(|member| member.reflection.as_ref()));
        for conflict in conflicts {
            let pair = (together.get(conflict.first), together.get(conflict.second));
            // Two that meet this layout need not meet each other.
            if let (Some(one), Some(other)) = pair
                && meet(&self::layout(one, own), &self::layout(other, own))
            {
                found.push((conflict, *one, *other));
            }
        }
    }
    found
}

/// Among variants with the two conflicting bindings, returns the pair that differs in the fewest axes.
fn closest<'a>(
    members: &[Member<'a>],
    own: &[&str],
    conflict: &InterfaceConflict,
    one: Member<'a>,
    other: Member<'a>,
) -> (Member<'a>, Member<'a>) {
    let alike = |name: &str, as_in: Member<'a>| -> Vec<Member<'a>> {
        let binding =
            |member: &Member<'a>| member.reflection.bindings.iter().find(|binding| binding.name == name);
        let Some(wanted) = binding(&as_in) else { return vec![as_in] };
        let is_it = |member: &&Member<'a>| binding(member).is_some_and(|each| interface::agree(each, wanted));
        members.iter().filter(is_it).take(MAX_CANDIDATES).copied().collect()
    };
    let (ones, others) = (alike(&conflict.first_name, one), alike(&conflict.name, other));
    let distance = |(one, other): &(Member<'a>, Member<'a>)| {
        apart(one.values, other.values).len() + apart(other.values, one.values).len()
    };
    let pairs = ones.iter().flat_map(|one| others.iter().map(|other| (*one, *other)));
    let pairs = pairs.filter(|(one, other)| meet(&layout(one, own), &layout(other, own)));
    pairs.min_by_key(distance).unwrap_or((one, other))
}

/// Returns the values of `one` that `other` lacks or has differently.
fn apart(one: &Choices, other: &Choices) -> AxisValues {
    let apart = one.iter().filter(|(name, value)| other.get(name) != Some(value));
    apart.map(|(name, value)| (name.to_owned(), value.clone())).collect()
}

/// The byte range of the name in the declaration of a module-scope variable with `@binding`; `None` if there is none.
fn declaration_of(wgsl: &str, name: &str) -> Option<std::ops::Range<usize>> {
    stages::words(wgsl, name).find(|range| {
        let statement = wgsl[..range.start].rfind([';', '}']).map_or(0, |end| end + 1);
        let before = &wgsl[statement..range.start];
        before.contains("@binding") && before.contains("var")
    })
}
