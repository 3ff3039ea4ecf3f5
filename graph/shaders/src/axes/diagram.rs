//! Constraints as the layers of a decision diagram.
//!
//! Each constraint becomes clauses, disjunctions of conditions on single axes. The axes that clauses name are the
//! layers; a node of a layer is the set of clauses already satisfied among those that are still open. A clause whose
//! last axis is passed is either satisfied, and forgotten, or ends the path.
//!
//! Axes that clauses tie to one another, directly or through others, stand together, so that nothing is open where one
//! such group ends: groups multiply, and the diagram is as wide as its widest group, however many there are. Within a
//! group the order is that of the names.

use std::collections::{BTreeMap, BTreeSet};

use super::condition::Condition;
use super::constraint::{Constraint, Rule};
use super::domain::Domain;
use umbragraph_text::diagnostic::AxisValue;

/// A decision diagram of constraints between axes, with one layer for each axis that the constraints name.
#[derive(Clone, Debug, Default)]
pub(super) struct Diagram {
    pub(super) layers: Vec<Layer>,
    pub(super) clauses: usize,
    pub(super) axes: BTreeSet<String>,
}

#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) axis: String,
    /// The values that constraints name for the axis.
    pub(super) named: BTreeSet<AxisValue>,
    /// The clauses (disjunctions of conditions) that name the axis: index of the clause, its conditions on the axis,
    /// and `true` if the clause names no axis of a later layer.
    clauses: Vec<(usize, Vec<Condition>, bool)>,
}

impl Diagram {
    pub(super) fn new(constraints: &[Constraint]) -> Self {
        let clauses = clauses(constraints);
        let order = order(&clauses);
        let layers = order.iter().enumerate().map(|(position, axis)| {
            let of_clause = |(at, clause): (usize, &Clause)| {
                let here: Vec<Condition> = clause.iter().filter(|each| each.axis == *axis).cloned().collect();
                let last = clause.iter().all(|each| !order[position + 1..].contains(&each.axis.as_str()));
                (!here.is_empty()).then_some((at, here, last))
            };
            let clauses: Vec<_> = clauses.iter().enumerate().filter_map(of_clause).collect();
            let named = clauses.iter().flat_map(|(_, here, _)| here).map(|each| each.value.clone()).collect();
            Layer { axis: (*axis).to_owned(), named, clauses }
        });
        let axes = order.iter().map(|axis| (*axis).to_owned()).collect();
        Self { layers: layers.collect(), clauses: clauses.len(), axes }
    }
}

/// Orders the axes of the clauses so that axes which share a clause, directly or through others, are adjacent.
fn order(clauses: &[Clause]) -> Vec<&str> {
    // The first axis of the group that each axis is known to be in.
    let mut groups: BTreeMap<&str, &str> = BTreeMap::new();
    for clause in clauses {
        let axes: BTreeSet<&str> = clause.iter().map(|condition| condition.axis.as_str()).collect();
        let joined: BTreeSet<&str> = axes.iter().map(|axis| *groups.get(axis).unwrap_or(axis)).collect();
        let Some(first) = joined.first().copied() else { continue };
        groups.values_mut().filter(|group| joined.contains(*group)).for_each(|group| *group = first);
        groups.extend(axes.into_iter().map(|axis| (axis, first)));
    }
    let mut order: Vec<(&str, &str)> = groups.into_iter().map(|(axis, group)| (group, axis)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, axis)| axis).collect()
}

/// A disjunction of conditions: at least one of them must hold.
type Clause = Vec<Condition>;

impl Layer {
    /// Returns the bit set of satisfied clauses after the axis takes `value`; `None` if a clause can no longer be
    /// satisfied.
    ///
    /// The bit of a clause is cleared at the clause's last axis, so that equivalent nodes of the diagram merge.
    pub(super) fn after(&self, satisfied: &[u64], value: &AxisValue) -> Option<Vec<u64>> {
        let mut satisfied = satisfied.to_vec();
        for (clause, conditions, last) in &self.clauses {
            let (word, bit) = (clause / 64, 1 << (clause % 64));
            let holds = satisfied[word] & bit != 0 || conditions.iter().any(|each| each.accepts(value));
            match (holds, last) {
                (true, true) => satisfied[word] &= !bit,
                (true, false) => satisfied[word] |= bit,
                (false, true) => return None,
                (false, false) => {}
            }
        }
        Some(satisfied)
    }
}

/// Groups the values of an axis that no clause distinguishes. Returns one value per group with the number of values in
/// the group. If `decided` is given, it is the only value.
pub(super) fn classes(layer: &Layer, domain: &Domain, decided: Option<&AxisValue>) -> Vec<(AxisValue, u128)> {
    if let Some(value) = decided {
        return vec![(value.clone(), 1)];
    }
    let named = layer.named.iter().filter(|value| domain.contains(value));
    let mut classes: Vec<(AxisValue, u128)> = named.map(|value| (value.clone(), 1)).collect();
    let others = u128::from(domain.count()) - classes.len() as u128;
    if others > 0
        && let Some(value) = (0..).map_while(|at| domain.value(at)).find(|value| !layer.named.contains(value))
    {
        classes.push((value, others));
    }
    classes
}

fn clauses(constraints: &[Constraint]) -> Vec<Clause> {
    let not = |condition: &Condition| Condition { equal: !condition.equal, ..condition.clone() };
    let mut clauses = BTreeSet::new();
    for constraint in constraints {
        match &constraint.rule {
            Rule::Requires { when, all } => {
                clauses.extend(all.iter().map(|each| when.iter().map(not).chain([each.clone()]).collect()));
            }
            Rule::Excludes { when, none } => {
                clauses.extend(none.iter().map(|each| when.iter().map(not).chain([not(each)]).collect()));
            }
            Rule::OneOf(conditions) => {
                clauses.insert(conditions.clone());
                for (at, first) in conditions.iter().enumerate() {
                    clauses.extend(conditions[at + 1..].iter().map(|second| vec![not(first), not(second)]));
                }
            }
        }
    }
    clauses.into_iter().collect()
}
