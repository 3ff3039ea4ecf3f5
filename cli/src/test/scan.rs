//! The shader tests in a rendered text: functions with `@test` and their tables, asserts, and loops.
//!
//! ```wgsl
//! @test
//! @case(0.25, 1.0)
//! @case(0.75, 0.5)
//! fn light_falls_with_distance(distance: f32, wanted: f32) {
//!     expect_near(falloff(distance), wanted, 1e-5, "the falloff");
//! }
//! ```
//!
//! Asserts are statements: `expect(condition)`, `expect_equal(found, wanted)` and
//! `expect_near(found, wanted, tolerance)`, each with a message as a further argument where one likes. They may stand
//! in any function that a test calls.

use std::ops::Range;

use umbragraph::diagnostic::suggested_name;

use super::tokens::{Token, TokenKind, tokens};

/// The tests, asserts and loops in one shader source; all ranges are byte ranges in it.
#[derive(Debug, Default)]
pub(super) struct Scan {
    pub(super) tests: Vec<TestFunction>,
    pub(super) asserts: Vec<Assert>,
    pub(super) loops: Vec<Loop>,
    /// The byte ranges of `@test` and `@case` attributes, which are not WGSL.
    pub(super) attributes: Vec<Range<usize>>,
    pub(super) problems: Vec<Problem>,
}

/// A function with the `@test` attribute.
#[derive(Debug)]
pub(super) struct TestFunction {
    pub(super) name: String,
    /// The byte range of the function's name.
    pub(super) at: Range<usize>,
    /// The types of the function's parameters.
    pub(super) parameters: Vec<String>,
    /// The argument rows of the test; a single row without arguments if there is no `@case`.
    pub(super) rows: Vec<TableRow>,
    /// Set if the rows come from `@case` attributes.
    pub(super) has_table: bool,
}

/// A row of arguments for a test.
#[derive(Clone, Debug)]
pub(super) struct TableRow {
    /// The byte range between the parentheses.
    pub(super) at: Range<usize>,
    pub(super) arguments: Vec<Range<usize>>,
}

/// The kind of check of an assert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AssertKind {
    True,
    Equal,
    Near,
}

/// An assert statement in a test.
#[derive(Debug)]
pub(super) struct Assert {
    pub(super) kind: AssertKind,
    /// The byte range of the entire statement.
    pub(super) whole: Range<usize>,
    /// The byte ranges of the arguments, without the message.
    pub(super) arguments: Vec<Range<usize>>,
    pub(super) message: Option<String>,
}

/// A loop statement.
#[derive(Debug)]
pub(super) struct Loop {
    /// The byte range of the loop's keyword.
    pub(super) at: Range<usize>,
    /// The byte offset of the first byte of the loop's body.
    pub(super) body: usize,
}

/// An error in the way a test is written.
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) at: Range<usize>,
    pub(super) message: String,
    pub(super) help: &'static str,
}

/// The names of the assert functions.
const ASSERTS: [&str; 3] = ["expect", "expect_equal", "expect_near"];

impl AssertKind {
    fn of(word: &str) -> Option<Self> {
        match word {
            "expect" => Some(Self::True),
            "expect_equal" => Some(Self::Equal),
            "expect_near" => Some(Self::Near),
            _ => None,
        }
    }

    fn arguments(self) -> usize {
        match self {
            Self::True => 1,
            Self::Equal => 2,
            Self::Near => 3,
        }
    }

    /// Returns the help text with the correct form of the assert.
    pub(super) fn form(self) -> &'static str {
        match self {
            Self::True => "write `expect(condition);` or `expect(condition, \"message\");`",
            Self::Equal => "write `expect_equal(found, wanted);`, with a message at the end if you like",
            Self::Near => {
                "write `expect_near(found, wanted, tolerance);`, with a message at the end if you like"
            }
        }
    }
}

/// Finds the tests, asserts and loops of a shader source.
pub(super) fn scan(text: &str) -> Scan {
    let tokens = tokens(text);
    let mut scanner = Scanner { text, tokens: &tokens, found: Scan::default() };
    scanner.functions();
    for at in 0..tokens.len() {
        scanner.assert(at);
        scanner.looped(at);
    }
    scanner.found
}

