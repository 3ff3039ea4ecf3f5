//! Groups many failures into few diagnostics: one per root cause.
//!
//! Failures with the same message at the same place of a template have one cause, in any number of variants, templates
//! and profiles. So have excesses over one limit, of any amount. A cause reports the number of affected variants and an
//! inclusion-minimal set of axis values: every variant with these values fails, and without any one of them some
//! variant passes. The search is greedy and drops axes with default values first, so that the remaining values are
//! those that somebody switched on.

use std::collections::{BTreeMap, BTreeSet};

use super::explore::Leaf;
use crate::axes::Space;
use crate::written::rejection::Excess;
use umbragraph_text::diagnostic::{AxisValues, Count, Diagnostic, Extent, Place, describe, list_of};

/// A failure shared by some leaves of one template. A leaf is one path through the template's branches.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    /// The diagnostic as reported for the first variant.
    pub(crate) diagnostic: Diagnostic,
    /// The indices of the failing template paths (leaves).
    pub(crate) leaves: BTreeSet<usize>,
    /// The names of the profiles with this failure; empty if the failure does not depend on profiles.
    pub(crate) profiles: BTreeSet<String>,
    /// The exceeded limit; `None` for other failures.
    pub(crate) excess: Option<Excess>,
    /// The override values that cause the failure; empty if it does not depend on overrides.
    pub(crate) overrides: AxisValues,
}

/// The key by which failures are merged: place, code, and message or limit.
type Key = (Place, &'static str, String);

impl Failure {
    fn key(&self) -> Key {
        let Diagnostic { place, code, message, .. } = &self.diagnostic;
        let of = self.excess.as_ref().map_or(message, |excess| &excess.of);
        (place.clone(), code.id, of.clone())
    }
}

/// A root cause to which failures are still added. `amount` and `max` are the first and the largest value found above a
/// limit, or 0 if no limit is exceeded.
struct Found {
    diagnostic: Diagnostic,
    amount: u64,
    max: u64,
    effects: Vec<Effect>,
}

/// The leaves (paths) of a template, and the data to measure how many variants a failure affects.
pub(crate) struct Ground<'a> {
    pub(crate) template: &'a str,
    pub(crate) space: &'a Space,
    pub(crate) leaves: &'a [Leaf],
    /// Axes whose values are combined with all others although some combinations may never occur. Maps each axis to a
    /// description of the source of its values.
    pub(crate) assumed: &'a BTreeMap<String, String>,
    /// The names of all profiles that were checked.
    pub(crate) profiles: BTreeSet<String>,
}

/// The effect of a root cause in one template: the affected variants and the axis values that cause it.
struct Effect {
    extent: Extent,
    /// Whether the failure occurs for only some of the checked profiles.
    is_of_some_profiles: bool,
    /// Notes on axes whose values were combined with all others, though some combinations may never occur.
    assumed: Vec<String>,
}

/// Root causes, keyed by place, code, and message or limit.
#[derive(Default)]
pub(crate) struct Causes {
    found: BTreeMap<Key, Found>,
}

impl Causes {
    /// Adds the failures of one template.
    pub(crate) fn add(&mut self, ground: &Ground<'_>, failures: Vec<Failure>) {
        let mut merged: BTreeMap<Key, (Failure, u64)> = BTreeMap::new();
        for failure in failures {
            let amount = failure.excess.as_ref().map_or(0, |excess| excess.found);
            match merged.get_mut(&failure.key()) {
                Some((known, max)) => {
                    if wording(&known.diagnostic) == wording(&failure.diagnostic) {
                        *max = (*max).max(amount);
                    }
                    // What no override is needed for needs none.
                    if known.overrides.len() > failure.overrides.len() {
                        known.overrides = failure.overrides;
                    }
                    let severity = &mut known.diagnostic.severity;
                    *severity = (*severity).min(failure.diagnostic.severity);
                    known.leaves.extend(failure.leaves);
                    known.profiles.extend(failure.profiles);
                }
                None => {
                    merged.insert(failure.key(), (failure, amount));
                }
            }
        }
        for (key, (failure, max)) in merged {
            let effect = weigh(ground, &failure);
            let amount = failure.excess.map_or(0, |excess| excess.found);
            let severity = failure.diagnostic.severity;
            let first = || Found { diagnostic: failure.diagnostic, amount, max, effects: Vec::new() };
            let found = self.found.entry(key).or_insert_with(first);
            found.diagnostic.severity = found.diagnostic.severity.min(severity);
            found.max = found.max.max(max);
            found.effects.push(effect);
        }
    }

