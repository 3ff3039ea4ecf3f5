//! Turns a text with tests into one that a device runs.
//!
//! Three texts follow from one another, each by edits that keep the places of the template:
//!
//! - *typed*: attributes are gone, and the arguments of asserts are initial values of variables, which have types;
//! - *proven*: asserts are comparisons that note a failure, and an entry point runs each row in a workgroup of its own.
//!   naga proves this text like any other;
//! - *bounded*: loops count their rounds as well, and leave after [`MAX_ROUNDS`]. No driver stops an endless loop.
//!
//! A row notes its first failure: which assert, both values, and the tolerance.

use std::ops::Range;

use umbragraph::low_level::shader::permutations::TextEdit;

use super::scan::{Assert, AssertKind, Scan};
use super::types::Shape;

/// The maximum total number of iterations of all loops in a row. llvmpipe silently leaves loops after 65,535 iterations
/// (its `LP_MAX_TGSI_LOOP_ITERATIONS`), so results would be incomplete.
pub(super) const MAX_ROUNDS: u32 = 65_000;
/// The name of the entry point that runs the tests.
pub(super) const ENTRY_POINT: &str = "test_runner_main";
/// The prefix of all identifiers that the instrumentation adds.
pub(super) const PREFIX: &str = "test_runner_";
/// The number of 32-bit words in a row's result. They are state, index of the assert or loop, tolerance and padding,
/// then four words each for the found and the wanted value.
pub(super) const RESULT_WORDS: usize = 12;
/// The state of a row that has passed; the state is 0 before the row ran.
pub(super) const PASSED: u32 = 1;
pub(super) const FAILED: u32 = 2;
pub(super) const ENDLESS: u32 = 3;

/// A test row to run: the index of the test, and of the row in its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) test: usize,
    pub(super) row: usize,
}

/// Returns the name of the variable that stores an argument of an assert, for finding its type. `assert` and `side` are
/// the indices of the assert and of the argument.
pub(super) fn variable(assert: usize, side: usize) -> String {
    format!("{PREFIX}{assert}_{side}")
}

/// Returns the edits that store each assert argument in a variable, so that naga infers its type.
pub(super) fn typed(scan: &Scan) -> Vec<TextEdit> {
    let mut edits = without_attributes(scan);
    for (at, assert) in scan.asserts.iter().enumerate() {
        let begin = |side: usize| match (assert.kind, side) {
            (AssertKind::True, _) => format!("var {}: bool = (", variable(at, side)),
            (_, 2) => format!("var {}: f32 = (", variable(at, side)),
            _ => format!("var {} = (", variable(at, side)),
        };
        edits.extend(rewritten(assert, "{ ", begin, "}"));
    }
    edits
}

/// Returns the edits that make the executable test source, given the argument types of each assert.
pub(super) fn proven(text: &str, scan: &Scan, shapes: &[Option<Shape>], rows: &[Row]) -> Vec<TextEdit> {
    let mut edits = without_attributes(scan);
    for (at, assert) in scan.asserts.iter().enumerate() {
        let shape = shapes.get(at).copied().flatten();
        let ty = shape.map_or_else(|| "bool".to_owned(), Shape::name);
        let begin = |side: usize| match side {
            0 => format!("var test_runner_found: {ty} = ("),
            1 => format!("var test_runner_wanted: {ty} = ("),
            _ => "var test_runner_tolerance: f32 = (".to_owned(),
        };
        let bits = |side: &str| shape.map_or_else(|| "vec4<u32>()".to_owned(), |shape| shape.bits(side));
        let (holds, tolerance) = match assert.kind {
            AssertKind::True => ("test_runner_found".to_owned(), "0u"),
            AssertKind::Equal => ("all(test_runner_found == test_runner_wanted)".to_owned(), "0u"),
            AssertKind::Near => {
                let tolerance = shape.map_or_else(String::new, |shape| shape.named("f32"));
                let difference = "abs(test_runner_found - test_runner_wanted)";
                let holds = format!("all({difference} <= {tolerance}(test_runner_tolerance))");
                (holds, "bitcast<u32>(test_runner_tolerance)")
            }
        };
        let (found, wanted) = match assert.kind {
            AssertKind::True => ("vec4<u32>()".to_owned(), "vec4<u32>()".to_owned()),
            _ => (bits("test_runner_found"), bits("test_runner_wanted")),
        };
        let end = format!("if !({holds}) {{ test_runner_fail({at}u, {tolerance}, {found}, {wanted}); }} }}");
        edits.extend(rewritten(assert, "{ ", begin, &end));
    }
    edits.extend(entry_point(text, scan, rows));
    edits
}

/// Returns the edits that limit the iterations of loops.
pub(super) fn bounds(scan: &Scan) -> Vec<TextEdit> {
    let mut edits = Vec::new();
    for (at, each) in scan.loops.iter().enumerate() {
        let guard = format!(
            " test_runner_rounds++; if test_runner_rounds > {MAX_ROUNDS}u {{ test_runner_endless({at}u); break; }}"
        );
        edits.push(inserted(each.body, guard, each.at.clone()));
    }
    edits
}

