//! All axes of a template.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::Axis;
use super::constraint::Constraint;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};
use umbragraph_text::source::Span;

/// Axes that are declared, but not so that anybody could tell what they are. A template that has them cannot be
/// rendered, and that its text knows nothing of them only follows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    pub(super) names: BTreeSet<String>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// The axes of a template, its own and the inherited ones, and their constraints.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Axes {
    pub(super) axes: BTreeMap<String, Axis>,
    pub(super) constraints: Vec<Constraint>,
    /// The templates whose axes are inherited, each with the place that says so.
    pub(crate) inherits: Vec<(String, Span)>,
    /// Axes that are declared, but not so that anybody could tell what they are.
    pub(crate) lost: Lost,
}

impl Axes {
    /// The axes in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &Axis> {
        self.axes.values()
    }

    /// An axis by its name.
    pub fn get(&self, name: &str) -> Option<&Axis> {
        self.axes.get(name)
    }

    /// The names in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.axes.keys().map(String::as_str)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// The constraints, own ones first, in the order of their declaration.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// The default value of every axis.
    pub fn defaults(&self) -> AxisValues {
        self.axes.iter().map(|(name, axis)| (name.clone(), axis.default.clone())).collect()
    }

    /// The constraints that complete values break.
    pub fn violated<'a>(&'a self, values: &'a AxisValues) -> impl Iterator<Item = &'a Constraint> {
        self.constraints.iter().filter(|constraint| !constraint.holds(values))
    }

    /// Takes over the axes and constraints of an inherited template. An own declaration stays; the answer is the pairs
    /// that do not agree (own, inherited).
    pub(crate) fn inherit(&mut self, other: &Axes) -> Vec<(Axis, Axis)> {
        let mut conflicts = Vec::new();
        for axis in other.axes.values() {
            match self.axes.get(&axis.name) {
                Some(own) if own.kind != axis.kind || own.mode != axis.mode => {
                    conflicts.push((own.clone(), axis.clone()));
                }
                Some(_) => {}
                None => {
                    self.axes.insert(axis.name.clone(), axis.clone());
                }
            }
        }
        self.lost.names.extend(other.lost.names.iter().cloned());
        self.lost.diagnostics.extend(other.lost.diagnostics.iter().cloned());
        for constraint in &other.constraints {
            if !self.constraints.contains(constraint) {
                self.constraints.push(constraint.clone());
            }
        }
        conflicts
    }
}
