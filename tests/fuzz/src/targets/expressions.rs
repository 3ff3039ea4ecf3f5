//! Expressions of random pieces.

use umbragraph::low_level::expression::{Scope, Value, evaluate, parse};

use crate::mutation::Choices;
use crate::worker::note;

const PIECES: [&str; 62] = [
    "a",
    "b",
    "size",
    "list",
    "picture",
    "picture.width",
    "viewport",
    "viewport.width",
    "missing",
    "true",
    "false",
    "0",
    "1",
    "2",
    "0.5",
    "1e308",
    "1e-320",
    "9007199254740993",
    "-",
    "+",
    "*",
    "/",
    "%",
    "!",
    "==",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "&&",
    "||",
    "?",
    ":",
    "(",
    ")",
    "[",
    "]",
    ",",
    ".",
    "'word'",
    "'",
    "'{a}'",
    "&picture",
    "&a[1]",
    "&",
    "@pass",
    "min(",
    "max(",
    "floor(",
    "ceil(",
    "len(",
    "range(",
    "sum(",
    "log2(",
    "pow(",
    "clamp(",
    "round(",
    "sqrt(",
    " ",
    "ä",
    "\u{0}",
];

struct Names;

impl Scope for Names {
    fn lookup(&self, name: &str) -> Option<Value> {
        Some(match name {
            "a" => Value::Bool(true),
            "b" => Value::Number(-3.5),
            "size" => Value::Number(640.0),
            "list" => Value::List(vec![Value::Number(1.0), Value::Text("x".into()), Value::List(Vec::new())]),
            "viewport" => Value::List(vec![Value::Number(640.0), Value::Number(480.0)]),
            _ => return None,
        })
    }

    fn names(&self) -> Vec<String> {
        ["a", "b", "size", "list", "viewport"].map(str::to_owned).into()
    }
}

/// A value, or an error inside the text.
pub(crate) fn expressions(choices: &mut Choices<'_>) {
    let count = 1 + choices.below(24);
    let text: String = (0..count).map(|_| *choices.one_of(&PIECES)).collect();
    note(text.as_bytes());
    let error = match parse(&text) {
        Ok(expression) => match evaluate(&expression, &Names) {
            Ok(value) => return assert_ne!(value.kind_name(), ""),
            Err(error) => error,
        },
        Err(error) => error,
    };
    assert!(!error.message.is_empty());
    let range = error.range;
    assert!(range.start <= range.end && range.end <= text.len(), "{range:?} of {} bytes", text.len());
}
