//! Live parameters: those that can change from frame to frame without another plan.
//!
//! A parameter is *live* where its value reaches only what each frame sets anew: members of blocks, settings that a CPU
//! node takes over ([`crate::work::CpuNode::update`]), clear values, the stencil reference, the blend constant, the
//! counts of dispatches and draws. It is *structural* where something follows from it that is made once: sizes,
//! formats, shader variants and overrides, states of pipelines, references, which passes there are.
//!
//! The parameters of an expression are read off its names, in all branches, through derived values and through the
//! parameters of subgraphs. The argument of `len` does not count, since a live list keeps its length.
//!
//! Limits: no data flow; what one branch alone needs counts for the whole expression.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::settings::derived::Derived;
use crate::pipeline::settings::setting::ValuedParameter;
use crate::work::Deferred;
use umbragraph_text::diagnostic::Diagnostic;
use umbragraph_text::expression::{Expression, ExpressionKind, Value};
use umbragraph_text::language::ParameterDeclaration;
use umbragraph_text::source::Span;

/// The use of a parameter that makes the parameter structural: a change of its value then needs a new plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structural {
    /// The place of the use in the document.
    pub place: Span,
    /// The JSON pointer of the use.
    pub pointer: String,
}

/// A setting of a pass that is evaluated again when a live parameter changes. Live parameters can change from frame to
/// frame.
#[derive(Clone, Debug)]
pub struct LiveSetting {
    /// Validates a new value. It accepts any value for blocks, workgroups and CPU nodes, which validate the value
    /// themselves.
    pub check: fn(&Value) -> Result<(), Diagnostic>,
    /// The JSON pointer of the setting, relative to the settings of the node kind.
    pub pointer: String,
    /// The expression, with its place.
    pub value: Deferred,
}

/// A value that depends on parameters: a derived value, or an argument of a subgraph.
#[derive(Clone, Debug)]
pub struct Following {
    /// The name of the value in expressions.
    pub name: String,
    /// The expression, which uses parameters and earlier values.
    pub expression: Expression,
    /// The declaration with its limits, for a parameter of a subgraph; `None` for a derived value.
    pub declaration: Option<ParameterDeclaration>,
    /// The place of the expression in the document.
    pub place: Span,
}

/// A condition on the values of parameters, which is checked again when a live parameter changes.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// The condition, an expression that yields a boolean.
    pub holds: Expression,
    /// The message for a violated constraint.
    pub message: String,
    /// The place of the condition in the document.
    pub place: Span,
    /// The JSON pointer of the condition.
    pub pointer: String,
}

/// The parameters on which each value depends, and the structural parameters found so far, whose changes need a new
/// plan.
#[derive(Debug, Default)]
pub(crate) struct Dependence {
    /// The parameters on which each name in expressions depends; names that depend on none are missing.
    of: BTreeMap<String, BTreeSet<String>>,
    /// The number of parameters.
    parameters: usize,
    pub(crate) structural: BTreeMap<String, Structural>,
    /// The values that depend on parameters, in an order in which each follows the values that it depends on.
    pub(crate) following: Vec<Following>,
}

impl Dependence {
    pub(crate) fn new(
        parameters: &BTreeMap<String, ValuedParameter>,
        derived: &BTreeMap<String, Derived>,
    ) -> Self {
        let mut all = Self { parameters: parameters.len(), ..Self::default() };
        all.of.extend(parameters.keys().map(|name| (name.clone(), BTreeSet::from([name.clone()]))));
        let mut derived: Vec<(&String, &Derived)> = derived.iter().collect();
        derived.sort_by_key(|(_, one)| one.rank);
        for (name, one) in derived {
            all.add(name.clone(), one.expression.clone(), None, one.place);
        }
        all
    }

    /// Records a named value that an expression computes, if the expression depends on parameters. Returns `true` if it
    /// was recorded.
    pub(crate) fn add(
        &mut self,
        name: String,
        expression: Expression,
        declaration: Option<ParameterDeclaration>,
        place: Span,
    ) -> bool {
        let needs = self.needs(names(&expression));
        if needs.is_empty() {
            return false;
        }
        self.of.insert(name.clone(), needs);
        self.following.push(Following { name, expression, declaration, place });
        true
    }

    /// The parameters on which any of the names depends.
    pub(crate) fn needs<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> BTreeSet<String> {
        names.into_iter().filter_map(|name| self.of.get(name)).flatten().cloned().collect()
    }

    /// Returns `true` if one of the names depends on a parameter.
    pub(crate) fn any<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> bool {
        names.into_iter().any(|name| self.of.contains_key(name))
    }

    /// Returns `true` if every parameter is structural, so that no other parameter can become structural.
    pub(crate) fn is_settled(&self) -> bool {
        self.structural.len() == self.parameters
    }

    /// Marks the parameters on which a name depends as structural: a change of them then needs a new plan. `at` returns
    /// the use that is the reason.
    pub(crate) fn fix(&mut self, name: &str, at: &dyn Fn() -> Structural) {
        for parameter in self.of.get(name).into_iter().flatten() {
            if !self.structural.contains_key(parameter) {
                self.structural.insert(parameter.clone(), at());
            }
        }
    }
}

/// The names on which the value of an expression depends. The argument of `len` does not count, because a list keeps
/// its length.
pub(crate) fn names(expression: &Expression) -> Vec<&str> {
    let mut names = Vec::new();
    collect(expression, &mut names);
    names
}

fn collect<'e>(expression: &'e Expression, names: &mut Vec<&'e str>) {
    match &expression.kind {
        ExpressionKind::Name(name) => names.push(name),
        ExpressionKind::Call(function, list)
            if function == "len"
                && matches!(list.as_slice(), [Expression { kind: ExpressionKind::Name(_), .. }]) => {}
        _ => expression.parts().for_each(|part| collect(part, names)),
    }
}
