//! Typed settings of expressions: of a pass that is declared, or of a CPU node whose live settings have changed.
//!
//! A node kind that takes over live settings evaluates them in one function over [`Evaluate`], and calls it twice: when
//! a pass is declared ([`PassBuilder::live`](super::PassBuilder::live)), and when a live parameter has changed
//! ([`CpuNode::update`](crate::work::CpuNode::update)). So both ask the same of a value.

use std::fmt::Display;

use serde::de::IntoDeserializer as _;

use crate::pipeline::settings::live::LiveSetting;
use crate::work::{Deferred, LiveValue, wrong_type};
use umbragraph_text::diagnostic::{Code, Diagnostic, Diagnostics, Place, codes};
use umbragraph_text::expression::{ExpressionKind, Value};
use umbragraph_text::language::{Expr, Word};

/// Evaluates expressions in settings. Each method takes the JSON pointer of the setting, relative to the settings of
/// the node kind. Methods report their diagnostics themselves, and then return `None`.
pub trait Evaluate {
    /// Evaluates an expression that uses parameters and features.
    fn value(&mut self, expr: &Expr, pointer: &str) -> Option<Value>;

    /// Adds a diagnostic, and places it at the setting with the JSON pointer `pointer`.
    fn add(&mut self, diagnostic: Diagnostic, pointer: &str);

    /// Reports an error at a setting.
    fn report(&mut self, code: Code, pointer: &str, message: impl Into<String>, help: impl Into<String>) {
        self.add(Diagnostic::error(code, Place::Nowhere, message).help(help), pointer);
    }

    /// Reports a warning at a setting when a pass is declared; does nothing when live settings are updated.
    fn warn(&mut self, _: Code, _: &str, _: impl Into<String>, _: impl Into<String>) {}

    /// Reports an expression that yields a word which the setting does not allow.
    fn report_word(&mut self, word: &str, _: &Expr, pointer: &str) {
        let message = format!("the expression yields \"{word}\", which is not known here");
        self.report(codes::UNKNOWN_WORD, pointer, message, "the schema lists the words known here");
    }

