//! The costs of entry points, and the lines of templates that they come from.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use super::compose::Composition;
use super::report::{Costs, TemplateReport, VariantReport};
use crate::module::wgsl;
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::rules::cost::{self, Spent};
use crate::rules::summary::Summary;
use umbragraph_text::source::Span;

/// Returns the costs of entry points, computed from the operations and calls of all functions of a module.
pub(super) fn of_summaries<'s>(
    summaries: &BTreeMap<String, Summary>,
    entry_points: impl Iterator<Item = &'s String>,
) -> Costs {
    let functions: HashMap<&String, &Spent<String>> =
        summaries.iter().map(|(name, summary)| (name, &summary.cost)).collect();
    entry_points.map(|name| (name.clone(), cost::total(name, &functions))).collect()
}

impl Composition<'_> {
    /// Returns the costs of a module's entry points. Equal results share one allocation in `known`.
    pub(super) fn costs(&self, text: usize, known: &mut HashSet<Arc<Costs>>) -> Arc<Costs> {
        let found = self.texts.get(text).map(|text| match &text.state.own {
            Some(own) if text.state.module.is_none() => own.costs.clone(),
            _ => self.costs_of_units(&text.state.units),
        });
        let found = Arc::new(found.unwrap_or_default());
        if let Some(known) = known.get(&found) {
            return known.clone();
        }
        known.insert(found.clone());
        found
    }

    fn costs_of_units(&self, units: &[u32]) -> Costs {
        let all = units.iter().filter_map(|unit| self.units.all.get(*unit as usize));
        let functions: HashMap<&u32, &Spent<u32>> =
            all.clone().filter_map(|unit| Some((unit.name.as_ref()?, unit.used.as_ref()?.spent()))).collect();
        let entries = all.filter(|unit| unit.entry_point.is_some());
        let named = entries.filter_map(|unit| unit.name.as_ref());
        named.map(|name| (self.declarations.name(*name).to_owned(), cost::total(name, &functions))).collect()
    }
}

impl TemplateReport {
    /// Returns the `max` most expensive template lines of a variant's most expensive entry point, in descending order.
    /// Each has its cost in scalar operations, counted once per loop iteration and per function call. Empty if the WGSL
    /// is invalid.
    pub fn expensive(
        &self,
        templates: &TemplateSet,
        variant: &VariantReport,
        max: usize,
    ) -> Vec<(Span, u64)> {
        let Some(source) = render::render_fixed(templates, &self.template, &variant.axes.values()) else {
            return Vec::new();
        };
        let found = wgsl::with_stack(|| {
            let module = wgsl::parse(&source.wgsl).ok()?;
            let info = wgsl::validate(&module, naga::valid::Capabilities::all()).ok()?;
            Some(cost::lines(&module, &info, variant.worst()?.0))
        });
        // By lines of the text: one line of a template can be many of them.
        let line_of = |at: usize| {
            let start = source.wgsl[..at].rfind('\n').map_or(0, |end| end + 1);
            let end = source.wgsl[at..].find('\n').map_or(source.wgsl.len(), |length| at + length);
            start + source.wgsl[start..end].find(|each: char| !each.is_whitespace()).unwrap_or_default()..end
        };
        let mut lines: BTreeMap<Span, u64> = BTreeMap::new();
        for (range, cost) in found.into_iter().flatten() {
            if let Some(span) = source.map.span(line_of(range.start)) {
                let sum = lines.entry(span).or_default();
                *sum = sum.saturating_add(cost);
            }
        }
        let mut lines: Vec<(Span, u64)> = lines.into_iter().collect();
        lines.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        lines.truncate(max);
        lines
    }
}
