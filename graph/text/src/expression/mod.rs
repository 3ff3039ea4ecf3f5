//! Typed expressions: sizes, counts, dispatches and parameters.
//!
//! An expression is a JSON number or boolean, or a string in the small language of [`parse`], after an equals sign:
//!
//! ```text
//! sum      +  -  *  /  %        conversion  floor ceil round abs sqrt log2 exp2
//! compare  == != < <= > >=      pick        min max clamp(x, low, high) align(x, step)
//! logic    && || !  a ? b : c   shape       len(list)  mip_count(size)  list[index]  [a, b]
//! name     parameter, feature, resource (its size), resource.width .height .layers .mips .samples, viewport
//! refer    &resource  &resource@pass  &resource@loop[round]  &resource@-1
//! ```
//!
//! Values are numbers (`f64`), booleans, texts, lists and references to resources. Arithmetic on a list works element
//! by element, so that `"=maps / 2"` halves both sides of a texture. Every way to leave the numbers (overflow, a
//! division by zero, the root of a negative number) is an error with its place in the string; no expression yields
//! infinity or NaN.
//!
//! Limits: nesting to 64 levels, texts to 4096 bytes, lists to 65,536 elements.

mod evaluate;
mod parse;
mod reference;
mod words;

pub use evaluate::unknown_name;
pub use evaluate::{Scope, evaluate, evaluate_into};
pub use parse::{parse, parse_from};
pub use reference::{Reference, ReferenceError};
pub use words::unknown_word;

use std::ops::Range;

/// The value of an expression.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A boolean.
    Bool(bool),
    /// A finite number.
    Number(f64),
    /// A text: a member of an enumeration, a texture format.
    Text(String),
    /// A list.
    List(Vec<Value>),
    /// A resource or published data, by its name outside of subgraphs.
    Reference(Reference),
}

impl Value {
    /// The kind of the value, with an article.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Value::Bool(_) => "a boolean",
            Value::Number(_) => "a number",
            Value::Text(_) => "a text",
            Value::List(_) => "a list",
            Value::Reference(_) => "a reference",
        }
    }

    /// Takes over another value, in the memory of one of the same shape.
    pub fn assign(&mut self, from: &Value) {
        match (self, from) {
            (Value::List(to), Value::List(from)) if to.len() == from.len() => {
                to.iter_mut().zip(from).for_each(|(to, from)| to.assign(from));
            }
            (Value::Text(to), Value::Text(from)) => to.clone_from(from),
            (to, from) => *to = from.clone(),
        }
    }

    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The numbers of a list of numbers, or the one number.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Value::Number(number) => Some(vec![*number]),
            Value::List(list) => list.iter().map(Value::number).collect(),
            _ => None,
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Bool(value) => value.fmt(f),
            Value::Number(value) => value.fmt(f),
            Value::Text(value) => value.fmt(f),
            Value::List(values) => {
                let values: Vec<String> = values.iter().map(Value::to_string).collect();
                write!(f, "[{}]", values.join(", "))
            }
            Value::Reference(reference) => reference.fmt(f),
        }
    }
}

/// A parsed expression; `range` is the bytes of the text that it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// The place in the expression's text.
    pub range: Range<usize>,
    /// The kind.
    pub kind: ExpressionKind,
}

impl Expression {
    /// Goes through the expression and all of its parts.
    pub fn visit<'e>(&'e self, each: &mut dyn FnMut(&'e Expression)) {
        each(self);
        self.parts().for_each(|part| part.visit(each));
    }

    /// Changes the expression and all of its parts.
    pub fn visit_mut(&mut self, each: &mut dyn FnMut(&mut Expression)) {
        each(self);
        match &mut self.kind {
            ExpressionKind::Literal(_) | ExpressionKind::Name(_) | ExpressionKind::Reference(_) => {}
            ExpressionKind::Unary(_, a) => a.visit_mut(each),
            ExpressionKind::Binary(_, a, b) | ExpressionKind::Index(a, b) => {
                a.visit_mut(each);
                b.visit_mut(each);
            }
            ExpressionKind::Conditional(a, b, c) => {
                [a, b, c].into_iter().for_each(|part| part.visit_mut(each));
            }
            ExpressionKind::Call(_, list) | ExpressionKind::List(list) => {
                list.iter_mut().for_each(|part| part.visit_mut(each));
            }
        }
    }

    /// The expressions that it is made of, each with its own parts in it.
    pub fn parts(&self) -> impl Iterator<Item = &Expression> {
        let (few, list): ([Option<&Expression>; 3], &[Expression]) = match &self.kind {
            ExpressionKind::Literal(_) | ExpressionKind::Name(_) | ExpressionKind::Reference(_) => {
                ([None; 3], &[])
            }
            ExpressionKind::Unary(_, a) => ([Some(a), None, None], &[]),
            ExpressionKind::Binary(_, a, b) | ExpressionKind::Index(a, b) => ([Some(a), Some(b), None], &[]),
            ExpressionKind::Conditional(a, b, c) => ([Some(a), Some(b), Some(c)], &[]),
            ExpressionKind::Call(_, list) | ExpressionKind::List(list) => ([None; 3], list),
        };
        few.into_iter().flatten().chain(list)
    }

