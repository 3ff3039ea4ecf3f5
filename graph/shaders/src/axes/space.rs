//! The space of configurations of a template: the product of its narrowed axes, restricted by constraints.
//!
//! Constraints become clauses over literals "this axis has one of these values". Counting goes axis by axis and keeps,
//! for the axes already placed, only which clauses are satisfied: two partial configurations that satisfy the same
//! clauses have the same completions, so they are counted together. That is a decision diagram, built one layer at a
//! time and never stored. Only the values of an axis that a clause names are distinguished; all others count as one,
//! weighted by their number. An axis in no clause is a factor. The same walk decides whether a partial configuration
//! has a completion.
//!
//! Limits: a layer holds one group of axes that constraints connect. It has at most 65,536 nodes, and a count at most
//! 128 bits. Beyond either, the count is a lower bound, and an undecided completion counts as possible, so that no
//! configuration is missed.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::axis::{AxisKind, AxisMode};
use super::constraint::Constraint;
use super::diagram::{Diagram, classes};
use super::domain::Domain;
use super::set::Axes;
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Count};

/// The maximum number of nodes in one layer of the decision diagram.
const MAX_NODES: usize = 1 << 16;

/// The combinations of axis values of a template that satisfy its constraints.
#[derive(Clone, Debug)]
pub struct Space {
    axes: BTreeMap<String, (Domain, AxisMode)>,
    defaults: AxisValues,
    constraints: Vec<Constraint>,
    diagram: Diagram,
}

impl Space {
    /// Creates the space of valid axis values. An axis in `allowed` is restricted to the values listed there.
    pub(crate) fn new(axes: &Axes, allowed: &BTreeMap<String, Vec<AxisValue>>) -> Self {
        let domains = axes.iter().map(|axis| {
            let domain = match (allowed.get(&axis.name), &axis.kind) {
                (Some(values), kind) => {
                    Domain::Values(values.iter().filter(|value| kind.contains(value)).cloned().collect())
                }
                (None, AxisKind::Integer { min, max }) if axis.ends => {
                    let ends = [AxisValue::Integer(*min), axis.default.clone(), AxisValue::Integer(*max)];
                    // Constraints tell apart the values that they name, and one that stands for all others.
                    let conditions = axes.constraints().iter().flat_map(Constraint::conditions);
                    let named: BTreeSet<AxisValue> = conditions
                        .filter(|condition| condition.axis == axis.name)
                        .map(|condition| condition.value.clone())
                        .collect();
                    let other = (*min..=*max).map(AxisValue::Integer).find(|value| !named.contains(value));
                    let other = other.filter(|_| !named.is_empty());
                    let named = named.into_iter().chain(other).chain(ends).collect::<BTreeSet<_>>();
                    Domain::Values(named.into_iter().filter(|value| axis.kind.contains(value)).collect())
                }
                (None, kind) => Domain::of(kind),
            };
            (axis.name.clone(), (domain, axis.mode))
        });
        Self {
            axes: domains.collect(),
            defaults: axes.defaults(),
            constraints: axes.constraints().to_vec(),
            diagram: Diagram::new(axes.constraints()),
        }
    }

    /// Creates a space from lists of values by axis name and constraints, independent of a template.
    pub fn of(values: BTreeMap<String, Vec<AxisValue>>, constraints: Vec<Constraint>) -> Self {
        let domain = |(name, values)| (name, (Domain::Values(values), AxisMode::Template));
        Self {
            axes: values.into_iter().map(domain).collect(),
            defaults: AxisValues::new(),
            diagram: Diagram::new(&constraints),
            constraints,
        }
    }

    /// The values of an axis that is a template variable; `None` for an override axis or an unknown name.
    pub(crate) fn variable(&self, name: &str) -> Option<&Domain> {
        self.axes.get(name).filter(|(_, mode)| *mode == AxisMode::Template).map(|(domain, _)| domain)
    }

    /// The default value of an axis; `None` for an unknown name.
    pub(crate) fn default_of(&self, name: &str) -> Option<&AxisValue> {
        self.defaults.get(name)
    }

    /// Returns the number of valid combinations in which the axes in `decided` have the given values.
    pub fn count(&self, decided: &AxisValues) -> Count {
        self.walk(decided, &self.diagram).unwrap_or(Count { number: 1, exact: false })
    }

    /// Returns `true` if a valid combination contains the values in `decided`, or if the search is too large to decide.
    pub(crate) fn possible(&self, decided: &AxisValues) -> bool {
        self.walk(decided, &self.diagram).is_none_or(|count| count.number > 0)
    }