struct Scanner<'t> {
    text: &'t str,
    tokens: &'t [Token],
    found: Scan,
}

impl<'t> Scanner<'t> {
    fn word(&self, at: usize) -> &'t str {
        let token = self.tokens.get(at).filter(|token| token.kind == TokenKind::Word);
        token.and_then(|token| self.text.get(token.range.clone())).unwrap_or_default()
    }

    fn is(&self, at: usize, sign: u8) -> bool {
        self.tokens.get(at).is_some_and(|token| token.kind == TokenKind::Sign(sign))
    }

    /// Returns the index of the token that closes the bracket at `open`; `None` if there is none.
    fn closing(&self, open: usize) -> Option<usize> {
        let mut depth = 0_usize;
        for (at, token) in self.tokens.iter().enumerate().skip(open) {
            match token.kind {
                TokenKind::Sign(b'(' | b'[' | b'{') => depth += 1,
                TokenKind::Sign(b')' | b']' | b'}') => depth = depth.checked_sub(1)?,
                _ => {}
            }
            if depth == 0 {
                return Some(at);
            }
        }
        None
    }

    fn between(&self, open: usize, close: usize) -> Range<usize> {
        self.tokens[open].range.end..self.tokens[close].range.start
    }

    fn problem(&mut self, at: Range<usize>, message: String, help: &'static str) {
        self.found.problems.push(Problem { at, message, help });
    }

    /// Finds test functions with their argument rows.
    fn functions(&mut self) {
        let (mut at, mut test, mut rows) = (0, None, Vec::new());
        let mut has_unknown = false;
        while at < self.tokens.len() {
            if self.is(at, b'@') {
                let start = self.tokens[at].range.start;
                let arguments = Some(at + 2).filter(|open| self.is(*open, b'('));
                let close = arguments.and_then(|open| self.closing(open));
                let end = close.unwrap_or(at + 1);
                let whole = start..self.tokens.get(end).map_or(self.text.len(), |token| token.range.end);
                match (self.word(at + 1), arguments.zip(close)) {
                    ("test", None) => test = Some(whole.clone()),
                    ("case", Some((open, close))) => {
                        let arguments = self.arguments(open, close);
                        rows.push(TableRow { at: self.between(open, close), arguments });
                    }
                    ("test", _) => {
                        let help = "write `@test`, and a row of its table as `@case(…)`";
                        self.problem(whole.clone(), "`@test` has no arguments".to_owned(), help);
                    }
                    ("case", None) => {
                        let help = "write the arguments of one call of the test: `@case(0.5, 1.0)`";
                        self.problem(whole.clone(), "`@case` has no arguments".to_owned(), help);
                    }
                    (word, _) => {
                        // WGSL has no attribute for a function that is no entry point but this.
                        if test.is_some() && word != "must_use" {
                            let message = format!("`@{word}` is no attribute of a test");
                            self.problem(whole, message, "a row of its table is written `@case(…)`");
                            has_unknown = true;
                        }
                        at = end + 1;
                        continue;
                    }
                }
                self.found.attributes.push(whole);
                at = end + 1;
                continue;
            }
            let (test, rows) = (test.take(), std::mem::take(&mut rows));
            // What an unknown attribute leaves out is no mistake of its own.
            if (test.is_some() || !rows.is_empty()) && !std::mem::take(&mut has_unknown) {
                self.test(at, test, rows);
            }
            at += 1;
        }
        if test.is_some() || !rows.is_empty() {
            self.test(at, test, rows);
        }
    }

    /// Adds the test function at a token index; `test` and `rows` come from its attributes.
    fn test(&mut self, at: usize, test: Option<Range<usize>>, rows: Vec<TableRow>) {
        let first = test.clone().or(rows.first().map(|row| row.at.clone())).unwrap_or(0..0);
        let help = "put `@test` and its `@case(…)` lines right before a function";
        if self.word(at) != "fn" {
            let message = "`@test` and `@case` belong to a function".to_owned();
            return self.problem(first, message, help);
        }
        let name = self.word(at + 1).to_owned();
        let place = self.tokens.get(at + 1).map_or(first.clone(), |token| token.range.clone());
        if test.is_none() {
            return self.problem(
                first,
                format!("`{name}` has a table, and is no test"),
                "add `@test` before it",
            );
        }
        let close = self.closing(at + 2).filter(|_| self.is(at + 2, b'('));
        let parameters: Vec<String> = close.map(|close| self.types(at + 2, close)).unwrap_or_default();
        if !parameters.is_empty() && rows.is_empty() {
            let help = "add a line `@case(…)` with arguments for each call before the function";
            return self.problem(place, format!("the test `{name}` has parameters, and no table"), help);
        }
        let (count, has_table) = (parameters.len(), !rows.is_empty());
        for row in rows.iter().filter(|row| row.arguments.len() != count) {
            let given = row.arguments.len();
            let message =
                format!("the test `{name}` takes {count} in a row of its table, and this one has {given}");
            self.problem(row.at.clone(), message, "give each parameter one value");
        }
        let empty = TableRow { at: place.clone(), arguments: Vec::new() };
        let rows = if has_table { rows } else { vec![empty] };
        self.found.tests.push(TestFunction { name, at: place, parameters, rows, has_table });
    }

    /// Returns the types of the parameters between two parentheses.
    fn types(&self, open: usize, close: usize) -> Vec<String> {
        let parameters = self.arguments(open, close).into_iter();
        let of =
            |range| self.text.get(range).and_then(|text: &str| text.split_once(':')).unwrap_or_default().1;
        parameters.map(|range| of(range).trim().to_owned()).collect()
    }

    /// Adds the assert at a token index, if there is one.
    fn assert(&mut self, at: usize) {
        let word = self.word(at);
        let Some(kind) = AssertKind::of(word).filter(|_| self.is(at + 1, b'(')) else {
            return self.misspelt(at, word);
        };
        if at > 0 && (self.word(at - 1) == "fn" || self.is(at - 1, b'.')) {
            return;
        }
        let name = self.tokens[at].range.clone();
        let Some(close) = self.closing(at + 1) else { return };
        if !self.is(close + 1, b';') {
            let message = format!("`{}` is no statement here", self.word(at));
            return self.problem(name, message, kind.form());
        }
        let whole = name.start..self.tokens[close + 1].range.end;
        let mut arguments = self.arguments(at + 1, close);
        let message = arguments.last().and_then(|last| string(self.text.get(last.clone())?.trim()));
        if message.is_some() {
            arguments.pop();
        }
        if arguments.len() != kind.arguments() {
            let count = arguments.len();
            let message = format!("`{}` has {count} arguments", self.word(at));
            return self.problem(whole, message, kind.form());
        }
        self.found.asserts.push(Assert { kind, whole, arguments, message });
    }

    /// Reports a call of an undeclared function whose name is almost that of an assert.
    fn misspelt(&mut self, at: usize, word: &str) {
        if !word.starts_with('e') || !self.is(at + 1, b'(') {
            return;
        }
        let Some(meant) = suggested_name(word, ASSERTS).and_then(AssertKind::of) else { return };
        let is_declared = |at: usize| {
            self.word(at) == word && at.checked_sub(1).is_some_and(|before| self.word(before) == "fn")
        };
        if !(0..self.tokens.len()).any(is_declared) {
            let message = format!("there is no assert `{word}`");
            self.problem(self.tokens[at].range.clone(), message, meant.form());
        }
    }

    /// Returns the byte ranges of the arguments between two parentheses.
    fn arguments(&self, open: usize, close: usize) -> Vec<Range<usize>> {
        let (mut found, mut depth, mut angles) = (Vec::new(), 0_usize, 0_usize);
        let mut start = self.tokens[open].range.end;
        for at in open + 1..close {
            let token = &self.tokens[at];
            match token.kind {
                TokenKind::Sign(b'(' | b'[' | b'{') => depth += 1,
                TokenKind::Sign(b')' | b']' | b'}') => depth = depth.saturating_sub(1),
                TokenKind::Sign(b'<') if is_generic(self.word(at - 1)) || angles > 0 => angles += 1,
                TokenKind::Sign(b'>') => angles = angles.saturating_sub(1),
                TokenKind::Sign(b',') if depth == 0 && angles == 0 => {
                    found.push(start..token.range.start);
                    start = token.range.end;
                }
                _ => {}
            }
        }
        let last = start..self.tokens[close].range.start;
        if !self.text.get(last.clone()).unwrap_or_default().trim().is_empty() {
            found.push(last);
        }
        found
    }

    /// Adds the loop at a token index, if there is one.
    fn looped(&mut self, at: usize) {
        if !matches!(self.word(at), "loop" | "for" | "while") || (at > 0 && self.is(at - 1, b'.')) {
            return;
        }
        let Some(open) = (at + 1..self.tokens.len()).find(|next| self.is(*next, b'{')) else { return };
        let (place, body) = (self.tokens[at].range.clone(), self.tokens[open].range.end);
        self.found.loops.push(Loop { at: place, body });
    }
}

