//! The properties that this project reads from glTF's free-form `extras`.

use gltf::json::Extras;
use serde_json::Value;

use super::report::Report;
use crate::codes;
use umbragraph_pipeline::diagnostic::list_of;

/// The property `extras` of one glTF object, as a JSON object.
pub(super) struct ObjectExtras {
    values: serde_json::Map<String, Value>,
    at: String,
}

impl ObjectExtras {
    /// Parses the extras of the object at the JSON pointer `at`. If they are not a JSON object, they count as empty.
    pub(super) fn new(extras: &Extras, at: &str) -> Self {
        let parsed = extras.as_ref().map(|extras| serde_json::from_str(extras.get()));
        let values =
            if let Some(Ok(Value::Object(values))) = parsed { values } else { serde_json::Map::new() };
        Self { values, at: format!("{at}/extras") }
    }

    /// Reads the boolean with this key. Returns `None` if the key is absent, or after reporting an error.
    pub(super) fn boolean(&self, key: &str, report: &mut Report) -> Option<bool> {
        self.typed(key, "true or false", Value::as_bool, report)
    }

    /// Reads the finite, non-negative number with this key. Returns `None` if the key is absent, or after reporting an
    /// error.
    pub(super) fn number(&self, key: &str, report: &mut Report) -> Option<f32> {
        let number = |value: &Value| {
            value.as_f64().map(|value| value as f32).filter(|value| value.is_finite() && *value >= 0.0)
        };
        self.typed(key, "a number that is not negative", number, report)
    }

    /// Reads the string with this key, which must be one of `words`, and returns its index in `words`. Returns `None`
    /// if the key is absent, or after reporting an error.
    pub(super) fn word(&self, key: &str, words: &[&str], report: &mut Report) -> Option<usize> {
        let known = |value: &Value| words.iter().position(|word| value.as_str() == Some(word));
        self.typed(key, &format!("one of {}", list_of(words)), known, report)
    }

    fn typed<T>(
        &self,
        key: &str,
        wanted: &str,
        read: impl Fn(&Value) -> Option<T>,
        report: &mut Report,
    ) -> Option<T> {
        let value = self.values.get(key)?;
        let found = read(value);
        if found.is_none() {
            let at = format!("{}/{key}", self.at);
            report.error(
                codes::BAD_VALUE,
                &at,
                format!("{key} has an unusable value"),
                format!("it is {wanted}"),
            );
        }
        found
    }
}