    /// Returns a minimal set of contradictory constraints; empty if a combination of values exists or the search is too
    /// large to decide.
    pub(crate) fn clash(&self) -> Vec<Constraint> {
        let nothing = AxisValues::new();
        let impossible = |constraints: &[Constraint]| {
            self.walk(&nothing, &Diagram::new(constraints)).is_some_and(|count| count.number == 0)
        };
        if !impossible(&self.constraints) {
            return Vec::new();
        }
        let mut kept = self.constraints.clone();
        let mut at = 0;
        while at < kept.len() {
            let mut fewer = kept.clone();
            fewer.remove(at);
            if impossible(&fewer) {
                kept = fewer;
            } else {
                at += 1;
            }
        }
        kept
    }

    /// Extends `decided` to a complete combination. Each further axis gets its default if the constraints allow it,
    /// else its first allowed value. `None` if `decided` has no completion.
    pub(crate) fn complete(&self, decided: &AxisValues) -> Option<AxisValues> {
        let mut values = decided.clone();
        if !self.possible(&values) {
            return None;
        }
        for (name, (domain, _)) in &self.axes {
            if values.contains_key(name) {
                continue;
            }
            let default = self.defaults.get(name).filter(|value| domain.contains(value)).cloned();
            // Values that no constraint names are alike, so looking further than one beyond the named ones is in vain.
            let layer = self.diagram.layers.iter().find(|layer| layer.axis == *name);
            let named = layer.map_or(0, |layer| layer.named.len());
            let others = (0..domain.count().min(named as u64 + 2)).filter_map(|at| domain.value(at));
            let chosen = default.into_iter().chain(others).find(|value| {
                values.insert(name.clone(), value.clone());
                self.possible(&values)
            });
            values.insert(name.clone(), chosen?);
        }
        Some(values)
    }

