//! From texts and proofs to a report: variants, coverage, the interface of all variants together, sizes, what is dead.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

use super::count::Count;
use super::dead;
use super::report::{TemplateReport, ValueBytes, VariantReport};
use super::{Explored, Proven};
use crate::diagnostic::{Diagnostic, Place};
use crate::shader::compile::template_values;
use crate::shader::render::{self, Placement};
use crate::shader::value::{AxisValues, describe};
use crate::shader::{Axes, Binding, TemplateSet, codes, interface};
use crate::source::Span;

/// The report on one request, and what its variants disagree about.
pub(super) fn report_on(
    templates: &TemplateSet,
    placement: &Placement<'_>,
    each: &Explored<'_>,
    proven: &[Proven],
) -> (TemplateReport, Vec<Diagnostic>) {
    let Explored { request, space, exploration, tasks } = each;
    let mut variants = Vec::new();
    let mut covered = Count::ZERO;
    for (at, text) in exploration.texts.iter().enumerate() {
        let leaves = exploration.leaves_of(at);
        let mut configurations = Count::ZERO;
        for leaf in leaves.iter().filter_map(|at| exploration.leaves.get(*at)) {
            configurations = configurations.plus(space.count(&leaf.decided));
        }
        covered = covered.plus(configurations);
        let proof = tasks.get(at).and_then(|task| proven.get(*task)).map(|proven| &proven.proof);
        variants.push(VariantReport {
            axes: exploration.leaves.get(text.leaf).map(|leaf| leaf.decided.clone()).unwrap_or_default(),
            paths: leaves.len(),
            configurations,
            bytes: text.bytes,
            hash: blake3::Hash::from_bytes(text.hash).to_string(),
            valid: proof.is_some_and(|proof| proof.refusals.is_empty()),
            reflection: proof.and_then(|proof| proof.reflection.clone()),
        });
    }
    let (interface, conflicts) = unite(templates, placement, each, &variants);
    let report = TemplateReport {
        name: request.name.clone(),
        template: request.template.clone(),
        profiles: request.profiles.iter().map(|profile| profile.name.clone()).collect(),
        configurations: space.count(&AxisValues::new()),
        // Paths that were not taken hold further combinations.
        covered: Count { exact: covered.exact && exploration.complete, ..covered },
        paths: exploration.leaves.len(),
        dead_axes: dead_axes(templates, each, &variants),
        bytes_of_values: bytes_of_values(templates, placement, each),
        variants,
        interface,
    };
    (report, conflicts)
}

fn unite(
    templates: &TemplateSet,
    placement: &Placement<'_>,
    each: &Explored<'_>,
    variants: &[VariantReport],
) -> (Vec<Binding>, Vec<Diagnostic>) {
    let request = each.request;
    // Equal reflections are one; the first variant stands for all of them.
    let mut seen = HashSet::new();
    let reflected: Vec<(usize, &VariantReport)> = variants
        .iter()
        .enumerate()
        .filter(|(_, variant)| variant.reflection.as_ref().is_some_and(|each| seen.insert(Arc::as_ptr(each))))
        .collect();
    let (bindings, conflicts) =
        interface::unite(reflected.iter().filter_map(|(_, variant)| variant.reflection.as_deref()));
    let place = |text: usize, name: &str| {
        let source = each.exploration.source(templates, placement, &request.template, text);
        let at = source
            .and_then(|source| declaration_of(&source.wgsl, name).and_then(|range| source.map.span(range)));
        at.or_else(|| templates.file(&request.template).map(|file| Span::new(file, 0..0)))
            .map_or(Place::Nowhere, Place::Span)
    };
    let mut findings: Vec<Diagnostic> = Vec::new();
    for conflict in conflicts.into_iter().filter(|_| request.one_interface) {
        let (Some((first, one)), Some((second, other))) =
            (reflected.get(conflict.first), reflected.get(conflict.second))
        else {
            continue;
        };
        let message = format!("two variants of \"{}\" disagree: {}", request.name, conflict.message);
        if findings.iter().any(|known| known.message == message) {
            continue;
        }
        let (here, there) = (place(*second, &conflict.name), place(*first, &conflict.name));
        findings.push(
            Diagnostic::error(codes::INTERFACE_CONFLICT, here.clone(), message)
                .related(there, format!("the one is {}", describe(&one.axes)))
                .related(here, format!("the other is {}", describe(&other.axes))),
        );
    }
    (bindings, findings)
}

/// The name in the declaration of a module-scope variable.
fn declaration_of(wgsl: &str, name: &str) -> Option<std::ops::Range<usize>> {
    let is_word = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    let bytes = wgsl.as_bytes();
    wgsl.match_indices(name).map(|(at, name)| at..at + name.len()).find(|range| {
        let statement = wgsl[..range.start].rfind([';', '}']).map_or(0, |end| end + 1);
        let before = &wgsl[statement..range.start];
        let whole = !is_word(bytes.get(range.end))
            && !is_word(range.start.checked_sub(1).and_then(|at| bytes.get(at)));
        whole && before.contains("@binding") && before.contains("var")
    })
}

fn dead_axes(templates: &TemplateSet, each: &Explored<'_>, variants: &[VariantReport]) -> Vec<String> {
    let effective = dead::effective_axes(&each.exploration);
    let overrides: BTreeSet<&str> = variants
        .iter()
        .filter_map(|variant| variant.reflection.as_ref())
        .flat_map(|each| &each.overrides)
        .map(String::as_str)
        .collect();
    let axes = templates.axes(&each.request.template).into_iter().flat_map(Axes::iter);
    axes.filter(|axis| {
        let choice = each.request.allowed.get(&axis.name).is_none_or(|values| values.len() > 1);
        let known = !each.exploration.partial.contains(&axis.name);
        choice && known && !effective.contains(&axis.name) && !overrides.contains(axis.name.as_str())
    })
    .map(|axis| axis.name.clone())
    .collect()
}

/// What each value of a small axis adds to the text of all defaults.
fn bytes_of_values(
    templates: &TemplateSet,
    placement: &Placement<'_>,
    each: &Explored<'_>,
) -> Vec<ValueBytes> {
    const MAXIMUM_VALUES: u64 = 16;
    let template = &each.request.template;
    let size = |values: &AxisValues| -> Option<i64> {
        let values = template_values(templates, template, &each.space.complete(values)?);
        render::render_with(templates, placement, template, render::fixed_context(&values))
            .ok()
            .map(|(text, _)| text.len() as i64)
    };
    let Some(plain) = size(&AxisValues::new()) else { return Vec::new() };
    let mut found = Vec::new();
    for name in &each.exploration.read {
        let Some(domain) = each.space.variable(name).filter(|domain| domain.count() <= MAXIMUM_VALUES) else {
            continue;
        };
        for value in (0..domain.count()).filter_map(|at| domain.value(at)) {
            if each.space.default_of(name) == Some(&value) {
                continue;
            }
            if let Some(bytes) = size(&[(name.clone(), value.clone())].into()) {
                found.push(ValueBytes { axis: name.clone(), value, bytes: bytes - plain });
            }
        }
    }
    found
}
