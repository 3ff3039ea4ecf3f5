//! The time of an answer after an edit: all diagnostics of loading and planning one configuration in a session.
//!
//! A string of `pipelines/awsm.json` becomes another, or a comment is added, or one of 10,000 passes changes. No shader
//! text changes, so that every module is there. Lines `ratio NAME VALUE` are ours divided by what is aimed at (20 ms for a
//! string, 2 ms for a comment, 100 ms for 10,000 passes). Times are the minimum of several runs; each is another edit.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::session::{Choice, Session, Target};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::{DiskStorage, with_templates};

const RUNS: usize = 15;

fn main() {
    let awsm = std::fs::read_to_string("pipelines/awsm.json").expect("the workspace is the working folder");
    let string = |at: usize| awsm.replacen("\"name\": \"", &format!("\"name\": \"x{at}"), 1);
    let comment = |at: usize| format!("// {at}\n{awsm}");
    let many = chain(10_000);
    let pass = |at: usize| many.replacen("one of a chain", &format!("one of {at}"), 1);
    println!("{:<12} {:>10} {:>10}", "edit", "first ms", "ms");
    edits("string", "pipelines/awsm.json", &awsm, &string, 20);
    edits("comment", "pipelines/awsm.json", &awsm, &comment, 2);
    edits("10000_passes", "chain.json", &many, &pass, 100);
}

/// Prints the time of the first answer and the least of those after edits, and the ratio to what is aimed at.
fn edits(name: &str, path: &str, text: &str, edit: &dyn Fn(usize) -> String, aim_ms: u64) {
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
    println!("{name:<12} {:>10.3} {:>10.3}", millis(first), millis(time));
    println!("ratio session/{name} {:.3}", millis(time) / aim_ms as f64);
}

/// A chain of full-screen passes, each of which reads what the one before it wrote.
fn chain(count: usize) -> String {
    let (mut resources, mut passes) = (String::new(), String::new());
    for at in 0..count {
        let last = at + 1 == count;
        let to = if last { "target".to_owned() } else { format!("r{at}") };
        if !last {
            let format = "\"format\": \"rgba8unorm\", \"size\": \"=viewport\"";
            let _ = writeln!(resources, "    \"{to}\": {{ \"texture\": {{ {format} }} }},");
        }
        let shader = match at.checked_sub(1) {
            None => "\"shader\": \"gradient.wgsl.jinja\"".to_owned(),
            Some(before) => format!(
                "\"shader\": \"tonemap.wgsl.jinja\", \"axes\": {{ \"debug_view\": \"shadow_term\" }}, \
                 \"bind\": {{ \"source\": \"&r{before}\" }}"
            ),
        };
        let comma = if last { "" } else { "," };
        let _ = writeln!(
            passes,
            "    \"p{at}\": {{ \"description\": \"one of a chain\", \
             \"fullscreen\": {{ {shader}, \"color\": [{{ \"to\": \"&{to}\" }}] }} }}{comma}"
        );
    }
    let target =
        r#""target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#;
    format!(
        "{{\n  \"format\": 1, \"name\": \"chain\",\n  \"resources\": {{\n{resources}    {target}\n  }},\n  \"passes\": {{\n{passes}  }}\n}}\n"
    )
}
