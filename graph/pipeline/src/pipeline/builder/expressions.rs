//! Expressions in settings: evaluated over parameters and features, or kept until sizes are known.

use std::rc::Rc;

use super::PassBuilder;
use crate::diagnostic::{Diagnostic, codes};
use crate::expression::{Expression, ExpressionError, UnknownName, Value};
use crate::language::{Expr, Word};
use crate::pipeline::expression_diagnostic::expression_diagnostic;
use crate::work::Deferred;

impl PassBuilder<'_> {
    /// Evaluates an expression over parameters and features.
    pub fn value(&mut self, expr: &Expr, pointer: &str) -> Option<Value> {
        let result = self.evaluate(expr);
        result.map_err(|error| self.expression_error(&error, pointer)).ok()
    }

    /// Evaluates an expression that yields a number.
    pub fn number(&mut self, expr: &Expr, pointer: &str) -> Option<f64> {
        match self.value(expr, pointer)? {
            Value::Number(number) => Some(number),
            other => self.wrong_type(pointer, "a number", other.kind_name()),
        }
    }

    /// Evaluates an expression that yields a whole number from 0.
    pub fn count(&mut self, expr: &Expr, pointer: &str) -> Option<u32> {
        let number = self.number(expr, pointer)?;
        if number.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&number) {
            return self.wrong_type(pointer, "a whole number from 0", &number.to_string());
        }
        Some(number as u32)
    }

    /// Evaluates an expression that yields a list of numbers (one number is a list of one).
    pub fn numbers(&mut self, expr: &Expr, pointer: &str) -> Option<Vec<f64>> {
        let value = self.value(expr, pointer)?;
        match value.numbers() {
            Some(numbers) => Some(numbers),
            None => self.wrong_type(pointer, "a list of numbers", value.kind_name()),
        }
    }

    /// Evaluates an expression that yields a boolean.
    pub fn boolean(&mut self, expr: &Expr, pointer: &str) -> Option<bool> {
        match self.value(expr, pointer)? {
            Value::Bool(value) => Some(value),
            other => self.wrong_type(pointer, "a boolean", other.kind_name()),
        }
    }

    /// A whole number from 0, or what counts without an expression.
    pub fn count_or(&mut self, expr: &Option<Expr>, pointer: &str, without: u32) -> Option<u32> {
        expr.as_ref().map_or(Some(without), |expr| self.count(expr, pointer))
    }

    /// A whole number from 0, if there is an expression; `None` after a diagnostic.
    pub fn count_if(&mut self, expr: &Option<Expr>, pointer: &str) -> Option<Option<u32>> {
        expr.as_ref().map_or(Some(None), |expr| self.count(expr, pointer).map(Some))
    }

    /// A number, or what counts without an expression.
    pub fn number_or(&mut self, expr: &Option<Expr>, pointer: &str, without: f64) -> Option<f64> {
        expr.as_ref().map_or(Some(without), |expr| self.number(expr, pointer))
    }

    /// A boolean, or what counts without an expression.
    pub fn boolean_or(&mut self, expr: &Option<Expr>, pointer: &str, without: bool) -> Option<bool> {
        expr.as_ref().map_or(Some(without), |expr| self.boolean(expr, pointer))
    }

    /// A word, or the one that counts without it.
    pub fn word_or<T: serde::de::DeserializeOwned + Clone + schemars::JsonSchema>(
        &mut self,
        word: &Option<Word<T>>,
        pointer: &str,
        without: T,
    ) -> Option<T> {
        word.as_ref().map_or(Some(without), |word| self.word(word, pointer))
    }

    /// A word, or the one that its expression yields.
    pub fn word<T: serde::de::DeserializeOwned + Clone + schemars::JsonSchema>(
        &mut self,
        word: &Word<T>,
        pointer: &str,
    ) -> Option<T> {
        let expr = match word {
            Word::Is(word) => return Some(word.clone()),
            Word::Computed(expr) => expr,
        };
        match self.evaluate(expr) {
            Ok(Value::Text(text)) => match serde_json::from_value(text.as_str().into()) {
                Ok(word) => Some(word),
                Err(_) => {
                    let message = format!("the expression yields \"{text}\", which is not known here");
                    let diagnostic = Diagnostic::error(codes::UNKNOWN_WORD, self.place(pointer), message)
                        .pointer(self.absolute(pointer))
                        .help("the schema lists the words known here");
                    let derived = expr.0.as_str().and_then(|name| self.shared.scope.derived_at(name.trim()));
                    self.shared.diagnostics.push(match derived {
                        Some(place) => diagnostic.related(place, "the word comes from here"),
                        None => diagnostic,
                    });
                    None
                }
            },
            Ok(other) => self.wrong_type(pointer, "a word", other.kind_name()),
            Err(error) => {
                // The equals sign in front is not part of the expression.
                let error = ExpressionError { range: error.range.start + 1..error.range.end + 1, ..error };
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    /// An expression that may name sizes too; it is evaluated when they are known.
    pub fn deferred(&mut self, expr: &Expr, pointer: &str) -> Option<Deferred> {
        match self.parse(expr) {
            Ok(expression) => {
                if let Err(error) = self.environment.check_words(&expression, &self.shared.scope) {
                    self.expression_error(&error, pointer);
                    return None;
                }
                let expression = if self.environment.is_top() {
                    Rc::unwrap_or_clone(expression)
                } else {
                    self.environment.close(&expression, &|name| self.shared.find(name).is_some())
                };
                self.check_names(&expression, pointer)?;
                Some(Deferred { expression, place: self.place(pointer), pointer: self.absolute(pointer) })
            }
            Err(error) => {
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    pub(super) fn evaluate(&mut self, expr: &Expr) -> Result<Value, ExpressionError> {
        let expression = self.parse(expr)?;
        let shared = &*self.shared;
        self.environment.evaluate(&expression, &|name| shared.find(name).is_some(), &shared.scope)
    }

    /// The parsed expression; what many instances share is parsed once.
    fn parse(&mut self, expr: &Expr) -> Result<Rc<Expression>, ExpressionError> {
        let Some(text) = expr.0.as_str().filter(|_| !self.environment.is_top()) else {
            return expr.parse().map(Rc::new);
        };
        if let Some(known) = self.shared.expressions.get(text) {
            return Ok(known.clone());
        }
        let parsed = Rc::new(expr.parse()?);
        self.shared.expressions.insert(text.to_owned(), parsed.clone());
        Ok(parsed)
    }

    pub(super) fn wrong_type<T>(&mut self, pointer: &str, wanted: &str, found: &str) -> Option<T> {
        let message = format!("{wanted} is wanted here, this is {found}");
        let help = format!("make the expression yield {wanted}");
        self.reject(codes::EXPRESSION_TYPE, pointer, message, help)
    }

    /// Finds names in a deferred expression that exist nowhere; their values come later.
    pub(super) fn check_names(&mut self, expression: &Expression, pointer: &str) -> Option<()> {
        match self.shared.unknown_name(expression) {
            None => Some(()),
            Some(error) => {
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    pub(super) fn expression_error(&mut self, error: &ExpressionError, pointer: &str) {
        if error
            .unknown
            .as_deref()
            .is_some_and(|unknown| !unknown.is_complete && self.report_misgiven(&unknown.name))
        {
            return;
        }
        let mut error = error.clone();
        self.environment
            .widen(&mut error, self.shared.resources.iter().map(|resource| resource.name.as_str()));
        let value = self.settings.nearest(pointer);
        let Some(mut diagnostic) = expression_diagnostic(&error, value, &self.absolute(pointer)) else {
            self.shared.withheld += 1;
            return;
        };
        let is_toggle =
            |unknown: &UnknownName| !unknown.is_complete && self.shared.toggles.contains(&unknown.name);
        if error.unknown.as_deref().is_some_and(is_toggle) {
            diagnostic.fix = None;
            diagnostic = diagnostic.help("expressions cannot see toggles, which change from frame to frame: give the pass \"toggle\", or make it a feature");
        }
        self.shared.diagnostics.push(diagnostic);
    }
}

impl PassBuilder<'_> {
    /// Reports that a name is an input which stands for nothing, where it is one.
    pub(super) fn report_misgiven(&mut self, name: &str) -> bool {
        let resources = self.shared.resources.iter().map(|resource| resource.name.as_str());
        let diagnostic = self.environment.misgiven(name, resources);
        let is_it = diagnostic.is_some();
        self.shared.withheld += usize::from(is_it);
        self.shared.misgiven.extend(diagnostic);
        is_it
    }
}
