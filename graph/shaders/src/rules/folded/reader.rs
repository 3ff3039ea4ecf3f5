//! Reads expressions of a text and computes those that are constant.
//!
//! naga has parsed the text before, so nothing here reports what is no expression: reading ends there, and goes on at
//! the next token. A part that is not constant has no value, and neither has what is made of it; its own parts are read
//! nevertheless.

use std::collections::HashMap;

use naga::Span;

use super::super::constant_arguments::beyond;
use super::functions::{self, Called};
use super::value::{self, Kind, Number, Value};
use crate::codes;
use crate::written::rejection::Rejection;
use crate::written::tokens::{Tokens, is_name};

/// Binary operators by precedence, the loosest first.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

/// The maximum number of open brackets and signs that are followed.
const MAX_DEPTH: usize = 128;

pub(super) struct Reader<'a> {
    tokens: &'a Tokens<'a>,
    declared: &'a HashMap<&'a str, usize>,
    constants: &'a HashMap<&'a str, Value>,
    /// The index of the next token.
    pub(super) at: usize,
    pub(super) rejection: Option<Rejection>,
    /// Whether the part that is read is not evaluated, as the right side of `false && …`.
    is_skipped: bool,
    depth: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(
        tokens: &'a Tokens<'a>,
        declared: &'a HashMap<&'a str, usize>,
        constants: &'a HashMap<&'a str, Value>,
    ) -> Self {
        Self { tokens, declared, constants, at: 0, rejection: None, is_skipped: false, depth: 0 }
    }

    /// Reads an expression. `None` if its value is not known.
    pub(super) fn expression(&mut self) -> Option<Value> {
        if self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let value = self.level(0);
        self.depth -= 1;
        value
    }

    /// Reads an expression of operators that bind at least as tight as those of a level.
    fn level(&mut self, level: usize) -> Option<Value> {
        let begun = self.at;
        let mut value = self.operand();
        while let Some((found, operator, count)) = self.operator().filter(|(found, ..)| *found >= level) {
            self.at += count;
            let truth = value.as_ref().and_then(Value::truth);
            let ends = matches!((operator, truth), ("&&", Some(false)) | ("||", Some(true)));
            let was_skipped = self.is_skipped;
            self.is_skipped |= ends;
            let right = self.level(found + 1);
            self.is_skipped = was_skipped;
            if ends {
                continue;
            }
            value = value.zip(right).and_then(|(left, right)| {
                let mut steps = left.steps();
                let value = value::binary(operator, left, right, &mut steps);
                if let Some((message, help)) = beyond(operator, steps) {
                    self.reject(begun, message, help);
                    return None;
                }
                value
            });
        }
        value
    }

    /// The level of the binary operator at the next token, the operator, and its number of tokens. `None` if there is
    /// none.
    fn operator(&self) -> Option<(usize, &'a str, usize)> {
        let (word, lists) = (self.tokens.word(self.at), &self.tokens.lists);
        if lists.contains(&self.at) {
            return None;
        }
        let (word, count) = if word == ">" {
            let end = self.tokens.ranges.get(self.at)?.end;
            let next = self.tokens.ranges.get(self.at + 1).filter(|next| next.start == end);
            match next.map(|_| self.tokens.word(self.at + 1)) {
                Some(">") if self.is_shift_assignment() => return None,
                Some(">") => (">>", 2),
                Some("=") => (">=", 2),
                _ => (">", 1),
            }
        } else {
            (word, 1)
        };
        let level = LEVELS.iter().position(|level| level.contains(&word))?;
        Some((level, word, count))
    }

    /// Returns `true` for `>>=`.
    fn is_shift_assignment(&self) -> bool {
        let (second, third) = (self.tokens.ranges.get(self.at + 1), self.tokens.ranges.get(self.at + 2));
        let is_joined = second.zip(third).is_some_and(|(second, third)| second.end == third.start);
        is_joined && self.tokens.word(self.at + 2) == "="
    }

    fn operand(&mut self) -> Option<Value> {
        let word = self.tokens.word(self.at);
        match word {
            "-" | "!" | "~" | "*" | "&" => {
                self.at += 1;
                if self.depth >= MAX_DEPTH {
                    return None;
                }
                self.depth += 1;
                let value = self.operand();
                self.depth -= 1;
                value::unary(word, value?)
            }
            "(" => {
                self.at += 1;
                let value = self.expression();
                if self.tokens.word(self.at) != ")" {
                    return None;
                }
                self.at += 1;
                self.parts(value)
            }
            _ if word.starts_with(|first: char| first.is_ascii_digit()) || self.is_fraction() => {
                self.number()
            }
            _ if is_name(word) => {
                let value = self.named(word);
                self.parts(value)
            }
            _ => None,
        }
    }

    fn is_fraction(&self) -> bool {
        self.tokens.word(self.at) == "."
            && self.tokens.word(self.at + 1).starts_with(|first: char| first.is_ascii_digit())
    }

    /// Reads a constant or a call.
    fn named(&mut self, name: &'a str) -> Option<Value> {
        let begun = self.at;
        self.at += 1;
        let mut list = "";
        if self.tokens.lists.contains(&self.at) && self.tokens.word(self.at) == "<" {
            let first = self.at;
            let mut depth = 0_usize;
            while let Some(range) = self.tokens.ranges.get(self.at) {
                if self.tokens.lists.contains(&self.at) {
                    depth =
                        if self.tokens.word(self.at) == "<" { depth + 1 } else { depth.saturating_sub(1) };
                }
                self.at += 1;
                if depth == 0 {
                    list = self.tokens.text.get(self.tokens.ranges[first].start..range.end)?;
                    break;
                }
            }
        }
        if self.tokens.word(self.at) != "(" {
            return match name {
                "true" | "false" => Some(Value::scalar(Kind::Bool, Number::Bool(name == "true"))),
                _ => self.constants.get(name).cloned(),
            };
        }
        self.at += 1;
        let mut arguments = Some(Vec::new());
        while self.tokens.word(self.at) != ")" {
            let value = self.expression();
            arguments = arguments.zip(value).map(|(mut arguments, value)| {
                arguments.push(value);
                arguments
            });
            match self.tokens.word(self.at) {
                "," => self.at += 1,
                ")" => {}
                _ => return None,
            }
        }
        self.at += 1;
        // A module may declare functions and types with the names of built-in ones.
        if self.declared.contains_key(name) {
            return None;
        }
        match functions::call(name, list, arguments?) {
            Called::Value(value) => Some(value),
            Called::Unknown => None,
            Called::Invalid(message, help) => {
                self.reject(begun, message, help);
                None
            }
        }
    }

    /// Reads components and indices behind an operand.
    fn parts(&mut self, mut value: Option<Value>) -> Option<Value> {
        loop {
            match self.tokens.word(self.at) {
                "." => {
                    value = value.and_then(|value| component(&value, self.tokens.word(self.at + 1)));
                    self.at += 2;
                }
                "[" => {
                    self.at += 1;
                    self.expression();
                    value = None;
                    if self.tokens.word(self.at) != "]" {
                        return None;
                    }
                    self.at += 1;
                }
                _ => return value,
            }
        }
    }

    /// Reads a number: one token, or several with a point among them.
    fn number(&mut self) -> Option<Value> {
        let start = self.tokens.ranges.get(self.at)?.start;
        let mut end = start;
        while let Some(range) = self.tokens.ranges.get(self.at).filter(|range| range.start == end) {
            let word = self.tokens.word(self.at);
            if word != "." && !word.starts_with(|first: char| first.is_ascii_alphanumeric()) {
                break;
            }
            end = range.end;
            self.at += 1;
        }
        literal(self.tokens.text.get(start..end)?)
    }

    fn reject(&mut self, first: usize, message: String, help: &str) {
        let (Some(start), Some(end)) = (self.tokens.ranges.get(first), self.tokens.ranges.get(self.at - 1))
        else {
            return;
        };
        if !self.is_skipped && self.rejection.is_none() {
            let place = Span::from(start.start..end.end);
            self.rejection = Some(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
        }
    }
}

