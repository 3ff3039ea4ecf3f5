//! The parser of expressions: a precedence climber over a hand-written scanner.
//!
//! Precedence, loosest first: `?:`, `||`, `&&`, comparisons (which do not chain), `+ -`, `* / %`, unary, postfix.

use std::ops::Range;

use super::{
    BinaryOperator, ErrorKind, Expression, ExpressionError, ExpressionKind, Reference, UnaryOperator, Value,
};

const MAX_DEPTH: usize = 64;
const MAX_BYTES: usize = 4096;
/// The maximum number of operators of one precedence in a row. Such a chain becomes a left-leaning tree, on which later
/// steps recurse.
const MAX_CHAIN: usize = 128;

/// Parses an expression, without an `=` before it.
///
/// # Errors
/// The first syntax error.
pub fn parse(text: &str) -> Result<Expression, ExpressionError> {
    parse_from(text, 0)
}

/// Parses the expression in `text` that begins at the byte offset `at`. Ranges in the result are byte ranges in `text`.
///
/// # Errors
/// The first syntax error.
pub fn parse_from(text: &str, at: usize) -> Result<Expression, ExpressionError> {
    if text.len() > MAX_BYTES {
        return Err(syntax(at..text.len(), format!("an expression has at most {MAX_BYTES} bytes")));
    }
    let mut parser = Parser { text, at, depth: 0 };
    let expression = parser.conditional()?;
    parser.blank();
    if parser.at < text.len() {
        return Err(parser
            .foreign()
            .unwrap_or_else(|| syntax(parser.at..text.len(), "the expression should end here")));
    }
    Ok(expression)
}

fn syntax(range: Range<usize>, message: impl Into<String>) -> ExpressionError {
    ExpressionError::new(ErrorKind::Syntax, range, message)
}

