//! The values that somebody gave parameters, features and toggles in the window.
//!
//! Only changed values are kept here. A reset removes a value; then the pipeline's own value counts again and follows
//! its file. Live parameters are set in the executor before each frame, all others are options of the plan. Without a
//! plan no parameter is known to be live.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::expression;
use umbragraph::{Error, Executor, Options, Plan, Setting};

/// The values of parameters, features and toggles that were changed in the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Values {
    pub(crate) preset: Option<String>,
    pub(crate) parameters: BTreeMap<String, Value>,
    pub(crate) features: BTreeMap<String, Value>,
    pub(crate) toggles: BTreeMap<String, bool>,
}

/// A JSON value of a parameter or feature, for use as a planning option.
struct Given<'a>(&'a Value);

impl Setting for Given<'_> {
    fn value(&self) -> Value {
        self.0.clone()
    }
}

impl Values {
    /// The planning options for a frame size in texels, with all values except live parameters of `plan`.
    pub(crate) fn options(&self, [width, height]: [u32; 2], plan: Option<&Plan>) -> Options {
        let is_live = |name: &str| {
            let known = plan.and_then(|plan| plan.pipeline.parameters.get(name));
            known.is_some_and(|parameter| parameter.structural.is_none())
        };
        // A look at contents records a frame once more, from what it began with.
        let mut options = Options::new(width, height).copyable_state(true);
        if let Some(preset) = &self.preset {
            options = options.preset(preset);
        }
        for (name, value) in self.parameters.iter().filter(|(name, _)| !is_live(name)) {
            options = options.set(name, Given(value));
        }
        for (name, value) in &self.features {
            options = options.feature(name, Given(value));
        }
        options
    }

    /// Sets the live parameters of an executor: to the changed values, or else to the values of its plan.
    ///
    /// # Errors
    /// A value is not valid for its parameter.
    pub(crate) fn set_live(&self, executor: &mut Executor) -> Result<(), Error> {
        let plan = executor.plan().clone();
        for (name, parameter) in &plan.pipeline.parameters {
            if parameter.structural.is_some() {
                continue;
            }
            let given = self.parameters.get(name).and_then(of_json);
            let value = given.unwrap_or_else(|| parameter.value.clone());
            executor.parameter(name).and_then(|handle| executor.set(handle, value))?;
        }
        Ok(())
    }

    /// The changed toggles that the plan has, with their state.
    pub(crate) fn toggles_of(&self, plan: &Plan) -> Vec<(&str, bool)> {
        let known = self.toggles.iter().filter(|(name, _)| plan.toggles.contains_key(*name));
        known.map(|(name, on)| (name.as_str(), *on)).collect()
    }

    /// The contents of a parameter file with these values, as JSON text.
    pub(crate) fn file(&self) -> String {
        let mut file = Map::new();
        file.insert("format".to_owned(), json!(1));
        if let Some(preset) = &self.preset {
            file.insert("preset".to_owned(), json!(preset));
        }
        for (section, values) in [("parameters", &self.parameters), ("features", &self.features)] {
            if !values.is_empty() {
                file.insert(section.to_owned(), json!(values));
            }
        }
        format!("{:#}\n", Value::Object(file))
    }

