//! `cargo xtask test`: runs every step, also after one has failed, and sums up.

use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Instant;

use crate::steps::{Step, steps};
use crate::summary::{Outcome, all_passed, summary};
use crate::{adapter, process, skips, toolchain};

/// Runs the command.
pub(crate) fn run() -> ExitCode {
    let adapter = adapter::ensure();
    if !adapter {
        eprintln!(
            "tests that need a graphics adapter will be skipped, or fail under UMBRAGRAPH_REQUIRE_GPU=1"
        );
    }
    let nextest = toolchain::has_nextest();
    if !nextest {
        println!("cargo-nextest is not installed; the tests run with cargo test");
    }
    let wasm = toolchain::has_wasm();
    if !wasm {
        println!("what browsers run is not checked: rustup target add wasm32-unknown-unknown");
    }
    let target = process::target_folder();
    let log = skips::new_log(&target);
    let variables = vec![(OsString::from(skips::VARIABLE), OsString::from(&log))];
    let outcomes: Vec<Outcome> = steps(nextest, wasm).iter().map(|step| run_step(step, &variables)).collect();
    println!("\n{}", summary(&outcomes, &skips::report(&log)).trim_end());
    if all_passed(&outcomes) { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

fn run_step(step: &Step, variables: &[(OsString, OsString)]) -> Outcome {
    println!("\n==> {}: {}", step.name, step.command_line());
    let start = Instant::now();
    let failure = step.needs.and_then(toolchain::Component::missing).or_else(|| {
        let mut command = process::program("cargo");
        command.args(&step.arguments).envs(step.environment.iter().copied());
        command.envs(variables.iter().map(|(name, value)| (name, value)));
        process::run(&mut command, "cargo").err()
    });
    let elapsed = start.elapsed();
    match &failure {
        None => println!("<== {}: passed in {:.1} s", step.name, elapsed.as_secs_f64()),
        Some(reason) => println!("<== {}: FAILED in {:.1} s: {reason}", step.name, elapsed.as_secs_f64()),
    }
    Outcome { name: step.name, elapsed, failure }
}