fn too_deep(range: Range<usize>) -> ExpressionError {
    syntax(range, format!("expressions nest to {MAX_DEPTH} levels at most"))
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

/// The binary operators, one row for each level of precedence, loosest first. In a row, longer spellings come before
/// their prefixes.
const LEVELS: &[&[(&str, BinaryOperator)]] = &[
    &[("||", BinaryOperator::Or)],
    &[("&&", BinaryOperator::And)],
    &[
        ("==", BinaryOperator::Equal),
        ("!=", BinaryOperator::NotEqual),
        ("<=", BinaryOperator::LessEqual),
        (">=", BinaryOperator::GreaterEqual),
        ("<", BinaryOperator::Less),
        (">", BinaryOperator::Greater),
    ],
    &[("+", BinaryOperator::Add), ("-", BinaryOperator::Subtract)],
    &[("*", BinaryOperator::Multiply), ("/", BinaryOperator::Divide), ("%", BinaryOperator::Remainder)],
];

impl Parser<'_> {
    fn conditional(&mut self) -> Result<Expression, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(too_deep(self.at..self.text.len()));
        }
        let condition = self.binary(0)?;
        let expression = if self.take("?") {
            let yes = self.conditional()?;
            if !self.take(":") {
                return Err(self.expected("\":\" of the condition"));
            }
            let no = self.conditional()?;
            Expression {
                range: condition.range.start..no.range.end,
                kind: ExpressionKind::Conditional(Box::new(condition), Box::new(yes), Box::new(no)),
            }
        } else {
            condition
        };
        self.depth -= 1;
        Ok(expression)
    }

    fn binary(&mut self, level: usize) -> Result<Expression, ExpressionError> {
        let Some(operators) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        let mut links = 0;
        while let Some((_, operator)) = operators.iter().find(|(spelling, _)| self.take(spelling)) {
            links += 1;
            if links > MAX_CHAIN {
                return Err(syntax(
                    left.range,
                    format!("a chain of operators has at most {MAX_CHAIN} links"),
                ));
            }
            let right = self.binary(level + 1)?;
            left = Expression {
                range: left.range.start..right.range.end,
                kind: ExpressionKind::Binary(*operator, Box::new(left), Box::new(right)),
            };
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Expression, ExpressionError> {
        self.blank();
        let start = self.at;
        let operator = if self.take("-") {
            UnaryOperator::Negate
        } else if !self.text[self.at..].starts_with("!=") && self.take("!") {
            UnaryOperator::Not
        } else {
            return self.postfix();
        };
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(too_deep(start..self.at));
        }
        let operand = self.unary()?;
        self.depth -= 1;
        Ok(Expression {
            range: start..operand.range.end,
            kind: ExpressionKind::Unary(operator, Box::new(operand)),
        })
    }

    fn postfix(&mut self) -> Result<Expression, ExpressionError> {
        let mut expression = self.primary()?;
        let mut links = 0;
        while self.take("[") {
            links += 1;
            if links > MAX_DEPTH {
                return Err(too_deep(expression.range));
            }
            let index = self.conditional()?;
            if !self.take("]") {
                return Err(self.expected("\"]\" of the index"));
            }
            expression = Expression {
                range: expression.range.start..self.at,
                kind: ExpressionKind::Index(Box::new(expression), Box::new(index)),
            };
        }
        Ok(expression)
    }

    fn primary(&mut self) -> Result<Expression, ExpressionError> {
        self.blank();
        let start = self.at;
        let rest = &self.text[start..];
        let Some(first) = rest.chars().next() else { return Err(self.expected("a value")) };
        if first.is_ascii_digit() {
            return self.number();
        }
        if first.is_ascii_alphabetic() || first == '_' {
            return self.name();
        }
        if first == '\'' {
            let Some(length) = rest[1..].find('\'') else {
                return Err(syntax(start..self.text.len(), "the text is not closed by '"));
            };
            self.at += length + 2;
            let text = rest[1..=length].to_owned();
            return Ok(Expression {
                range: start..self.at,
                kind: ExpressionKind::Literal(Value::Text(text)),
            });
        }
        if first == '&' {
            return self.reference();
        }
        if self.take("(") {
            let inner = self.conditional()?;
            if !self.take(")") {
                return Err(self.expected("\")\""));
            }
            return Ok(Expression { range: start..self.at, kind: inner.kind });
        }
        if self.take("[") {
            let elements = self.arguments("]")?;
            return Ok(Expression { range: start..self.at, kind: ExpressionKind::List(elements) });
        }
        Err(self.expected("a value"))
    }

    fn number(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let digits = |at: usize| at + bytes[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        self.at = digits(self.at);
        if bytes.get(self.at) == Some(&b'.') && bytes.get(self.at + 1).is_some_and(u8::is_ascii_digit) {
            self.at = digits(self.at + 1);
        }
        if matches!(bytes.get(self.at), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(self.at + 1), Some(b'+' | b'-')));
            if bytes.get(self.at + 1 + sign).is_some_and(u8::is_ascii_digit) {
                self.at = digits(self.at + 1 + sign);
            }
        }
        let range = start..self.at;
        match self.text[range.clone()].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                Ok(Expression { range, kind: ExpressionKind::Literal(Value::Number(number)) })
            }
            _ => Err(syntax(range, "the number cannot be represented")),
        }
    }

    fn name(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.at;
        let end = self.text[start..]
            .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.'))
            .map_or(self.text.len(), |length| start + length);
        self.at = end;
        let name = &self.text[start..end];
        if self.take("(") {
            let arguments = self.arguments(")")?;
            return Ok(Expression {
                range: start..self.at,
                kind: ExpressionKind::Call(name.to_owned(), arguments),
            });
        }
        let kind = match name {
            "true" => ExpressionKind::Literal(Value::Bool(true)),
            "false" => ExpressionKind::Literal(Value::Bool(false)),
            _ => ExpressionKind::Name(name.to_owned()),
        };
        Ok(Expression { range: start..end, kind })
    }

    fn reference(&mut self) -> Result<Expression, ExpressionError> {
        let start = self.at;
        let name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '@');
        let rest = &self.text[start + 1..];
        let end = rest
            .char_indices()
            .find(|(at, c)| !(name(*c) || *c == '-' && rest[..*at].ends_with('@')))
            .map_or(self.text.len(), |(at, _)| start + 1 + at);
        self.at = end;
        let range = start..end;
        let text = &self.text[start + 1..end];
        let reference = Reference::parse(text).map_err(|error| error.of(text, range.clone()))?;
        Ok(Expression { range, kind: ExpressionKind::Reference(reference) })
    }

    fn arguments(&mut self, close: &str) -> Result<Vec<Expression>, ExpressionError> {
        let mut arguments = Vec::new();
        if self.take(close) {
            return Ok(arguments);
        }
        loop {
            arguments.push(self.conditional()?);
            if self.take(close) {
                return Ok(arguments);
            }
            if !self.take(",") {
                return Err(self.expected(&format!("\",\" or \"{close}\"")));
            }
        }
    }

    fn take(&mut self, spelling: &str) -> bool {
        self.blank();
        let found = self.text[self.at..].starts_with(spelling);
        if found {
            self.at += spelling.len();
        }
        found
    }

    fn blank(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    /// The error for an operator of another language at this point, with the one of this language as help text.
    fn foreign(&self) -> Option<ExpressionError> {
        let (before, rest) = self.text.split_at_checked(self.at)?;
        let error = |range: Range<usize>, help: &str| {
            let message = format!("\"{}\" is no operator", &self.text[range.clone()]);
            ExpressionError { help: Some(help.to_owned()), ..syntax(range, message) }
        };
        for (word, help) in [("and", "write &&"), ("or", "write ||")] {
            let is_word = |rest: &str| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
            if rest.strip_prefix(word).is_some_and(is_word) {
                return Some(error(self.at..self.at + word.len(), help));
            }
        }
        let head = before.trim_end();
        let is_not = !rest.is_empty()
            && head.strip_suffix("not").is_some_and(|head| {
                !head.ends_with(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '&' | '@'))
            });
        if is_not {
            return Some(error(head.len() - 3..head.len(), "write ! before the condition"));
        }
        if rest.starts_with('*') && head.ends_with('*') {
            return Some(error(head.len() - 1..self.at + 1, "there is no power: multiply, as in x * x"));
        }
        let help = match rest.get(..2) {
            Some("=>") => "write >=",
            Some("=<") => "write <=",
            _ => "write == to compare",
        };
        let length = if help.ends_with("= to compare") { 1 } else { 2 };
        rest.starts_with('=').then(|| error(self.at..self.at + length, help))
    }

    fn expected(&self, what: &str) -> ExpressionError {
        if let Some(error) = self.foreign() {
            return error;
        }
        let end = self.text[self.at..].chars().next().map_or(self.at, |c| self.at + c.len_utf8());
        let found =
            if self.at == end { "the end".to_owned() } else { format!("\"{}\"", &self.text[self.at..end]) };
        syntax(self.at..end, format!("expected {what}, found {found}"))
    }
}
