//! Axes: what a template varies in, declared beside it.
//!
//! `forward.axes.json` declares the axes of `forward.wgsl.jinja`:
//!
//! ```jsonc
//! {
//!   "inherits": ["lib/noise.wgsl.jinja"],        // included templates, whose axes and constraints hold here too
//!   "axes": {
//!     "sscs":   { "type": "bool", "default": false, "requires": ["depth_prepass"] },
//!     "filter": { "type": "enum", "values": ["hard", "pcf", "evsm"], "default": "pcf" },
//!     "taps":   { "type": "integer", "min": 1, "max": 64, "default": 16, "as": "override" },
//!     "target": { "type": "texture_format", "values": ["rgba16float", "rgba32float"], "default": "rgba16float" }
//!   },
//!   "constraints": [
//!     { "when": "filter=evsm", "excludes": ["msaa"] },
//!     { "one_of": ["filter=hard", "filter=pcf", "filter=evsm"] }
//!   ]
//! }
//! ```
//!
//! A *template* axis is a variable of the template, with one variant per value that changes the text. An *override* axis
//! is a pipeline-overridable constant of the module instead: one text, any value. Constraints narrow the product of all
//! axes; `requires` and `excludes` inside an axis are short for a constraint whose `when` is the axis itself.
//!
//! Limits: an axis name is a WGSL identifier; an integer axis spans at most 2³² values.

mod condition;
mod constraint;
mod parse;
mod schema;

pub use condition::Condition;
pub use constraint::{Constraint, Rule};
use parse::Lost;
pub(crate) use parse::{Declaration, parse};
pub use schema::schema;

use std::collections::BTreeMap;

use crate::diagnostic::{AxisValue, AxisValues};
use crate::source::Span;

/// The values of an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AxisKind {
    /// `false` and `true`.
    Bool,
    /// The members of an enumeration, in the order of their declaration.
    Enum(Vec<String>),
    /// All integers from `min` to `max`, both included.
    Integer {
        /// The minimum.
        min: i64,
        /// The maximum.
        max: i64,
    },
    /// Names of texture formats, spelt as in WGSL, in the order of their declaration.
    TextureFormat(Vec<String>),
}

impl AxisKind {
    /// The number of values.
    pub fn count(&self) -> u64 {
        match self {
            AxisKind::Bool => 2,
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => names.len() as u64,
            AxisKind::Integer { min, max } => max.abs_diff(*min).saturating_add(1),
        }
    }

    /// Whether a value belongs to the axis.
    pub fn contains(&self, value: &AxisValue) -> bool {
        match (self, value) {
            (AxisKind::Bool, AxisValue::Bool(_)) => true,
            (AxisKind::Enum(names) | AxisKind::TextureFormat(names), AxisValue::Name(name)) => {
                names.contains(name)
            }
            (AxisKind::Integer { min, max }, AxisValue::Integer(value)) => (min..=max).contains(&value),
            _ => false,
        }
    }

    /// The values in words: `false or true`, `1 to 64`, `hard, pcf or evsm`.
    pub fn describe(&self) -> String {
        match self {
            AxisKind::Bool => "false or true".to_owned(),
            AxisKind::Integer { min, max } => format!("{min} to {max}"),
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => match names.split_last() {
                Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
                Some((last, _)) => last.clone(),
                None => "nothing".to_owned(),
            },
        }
    }
}

/// The form of an axis in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisMode {
    /// A variable of the template: another value may be another text.
    Template,
    /// A pipeline-overridable constant of the module: one text for all values.
    Override,
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name: the variable in the template, or the constant in the WGSL.
    pub name: String,
    /// Its values.
    pub kind: AxisKind,
    /// The value where none is given.
    pub default: AxisValue,
    /// A description for people.
    pub description: String,
    /// The form in WGSL.
    pub mode: AxisMode,
    /// Whether its minimum, default and maximum, and those that constraints name, stand for all where nothing
    /// narrows them: a number that is only a size, in a text that is otherwise the same. Pipelines are proven with the
    /// values that they reach all the same.
    pub ends: bool,
    /// Whether it is there to choose between layouts: variants with different values of it never stand for one another,
    /// so they may mean different things by one binding. All other variants of a template have to agree.
    pub own_layout: bool,
    /// Where its name is declared.
    pub span: Span,
}

/// The axes of a template, its own and the inherited ones, and their constraints.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Axes {
    axes: BTreeMap<String, Axis>,
    constraints: Vec<Constraint>,
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
