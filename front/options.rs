//! [`Options`]: the inputs of a plan.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::Location;

use serde_json::Value;

use crate::low_level::compiler::{ImportDescriptor, Objective, PlanOptions};

/// The inputs of a plan: the size of the picture, values of parameters and features, and descriptors of the host's own
/// textures. Unknown names and values of a wrong type are errors of [`Pipeline::plan`](crate::Pipeline::plan). Such
/// errors name the place in your code that set the value.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    pub(super) plan: PlanOptions,
    pub(super) preset: Option<Given>,
    pub(super) parameters: Vec<Given>,
    pub(super) features: Vec<Given>,
    pub(super) exposed: BTreeSet<String>,
}

/// A name with a value, and the place in the host's code that sets them.
#[derive(Clone, Debug)]
pub(super) struct Given {
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) at: &'static Location<'static>,
}

impl PartialEq for Given {
    /// Returns `true` if names and values are equal; the places that set them do not count.
    fn eq(&self, other: &Self) -> bool {
        (&self.name, &self.value) == (&other.name, &other.value)
    }
}

/// A value of a parameter or a feature: a number, a boolean, a keyword, or a list of numbers.
pub trait Setting {
    /// Returns the value as JSON. A number that JSON cannot express gives `null`, which no parameter accepts.
    fn value(&self) -> Value;
}

macro_rules! settings {
    ($($type:ty),*) => {
        $(impl Setting for $type {
            fn value(&self) -> Value {
                Value::from(*self)
            }
        })*
    };
}

settings!(bool, u8, u16, u32, u64, usize, i8, i16, i32, i64, isize, f64, &str);

impl Setting for f32 {
    fn value(&self) -> Value {
        Value::from(decimal(*self))
    }
}

impl Setting for String {
    fn value(&self) -> Value {
        Value::from(self.as_str())
    }
}

impl<T: Setting> Setting for [T] {
    fn value(&self) -> Value {
        self.iter().map(Setting::value).collect()
    }
}

impl<T: Setting, const N: usize> Setting for [T; N] {
    fn value(&self) -> Value {
        self.as_slice().value()
    }
}

impl<T: Setting> Setting for Vec<T> {
    fn value(&self) -> Value {
        self.as_slice().value()
    }
}

impl<T: Setting + ?Sized> Setting for &T {
    fn value(&self) -> Value {
        (**self).value()
    }
}

/// Returns the number with the fewest decimal places that rounds to `number`: 0.1 instead of 0.10000000149, which would
/// exceed a maximum of 0.1.
fn decimal(number: f32) -> f64 {
    let exact = f64::from(number);
    let rounded = |places: i32| {
        let scale = 10_f64.powi(places);
        (exact * scale).round() / scale
    };
    // Powers of ten beyond 22 are not exact.
    let mut candidates = (0..=22).map(rounded);
    candidates.find(|candidate| *candidate as f32 == number).unwrap_or(exact)
}

impl Options {
    /// Creates options for a picture of this width and height in texels, with the pipeline's default values.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            plan: PlanOptions::new(width, height),
            preset: None,
            parameters: Vec::new(),
            features: Vec::new(),
            exposed: BTreeSet::new(),
        }
    }

    /// Chooses a preset of the pipeline. [`set`](Self::set) and [`feature`](Self::feature) override its values.
    #[must_use]
    #[track_caller]
    pub fn preset(mut self, name: impl Into<String>) -> Self {
        self.preset = Some(Given { name: name.into(), value: Value::Null, at: Location::caller() });
        self
    }

    /// Sets a parameter of the pipeline to a value.
    #[must_use]
    #[track_caller]
    pub fn set(mut self, parameter: impl Into<String>, value: impl Setting) -> Self {
        let (name, value) = (parameter.into(), value.value());
        self.parameters.push(Given { name, value, at: Location::caller() });
        self
    }

    /// Sets a feature of the pipeline to a boolean or to a keyword.
    #[must_use]
    #[track_caller]
    pub fn feature(mut self, feature: impl Into<String>, value: impl Setting) -> Self {
        let (name, value) = (feature.into(), value.value());
        self.features.push(Given { name, value, at: Location::caller() });
        self
    }

    /// Returns all given values, the preset first, in the order of the indices that loading assigns to them.
    pub(super) fn given(&self) -> impl Iterator<Item = &Given> {
        self.preset.iter().chain(&self.parameters).chain(&self.features)
    }

    /// Exposes a texture or buffer, so that the host can read it between frames (`Executor::texture`,
    /// `Executor::buffer`). An exposed resource shares memory with no other, as if the pipeline declared it `exposed`.
    #[must_use]
    pub fn expose(mut self, resource: impl Into<String>) -> Self {
        self.exposed.insert(resource.into());
        self
    }

    /// Sets format, size and usages of an imported texture, if they differ from what the pipeline declares.
    #[must_use]
    pub fn import(mut self, resource: impl Into<String>, import: ImportDescriptor) -> Self {
        self.plan.imports.insert(resource.into(), import);
        self
    }

    /// Sets the descriptors of imported textures from the host's textures, or from parts of textures such as one mip
    /// level. Takes the same list as `Frame::imports`.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn imports<'a>(mut self, imports: impl Into<crate::executor::FrameImports<'a>>) -> Self {
        for (resource, import) in imports.into().iter() {
            self.plan.imports.insert(resource.to_owned(), import.descriptor());
        }
        self
    }

    /// Sets the sizes of data that CPU passes publish, keyed `DATA.SIZE`, in place of their initial values.
    /// `Executor::wanted_sizes` returns the sizes that the passes request.
    #[must_use]
    pub fn data_sizes(mut self, sizes: BTreeMap<String, u32>) -> Self {
        self.plan.data_sizes = sizes;
        self
    }

    /// Sets whether transient resources may share memory; the default is `true`.
    #[must_use]
    pub fn aliasing(mut self, may: bool) -> Self {
        self.plan.aliasing = may;
        self
    }

    /// Sets whether textures and buffers that outlive a frame can be copied from and to; the default is `false`. A host
    /// can then save and restore what `Executor::texture` and `Executor::buffer` return.
    #[must_use]
    pub fn copyable_state(mut self, can: bool) -> Self {
        self.plan.copyable_state = can;
        self
    }

    /// Sets the objective by which passes are ordered.
    #[must_use]
    pub fn objective(mut self, objective: Objective) -> Self {
        self.plan.objective = objective;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_of_32_bits_is_the_decimal_that_was_written() {
        for (number, decimal) in [(0.1_f32, 0.1), (1.0e-9, 1.0e-9), (16_777_216.0, 16_777_216.0), (0.3, 0.3)]
        {
            assert_eq!(number.value(), Value::from(decimal));
        }
        assert_eq!(f32::NAN.value(), Value::Null);
        assert_eq!([1_u32, 2].value(), serde_json::json!([1, 2]));
    }
}
