//! Remarks that `check` prints below its line about a pipeline: what the plan does not use, and what is left to
//! `permutations`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use umbragraph::low_level::session::Surveyed;

use crate::arguments::Files;

/// The maximum number of names in a line.
const NAMES: usize = 8;

/// Returns the number of reachable configurations that `check` has not checked.
pub(crate) fn left(covered: &Surveyed) -> u64 {
    let Some(reachable) = covered.reachable else { return 0 };
    let checked = covered.configurations.list.len() as u128;
    u64::try_from(reachable.number.saturating_sub(checked)).unwrap_or(u64::MAX)
}

/// The greatest number of configurations that is printed digit by digit.
const COUNTED: u64 = 1_000_000_000;

/// Returns the remarks on a pipeline, one indented line for each; empty if there are none. `files` are the options that
/// the commands in the remarks need as well.
pub(crate) fn lines(path: &Path, files: &Files, covered: &Surveyed) -> String {
    let remarks = &covered.coverage.remarks;
    let mut text = String::new();
    let culled = remarks.culled.iter().map(|(_, reason)| reason.clone());
    list(&mut text, "culled", "; ", culled);
    let small = remarks.small_dispatches.iter().map(|(pass, [x, y], texture, [width, height])| {
        format!("{pass} has {x} by {y} for {texture} of {width} by {height}")
    });
    list(&mut text, "dispatches with fewer invocations than texels that they write", "; ", small);
    let entries = remarks.entry_points.iter().map(|(template, name)| format!("{name} of {template}"));
    list(&mut text, "entry points that no pass runs", ", ", entries);
    list(&mut text, "parameters without effect here", ", ", remarks.parameters.iter().cloned());
    let left = left(covered);
    if left > 0 {
        let exact = covered.reachable.is_some_and(|reachable| reachable.exact);
        let number = match left {
            COUNTED.. => format!("more than 10^{}", left.ilog10()),
            left if exact => left.to_string(),
            left => format!("at least {left}"),
        };
        let options = options(files);
        let _ = writeln!(
            text,
            "  not checked: {number} configurations with other values of parameters that reach other shaders or \
             passes; `umbragraph permutations {path}{options}` proves their shaders, and `umbragraph check \
             {path}{options} --set NAME=VALUE` the plan of one",
            path = path.display()
        );
    }
    text
}

/// Returns the options for files as on the command line, with a space before each.
fn options(files: &Files) -> String {
    let named = |name: &'static str, paths: &[PathBuf]| -> String {
        paths.iter().map(|path| format!(" {name} {}", path.display())).collect()
    };
    named("--extension", &files.extension)
        + &named("--templates", files.templates.as_slice())
        + &named("--root", &files.root)
}

fn list(text: &mut String, what: &str, between: &str, names: impl ExactSizeIterator<Item = String>) {
    let number = names.len();
    if number == 0 {
        return;
    }
    let shown: Vec<String> = names.take(NAMES).collect();
    let more = if number > NAMES { format!("{between}and {} more", number - NAMES) } else { String::new() };
    let _ = writeln!(text, "  {what}: {}{more}", shown.join(between));
}
