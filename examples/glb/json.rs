//! Just enough JSON to write a glTF document: text with its members in the order given.

/// A string; our own names need no escapes beyond quotes and backslashes.
pub(crate) fn string(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// An array of values that are JSON already.
pub(crate) fn array(values: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", values.into_iter().collect::<Vec<_>>().join(","))
}

/// An array of numbers, rounded to a millionth.
pub(crate) fn numbers(values: &[f64]) -> String {
    array(values.iter().map(|value| number(*value)))
}

/// A number, rounded to a millionth.
pub(crate) fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // Adding zero turns −0 into 0.
    format!("{}", rounded + 0.0)
}

/// An object under construction.
#[derive(Clone, Default)]
pub(crate) struct Object(Vec<String>);

impl Object {
    /// Adds a member whose value is JSON already.
    pub(crate) fn with(mut self, key: &str, value: impl std::fmt::Display) -> Self {
        self.0.push(format!("\"{key}\":{value}"));
        self
    }

    /// Adds a member where there is a value.
    pub(crate) fn with_some(self, key: &str, value: Option<impl std::fmt::Display>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }

    /// The object as JSON.
    pub(crate) fn json(&self) -> String {
        format!("{{{}}}", self.0.join(","))
    }
}
