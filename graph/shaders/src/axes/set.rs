//! All axes of a template.

use std::collections::{BTreeMap, BTreeSet};

use super::axis::Axis;
use super::constraint::Constraint;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};
use umbragraph_text::source::Span;

/// Axes whose declarations are invalid. A template with any of them is not rendered, since it would only report
/// follow-up errors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    pub(super) names: BTreeSet<String>,
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// The axes of a template and their constraints, including the inherited ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Axes {
    pub(super) axes: BTreeMap<String, Axis>,
    pub(super) constraints: Vec<Constraint>,
    /// The names of the templates whose axes are inherited, each with its source span.
    pub(crate) inherits: Vec<(String, Span)>,
    /// Axes whose declarations are invalid.
    pub(crate) lost: Lost,
}

impl Axes {
    /// Iterates over the axes in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &Axis> {
        self.axes.values()
    }

    /// Returns the axis with this name, or `None`.
    pub fn get(&self, name: &str) -> Option<&Axis> {
        self.axes.get(name)
    }

    /// Iterates over the names of the axes in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.axes.keys().map(String::as_str)
    }

    /// Returns `true` if the template has no axes.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// The constraints in the order of their declaration, the template's own before inherited ones.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Returns the default value of every axis.
    pub fn defaults(&self) -> AxisValues {
        self.axes.iter().map(|(name, axis)| (name.clone(), axis.default.clone())).collect()
    }

    /// Iterates over the constraints that the axis values violate. `values` must contain every axis.
    pub fn violated<'a>(&'a self, values: &'a AxisValues) -> impl Iterator<Item = &'a Constraint> {
        self.constraints.iter().filter(|constraint| !constraint.holds(values))
    }

    /// Adds the axes and constraints of an inherited template. Own declarations take precedence. Returns the pairs
    /// (own, inherited) that differ in type, values or mode.
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
