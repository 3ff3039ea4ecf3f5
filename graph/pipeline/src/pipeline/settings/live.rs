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

/// The place that makes a parameter structural.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structural {
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

/// A setting of a pass that is evaluated again when a live parameter changes.
#[derive(Clone, Debug)]
pub struct LiveSetting {
    /// Judges a value; those of blocks, workgroups and CPU nodes are judged where they are used.
    pub check: fn(&Value) -> Result<(), Diagnostic>,
    /// Its pointer, relative to the settings of the node kind.
    pub pointer: String,
    /// The expression.
    pub value: Deferred,
}

/// A value that follows from parameters: a derived one, or one that a subgraph is given.
#[derive(Clone, Debug)]
pub struct Following {
    /// The name that expressions know it by.
    pub name: String,
    /// The expression, over parameters and those before it.
    pub expression: Expression,
    /// The declaration with its limits, if it is a parameter of a subgraph.
    pub declaration: Option<ParameterDeclaration>,
    /// The place of its expression.
    pub place: Span,
}

/// A constraint whose condition follows from parameters.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// The condition.
    pub holds: Expression,
    /// The message if it does not hold.
    pub message: String,
    /// The place of the condition.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

/// The parameters that each value follows from, and those that are structural so far.
#[derive(Debug, Default)]
pub(crate) struct Dependence {
    /// The parameters that each name follows from, for names that expressions can use.
    of: BTreeMap<String, BTreeSet<String>>,
    /// The number of parameters.
    parameters: usize,
    pub(crate) structural: BTreeMap<String, Structural>,
    /// Values that follow from parameters, each after those that it depends on.
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

    /// Adds a value that an expression yields, which is closed; whether it follows from parameters.
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

    /// The parameters that names follow from.
    pub(crate) fn needs<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> BTreeSet<String> {
        names.into_iter().filter_map(|name| self.of.get(name)).flatten().cloned().collect()
    }

    /// Whether one of the names follows from a parameter.
    pub(crate) fn any<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> bool {
        names.into_iter().any(|name| self.of.contains_key(name))
    }

    /// Whether every parameter is structural.
    pub(crate) fn is_settled(&self) -> bool {
        self.structural.len() == self.parameters
    }

    /// Makes structural what a name follows from, because of what stands at a place.
    pub(crate) fn fix(&mut self, name: &str, at: &dyn Fn() -> Structural) {
        for parameter in self.of.get(name).into_iter().flatten() {
            if !self.structural.contains_key(parameter) {
                self.structural.insert(parameter.clone(), at());
            }
        }
    }
}

/// The names that the value of an expression follows from.
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

/// Whether two values are of one shape: what is live keeps the length of its list.
pub fn is_alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::List(a), Value::List(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_alike(a, b))
        }
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}
