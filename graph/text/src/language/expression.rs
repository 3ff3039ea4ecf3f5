//! [`Expr`]: the place of an expression in a document.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::Written;
use crate::expression::{self, Expression, ExpressionError, ExpressionKind, Reference, Value};

/// A JSON value that holds an expression: a number, a boolean, a list of expressions, or a string with `=` before the
/// expression. A string without `=` or `&` is a literal word, which few keys accept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Expr(pub serde_json::Value);

impl Expr {
    /// Parses the expression.
    ///
    /// # Errors
    /// A syntax error, with its byte range in the string.
    pub fn parse(&self) -> Result<Expression, ExpressionError> {
        let literal = |value| Expression { range: 0..0, kind: ExpressionKind::Literal(value) };
        match &self.0 {
            serde_json::Value::Bool(value) => Ok(literal(Value::Bool(*value))),
            serde_json::Value::Number(value) => {
                Ok(literal(Value::Number(value.as_f64().unwrap_or(f64::MAX))))
            }
            serde_json::Value::String(text) => Self::parse_text(text),
            serde_json::Value::Array(elements) => {
                let elements =
                    elements.iter().map(|element| Expr(element.clone()).parse()).collect::<Result<_, _>>()?;
                Ok(Expression { range: 0..0, kind: ExpressionKind::List(elements) })
            }
            _ => {
                let message = "an expression is a number, a boolean, a string or a list";
                Err(ExpressionError::new(expression::ErrorKind::Type, 0..0, message))
            }
        }
    }
}

impl Expr {
    /// Parses a string: an expression after `=`, a reference after `&`, otherwise a literal word.
    ///
    /// # Errors
    /// A syntax error, with its byte range in the string.
    pub fn parse_text(text: &str) -> Result<Expression, ExpressionError> {
        match Written::of(text) {
            Written::Expression(_) => expression::parse_from(text, 1),
            Written::Reference(name) => {
                let reference = Reference::parse(name).map_err(|error| error.of(name, 0..0))?;
                Ok(Expression { range: 0..text.len(), kind: ExpressionKind::Reference(reference) })
            }
            Written::Plain(word) => {
                let kind = ExpressionKind::Literal(Value::Text(word.to_owned()));
                Ok(Expression { range: 0..text.len(), kind })
            }
        }
    }
}

impl From<f64> for Expr {
    fn from(value: f64) -> Self {
        Expr(value.into())
    }
}

impl From<&str> for Expr {
    fn from(text: &str) -> Self {
        Expr(text.into())
    }
}

impl JsonSchema for Expr {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Expression".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An expression: a number, a boolean, a string after an equals sign such as \"=ceil(viewport.width / 16)\" or \"=len(far)\", or a list of expressions.",
            "type": ["number", "boolean", "string", "array"],
            "pattern": "^=",
            "items": { "$ref": "#/$defs/Expression" },
        })
    }
}

/// The JSON Schema of an expression whose values may also be words and references.
#[derive(Debug)]
pub struct AnyExpr;

impl JsonSchema for AnyExpr {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "AnyExpression".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, a boolean, a word, a reference such as \"&maps\" where one is wanted, a string after an equals sign that yields one such as \"=len(far)\", or a list of these.",
            "type": ["number", "boolean", "string", "array"],
            "items": { "$ref": "#/$defs/AnyExpression" },
        })
    }
}
