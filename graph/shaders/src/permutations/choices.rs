//! The axis values of a path through a template, as a chain from the last decision to the first. Paths share the
//! beginning in which they agree, so a path costs the memory of what it decides anew.

use std::fmt;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use umbragraph_text::diagnostic::{AxisValue, AxisValues};

/// The axis values of one path. In JSON: an object, by axis.
#[derive(Clone, Default)]
pub struct Choices(Option<Arc<Choice>>);

struct Choice {
    axis: String,
    value: AxisValue,
    before: Choices,
}

impl Choices {
    /// Returns these choices and one more.
    pub(super) fn and(&self, axis: String, value: AxisValue) -> Self {
        debug_assert!(self.get(&axis).is_none(), "\"{axis}\" is decided twice");
        Self(Some(Arc::new(Choice { axis, value, before: self.clone() })))
    }

    /// The choices by axis.
    pub fn values(&self) -> AxisValues {
        self.iter().map(|(axis, value)| (axis.to_owned(), value.clone())).collect()
    }

    /// The value of an axis; `None` if the path does not decide it.
    pub fn get(&self, axis: &str) -> Option<&AxisValue> {
        self.iter().find_map(|(name, value)| (name == axis).then_some(value))
    }

    /// The axes and their values, the last decision first.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &AxisValue)> {
        let choices = std::iter::successors(self.0.as_deref(), |choice| choice.before.0.as_deref());
        choices.map(|choice| (choice.axis.as_str(), &choice.value))
    }
}

impl Drop for Choices {
    /// Drops a long chain without recursion.
    fn drop(&mut self) {
        let mut next = self.0.take();
        while let Some(mut choice) = next.and_then(Arc::into_inner) {
            next = choice.before.0.take();
        }
    }
}

impl fmt::Debug for Choices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.values().fmt(f)
    }
}

impl From<&AxisValues> for Choices {
    fn from(values: &AxisValues) -> Self {
        let one_more = |all: Self, (axis, value): (&String, &AxisValue)| all.and(axis.clone(), value.clone());
        values.iter().fold(Self::default(), one_more)
    }
}

impl Serialize for Choices {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.values().serialize(serializer)
    }
}