fn inserted(at: usize, text: String, origin: Range<usize>) -> TextEdit {
    TextEdit { range: at..at, text, origin }
}

fn without_attributes(scan: &Scan) -> Vec<TextEdit> {
    let gone =
        |range: &Range<usize>| TextEdit { range: range.clone(), text: String::new(), origin: range.clone() };
    scan.attributes.iter().map(gone).collect()
}

/// Replaces the text around an assert's arguments. `start` comes first, `begin` before each argument, `);` after it,
/// and `end` replaces the rest.
fn rewritten(assert: &Assert, start: &str, begin: impl Fn(usize) -> String, end: &str) -> Vec<TextEdit> {
    let mut edits = Vec::new();
    let (mut done, mut before) = (assert.whole.start, start.to_owned());
    for (side, argument) in assert.arguments.iter().enumerate() {
        let text = format!("{before}{}", begin(side));
        edits.push(TextEdit { range: done..argument.start, text, origin: assert.whole.clone() });
        (done, before) = (argument.end, "); ".to_owned());
    }
    let text = format!("{before}{end}");
    edits.push(TextEdit { range: done..assert.whole.end, text, origin: assert.whole.clone() });
    edits
}

/// Returns the edits that append the entry point, which runs the rows.
///
/// Each test has one call site, with the row's values in variables, because drivers compile each call separately. A row
/// counts as passed only after its call returns.
fn entry_point(text: &str, scan: &Scan, rows: &[Row]) -> Vec<TextEdit> {
    let whole = text.len();
    let mut edits = vec![inserted(whole, runner(), whole..whole)];
    let mut add = |text: String, origin: &Range<usize>| edits.push(inserted(whole, text, origin.clone()));
    let mut calls = String::new();
    let mut first = 0;
    for (at, test) in scan.tests.iter().enumerate() {
        let count = rows.iter().filter(|row| row.test == at).count();
        if count == 0 {
            continue;
        }
        add(format!("fn test_runner_test_{at}(test_runner_at: u32) {{\n"), &test.at);
        for (number, ty) in test.parameters.iter().enumerate() {
            add(format!("    var test_runner_argument_{number}: {ty};\n"), &test.at);
        }
        add("    switch test_runner_at {\n".to_owned(), &test.at);
        for (number, row) in test.rows.iter().enumerate() {
            add(format!("        case {number}u: {{"), &row.at);
            for (parameter, argument) in row.arguments.iter().enumerate() {
                let given = text.get(argument.clone()).unwrap_or_default().trim();
                add(format!(" test_runner_argument_{parameter} = ({given});"), argument);
            }
            add(" }\n".to_owned(), &row.at);
        }
        let arguments: Vec<String> =
            (0..test.parameters.len()).map(|number| format!("test_runner_argument_{number}")).collect();
        let (name, arguments) = (&test.name, arguments.join(", "));
        let call = format!("    {name}({arguments});\n    test_runner_end();\n");
        add(format!("        default: {{ return; }}\n    }}\n{call}}}\n"), &test.at);
        let end = first + count;
        calls.push_str(&format!(
            "    if test_runner_row >= {first}u && test_runner_row < {end}u {{ test_runner_test_{at}(test_runner_row - {first}u); }}\n"
        ));
        first = end;
    }
    let main = format!(
        "@compute @workgroup_size(1) fn {ENTRY_POINT}(@builtin(workgroup_id) test_runner_id: vec3<u32>) {{
    test_runner_row = test_runner_id.x;
{calls}}}
"
    );
    add(main, &(whole..whole));
    edits
}

/// Returns WGSL for the state of a row, with functions that record it.
fn runner() -> String {
    format!(
        "
var<private> test_runner_row: u32;
var<private> test_runner_state: u32;
var<private> test_runner_rounds: u32;
@group(0) @binding(0) var<storage, read_write> test_runner_results: array<vec4<u32>>;
fn test_runner_fail(which: u32, tolerance: u32, found: vec4<u32>, wanted: vec4<u32>) {{
    if test_runner_state != 0u {{ return; }}
    test_runner_state = {FAILED}u;
    test_runner_results[test_runner_row * 3u] = vec4<u32>({FAILED}u, which, tolerance, 0u);
    test_runner_results[test_runner_row * 3u + 1u] = found;
    test_runner_results[test_runner_row * 3u + 2u] = wanted;
}}
fn test_runner_end() {{
    if test_runner_state == 0u {{ test_runner_results[test_runner_row * 3u] = vec4<u32>({PASSED}u, 0u, 0u, 0u); }}
}}
fn test_runner_endless(which: u32) {{
    if test_runner_state == {ENDLESS}u {{ return; }}
    test_runner_state = {ENDLESS}u;
    test_runner_results[test_runner_row * 3u] = vec4<u32>({ENDLESS}u, which, 0u, 0u);
}}
"
    )
}
