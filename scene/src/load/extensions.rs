//! Extensions of an object: numbers, checked and with a place.

use serde_json::{Map, Value};

use super::report::Report;
use crate::codes;

/// The JSON value of one extension of a glTF object, such as `KHR_texture_transform`.
pub(super) struct Extension<'a> {
    value: &'a Value,
    /// The JSON pointer of the extension, for diagnostics.
    at: String,
}

impl<'a> Extension<'a> {
    /// Finds an extension of the object at the JSON pointer `at`. Returns `None` if the object does not have the
    /// extension.
    pub(super) fn find(extensions: Option<&'a Map<String, Value>>, name: &str, at: &str) -> Option<Self> {
        let value = extensions?.get(name)?;
        Some(Self { value, at: format!("{at}/extensions/{name}") })
    }

    /// Reads a property of `N` numbers: an array, or a plain number if `N` is 1. Returns `None` if the property is
    /// absent, or after reporting an error.
    pub(super) fn numbers<const N: usize>(&self, property: &str, report: &mut Report) -> Option<[f32; N]> {
        let value = self.value.get(property)?;
        let list: Vec<Option<f64>> = match value {
            Value::Array(list) if N > 1 => list.iter().map(Value::as_f64).collect(),
            one if N == 1 => one.as_f64().map(|one| vec![Some(one)]).unwrap_or_default(),
            _ => Vec::new(),
        };
        let numbers: Option<Vec<f32>> =
            list.into_iter().map(|number| number.map(|number| number as f32)).collect();
        let numbers = numbers.and_then(|numbers| <[f32; N]>::try_from(numbers).ok());
        let numbers = numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
        if numbers.is_none() {
            let message = format!("{property} is {value}");
            let help =
                if N == 1 { "it is a number".to_owned() } else { format!("it is a list of {N} numbers") };
            report.error(codes::BAD_MATERIAL, &format!("{}/{property}", self.at), message, help);
        }
        numbers
    }

    /// Reads a property of `N` numbers that must not be negative. Returns `None` if the property is absent, or after
    /// reporting an error.
    pub(super) fn positive<const N: usize>(&self, property: &str, report: &mut Report) -> Option<[f32; N]> {
        let numbers = self.numbers::<N>(property, report)?;
        if numbers.iter().any(|number| *number < 0.0) {
            let message = format!("{property} is negative: {numbers:?}");
            report.error(
                codes::BAD_MATERIAL,
                &format!("{}/{property}", self.at),
                message,
                "set it to 0 or more",
            );
            return None;
        }
        Some(numbers)
    }

    /// Reports a warning if the extension has this property, which the loader ignores.
    pub(super) fn left_out(&self, property: &str, report: &mut Report) {
        if self.value.get(property).is_some() {
            let at = format!("{}/{property}", self.at);
            report.warning(
                codes::LEFT_OUT,
                &at,
                format!("{property} is not used"),
                "its factor alone counts",
            );
        }
    }
}
