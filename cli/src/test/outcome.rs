//! Turns the results of rows into diagnostics at the asserts that failed.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::time::Duration;

use umbragraph::diagnostic::{Diagnostic, Place};
use umbragraph::low_level::shader::permutations::Variant;

use super::device::RowResult;
use super::instrument::{ENDLESS, FAILED, MAX_ROUNDS, PASSED, Row};
use super::scan::{Assert, AssertKind, Scan, TestFunction};
use super::types::Shape;
use crate::codes;

/// The rows that a variant ran, for reporting their results.
pub(super) struct Shown<'a> {
    pub(super) variant: &'a Variant,
    pub(super) scan: &'a Scan,
    pub(super) shapes: &'a [Option<Shape>],
    pub(super) rows: &'a [Row],
}

/// Returns the source place of a byte range in a variant's shader source.
fn place(variant: &Variant, range: &Range<usize>) -> Place {
    variant.map().span(range.clone()).map_or(Place::Nowhere, Place::Span)
}

/// Returns diagnostics for tests that are written incorrectly.
pub(super) fn problems(variant: &Variant, scan: &Scan) -> Vec<Diagnostic> {
    let diagnostic = |problem: &super::scan::Problem| {
        let place = place(variant, &problem.at);
        Diagnostic::error(codes::TEST_INVALID, place, problem.message.as_str()).help(problem.help)
    };
    scan.problems.iter().map(diagnostic).collect()
}

/// Creates the diagnostic for tests that did not end in time.
pub(super) fn timed_out(variant: &Variant, scan: &Scan, rows: &[Row], limit: Duration) -> Diagnostic {
    let of_row = |row: &Row| scan.tests.get(row.test);
    let names: BTreeSet<&str> = rows.iter().filter_map(of_row).map(|test| test.name.as_str()).collect();
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let (the, verb) = if names.len() == 1 { ("the test", "does") } else { ("the tests", "do") };
    let (names, seconds) = (names.join(", "), limit.as_secs());
    let message = format!("{the} {names} {verb} not end within {seconds} s");
    let first = rows.first().and_then(of_row).map_or(0..0, |test| test.at.clone());
    Diagnostic::error(codes::TEST_ENDLESS, place(variant, &first), message)
        .help("run fewer rows at once (--filter NAME), do less in each, or wait longer (--timeout SECONDS)")
}

impl Shown<'_> {
    /// Returns a diagnostic, with its test's name, for each failed assert or endless loop. Each diagnostic shows the
    /// first affected row.
    pub(super) fn failures(&self, results: &[RowResult]) -> Vec<(String, Diagnostic)> {
        // By test, state, and assert or loop.
        let mut found: BTreeMap<(usize, u32, u32), Vec<(usize, RowResult)>> = BTreeMap::new();
        for (at, row) in self.rows.iter().enumerate() {
            let result = results.get(at).copied().unwrap_or_default();
            if result[0] != PASSED {
                found.entry((row.test, result[0], result[1])).or_default().push((at, result));
            }
        }
        let mut diagnostics = Vec::new();
        for ((test, state, which), rows) in found {
            let (Some(test), Some((row, result))) = (self.scan.tests.get(test), rows.first()) else {
                continue;
            };
            let diagnostic = match state {
                FAILED => self.failed(test, which as usize, result),
                ENDLESS => self.endless(test, which as usize),
                _ => {
                    let message = format!("the test `{}` did not run to its end", test.name);
                    let help = "the driver gave up on it: try another adapter (--adapter)";
                    Diagnostic::error(codes::TEST_FAILS, place(self.variant, &test.at), message).help(help)
                }
            };
            diagnostics.push((test.name.clone(), self.with_row(diagnostic, test, *row, rows.len())));
        }
        diagnostics
    }

    fn failed(&self, test: &TestFunction, which: usize, result: &RowResult) -> Diagnostic {
        let Some(assert) = self.scan.asserts.get(which) else {
            let message = format!("the test `{}` fails", test.name);
            return Diagnostic::error(codes::TEST_FAILS, place(self.variant, &test.at), message);
        };
        let message = format!("the test `{}` fails: {}", test.name, self.said(assert));
        let diagnostic = Diagnostic::error(codes::TEST_FAILS, place(self.variant, &assert.whole), message);
        let Some(shape) = self.shapes.get(which).copied().flatten() else { return diagnostic };
        let side = |at: usize| [0, 1, 2, 3].map(|part| result.get(at + part).copied().unwrap_or_default());
        let (found, wanted) = (shape.show(side(4)), shape.show(side(8)));
        let mut values = format!("found {found}, wanted {wanted}");
        if assert.kind == AssertKind::Near {
            let float = |bits: u32| f64::from(f32::from_bits(bits));
            let differences = side(4).into_iter().zip(side(8)).take(shape.components);
            let differences = differences.map(|(found, wanted)| (float(found) - float(wanted)).abs());
            let largest =
                differences.fold(0.0, |max: f64, one| if one.is_nan() { one } else { max.max(one) });
            let tolerance = f32::from_bits(result[2]);
            values.push_str(&format!(", which is off by {largest:.3e}, and more than {tolerance:e}"));
        }
        diagnostic.related(Place::Nowhere, values)
    }

    /// Returns the message of an assert, or else the source of the assert.
    fn said(&self, assert: &Assert) -> String {
        let text = || self.variant.wgsl().get(assert.whole.clone()).unwrap_or_default();
        let words = || text().trim_end_matches(';').split_whitespace().collect::<Vec<_>>().join(" ");
        assert.message.clone().unwrap_or_else(|| format!("`{}`", words()))
    }

    fn endless(&self, test: &TestFunction, which: usize) -> Diagnostic {
        let at = self.scan.loops.get(which).map_or(&test.at, |each| &each.at);
        let message = format!("the test `{}` does not end", test.name);
        Diagnostic::error(codes::TEST_ENDLESS, place(self.variant, at), message)
            .related(
                Place::Nowhere,
                format!("the loops of a row took more than {MAX_ROUNDS} rounds, the last here"),
            )
            .help("let the loop end, or do less in one row")
    }

    /// Adds the affected row to a diagnostic, and the number of other failing rows.
    fn with_row(
        &self,
        diagnostic: Diagnostic,
        test: &TestFunction,
        row: usize,
        failing: usize,
    ) -> Diagnostic {
        let Some(row) = self.rows.get(row).filter(|_| test.has_table) else { return diagnostic };
        let Some(arguments) = test.rows.get(row.row).map(|row| &row.at) else { return diagnostic };
        let given = self.variant.wgsl().get(arguments.clone()).unwrap_or_default().trim();
        let (number, count) = (row.row + 1, test.rows.len());
        let mut said = format!("row {number} of {count}: @case({given})");
        if failing > 1 {
            said.push_str(&format!(", and {} more", failing - 1));
        }
        diagnostic.related(place(self.variant, arguments), said)
    }
}
