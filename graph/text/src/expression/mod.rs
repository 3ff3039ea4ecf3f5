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

/// The value of an expression in a pipeline document.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A boolean.
    Bool(bool),
    /// A finite number.
    Number(f64),
    /// A string: a word of an enumeration, or the name of a texture format.
    Text(String),
    /// A list of values.
    List(Vec<Value>),
    /// A reference to a resource or published data, by its name at the top level of the pipeline.
    Reference(Reference),
}

impl Value {
    /// The kind of the value with an article, such as `a number`.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Value::Bool(_) => "a boolean",
            Value::Number(_) => "a number",
            Value::Text(_) => "a text",
            Value::List(_) => "a list",
            Value::Reference(_) => "a reference",
        }
    }

    /// Copies another value into this one, reusing the memory of lists of the same length and of strings.
    pub fn assign(&mut self, from: &Value) {
        match (self, from) {
            (Value::List(to), Value::List(from)) if to.len() == from.len() => {
                to.iter_mut().zip(from).for_each(|(to, from)| to.assign(from));
            }
            (Value::Text(to), Value::Text(from)) => to.clone_from(from),
            (to, from) => *to = from.clone(),
        }
    }

    /// The number; `None` for a value of another kind.
    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// The elements of a list of numbers, or a single number as a list. `None` for other values.
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

/// A node of the syntax tree of a parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// The byte range in the source string.
    pub range: Range<usize>,
    /// The kind of the node, with its operands.
    pub kind: ExpressionKind,
}

impl Expression {
    /// Calls `each` with the expression and all expressions in it, in depth-first order.
    pub fn visit<'e>(&'e self, each: &mut dyn FnMut(&'e Expression)) {
        each(self);
        self.parts().for_each(|part| part.visit(each));
    }

    /// Calls `each` with the expression and all expressions in it, to change them. A parent is visited before its
    /// operands.
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

    /// The operands: the direct subexpressions of this expression.
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

    /// The names in the expression in the order of the source, with repetitions.
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

/// The kind of an expression, with its operands.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionKind {
    /// A literal value, such as `1.5` or `true`.
    Literal(Value),
    /// A name, dots included: `viewport.width`.
    Name(String),
    /// A reference such as `&maps@draw`, by the names of the scope in which it is written.
    Reference(Reference),
    /// A unary operation: `-x`, `!x`.
    Unary(UnaryOperator, Box<Expression>),
    /// A binary operation: `a + b`.
    Binary(BinaryOperator, Box<Expression>, Box<Expression>),
    /// A conditional: `a ? b : c`.
    Conditional(Box<Expression>, Box<Expression>, Box<Expression>),
    /// A call of a built-in function: `f(a, b)`.
    Call(String, Vec<Expression>),
    /// An element of a list: `list[index]`.
    Index(Box<Expression>, Box<Expression>),
    /// A list literal: `[a, b]`.
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

/// An error in parsing or evaluating an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionError {
    /// The byte range of the error in the expression's source string.
    pub range: Range<usize>,
    /// The kind of the error.
    pub kind: ErrorKind,
    /// The message: one sentence without a full stop.
    pub message: String,
    /// A remedy in one sentence; `None` if none is known.
    pub help: Option<String>,
    /// The unknown name that causes the error; `None` for other errors.
    pub unknown: Option<Box<UnknownName>>,
}

impl ExpressionError {
    /// Creates an error without help text.
    pub fn new(kind: ErrorKind, range: Range<usize>, message: impl Into<String>) -> Self {
        Self { range, kind, message: message.into(), help: None, unknown: None }
    }
}

/// An unknown name, and the known names for suggestions.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownName {
    /// The unknown name, which begins at the start of the error's range.
    pub name: String,
    /// The known names, in no particular order.
    pub known: Vec<String>,
    /// Whether `known` lists all valid names, as for functions and words of an enumeration. `false` if the caller may
    /// know more names.
    pub is_complete: bool,
}

/// The kinds of error of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The string is not a valid expression.
    Syntax,
    /// A name or function does not exist in the scope.
    UnknownName,
    /// An enumeration is compared with a string that is none of its words.
    UnknownWord,
    /// A name is declared, but has no value because its declaration has an error of its own. This error is only a
    /// consequence.
    Follows,
    /// A reference is malformed.
    Reference,
    /// An operand has the wrong type, or a function gets the wrong number of arguments.
    Type,
    /// A result is not a finite number, or an index is outside its list.
    Arithmetic,
}

/// A built-in function of the expression language.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// The name by which expressions call the function.
    pub name: &'static str,
    /// The minimum and maximum number of arguments.
    pub arguments: (usize, usize),
    /// An example call, such as `clamp(x, low, high)`.
    pub usage: &'static str,
    /// A description of the result, a noun phrase without a full stop.
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

/// The built-in functions of the expression language, sorted by name.
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
