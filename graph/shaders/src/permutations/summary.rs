//! Builds a report from texts and verdicts: variants, coverage, values of axes, the union of their interfaces, sizes,
//! dead axes and text.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

use super::dead;
use super::explore::Exploration;
use super::interned::{Declarations, Id};
use super::proven::{Explored, Verdict};
use super::report::{TemplateReport, ValueBytes, VariantReport};
use crate::axes::{Axes, AxisMode};
use crate::reflection::interface;
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::variant::compile::template_values;
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Count};

/// Builds the report on one request.
pub(super) fn report_on(
    templates: &TemplateSet,
    each: &Explored<'_>,
    declarations: &Declarations,
    verdicts: Vec<Verdict>,
) -> TemplateReport {
    let Explored { request, space, exploration, .. } = each;
    let mut variants = Vec::new();
    let mut covered = Count::ZERO;
    for ((at, text), verdict) in exploration.texts.iter().enumerate().zip(verdicts) {
        let leaves = exploration.leaves_of(at);
        let mut configurations = Count::ZERO;
        for leaf in leaves.iter().filter_map(|at| exploration.leaves.get(*at)) {
            configurations = configurations.plus(space.count(&leaf.decided.values()));
        }
        covered = covered.plus(configurations);
        variants.push(VariantReport {
            axes: exploration.leaves.get(text.leaf).map(|leaf| leaf.decided.clone()).unwrap_or_default(),
            paths: leaves.len(),
            configurations,
            bytes: text.bytes,
            hash: blake3::Hash::from_bytes(text.hash).to_string(),
            valid: verdict.is_valid,
            costs: verdict.costs,
            reflection: verdict.reflection,
        });
    }
    // Equal reflections are one.
    let mut seen = HashSet::new();
    let reflections = variants.iter().filter_map(|variant| variant.reflection.as_ref());
    let distinct = reflections.filter(|each| seen.insert(Arc::as_ptr(each)));
    let (interface, _) = interface::unite(distinct.map(Arc::as_ref));
    TemplateReport {
        request: each.at,
        name: request.name.clone(),
        group: request.group.clone(),
        template: request.template.clone(),
        profiles: request.profiles.iter().map(|profile| profile.name.clone()).collect(),
        configurations: space.count(&AxisValues::new()),
        // Paths that were not taken hold further combinations.
        covered: Count { exact: covered.exact && exploration.complete, ..covered },
        paths: exploration.leaves.len(),
        values: values_of(exploration),
        declarations: declarations_of(exploration, declarations),
        dead_axes: dead_axes(templates, each, &variants),
        bytes_of_values: bytes_of_values(templates, each),
        variants,
        interface,
    }
}

/// Collects the explored values of each axis.
fn values_of(exploration: &Exploration) -> BTreeMap<String, BTreeSet<AxisValue>> {
    let mut values: BTreeMap<String, BTreeSet<AxisValue>> = BTreeMap::new();
    for (name, value) in exploration.leaves.iter().flat_map(|leaf| leaf.decided.iter()) {
        match values.get_mut(name) {
            Some(known) if known.contains(value) => {}
            Some(known) => drop(known.insert(value.clone())),
            None => drop(values.insert(name.to_owned(), [value.clone()].into())),
        }
    }
    values
}

/// Hashes the distinct declarations; the result does not depend on the order in which threads found them.
fn declarations_of(exploration: &Exploration, declarations: &Declarations) -> BTreeSet<u64> {
    let ids: BTreeSet<Id> =
        exploration.texts.iter().filter_map(|text| text.declarations.as_deref()).flatten().copied().collect();
    let all = ids.into_iter().filter_map(|id| declarations.all.get(id as usize));
    let hash = |text: &str| blake3::hash(text.as_bytes()).as_bytes().first_chunk().copied();
    all.filter_map(|declared| hash(&declared.text)).map(u64::from_le_bytes).collect()
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
        // Nobody knows what overrides do in a text that is rejected.
        let rejected =
            axis.mode == AxisMode::Override && variants.iter().any(|each| each.reflection.is_none());
        let known = !rejected && !each.exploration.partial.contains(&axis.name);
        choice && known && !effective.contains(&axis.name) && !overrides.contains(axis.name.as_str())
    })
    .map(|axis| axis.name.clone())
    .collect()
}

/// Returns the change in WGSL size, in bytes, for each non-default value of axes with at most 16 values.
fn bytes_of_values(templates: &TemplateSet, each: &Explored<'_>) -> Vec<ValueBytes> {
    const MAX_VALUES: u64 = 16;
    let template = &each.request.template;
    let size = |values: &AxisValues| -> Option<i64> {
        let values = template_values(templates, template, &each.space.complete(values)?);
        render::render_fixed(templates, template, &values).map(|source| source.wgsl.len() as i64)
    };
    let Some(plain) = size(&AxisValues::new()) else { return Vec::new() };
    let mut found = Vec::new();
    for name in &each.exploration.read {
        let Some(domain) = each.space.variable(name).filter(|domain| domain.count() <= MAX_VALUES) else {
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
