//! One variant of a file of tests: proven, run with each set of values of its overrides, and judged.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph::diagnostic::{Diagnostic, codes as engine};
use umbragraph::low_level::shader::permutations::{Request, Variant};
use umbragraph::low_level::shader::{AxisKind, AxisMode, AxisValue, AxisValues, TargetProfile, TemplateSet};
use umbragraph::low_level::source::Span;

use super::device::{self, Failure};
use super::instrument::{self, PREFIX, Row};
use super::outcome::{self, Shown};
use super::running::{Run, STACK_BYTES, TestCount};
use super::scan::{AssertKind, Scan, scan};
use super::types::{self, Shape};
use crate::codes;

/// The maximum number of values of one `override` constant that are all tried. If there are more, only the ends and the
/// default are tried.
const MAX_VALUES: u64 = 16;
/// The maximum number of sets of `override` values for one shader source.
const MAX_SETS: usize = 64;
/// The maximum number of rows in one pass, which every device can dispatch.
const MAX_ROWS: usize = 65_535;

/// A tested variant: its axis values, and its diagnostics.
pub(super) type Judged = (AxisValues, Vec<Diagnostic>);

/// Runs the tests of one shader source with all sets of `override` values, until a time limit is exceeded. Adds the
/// counts to `tests`.
pub(super) fn judge(
    run: &Run<'_>,
    requests: &[&Request],
    variant: &Variant,
    tests: &mut BTreeMap<String, TestCount>,
) -> Vec<Judged> {
    let scan = scan(variant.wgsl());
    let alone = |diagnostics: Vec<Diagnostic>| vec![(variant.axes.as_ref().clone(), diagnostics)];
    let mut broken = outcome::problems(variant, &scan);
    let rows = rows(&scan, run.filter);
    if rows.is_empty() && broken.is_empty() {
        return alone(Vec::new());
    }
    if broken.is_empty() && rows.len() > MAX_ROWS {
        let message = format!("{} rows are more than the {MAX_ROWS} that one pass can have", rows.len());
        let help = "split the table over two files, or leave rows out";
        let first = rows.first().and_then(|row| scan.tests.get(row.test));
        let place = first.and_then(|test| variant.map().span(test.at.clone()));
        broken.extend(place.map(|place| Diagnostic::error(codes::TEST_INVALID, place, message).help(help)));
    }
    // What ran, with what is wrong: of one test, or of all.
    let mut count = |found: &[(Option<String>, Diagnostic)]| {
        let mut names = BTreeSet::new();
        for test in rows.iter().filter_map(|row| scan.tests.get(row.test)) {
            let own = tests.entry(test.name.clone()).or_default();
            own.variants += usize::from(names.insert(&test.name));
            own.rows = own.rows.max(test.rows.len());
            let is_own = |(of, _): &&(Option<String>, _)| of.as_ref().is_none_or(|name| *name == test.name);
            own.messages
                .extend(found.iter().filter(is_own).map(|(_, diagnostic)| diagnostic.message.clone()));
        }
    };
    let of_all = |diagnostics: Vec<Diagnostic>| -> Vec<_> {
        diagnostics.into_iter().map(|diagnostic| (None, diagnostic)).collect()
    };
    let prepared = if broken.is_empty() { prepare(run, variant, &scan) } else { Err(broken) };
    let (shapes, declared) = match prepared {
        Ok(prepared) => prepared,
        Err(diagnostics) => {
            count(&of_all(diagnostics.clone()));
            return alone(diagnostics);
        }
    };
    let mut edits = instrument::proven(variant.wgsl(), &scan, &shapes, &rows);
    let proven = variant.edited(&edits);
    edits.extend(instrument::bounds(&scan));
    let bounded = variant.edited(&edits);
    let shown = Shown { variant, scan: &scan, shapes: &shapes, rows: &rows };
    let mut judged = Vec::new();
    let sets: BTreeSet<AxisValues> =
        requests.iter().flat_map(|request| sets(run.templates, request, variant, &declared)).collect();
    for values in sets {
        let found = match proven.prove(run.templates, &values, &TargetProfile::webgpu()) {
            Err(diagnostics) => of_all(diagnostics),
            Ok(module) => {
                match device::run(run.graphics, bounded.wgsl(), &module.constants, rows.len(), run.limit) {
                    Ok(results) => {
                        let named = |(name, diagnostic)| (Some(name), diagnostic);
                        shown.failures(&results).into_iter().map(named).collect()
                    }
                    Err(Failure::Device(diagnostic)) => vec![(None, *diagnostic)],
                    Err(Failure::TimedOut) => {
                        run.has_timed_out.set(true);
                        vec![(None, outcome::timed_out(variant, &scan, &rows, run.limit))]
                    }
                }
            }
        };
        count(&found);
        let mut axes = variant.axes.as_ref().clone();
        axes.extend(values);
        judged.push((axes, found.into_iter().map(|(_, diagnostic)| diagnostic).collect()));
        if run.has_timed_out.get() {
            break;
        }
    }
    judged
}

/// Returns the rows of the tests whose names contain the filter; `None` selects all.
fn rows(scan: &Scan, filter: Option<&str>) -> Vec<Row> {
    let is_wanted = |name: &str| filter.is_none_or(|part| name.contains(part));
    let tests = scan.tests.iter().enumerate().filter(|(_, test)| is_wanted(&test.name));
    tests.flat_map(|(test, each)| (0..each.rows.len()).map(move |row| Row { test, row })).collect()
}

/// The types that asserts compare (`None` if unknown), and the names of the `override` constants.
type Prepared = (Vec<Option<Shape>>, BTreeSet<String>);