/// One component of a vector, or several: `xy`.
fn component(value: &Value, names: &str) -> Option<Value> {
    if value.is_scalar {
        return None;
    }
    let part = |name: char| {
        let at = "xyzw".find(name).or_else(|| "rgba".find(name))?;
        value.parts.get(at).copied()
    };
    let parts = names.chars().map(part).collect::<Option<Vec<_>>>()?;
    Some(match parts[..] {
        [only] => Value::scalar(value.kind, only),
        _ => Value::vector(value.kind, parts),
    })
}

/// The value of a literal; `None` for `f16` and for hexadecimal floats.
fn literal(text: &str) -> Option<Value> {
    let hex = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    if hex.is_some_and(|hex| hex.contains(['.', 'p', 'P'])) || (hex.is_none() && text.ends_with('h')) {
        return None;
    }
    let whole = |kind: Kind, digits: &str| {
        let whole = match digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
            Some(hex) => i64::from_str_radix(hex, 16),
            None => digits.parse(),
        };
        whole.ok().map(|whole| Value::scalar(kind, Number::Whole(whole)))
    };
    if let Some(digits) = text.strip_suffix('u') {
        return whole(Kind::U32, digits);
    }
    if let Some(digits) = text.strip_suffix('i') {
        return whole(Kind::I32, digits);
    }
    if hex.is_none() && text.ends_with('f') {
        let real = f64::from(text.trim_end_matches('f').parse::<f32>().ok()?);
        return real.is_finite().then(|| Value::scalar(Kind::F32, Number::Real(real)));
    }
    if hex.is_none() && text.contains(['.', 'e', 'E']) {
        let real = text.parse::<f64>().ok().filter(|real| real.is_finite())?;
        return Some(Value::scalar(Kind::Float, Number::Real(real)));
    }
    whole(Kind::Int, text)
}