    /// Returns one diagnostic per root cause, in the order of their places.
    pub(crate) fn diagnostics(self) -> Vec<Diagnostic> {
        self.found
            .into_values()
            .map(|Found { mut diagnostic, amount, max, effects }| {
                if max > amount {
                    diagnostic = diagnostic.related(Place::Nowhere, format!("up to {max} in other variants"));
                }
                for effect in effects {
                    let Effect { extent, is_of_some_profiles, assumed } = effect;
                    if extent.of_variants > 1 || is_of_some_profiles || !extent.provoked_by.is_empty() {
                        let text = describe_extent(&extent, is_of_some_profiles);
                        diagnostic = diagnostic.related(Place::Nowhere, text);
                        for note in assumed.iter().filter(|_| extent.variants < extent.of_variants) {
                            diagnostic = diagnostic.related(Place::Nowhere, note);
                        }
                    }
                    diagnostic.extent.push(extent);
                }
                diagnostic
            })
            .collect()
    }
}

fn describe_extent(extent: &Extent, is_of_some_profiles: bool) -> String {
    let mut text = format!(
        "in {} of {} variants of \"{}\" ({} configuration{})",
        extent.variants,
        extent.of_variants,
        extent.template,
        extent.configurations,
        if extent.configurations.number == 1 { "" } else { "s" }
    );
    if !extent.provoked_by.is_empty() {
        text.push_str(&format!(", provoked by {}", describe(&extent.provoked_by)));
    } else if extent.variants == extent.of_variants {
        text.push_str(", whatever the axes");
    }
    if is_of_some_profiles {
        let names: Vec<&str> = extent.profiles.iter().map(String::as_str).collect();
        text.push_str(&format!(", only for {}", list_of(names)));
    }
    text
}

/// Returns the message without its digits, to compare messages that differ only in numbers.
fn wording(diagnostic: &Diagnostic) -> String {
    diagnostic.message.chars().filter(|each| !each.is_ascii_digit()).collect()
}

fn weigh(ground: &Ground<'_>, failure: &Failure) -> Effect {
    let mut configurations = Count::ZERO;
    for leaf in failure.leaves.iter().filter_map(|at| ground.leaves.get(*at)) {
        let mut decided = leaf.decided.values();
        decided.extend(failure.overrides.clone());
        configurations = configurations.plus(ground.space.count(&decided));
    }
    let provocation = provocation(ground, &failure.leaves);
    let note = |(axis, yielded): (&String, &String)| {
        provocation.contains_key(axis).then(|| {
            format!(
                "\"{axis}\" follows {yielded}, which has too many values to try each: its values are combined with all others"
            )
        })
    };
    let assumed = ground.assumed.iter().filter_map(note).collect();
    let profiles = if failure.profiles.is_empty() { &ground.profiles } else { &failure.profiles };
    let (variants, of_variants) = (failure.leaves.len(), ground.leaves.len());
    let mut provoked_by = failure.overrides.clone();
    if variants != of_variants {
        provoked_by.extend(provocation);
    }
    let extent = Extent {
        template: ground.template.to_owned(),
        variants,
        of_variants,
        configurations,
        provoked_by,
        profiles: profiles.clone(),
    };
    Effect { extent, is_of_some_profiles: *profiles != ground.profiles, assumed }
}

/// Returns a minimal set of axis values such that every variant with these values fails.
fn provocation(ground: &Ground<'_>, failing: &BTreeSet<usize>) -> AxisValues {
    let switched_on = |leaf: &Leaf| {
        leaf.decided.iter().filter(|(name, value)| ground.space.default_of(name) != Some(value)).count()
    };
    let Some(plainest) = failing
        .iter()
        .filter_map(|at| ground.leaves.get(*at))
        .min_by_key(|leaf| (switched_on(leaf), leaf.decided.iter().count()))
    else {
        return AxisValues::new();
    };
    let mut values = plainest.decided.values();
    let mut order: Vec<String> = values.keys().cloned().collect();
    order.sort_by_key(|name| ground.space.default_of(name) != values.get(name));
    for name in order {
        let mut fewer = values.clone();
        fewer.remove(&name);
        let passes = ground
            .leaves
            .iter()
            .enumerate()
            .any(|(at, leaf)| !failing.contains(&at) && meet(ground, leaf, &fewer));
        if !passes {
            values = fewer;
        }
    }
    values
}

/// Returns `true` if a configuration on a template path (leaf) can have these axis values.
fn meet(ground: &Ground<'_>, leaf: &Leaf, values: &AxisValues) -> bool {
    if values.iter().any(|(name, value)| leaf.decided.get(name).is_some_and(|other| other != value)) {
        return false;
    }
    let mut both = leaf.decided.values();
    both.extend(values.clone());
    ground.space.possible(&both)
}