/// Finds the argument types of asserts. Fails for tests that use bound resources.
fn prepare(run: &Run<'_>, variant: &Variant, scan: &Scan) -> Result<Prepared, Vec<Diagnostic>> {
    let typed = variant.edited(&instrument::typed(scan));
    let module = typed.prove(run.templates, &AxisValues::new(), &TargetProfile::webgpu())?;
    let parsed = parsed(&module.wgsl).map_err(|error| {
        let message = format!("the text of the tests cannot be read again: {error}");
        vec![Diagnostic::error(engine::DEVICE, place_of_file(variant), message)]
    })?;
    let mut problems = Vec::new();
    for test in &scan.tests {
        let bound = types::bindings(&parsed, &test.name);
        if let (Some(first), Some(place)) = (bound.first(), variant.map().span(test.at.clone())) {
            let message =
                format!("the test `{}` reaches the binding `{first}`, which tests do not have", test.name);
            let help = "test a function that takes the value as an argument, or leave out the call";
            problems.push(Diagnostic::error(codes::TEST_INVALID, place, message).help(help));
        }
    }
    let known = types::variables(&parsed, PREFIX);
    let mut shapes = Vec::new();
    for (at, assert) in scan.asserts.iter().enumerate() {
        if assert.kind == AssertKind::True {
            shapes.push(None);
            continue;
        }
        let side = |side: usize| known.get(&instrument::variable(at, side));
        let shape = match (side(0), side(1)) {
            (Some(Ok(found)), Some(Ok(wanted))) => types::common(*found, *wanted)
                .ok_or_else(|| format!("{} cannot be compared with {}", found.name(), wanted.name())),
            (Some(Err(other)), _) | (_, Some(Err(other))) => Err(format!("{other} cannot be compared")),
            _ => Err("the types of both sides are not known".to_owned()),
        };
        let shape = shape.and_then(|shape| match (assert.kind, shape.kind) {
            (AssertKind::Near, naga::ScalarKind::Float) | (AssertKind::Equal, _) => Ok(shape),
            _ => Err(format!("`expect_near` compares floats, and this is {}", shape.name())),
        });
        match shape {
            Ok(shape) => shapes.push(Some(shape)),
            Err(message) => {
                shapes.push(None);
                let place = variant.map().span(assert.whole.clone());
                let help =
                    "compare scalars or vectors of one type; of a matrix or structure its columns or members";
                problems.extend(
                    place.map(|place| Diagnostic::error(codes::TEST_INVALID, place, message).help(help)),
                );
            }
        }
    }
    if problems.is_empty() { Ok((shapes, types::overrides(&parsed))) } else { Err(problems) }
}

/// Parses a shader source that naga has already validated.
fn parsed(text: &str) -> Result<naga::Module, String> {
    std::thread::scope(|scope| {
        let parse = || naga::front::wgsl::parse_str(text).map_err(|error| error.to_string());
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, parse);
        let joined = thread.map_err(|error| error.to_string())?.join();
        joined.unwrap_or_else(|_| Err("naga failed".to_owned()))
    })
}

fn place_of_file(variant: &Variant) -> umbragraph::diagnostic::Place {
    let first: Option<Span> = variant.map().pieces().find_map(|(_, span)| span);
    first.map_or(umbragraph::diagnostic::Place::Nowhere, Into::into)
}

/// Returns the sets of `override` values to test: all combinations, or one value at a time if there are more than
/// [`MAX_SETS`] combinations. Sets that violate a constraint are left out.
fn sets(
    templates: &TemplateSet,
    request: &Request,
    variant: &Variant,
    declared: &BTreeSet<String>,
) -> Vec<AxisValues> {
    let Some(axes) = templates.axes(&request.template) else { return vec![AxisValues::new()] };
    let overrides =
        axes.iter().filter(|axis| axis.mode == AxisMode::Override && declared.contains(&axis.name));
    let mut sets = vec![AxisValues::new()];
    let mut alone = vec![AxisValues::new()];
    for axis in overrides {
        let allowed = request.allowed.get(&axis.name).cloned();
        let all = || match &axis.kind {
            AxisKind::Bool => vec![false.into(), true.into()],
            AxisKind::Integer { min, max } if axis.kind.count() <= MAX_VALUES => {
                (*min..=*max).map(AxisValue::Integer).collect()
            }
            AxisKind::Integer { min, max } => vec![AxisValue::Integer(*min), AxisValue::Integer(*max)],
            AxisKind::Enum(_) | AxisKind::TextureFormat(_) => Vec::new(),
        };
        let mut values: BTreeSet<AxisValue> = allowed.unwrap_or_else(all).into_iter().collect();
        if values.len() as u64 > MAX_VALUES {
            values = [values.first(), values.last()].into_iter().flatten().cloned().collect();
        }
        if request.allowed.get(&axis.name).is_none_or(|allowed| allowed.contains(&axis.default)) {
            values.insert(axis.default.clone());
        }
        let with = |set: &AxisValues, value: &AxisValue| {
            let mut set = set.clone();
            set.insert(axis.name.clone(), value.clone());
            set
        };
        sets = sets
            .iter()
            .flat_map(|set| values.iter().map(|value| with(set, value)))
            .take(MAX_SETS + 1)
            .collect();
        alone.extend(values.iter().map(|value| with(&AxisValues::new(), value)));
    }
    if sets.len() > MAX_SETS {
        sets = alone;
    }
    let mut complete = axes.defaults();
    complete.extend(variant.axes.as_ref().clone());
    sets.retain(|set| {
        let mut values = complete.clone();
        values.extend(set.clone());
        axes.violated(&values).next().is_none()
    });
    sets
}