    /// The command line options that set these values.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        if let Some(preset) = &self.preset {
            arguments.extend(["--preset".to_owned(), preset.clone()]);
        }
        for (option, values) in [("--set", &self.parameters), ("--feature", &self.features)] {
            for (name, value) in values {
                let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                arguments.extend([option.to_owned(), format!("{name}={value}")]);
            }
        }
        for (name, on) in &self.toggles {
            arguments.extend(["--toggle".to_owned(), format!("{name}={}", if *on { "on" } else { "off" })]);
        }
        arguments
    }

    /// Removes the values whose names a document does not declare. Returns these names.
    pub(crate) fn keep_known(&mut self, document: &Document) -> Vec<String> {
        let mut gone = Vec::new();
        let mut knows = |section: &str, name: &String| {
            let is_known = document.root.entries_of(section).iter().any(|entry| entry.key == *name);
            if !is_known {
                gone.push(name.clone());
            }
            is_known
        };
        self.preset.take_if(|name| !knows("presets", name));
        self.parameters.retain(|name, _| knows("parameters", name));
        self.features.retain(|name, _| knows("features", name));
        self.toggles.retain(|name, _| knows("toggles", name));
        gone
    }

    /// Removes those of the values `saved` that a document and its plan have as their own defaults now, so that the
    /// file counts again. Values that the chosen preset sets stay. Returns `true` if a value was removed.
    pub(crate) fn drop_defaults(&mut self, saved: &Self, document: &Document, plan: &Plan) -> bool {
        let root = &document.root;
        let presets = root.entries_of("presets").iter();
        let preset =
            presets.filter(|entry| Some(&entry.key) == self.preset.as_ref()).map(|one| &one.value).next();
        let has = |value: &document::Value, section: &str, name: &str| {
            value.entries_of(section).iter().any(|entry| entry.key == name)
        };
        let is_default = |section: &str, name: &str, value: &Value| {
            let declared = root.entries_of(section).iter().find(|entry| entry.key == name);
            let default = declared.and_then(|entry| of_json(&entry.value.get("default")?.to_json()));
            default.is_some_and(|default| Some(default) == of_json(value))
                && !preset.is_some_and(|preset| has(preset, section, name))
        };
        // A live value is no option of the plan, so the plan has the default of the document that it was made of.
        let is_planned = |name: &str, value: &Value| {
            let known = plan.pipeline.parameters.get(name);
            known.is_some_and(|one| one.structural.is_some() || Some(&one.value) == of_json(value).as_ref())
        };
        let before = self.clone();
        self.parameters.retain(|name, value| {
            saved.parameters.get(name) != Some(value)
                || !is_default("parameters", name, value)
                || !is_planned(name, value)
        });
        self.features.retain(|name, value| {
            saved.features.get(name) != Some(value) || !is_default("features", name, value)
        });
        self.toggles.retain(|name, on| {
            saved.toggles.get(name) != Some(on) || !is_default("toggles", name, &Value::Bool(*on))
        });
        *self != before
    }

    /// Returns `true` if no value has been changed.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Converts JSON to a value of the engine; `None` for `null`, for objects, and for lists that contain either.
pub(crate) fn of_json(json: &Value) -> Option<expression::Value> {
    Some(match json {
        Value::Bool(on) => expression::Value::Bool(*on),
        Value::Number(number) => expression::Value::Number(number.as_f64()?),
        Value::String(text) => expression::Value::Text(text.clone()),
        Value::Array(list) => expression::Value::List(list.iter().map(of_json).collect::<Option<_>>()?),
        Value::Null | Value::Object(_) => return None,
    })
}

/// Converts a value of the engine to JSON; references become `null`.
pub(crate) fn to_json(value: &expression::Value) -> Value {
    match value {
        expression::Value::Bool(on) => json!(on),
        expression::Value::Number(number) => number_of(*number),
        expression::Value::Text(text) => json!(text),
        expression::Value::List(list) => list.iter().map(to_json).collect(),
        expression::Value::Reference(_) => Value::Null,
    }
}

/// Converts a number to short JSON: an integer if it has no fraction, else with the digits that `f32` needs.
pub(crate) fn number_of(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 {
        return json!(number as i64);
    }
    let short = format!("{}", number as f32).parse().unwrap_or(number);
    json!(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_a_file_and_a_command_line() {
        let mut values = Values { preset: Some("high".to_owned()), ..Values::default() };
        values.parameters.insert("exposure".to_owned(), number_of(0.3));
        values.features.insert("msaa".to_owned(), json!(true));
        values.toggles.insert("bloom".to_owned(), false);
        let file: Value = serde_json::from_str(&values.file()).expect("JSON");
        assert_eq!(file["parameters"]["exposure"], json!(0.3));
        let said = values.arguments().join(" ");
        assert_eq!(said, "--preset high --set exposure=0.3 --feature msaa=true --toggle bloom=off");
    }

    #[test]
    fn numbers_are_written_as_people_write_them() {
        assert_eq!(number_of(f64::from(0.1_f32)).to_string(), "0.1");
        assert_eq!(number_of(3.0).to_string(), "3");
    }
}
