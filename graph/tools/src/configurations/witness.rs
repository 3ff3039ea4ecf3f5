//! Settings with which a condition holds, and the values that an expression can have.
//!
//! Some pipelines have too many configurations to check each. For these the search looks for configurations in which
//! each condition holds, and for others in which it does not. One setting after the other gets a value. A branch ends
//! as soon as the condition is decided, `false && anything` being false.
//!
//! Limits: 20,000 steps for one condition, and 4,096 combinations for the values of one expression; what is not found
//! within them is unknown.

use std::collections::{BTreeMap, BTreeSet};

use crate::configurations::cover::Rules;
use crate::configurations::varied_setting::Varied;
use umbragraph_pipeline::document;
use umbragraph_pipeline::expression::{
    BinaryOperator, Expression, ExpressionKind, UnaryOperator, Value, evaluate,
};

/// The maximum number of assignments of values to settings that the search for one condition tries.
const MAX_STEPS: usize = 20_000;

/// The settings that vary between configurations, and the default values of all settings.
pub(super) struct Settings<'a> {
    pub(super) varied: &'a [Varied],
    pub(super) rules: Rules,
    defaults: &'a BTreeMap<String, Value>,
}

/// The result of a search for settings with which a condition is true, or is false.
#[derive(Debug, PartialEq)]
pub(super) enum Witness {
    /// The index of each setting's value in a configuration that the search found.
    Found(Vec<usize>),
    /// No allowed combination of the settings' tried values gives the condition the wanted result.
    Nowhere,
    /// The search took too many steps, or the settings do not decide the condition.
    Unknown,
}

impl<'a> Settings<'a> {
    pub(super) fn new(varied: &'a [Varied], defaults: &'a BTreeMap<String, Value>) -> Self {
        Self { varied, rules: Rules::new(varied), defaults }
    }

    fn position(&self, name: &str) -> Option<usize> {
        self.varied.iter().position(|each| each.name == name)
    }

    /// Returns the indices of the settings that an expression names.
    pub(super) fn named(&self, expression: &Expression) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        expression.visit(&mut |inner| {
            if let ExpressionKind::Name(name) = &inner.kind {
                found.extend(self.position(name));
            }
        });
        found
    }

    /// Evaluates an expression with the value indices in `pick`; settings that do not vary have their defaults. `None`
    /// if a needed value is not chosen or the evaluation fails.
    pub(super) fn value(&self, expression: &Expression, pick: &[Option<usize>]) -> Option<Value> {
        let scope = |name: &str| match self.position(name) {
            Some(at) => value_of(self.varied[at].values.get((*pick.get(at)?)?)?),
            None => self.defaults.get(name).cloned(),
        };
        evaluate(expression, &scope).ok()
    }

    /// Evaluates a condition with the value indices chosen so far; `None` if they do not decide it.
    pub(super) fn holds(&self, condition: &Expression, pick: &[Option<usize>]) -> Option<bool> {
        match &condition.kind {
            ExpressionKind::Unary(UnaryOperator::Not, inner) => self.holds(inner, pick).map(|holds| !holds),
            ExpressionKind::Binary(operator @ (BinaryOperator::And | BinaryOperator::Or), a, b) => {
                let deciding = *operator == BinaryOperator::Or;
                match (self.holds(a, pick), self.holds(b, pick)) {
                    (Some(a), Some(b)) => Some(if deciding { a || b } else { a && b }),
                    (Some(one), None) | (None, Some(one)) if one == deciding => Some(deciding),
                    _ => None,
                }
            }
            ExpressionKind::Conditional(a, b, c) => match self.holds(a, pick) {
                Some(true) => self.holds(b, pick),
                Some(false) => self.holds(c, pick),
                None => None,
            },
            _ => match self.value(condition, pick)? {
                Value::Bool(holds) => Some(holds),
                _ => None,
            },
        }
    }

    /// Searches for values, allowed by the rules between features, with which a condition has the result `wanted`.
    pub(super) fn witness(&self, condition: &Expression, wanted: bool) -> Witness {
        let mut order: Vec<usize> = self.named(condition).into_iter().collect();
        let tied = self.rules.with_tied(order.iter().copied().collect());
        order.extend(tied.into_iter().filter(|at| !order.contains(at)).collect::<Vec<_>>());
        let mut search = Search { settings: self, condition, wanted, order, steps: 0, is_decided: true };
        let mut pick = vec![None; self.varied.len()];
        match search.extend(&mut pick, 0) {
            true => Witness::Found(pick.into_iter().map(Option::unwrap_or_default).collect()),
            false if search.is_decided && search.steps < MAX_STEPS => Witness::Nowhere,
            false => Witness::Unknown,
        }
    }
}

struct Search<'s> {
    settings: &'s Settings<'s>,
    condition: &'s Expression,
    wanted: bool,
    order: Vec<usize>,
    steps: usize,
    /// Whether every complete choice of values so far has decided the condition.
    is_decided: bool,
}

impl Search<'_> {
    fn extend(&mut self, pick: &mut Vec<Option<usize>>, depth: usize) -> bool {
        let holds = self.settings.holds(self.condition, pick);
        if holds == Some(!self.wanted) {
            return false;
        }
        let Some(at) = self.order.get(depth).copied() else {
            self.is_decided &= holds.is_some();
            let whole: Vec<usize> = pick.iter().map(|value| value.unwrap_or_default()).collect();
            return holds.is_some() && self.settings.rules.allow(&whole);
        };
        for value in 0..self.settings.varied[at].values.len().max(1) {
            self.steps += 1;
            if self.steps >= MAX_STEPS {
                return false;
            }
            pick[at] = Some(value);
            if self.extend(pick, depth + 1) {
                return true;
            }
        }
        pick[at] = None;
        false
    }
}

/// Converts a JSON value of a document to a value of an expression; `None` for null and objects.
pub(super) fn value_of(value: &document::Value) -> Option<Value> {
    use document::Kind as K;
    Some(match &value.kind {
        K::Bool(value) => Value::Bool(*value),
        K::Number(number) => Value::Number(number.as_f64()?),
        K::Text(text) => Value::Text(text.clone()),
        K::Array(elements) => Value::List(elements.iter().map(value_of).collect::<Option<_>>()?),
        K::Null | K::Missing | K::Object(_) => return None,
    })
}