    /// Reports an error at a setting, and returns `None`.
    fn reject<T>(
        &mut self,
        code: Code,
        pointer: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Option<T> {
        self.report(code, pointer, message, help);
        None
    }

    /// Reports a value of the wrong type, and returns `None`.
    fn wrong_type<T>(&mut self, pointer: &str, wanted: &str, found: &str) -> Option<T> {
        self.add(wrong_type(wanted, found), pointer);
        None
    }

    /// Evaluates an expression that yields a number.
    fn number(&mut self, expr: &Expr, pointer: &str) -> Option<f64> {
        match self.value(expr, pointer)? {
            Value::Number(number) => Some(number),
            other => self.wrong_type(pointer, "a number", other.kind_name()),
        }
    }

    /// Evaluates an expression and converts its value to the type `T`, with a check of the type's range.
    fn read<T: LiveValue>(&mut self, expr: &Expr, pointer: &str) -> Option<T> {
        let value = self.value(expr, pointer)?;
        self.judged(&value, pointer)
    }

    /// Converts a value to the type `T`. Reports a value of another type or out of range, and returns `None`.
    fn judged<T: LiveValue>(&mut self, value: &Value, pointer: &str) -> Option<T> {
        T::read(value).map_err(|diagnostic| self.add(diagnostic, pointer)).ok()
    }

    /// Evaluates an expression that yields a whole number from 0.
    fn count(&mut self, expr: &Expr, pointer: &str) -> Option<u32> {
        self.read(expr, pointer)
    }

    /// Evaluates an expression that yields a list of numbers (one number is a list of one).
    fn numbers(&mut self, expr: &Expr, pointer: &str) -> Option<Vec<f64>> {
        let value = self.value(expr, pointer)?;
        match value.numbers() {
            Some(numbers) => Some(numbers),
            None => self.wrong_type(pointer, "a list of numbers", value.kind_name()),
        }
    }

    /// Evaluates an expression that yields a boolean.
    fn boolean(&mut self, expr: &Expr, pointer: &str) -> Option<bool> {
        match self.value(expr, pointer)? {
            Value::Bool(value) => Some(value),
            other => {
                let diagnostic = wrong_type("a boolean", other.kind_name());
                let name = expr.parse().ok().and_then(|expression| match expression.kind {
                    ExpressionKind::Name(name) => Some(name),
                    _ => None,
                });
                let diagnostic = match (&other, name) {
                    (Value::Text(word), Some(name)) => {
                        diagnostic.help(format!("compare it with a word, as in \"={name} == '{word}'\""))
                    }
                    (Value::Reference(_), _) => {
                        let help =
                            "conditions see parameters, features and derived values; a resource is none";
                        diagnostic.help(help)
                    }
                    _ => diagnostic,
                };
                self.add(diagnostic, pointer);
                None
            }
        }
    }

    /// Evaluates an expression that yields a whole number from 0; returns `without` if there is no expression.
    fn count_or(&mut self, expr: &Option<Expr>, pointer: impl Display, without: u32) -> Option<u32> {
        expr.as_ref().map_or(Some(without), |expr| self.count(expr, &pointer.to_string()))
    }

    /// Evaluates an expression that yields a whole number from 0. The outer `None` follows a diagnostic; the inner
    /// `None` means no expression.
    fn count_if(&mut self, expr: &Option<Expr>, pointer: impl Display) -> Option<Option<u32>> {
        expr.as_ref().map_or(Some(None), |expr| self.count(expr, &pointer.to_string()).map(Some))
    }

    /// Evaluates an expression that yields a number; returns `without` if there is no expression.
    fn number_or(&mut self, expr: &Option<Expr>, pointer: impl Display, without: f64) -> Option<f64> {
        expr.as_ref().map_or(Some(without), |expr| self.number(expr, &pointer.to_string()))
    }

    /// Evaluates an expression that yields a boolean; returns `without` if there is no expression.
    fn boolean_or(&mut self, expr: &Option<Expr>, pointer: impl Display, without: bool) -> Option<bool> {
        expr.as_ref().map_or(Some(without), |expr| self.boolean(expr, &pointer.to_string()))
    }

    /// Returns the word of an enumeration from an optional setting, which is a literal or an expression; returns
    /// `without` if the setting is missing.
    fn word_or<T: serde::de::DeserializeOwned + Clone + schemars::JsonSchema>(
        &mut self,
        word: &Option<Word<T>>,
        pointer: impl Display,
        without: T,
    ) -> Option<T> {
        word.as_ref().map_or(Some(without), |word| self.word(word, &pointer.to_string()))
    }

    /// Returns the word of an enumeration from a setting that is a literal or an expression.
    fn word<T: serde::de::DeserializeOwned + Clone + schemars::JsonSchema>(
        &mut self,
        word: &Word<T>,
        pointer: &str,
    ) -> Option<T> {
        let expr = match word {
            Word::Is(word) => return Some(word.clone()),
            Word::Computed(expr) => expr,
        };
        let text = match self.value(expr, pointer)? {
            Value::Text(text) => text,
            other => return self.wrong_type(pointer, "a word", other.kind_name()),
        };
        let known: Result<T, serde::de::value::Error> = T::deserialize(text.as_str().into_deserializer());
        if known.is_err() {
            self.report_word(&text, expr, pointer);
        }
        known.ok()
    }
}

/// The live settings of a CPU node with their new values, after a live parameter has changed.
#[derive(Debug)]
pub struct LiveSettings<'a> {
    /// The live settings of the pass.
    pub settings: &'a [LiveSetting],
    /// The values of the settings, in the same order.
    pub values: &'a [Value],
    /// The list to which diagnostics about the settings are added.
    pub diagnostics: &'a mut Diagnostics,
}

impl Evaluate for LiveSettings<'_> {
    fn value(&mut self, _: &Expr, pointer: &str) -> Option<Value> {
        let at = self.settings.iter().position(|setting| setting.pointer == pointer);
        match at.and_then(|at| self.values.get(at)) {
            Some(value) => Some(value.clone()),
            None => {
                let help = "evaluate it within \"live\" when the pass is declared";
                self.reject(codes::EXPRESSION_TYPE, pointer, "this setting is not live", help)
            }
        }
    }

    fn add(&mut self, diagnostic: Diagnostic, pointer: &str) {
        let setting = self.settings.iter().find(|setting| {
            let rest = pointer.strip_prefix(setting.pointer.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        });
        let Some(setting) = setting.or(self.settings.first()) else { return };
        let Deferred { place, pointer, .. } = &setting.value;
        self.diagnostics.push(diagnostic.at(*place, pointer));
    }
}