/// Returns `true` if a `<` after this word begins a template list of types.
fn is_generic(word: &str) -> bool {
    matches!(word, "array" | "bitcast" | "vec2" | "vec3" | "vec4") || word.starts_with("mat")
}

/// Returns the contents of a quoted string; `None` without quotes.
fn string(text: &str) -> Option<String> {
    let inner = text.strip_prefix('"')?.strip_suffix('"')?;
    Some(inner.replace("\\\"", "\"").replace("\\\\", "\\"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_asserts_and_loops_are_found() {
        let text = "// @test\n@test @case(1.0, vec2(2.0, 3.0)) @case(4.0, vec2(5.0)) fn a(x: f32, y: vec2<f32>) {\n\
            for (var i = 0; i < 3; i++) { expect_near(x, f(array<f32, 2>(1.0, 2.0)[0], 1), 1e-3, \"a, \\\"b\\\"\"); } }\n\
            fn f(x: f32, i: i32) -> f32 { loop { expect(x < 1.0); if i > 0 { return x; } } }\n";
        let scan = scan(text);
        assert!(scan.problems.is_empty(), "{:?}", scan.problems);
        let rows: Vec<&str> = scan.tests[0].rows.iter().map(|row| &text[row.at.clone()]).collect();
        assert_eq!(scan.tests[0].parameters, ["f32", "vec2<f32>"]);
        assert_eq!(scan.tests[0].rows[0].arguments.len(), 2);
        assert_eq!((scan.tests.len(), rows), (1, vec!["1.0, vec2(2.0, 3.0)", "4.0, vec2(5.0)"]));
        assert_eq!(scan.attributes.len(), 3);
        let near = &scan.asserts[0];
        assert_eq!((near.kind, near.arguments.len()), (AssertKind::Near, 3));
        assert_eq!(near.message.as_deref(), Some("a, \"b\""));
        assert_eq!((scan.asserts[1].kind, scan.asserts[1].message.is_none()), (AssertKind::True, true));
        assert_eq!(scan.loops.len(), 2);
    }

    #[test]
    fn mistakes_are_named() {
        let of = |text: &str| scan(text).problems.into_iter().map(|one| one.message).collect::<Vec<_>>();
        assert_eq!(of("fn a() {} @test"), ["`@test` and `@case` belong to a function"]);
        assert_eq!(of("@test var x = 1;"), ["`@test` and `@case` belong to a function"]);
        assert_eq!(of("@case(1) fn a(x: i32) {}"), ["`a` has a table, and is no test"]);
        assert_eq!(
            of("@test @case(1, 2) fn a(x: i32) {}"),
            ["the test `a` takes 1 in a row of its table, and this one has 2"]
        );
        assert_eq!(of("@test fn a(x: i32) {}"), ["the test `a` has parameters, and no table"]);
        assert_eq!(of("@test @cas(1) fn a(x: i32) {}"), ["`@cas` is no attribute of a test"]);
        assert_eq!(of("@test fn a() { expekt(true); }"), ["there is no assert `expekt`"]);
        assert_eq!(of("fn expekt(a: bool) {} @test fn a() { expekt(true); exp(1.0); }"), [""; 0]);
        assert_eq!(of("@test fn a() { expect_near(1.0, 2.0); }"), ["`expect_near` has 2 arguments"]);
        assert_eq!(of("@test fn a() { let x = expect(true) + 1; }"), ["`expect` is no statement here"]);
    }
}
