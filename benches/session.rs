//! The time of an answer after an edit: all diagnostics of loading and planning one configuration in a session.
//!
//! A string of `pipelines/awsm.json` becomes another, or a comment is added, or one of 10,000 passes changes. No shader
//! text changes, so that every module is there. Lines `ratio NAME VALUE` are ours divided by what is aimed at (20 ms
//! for a string, 2 ms for a comment, 100 ms for 10,000 passes). Times are the minimum of several runs; each is another
//! edit. The lines after them time each step of an answer that reads everything again.

use std::sync::Arc;
use std::time::{Duration, Instant};

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{self, PlanOptions};
use umbragraph::low_level::pipeline::{LoadOptions, Overrides, check_schema, load};
use umbragraph::low_level::session::{Choice, Session, Target};
use umbragraph::low_level::shader::{ShaderCache, TargetProfile};
use umbragraph::{DiskStorage, with_templates};

#[path = "chain.rs"]
mod chain;
#[path = "measure.rs"]
mod measure;

const RUNS: usize = 15;

fn main() {
    let awsm = std::fs::read_to_string("pipelines/awsm.json").expect("the workspace is the working folder");
    let string = |at: usize| awsm.replacen("\"name\": \"", &format!("\"name\": \"x{at}"), 1);
    let comment = |at: usize| format!("// {at}\n{awsm}");
    let many = chain::chain(10_000);
    let pass = |at: usize| many.replacen("one of a chain", &format!("one of {at}"), 1);
    let edited = [
        edits("one string of `awsm.json`", "pipelines/awsm.json", &awsm, &string, 20),
        edits("a comment of `awsm.json`", "pipelines/awsm.json", &awsm, &comment, 2),
        edits("one pass of 10,000", "chain.json", &many, &pass, 100),
    ];
    let heads =
        ["edit", "first answer", "answer after an edit", "aim", "read", "compose", "schema", "load", "plan"];
    measure::table(heads, &edited);
}

/// Returns a table row: name, time of the first answer, shortest time after edits, target time, and times of the steps.
fn edits(name: &str, path: &str, text: &str, edit: &dyn Fn(usize) -> String, aim_ms: u64) -> [String; 9] {
    let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
    let target = Target::new(path);
    let choice = Choice::new(TargetProfile::webgpu(), PlanOptions::new(1280, 720));
    let mut answer = |text: &str| {
        let start = Instant::now();
        session.overlay(path, text.as_bytes());
        let (planned, diagnostics) = session.plan(&target, &choice).expect("nothing cancels");
        let time = start.elapsed();
        assert!(planned.report.plan.is_some() && !diagnostics.has_errors(), "{diagnostics:?}");
        time
    };
    let first = answer(text);
    let time = (0..RUNS).map(|at| answer(&edit(at))).min().unwrap_or_default();
    let millis = |time: Duration| time.as_secs_f64() * 1e3;
    println!("ratio session/{} {:.3}", name.replace(' ', "_"), millis(time) / aim_ms as f64);
    let [read, composed, checked, typed, planned] = steps(path, text, edit).map(shown);
    let name = name.to_owned();
    let [first, time] = [first, time].map(|time| shown(millis(time)));
    [name, first, time, format!("{aim_ms} ms"), read, composed, checked, typed, planned]
}

/// Formats milliseconds with about two significant digits.
fn shown(millis: f64) -> String {
    let digits = if millis < 1.0 { 2 } else { usize::from(millis < 10.0) };
    format!("{millis:.digits$} ms")
}

/// Returns the shortest time of each step of an answer, in milliseconds.
fn steps(path: &str, text: &str, edit: &dyn Fn(usize) -> String) -> [f64; 5] {
    let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
    let (target, profile) = (Target::new(path), TargetProfile::webgpu());
    let shaders = Arc::new(ShaderCache::new(&session.templates(), &profile));
    let mut least = [f64::INFINITY; 5];
    session.overlay(path, text.as_bytes());
    for at in 0..RUNS {
        let edited = edit(RUNS + at);
        let mut clock = Instant::now();
        let mut step = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64() * 1e3;
        session.overlay(path, edited.as_bytes());
        let read = step();
        let loaded = session.load_exactly(&target).expect("nothing cancels");
        let composed = step();
        let (document, sources) = (loaded.document().expect("a document"), loaded.sources());
        let mut diagnostics = Diagnostics::new();
        step();
        let schema = check_schema(document, loaded.registry());
        let checked = step();
        let overrides = Overrides::default();
        let options = LoadOptions {
            schema: Some(&schema),
            ..LoadOptions::new(loaded.registry(), &shaders, &overrides)
        };
        let pipeline = Arc::new(load(document, &options, sources, &mut diagnostics).expect("a pipeline"));
        let typed = step();
        let graph = compiler::build(&pipeline, &mut diagnostics).expect("a graph");
        let plan = compiler::plan(&pipeline, &graph, &PlanOptions::new(1280, 720), sources, &mut diagnostics);
        let planned = step();
        assert!(plan.is_some(), "{diagnostics:?}");
        for (least, time) in least.iter_mut().zip([read, composed, checked, typed, planned]) {
            *least = least.min(time);
        }
    }
    least
}
