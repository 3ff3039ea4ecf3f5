//! Live parameters by typed handle, and what they set of the objects of a plan.

use std::marker::PhantomData;

use super::instantiate::Instantiated;
use umbragraph_compiler::{PackedBlock, Parameters, Plan};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::language::ParameterType;

/// The handle of a live parameter, which can change between frames without a new plan. `T` is the Rust type of its
/// values. Returned by [`crate::Executor::parameter`].
#[derive(Debug)]
pub struct Parameter<T> {
    pub(crate) at: usize,
    /// The identity of the set of parameters that the handle belongs to.
    pub(crate) of: u64,
    value_type: PhantomData<fn() -> T>,
}

impl<T> Clone for Parameter<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Parameter<T> {}

/// A Rust type for values of parameters: the declared type, `f64` for every number, or [`Value`] for any type.
pub trait ParameterValue {
    /// Writes this value to `to`, reusing the memory of `to` where possible.
    fn assign(&self, to: &mut Value);
    /// Returns `true` if a parameter with this declared type and current value accepts values of the Rust type.
    fn is_of(declared: ParameterType, value: &Value) -> bool;
}

macro_rules! numbers {
    ($($number:ty: $declared:pat),*) => {$(
        impl ParameterValue for $number {
            fn assign(&self, to: &mut Value) {
                *to = Value::Number(f64::from(*self));
            }

            fn is_of(declared: ParameterType, value: &Value) -> bool {
                matches!(declared, $declared) && matches!(value, Value::Number(_))
            }
        }
    )*};
}

use ParameterType as T;
numbers!(f32: T::F32 | T::F32List, f64: _, u32: T::U32 | T::U32List, i32: T::I32);

impl ParameterValue for bool {
    fn assign(&self, to: &mut Value) {
        *to = Value::Bool(*self);
    }

    fn is_of(_: ParameterType, value: &Value) -> bool {
        matches!(value, Value::Bool(_))
    }
}

impl ParameterValue for &str {
    fn assign(&self, to: &mut Value) {
        match to {
            Value::Text(text) => {
                text.clear();
                text.push_str(self);
            }
            to => *to = Value::Text((*self).to_owned()),
        }
    }

    fn is_of(_: ParameterType, value: &Value) -> bool {
        matches!(value, Value::Text(_))
    }
}

fn assign_list<T: ParameterValue>(list: &[T], to: &mut Value) {
    if !matches!(to, Value::List(_)) {
        *to = Value::List(Vec::new());
    }
    if let Value::List(to) = to {
        to.resize(list.len(), Value::Bool(false));
        list.iter().zip(to).for_each(|(value, to)| value.assign(to));
    }
}

impl<T: ParameterValue, const N: usize> ParameterValue for [T; N] {
    fn assign(&self, to: &mut Value) {
        assign_list(self, to);
    }

    fn is_of(declared: ParameterType, value: &Value) -> bool {
        matches!(value, Value::List(list) if list.len() == N && list.iter().all(|one| T::is_of(declared, one)))
    }
}

impl<T: ParameterValue> ParameterValue for &[T] {
    fn assign(&self, to: &mut Value) {
        assign_list(self, to);
    }

    fn is_of(declared: ParameterType, value: &Value) -> bool {
        matches!(value, Value::List(list) if list.iter().all(|one| T::is_of(declared, one)))
    }
}

impl ParameterValue for Value {
    fn assign(&self, to: &mut Value) {
        to.clone_from(self);
    }

    fn is_of(_: ParameterType, _: &Value) -> bool {
        true
    }
}

impl<T: ParameterValue> Parameter<T> {
    /// Returns the handle of a parameter by name, if the parameter has this Rust type.
    pub(crate) fn new(name: &str, parameters: &Parameters, plan: &Plan) -> Result<Self, Diagnostics> {
        let at = parameters.find(name)?;
        let declared = plan.pipeline.parameters.get(name);
        let declared = declared.map(|parameter| (parameter.declaration.parameter_type, parameter.place));
        let wrong =
            declared.zip(parameters.get(at)).filter(|((declared, _), value)| !T::is_of(*declared, value));
        let Some(((declared, place), value)) = wrong else {
            return Ok(Self { at, of: parameters.id(), value_type: PhantomData });
        };
        let asked = std::any::type_name::<T>();
        let length = match value {
            Value::List(list) => format!(" of {}", list.len()),
            _ => String::new(),
        };
        let message =
            format!("the parameter \"{name}\" is declared as {}{length}, not {asked}", declared.name());
        let diagnostic = Diagnostic::error(codes::SETTING_TYPE, place, message);
        Err(diagnostic.help("ask for it with the type that the pipeline declares").into())
    }
}

impl Instantiated {
    /// Applies changed live parameters to the passes and their blocks. Passes that keep views and depend on a changed
    /// parameter draw them again.
    ///
    /// # Errors
    /// Values that loading or planning would reject; the previous values then stay in effect.
    pub(crate) fn apply_parameters(&mut self) -> Result<(), Diagnostics> {
        let Self { parameters, cpu_passes, passes, blocks, plan, kept, keepers, .. } = self;
        let mut set = |at: usize, values: &[Value], packed: &[PackedBlock]| {
            // What a view is drawn with may be other than when it was kept.
            for keeper in keepers.get(at).into_iter().flatten() {
                kept[*keeper].forget();
            }
            packed.iter().for_each(|block| blocks.replace(plan, at, block));
            if let Some(pass) = passes.get_mut(at) {
                pass.update(values);
            }
        };
        parameters.apply(cpu_passes, &mut set)
    }
}
