//! A plan as tables that a person reads: passes in their order, then resources, then memory.
//!
//! Culled passes stand where they would run, with the reason in short. Passes are numbered from 1, and the resources
//! name the passes that use them by these numbers.

use std::fmt::Write as _;

use umbragraph_pipeline::diagnostic::counted;
use umbragraph_pipeline::language::Lifetime;

use super::model::{PassReport, Report, ResourceReport, bytes_in_words};
use super::settings::word;

/// Renders the tables of a plan. The text has no escape sequences, and lines are as long as the names in them need.
pub fn table(report: &Report) -> String {
    let [width, height] = report.viewport;
    let live = report.live_passes();
    let culled = report.passes.len() - live;
    let resources = report.resources.iter().filter(|one| one.live).count();
    let order = match report.objective.as_str() {
        "declaration" => "in declared order".to_owned(),
        other => format!("ordered for {other}"),
    };
    let mut text = format!(
        "{}: {width}×{height}, {} ({culled} culled), {}, {order}\n\n",
        report.pipeline,
        counted(live, "pass"),
        counted(resources, "resource"),
    );
    let numbers = numbers(report);
    rows(&mut text, ["", "pass", "kind", "reads → writes"], passes(report, &numbers));
    text.push('\n');
    let resources = report.resources.iter().filter(|one| one.live);
    let resources = resources.map(|one| resource(one, &numbers));
    rows(&mut text, ["resource", "what", "bytes", "memory", "passes"], resources.collect());
    let memory = &report.memory;
    let [created, apart, peak] = [memory.created, memory.without_aliasing, memory.peak].map(bytes_in_words);
    if report.resources.iter().any(|one| one.live && !one.shares_with.is_empty()) {
        text.push_str("\nResources with one number under \"memory\" share it.");
    }
    let _ = writeln!(text, "\n{created} created ({apart} without aliasing), {peak} alive at most");
    text
}

/// Returns the number of each column's pass, from 1; `None` for a culled pass.
fn numbers(report: &Report) -> Vec<Option<usize>> {
    let mut number = 0;
    let mut next = |pass: &PassReport| {
        pass.live.then(|| {
            number += 1;
            number
        })
    };
    report.passes.iter().map(&mut next).collect()
}

fn passes(report: &Report, numbers: &[Option<usize>]) -> Vec<[String; 4]> {
    let mut before = None;
    let row = |(pass, number): (&PassReport, &Option<usize>)| {
        let Some(number) = number else {
            let reason = pass.why.first().map_or("", String::as_str);
            return ["-".to_owned(), pass.name.clone(), pass.kind.clone(), format!("culled: {reason}")];
        };
        let or_nothing = |names: &[String]| match names {
            [] => "nothing".to_owned(),
            names => names.join(", "),
        };
        let mut what = format!("{} → {}", or_nothing(&pass.reads), or_nothing(&pass.writes));
        if let Some(toggle) = &pass.toggle {
            let _ = write!(what, " (toggle {toggle})");
        }
        if before.replace(pass.group) == Some(pass.group) && pass.work == "draw" {
            what.push_str(" (same render pass as the pass above)");
        }
        [number.to_string(), pass.name.clone(), pass.kind.clone(), what]
    };
    report.passes.iter().zip(numbers).map(row).collect()
}

fn resource(resource: &ResourceReport, numbers: &[Option<usize>]) -> [String; 5] {
    let used = resource.columns.map(|column| numbers.get(column).copied().flatten());
    let passes = match used {
        [Some(first), Some(last)] if first != last => format!("{first} to {last}"),
        [Some(one), _] | [None, Some(one)] => one.to_string(),
        [None, None] => String::new(),
    };
    let what = match resource.description.as_str() {
        "" => resource.kind.clone(),
        what => what.to_owned(),
    };
    let bytes = if resource.bytes == 0 { String::new() } else { bytes_in_words(resource.bytes) };
    let lifetime = match resource.lifetime {
        Lifetime::Transient | Lifetime::Imported => String::new(),
        other => format!(", {}", word(&other)),
    };
    let shared = if resource.shares_with.is_empty() { "" } else { ", shared" };
    let place = format!("{}{lifetime}{shared}", resource.place);
    [resource.name.clone(), what, bytes, place, passes]
}

/// Adds a table with aligned columns. The last column is not padded.
fn rows<const N: usize>(text: &mut String, head: [&str; N], rows: Vec<[String; N]>) {
    let head = head.map(str::to_owned);
    let mut widths = [0; N];
    for row in std::iter::once(&head).chain(&rows) {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    for row in std::iter::once(&head).chain(&rows) {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        let line = cells.collect::<Vec<_>>().join("  ");
        let _ = writeln!(text, "{}", line.trim_end());
    }
}
