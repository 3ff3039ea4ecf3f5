//! Just enough JSON to write a glTF document: text with its members in the order given.

/// A JSON string. Only quotes and backslashes are escaped, which suffices for the names of the scenes.
pub(crate) fn string(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// A JSON array of values that are already JSON.
pub(crate) fn array(values: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", values.into_iter().collect::<Vec<_>>().join(","))
}

/// A JSON array of numbers, rounded to six decimal places.
pub(crate) fn numbers(values: &[f64]) -> String {
    array(values.iter().map(|value| number(*value)))
}

/// A JSON number, rounded to six decimal places.
pub(crate) fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // Adding zero turns −0 into 0.
    format!("{}", rounded + 0.0)
}

/// A JSON object under construction: its members as JSON text.
#[derive(Clone, Default)]
pub(crate) struct Object(Vec<String>);

impl Object {
    /// Adds a member whose value is already JSON or a plain number.
    pub(crate) fn with(mut self, key: &str, value: impl std::fmt::Display) -> Self {
        self.0.push(format!("\"{key}\":{value}"));
        self
    }

    /// Adds a member if there is a value; otherwise changes nothing.
    pub(crate) fn with_some(self, key: &str, value: Option<impl std::fmt::Display>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }

    /// The JSON text of the object.
    pub(crate) fn json(&self) -> String {
        format!("{{{}}}", self.0.join(","))
    }
}
