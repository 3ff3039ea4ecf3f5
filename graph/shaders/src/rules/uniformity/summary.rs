//! The summary of a function for its callers: its demands on them, and the dependencies of its results.

use naga::Span;

use super::flow_graph::Note;

/// An operation that is only valid in uniform control flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    Derivative,
    /// Texture sampling with an implicit mip level, with or without a depth comparison.
    Sample {
        compares: bool,
    },
    Barrier,
    WorkgroupUniformLoad,
    Subgroup,
}

impl Operation {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Derivative => "a derivative",
            Self::Sample { compares: false } => "textureSample",
            Self::Sample { compares: true } => "textureSampleCompare",
            Self::Barrier => "a barrier",
            Self::WorkgroupUniformLoad => "workgroupUniformLoad",
            Self::Subgroup => "a subgroup operation",
        }
    }

    pub(super) fn help(self) -> &'static str {
        match self {
            Self::Derivative => "take the derivative before the branch, and use its value within",
            Self::Sample { compares: false } => {
                "sample before the branch and choose with `select`, or name the level: `textureSampleLevel`, \
                 `textureSampleGrad` with derivatives from before the branch"
            }
            Self::Sample { compares: true } => {
                "sample before the branch and choose with `select`, or use `textureSampleCompareLevel`"
            }
            Self::Barrier => {
                "let every invocation reach the barrier: put the work before and after it under the condition"
            }
            Self::WorkgroupUniformLoad => {
                "load before the branch, from a place that is the same in every invocation"
            }
            Self::Subgroup => {
                "move the operation out of the branch, and give it a value that changes nothing"
            }
        }
    }
}

/// A requirement that control flow or a value is uniform, with the operation that needs it.
#[derive(Clone, Debug)]
pub(super) struct Need {
    pub(super) operation: Operation,
    /// Whether a violation is only a warning, because the module lowers the severity.
    pub(super) warning: bool,
    /// The place in the current function: the operation, or the call that leads to it.
    pub(super) place: Span,
    /// The name of the called function if `place` is a call; `None` if it is the operation itself.
    pub(super) called: Option<String>,
    /// Whether a value must be uniform as well, not only the control flow.
    pub(super) is_value: bool,
    /// The calls on the path from `place` to the operation, and the operation; empty if `place` is the operation
    /// itself.
    pub(super) way: Vec<Note>,
}

impl Need {
    pub(super) fn message(&self) -> String {
        let operation = self.operation.name();
        match (&self.called, self.is_value) {
            (None, false) => format!("{operation} in control flow that is not uniform"),
            (None, true) => format!("{operation} of what may differ between invocations"),
            (Some(called), false) => {
                format!(
                    "call of \"{called}\" in control flow that is not uniform, which {operation} in it needs"
                )
            }
            (Some(called), true) => {
                format!(
                    "\"{called}\" is given what may differ between invocations, and uses it for {operation}"
                )
            }
        }
    }

    /// Converts a requirement inside `function` to a requirement at the call of `function` at `place`.
    pub(super) fn called_at(&self, place: Span, function: &str, is_value: bool) -> Self {
        let text = match &self.called {
            None => format!("{} is here", self.operation.name()),
            Some(called) => format!("calls \"{called}\""),
        };
        let mut way = vec![Note { span: self.place, text }];
        way.extend(self.way.iter().cloned());
        Self { place, called: Some(function.to_owned()), is_value, way, ..self.clone() }
    }
}

/// A violation of a uniformity requirement, with the reasons why the control flow or value is not uniform.
#[derive(Debug)]
pub(super) struct Finding {
    pub(super) need: Need,
    pub(super) reasons: Vec<Note>,
}

/// An input that a function gets from its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passed {
    /// The value of the argument with this index.
    Argument(usize),
    /// The value that the pointer argument with this index refers to, before the call.
    Contents(usize),
}

/// The dependencies of a function's result, or of a value that a pointer argument refers to after the call.
#[derive(Clone, Debug, Default)]
pub(super) struct Origin {
    /// The reasons why the output differs between invocations even if all inputs are uniform; `None` if it does not.
    pub(super) differs: Option<Vec<Note>>,
    pub(super) passed: Vec<Passed>,
}

#[derive(Debug, Default)]
pub(crate) struct Summary {
    /// The requirements that the control flow at a call of the function is uniform.
    pub(super) flow: Vec<Need>,
    /// The requirements that an input of the function is uniform.
    pub(super) values: Vec<(Passed, Need)>,
    pub(super) result: Origin,
    /// The dependencies of the values that pointer arguments refer to after the call. `None` for an argument that is
    /// no pointer into the `function` address space.
    pub(super) contents: Vec<Option<Origin>>,
}

impl Summary {
    /// A string of all properties that affect callers, without places in the source, for comparing functions.
    pub(crate) fn digest(&self) -> String {
        let need = |need: &Need| (need.operation, need.warning, need.is_value);
        let flow: Vec<_> = self.flow.iter().map(need).collect();
        let values: Vec<_> = self.values.iter().map(|(passed, value)| (*passed, need(value))).collect();
        let origin = |origin: &Origin| (origin.differs.is_some(), origin.passed.clone());
        let contents: Vec<_> = self.contents.iter().map(|each| each.as_ref().map(origin)).collect();
        format!("{flow:?} {values:?} {:?} {contents:?}", origin(&self.result))
    }
}