    /// The names in it, in their order.
    pub fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.visit(&mut |inner| {
            if let ExpressionKind::Name(name) = &inner.kind {
                names.push(name.as_str());
            }
        });
        names
    }
}

/// The kind of an expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionKind {
    /// A literal.
    Literal(Value),
    /// A name, dots included: `viewport.width`.
    Name(String),
    /// `&maps@draw`, by the names that are known where it is written.
    Reference(Reference),
    /// `-x`, `!x`.
    Unary(UnaryOperator, Box<Expression>),
    /// `a + b`.
    Binary(BinaryOperator, Box<Expression>, Box<Expression>),
    /// `a ? b : c`.
    Conditional(Box<Expression>, Box<Expression>, Box<Expression>),
    /// `f(a, b)`.
    Call(String, Vec<Expression>),
    /// `list[index]`.
    Index(Box<Expression>, Box<Expression>),
    /// `[a, b]`.
    List(Vec<Expression>),
}

/// An operator with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOperator {
    /// `-`
    Negate,
    /// `!`
    Not,
}

/// An operator with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOperator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `%`
    Remainder,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `&&`
    And,
    /// `||`
    Or,
}

/// Why an expression cannot be parsed or evaluated, and where in its text.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionError {
    /// The bytes of the expression's text that are at fault.
    pub range: Range<usize>,
    /// The kind of the error.
    pub kind: ErrorKind,
    /// The message: one sentence without a full stop.
    pub message: String,
    /// The way out, where there is one to name.
    pub help: Option<String>,
    /// The name that does not exist, where that is the error.
    pub unknown: Option<Box<UnknownName>>,
}

impl ExpressionError {
    /// An error without a way out of its own.
    pub fn new(kind: ErrorKind, range: Range<usize>, message: impl Into<String>) -> Self {
        Self { range, kind, message: message.into(), help: None, unknown: None }
    }
}

/// A name that does not exist, and those that do.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownName {
    /// The name; it begins where the range of its error begins.
    pub name: String,
    /// The possible names, in no order.
    pub known: Vec<String>,
    /// Whether nothing else could stand there: so for functions and for the words of an enumeration, while other names
    /// may be known where the expression stands.
    pub is_complete: bool,
}

/// The kinds of error of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// It is not an expression.
    Syntax,
    /// A name or function that does not exist here.
    UnknownName,
    /// A text that an enumeration is compared with, and that is none of its words.
    UnknownWord,
    /// A name that is declared, but has no value because its declaration has a diagnostic: this one only follows from
    /// it.
    Follows,
    /// It refers to nothing that can be.
    Reference,
    /// An operand of the wrong kind, or the wrong number of arguments.
    Type,
    /// A result that is no number: overflow, division by zero, an index outside its list.
    Arithmetic,
}

/// A function of expressions.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// The minimum and the maximum number of arguments.
    pub arguments: (usize, usize),
    /// A call of it.
    pub usage: &'static str,
    /// A description of its result.
    pub description: &'static str,
}

const fn function(
    name: &'static str,
    arguments: (usize, usize),
    usage: &'static str,
    description: &'static str,
) -> Function {
    Function { name, arguments, usage, description }
}

/// All functions, sorted by name.
pub const FUNCTIONS: &[Function] = &[
    function("abs", (1, 1), "abs(x)", "the distance from zero, of each element of a list"),
    function(
        "align",
        (2, 2),
        "align(x, step)",
        "the next multiple of a step from x on, of each element of a list",
    ),
    function("ceil", (1, 1), "ceil(x)", "the next whole number from x on, of each element of a list"),
    function(
        "clamp",
        (3, 3),
        "clamp(x, low, high)",
        "x, or the bound beyond which it is, of each element of a list",
    ),
    function("exp2", (1, 1), "exp2(x)", "two to the power of x, of each element of a list"),
    function("floor", (1, 1), "floor(x)", "the whole number up to x, of each element of a list"),
    function("len", (1, 1), "len(list)", "the number of elements of a list"),
    function("log2", (1, 1), "log2(x)", "the logarithm to the base of two, of each element of a list"),
    function("max", (1, 64), "max(a, b, …)", "the greatest of numbers and of the elements of lists"),
    function("min", (1, 64), "min(a, b, …)", "the smallest of numbers and of the elements of lists"),
    function("mip_count", (1, 1), "mip_count(size)", "the number of mip levels down to one texel of a size"),
    function(
        "round",
        (1, 1),
        "round(x)",
        "the nearest whole number, halves away from zero, of each element of a list",
    ),
    function("sqrt", (1, 1), "sqrt(x)", "the square root, of each element of a list"),
];
