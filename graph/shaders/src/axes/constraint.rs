//! Constraints: which combinations of values make sense.
//!
//! A constraint holds or does not hold for complete values. `requires` wants all of its conditions, `excludes` none of
//! them, `one_of` exactly one; the first two apply only where `when` holds.

use std::collections::BTreeSet;
use std::fmt;

use super::condition::Condition;
use umbragraph_text::diagnostic::{AxisValues, list_of};
use umbragraph_text::source::Span;

/// The form of a constraint between axes, with its conditions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rule {
    /// If `when` holds, every condition of `all` must hold.
    Requires {
        /// The premise; `None` if the conditions must always hold.
        when: Option<Condition>,
        /// The conditions that must hold.
        all: Vec<Condition>,
    },
    /// If `when` holds, no condition of `none` may hold.
    Excludes {
        /// The premise; `None` if the conditions must never hold.
        when: Option<Condition>,
        /// The conditions that must not hold.
        none: Vec<Condition>,
    },
    /// Exactly one of these conditions must hold.
    OneOf(Vec<Condition>),
}

/// A constraint between axes and the source span of its declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constraint {
    /// The conditions and the way in which they are combined.
    pub rule: Rule,
    /// The source span of the constraint's declaration.
    pub span: Span,
}

impl Constraint {
    /// Returns `true` if the axis values satisfy the constraint. `values` must contain every axis that the constraint
    /// names.
    pub fn holds(&self, values: &AxisValues) -> bool {
        let applies = |when: &Option<Condition>| when.as_ref().is_none_or(|when| when.holds(values));
        match &self.rule {
            Rule::Requires { when, all } => {
                !applies(when) || all.iter().all(|condition| condition.holds(values))
            }
            Rule::Excludes { when, none } => {
                !applies(when) || !none.iter().any(|condition| condition.holds(values))
            }
            Rule::OneOf(conditions) => {
                conditions.iter().filter(|condition| condition.holds(values)).take(2).count() == 1
            }
        }
    }

    /// Iterates over the conditions of the constraint; the premise, if there is one, comes first.
    pub fn conditions(&self) -> impl Iterator<Item = &Condition> {
        let (when, rest) = match &self.rule {
            Rule::Requires { when, all: rest } | Rule::Excludes { when, none: rest } => (when.as_ref(), rest),
            Rule::OneOf(rest) => (None, rest),
        };
        when.into_iter().chain(rest)
    }

    /// Returns the names of the axes on which the constraint depends.
    pub fn axes(&self) -> BTreeSet<&str> {
        self.conditions().map(|condition| condition.axis.as_str()).collect()
    }
}

impl fmt::Display for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |conditions: &[Condition]| list_of(conditions.iter().map(Condition::to_string));
        match &self.rule {
            Rule::Requires { when: Some(when), all } => write!(f, "{when} requires {}", list(all)),
            Rule::Requires { when: None, all } => write!(f, "{} is required", list(all)),
            Rule::Excludes { when: Some(when), none } => write!(f, "{when} excludes {}", list(none)),
            Rule::Excludes { when: None, none } => write!(f, "{} is excluded", list(none)),
            Rule::OneOf(conditions) => write!(f, "exactly one of {}", list(conditions)),
        }
    }
}
