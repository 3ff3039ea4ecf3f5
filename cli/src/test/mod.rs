//! `umbragraph test`: functions of templates, tested on an adapter.
//!
//! A file of tests (`find`) is a template. Each of its variants is a text in which tests, their tables and asserts are
//! found (`scan`) and rewritten to WGSL (`instrument`, `types`); naga proves it, and one compute pass runs all rows
//! (`variant`, `device`). A failed row becomes a diagnostic at its assert (`outcome`), one for all variants that show
//! it.
//!
//! Limits: tests have no bindings, and no derivatives, since they run in a compute stage. An override with more than 16
//! values is tried at its ends and its default; of more than 64 combinations of overrides each is tried by itself.

mod device;
mod find;
mod instrument;
mod outcome;
mod report;
mod requests;
mod running;
mod scan;
mod tokens;
mod types;
mod variant;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::time::Duration;

use umbragraph::diagnostic::{Diagnostic, Place, codes as engine};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::shader::permutations::{Request, Variant, root_causes, variants};

use crate::arguments::TestArguments;
use crate::device::Graphics;
use crate::session::Session;
use crate::{codes, interrupt};
use running::{FileCount, Run};

/// Runs shader tests. Returns `true` if all passed.
pub(crate) fn run(arguments: &TestArguments) -> bool {
    let found = find::find(arguments);
    let mut session = Session::with_more(&arguments.files, |known| find::templates(&found.files, known));
    session.diagnostics.extend(found.diagnostics);
    let mut requests: BTreeMap<String, Vec<Request>> = BTreeMap::new();
    for path in &found.pipelines {
        // Without a file there is nothing to load a pipeline for.
        if found.files.is_empty()
            || requests::of_pipeline(&mut session, path, &found.files, &mut requests) == Some(0)
        {
            let why = match arguments.files.templates {
                Some(_) => {
                    "no file of tests in the folder of --templates includes a template that its passes use"
                }
                None => "they are looked for in the folder of --templates, which is not given",
            };
            session.diagnostics.push(find::nothing(&path.to_string_lossy(), why));
        }
    }
    for file in found.files.iter().filter(|file| file.is_named) {
        requests.insert(file.name.clone(), vec![Request::all(&file.name, &[TargetProfile::webgpu()])]);
    }
    session.quiet(arguments.format.is_data());
    let mut counts = Vec::new();
    let mut adapter = String::new();
    let mut has_timed_out = false;
    if !session.diagnostics.has_errors() {
        match crate::device::open(arguments.drawn.adapter.as_deref()) {
            Ok(graphics) if !graphics.has_compute() => {
                let message = format!("{} has no compute shaders, in which tests run", graphics.name);
                let diagnostic = Diagnostic::error(engine::DEVICE_LIMIT, Place::Nowhere, message);
                let help = "choose another adapter (--adapter); `umbragraph adapters` lists them";
                session.diagnostics.push(diagnostic.help(help));
            }
            Ok(graphics) => {
                adapter.clone_from(&graphics.name);
                (counts, has_timed_out) = run_all(arguments, &mut session, &graphics, &requests);
                if has_timed_out {
                    // It would wait for what does not end.
                    std::mem::forget(graphics);
                }
            }
            Err(diagnostic) => session.diagnostics.push(diagnostic),
        }
    }
    let is_fine = report::report(arguments.format, &mut session, &counts, &adapter);
    if has_timed_out {
        interrupt::leave(1);
    }
    is_fine
}

/// Runs all test files. Returns the counts for each file, and `true` if a pass did not end in time.
fn run_all(
    arguments: &TestArguments,
    session: &mut Session,
    graphics: &Graphics,
    requests: &BTreeMap<String, Vec<Request>>,
) -> (Vec<FileCount>, bool) {
    let templates = session.templates.clone();
    let run = Run {
        templates: &templates,
        graphics,
        filter: arguments.filter.as_deref(),
        limit: Duration::from_secs(arguments.timeout),
        has_timed_out: Cell::new(false),
    };
    let mut counts = Vec::new();
    for (name, requests) in requests {
        let (count, diagnostics) = run_file(&run, name, requests);
        if count.tests.is_empty() && diagnostics.is_empty() && run.filter.is_none() {
            session.diagnostics.push(find::nothing(name, "no function has the attribute `@test`"));
        }
        session.diagnostics.extend(diagnostics);
        counts.push(count);
        if run.has_timed_out.get() {
            break;
        }
    }
    let has_run = counts.iter().any(|file| !file.tests.is_empty());
    if let Some(filter) = run.filter.filter(|_| !has_run && !session.diagnostics.has_errors()) {
        let message = format!("no test has a name with \"{filter}\" in it, as --filter asks for");
        let diagnostic = Diagnostic::error(codes::TEST_INVALID, Place::Nowhere, message);
        session.diagnostics.push(diagnostic.help("leave out --filter to run all"));
    }
    (counts, run.has_timed_out.get())
}

fn run_file(run: &Run<'_>, name: &str, requests: &[Request]) -> (FileCount, Vec<Diagnostic>) {
    let mut count = FileCount { name: name.to_owned(), tests: BTreeMap::new() };
    let (mut judged, mut diagnostics) = (Vec::new(), Vec::new());
    // Requests that share a text can differ in the values of its overrides.
    let mut texts: BTreeMap<String, (Variant, Vec<&Request>)> = BTreeMap::new();
    for request in requests {
        let (variants, failures) = variants(run.templates, request);
        diagnostics.extend(failures);
        for variant in variants {
            let text = variant.wgsl().to_owned();
            texts.entry(text).or_insert_with(|| (variant, Vec::new())).1.push(request);
        }
    }
    for (variant, requests) in texts.values() {
        if !run.has_timed_out.get() {
            judged.extend(variant::judge(run, requests, variant, &mut count.tests));
        }
    }
    let whole = Request::all(name, &[TargetProfile::webgpu()]);
    diagnostics.extend(root_causes(run.templates, &whole, &judged));
    (count, diagnostics)
}