    /// Counts the valid combinations that extend `decided`; `None` if a layer of the diagram exceeds [`MAX_NODES`].
    fn walk(&self, decided: &AxisValues, diagram: &Diagram) -> Option<Count> {
        let mut total = Count { number: 1, exact: true };
        for (name, (domain, _)) in &self.axes {
            let number = match decided.get(name) {
                Some(value) => u128::from(domain.contains(value)),
                None => u128::from(domain.count()),
            };
            if number == 0 {
                return Some(Count::ZERO);
            }
            if !diagram.axes.contains(name) {
                total = total.times(number);
            }
        }
        let mut nodes: HashMap<Vec<u64>, Count> = HashMap::new();
        nodes.insert(vec![0; diagram.clauses.div_ceil(64)], Count { number: 1, exact: true });
        for layer in &diagram.layers {
            let Some((domain, _)) = self.axes.get(&layer.axis) else { return Some(Count::ZERO) };
            let classes = classes(layer, domain, decided.get(&layer.axis));
            let mut next: HashMap<Vec<u64>, Count> = HashMap::new();
            for (satisfied, count) in &nodes {
                for (value, weight) in &classes {
                    let Some(satisfied) = layer.after(satisfied, value) else { continue };
                    let count = count.times(*weight);
                    let sum = next.entry(satisfied).or_insert(Count::ZERO);
                    *sum = sum.plus(count);
                }
            }
            if next.len() > MAX_NODES {
                return None;
            }
            nodes = next;
        }
        let sum = nodes.values().fold(Count::ZERO, |sum, count| sum.plus(*count));
        Some(Count { exact: sum.exact && total.exact, ..sum.times(total.number) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::Fixture;

    fn space(axes: &str) -> Space {
        let fixture = Fixture::new(&[("main.wgsl.jinja", ""), ("main.axes.json", axes)]);
        Space::new(fixture.set.axes("main.wgsl.jinja").unwrap(), &BTreeMap::new())
    }

    /// Counts the valid combinations by enumerating all of them.
    fn brute_force(space: &Space) -> u128 {
        let mut all = vec![AxisValues::new()];
        for (name, (domain, _)) in &space.axes {
            all = all
                .into_iter()
                .flat_map(|values| {
                    (0..domain.count()).filter_map(|at| domain.value(at)).map(move |value| {
                        let mut values = values.clone();
                        values.insert(name.clone(), value);
                        values
                    })
                })
                .collect();
        }
        all.iter().filter(|values| space.constraints.iter().all(|each| each.holds(values))).count() as u128
    }

    const CONSTRAINED: &str = r#"{ "axes": {
        "a": { "type": "bool", "default": false, "requires": ["b", "taps!=3"] },
        "b": { "type": "bool", "default": false },
        "c": { "type": "bool", "default": false, "excludes": ["mode=evsm", "b"] },
        "mode": { "type": "enum", "values": ["hard", "pcf", "evsm"], "default": "hard" },
        "taps": { "type": "integer", "min": 1, "max": 9, "default": 1 },
        "free": { "type": "integer", "min": 0, "max": 4, "default": 0 } },
      "constraints": [ { "when": "mode=pcf", "requires": ["taps=3"] },
                       { "one_of": ["mode=hard", "a", "c"] } ] }"#;

    #[test]
    fn the_count_is_that_of_the_whole_product() {
        let space = space(CONSTRAINED);
        let counted = space.count(&AxisValues::new());
        assert_eq!(counted, Count { number: brute_force(&space), exact: true });
        assert!(counted.number > 0);
    }

    #[test]
    fn groups_of_axes_that_nothing_ties_multiply() {
        // 24 groups of four, interleaved by name: as one, the diagram would have 5^24 ways to be open.
        let mut axes = String::new();
        for member in ["a", "b", "c", "d"] {
            for group in 0..24 {
                let tie = match member {
                    "a" => format!(", \"requires\": [\"d{group}\"]"),
                    "b" => format!(", \"excludes\": [\"c{group}\"]"),
                    "c" => format!(", \"requires\": [\"a{group}\"]"),
                    _ => String::new(),
                };
                axes.push_str(&format!(
                    "\"{member}{group}\": {{ \"type\": \"bool\", \"default\": false{tie} }}, "
                ));
            }
        }
        let axes = format!("{{ \"axes\": {{ {} }} }}", axes.trim_end_matches(", "));
        let one = brute_force(&space(
            r#"{ "axes": { "a": { "type": "bool", "default": false, "requires": ["d"] },
                           "b": { "type": "bool", "default": false, "excludes": ["c"] },
                           "c": { "type": "bool", "default": false, "requires": ["a"] },
                           "d": { "type": "bool", "default": false } } }"#,
        ));
        let space = space(&axes);
        assert_eq!(space.count(&AxisValues::new()), Count { number: one.pow(24), exact: true });
        assert!(space.possible(&[("c3".to_owned(), true.into()), ("b4".to_owned(), true.into())].into()));
        assert!(!space.possible(&[("c3".to_owned(), true.into()), ("b3".to_owned(), true.into())].into()));
    }

    #[test]
    fn parts_of_the_space_add_up() {
        let space = space(CONSTRAINED);
        let mut sum = Count::ZERO;
        for mode in ["hard", "pcf", "evsm"] {
            for a in [false, true] {
                sum = sum.plus(
                    space.count(&[("mode".to_owned(), mode.into()), ("a".to_owned(), a.into())].into()),
                );
            }
        }
        assert_eq!(sum, space.count(&AxisValues::new()));
    }

    #[test]
    fn a_wide_free_space_is_counted_exactly() {
        let axes: String =
            (0..30).map(|at| format!("\"a{at}\": {{ \"type\": \"bool\", \"default\": false }}, ")).collect();
        let axes = format!(
            "{{ \"axes\": {{ {axes} \"n\": {{ \"type\": \"integer\", \"min\": 0, \"max\": 4294967295, \"default\": 0 }} }} }}"
        );
        let count = space(&axes).count(&AxisValues::new());
        assert_eq!(count, Count { number: 1 << 62, exact: true });
        assert_eq!(count.to_string(), "4,611,686,018,427,387,904");
    }

    #[test]
    fn a_clash_names_the_constraints_and_no_others() {
        let space = space(
            r#"{ "axes": { "a": { "type": "bool", "default": false }, "b": { "type": "bool", "default": false },
                           "c": { "type": "bool", "default": false, "requires": ["a"] } },
                 "constraints": [ { "requires": ["a"] }, { "requires": ["b"] }, { "when": "a", "excludes": ["b"] } ] }"#,
        );
        let clash: Vec<String> = space.clash().iter().map(Constraint::to_string).collect();
        assert_eq!(clash, ["a is required", "b is required", "a excludes b"]);
        assert!(!space.possible(&AxisValues::new()));
    }

    #[test]
    fn a_configuration_is_completed_with_defaults_where_they_fit() {
        let space = space(CONSTRAINED);
        let complete = space.complete(&[("mode".to_owned(), "evsm".into())].into()).unwrap();
        assert!(space.constraints.iter().all(|each| each.holds(&complete)), "{complete:?}");
        assert_eq!(complete["free"], AxisValue::Integer(0));
    }
}
