//! `cargo xtask test`: runs every step, even after a failure, and prints a summary.

use std::path::Path;
use std::time::Instant;

use crate::steps::{Step, steps};
use crate::summary::{Outcome, all_passed, summary};
use crate::{adapter, drivers, process, skips, toolchain};

/// Runs all checks and tests, and prints a summary. Returns `true` if every step succeeded.
pub(crate) fn run() -> Result<bool, String> {
    if !adapter::ensure() {
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
    let second = drivers::swiftshader();
    if second.is_none() {
        println!("nothing is drawn on a second driver of Vulkan: install chromium, which brings SwiftShader");
    }
    let log = skips::new_log(&process::target_folder());
    let outcomes: Vec<Outcome> =
        steps(nextest, wasm, second).iter().map(|step| run_step(step, &log)).collect();
    println!("\n{}", summary(&outcomes, &skips::report(&log)).trim_end());
    Ok(all_passed(&outcomes))
}

fn run_step(step: &Step, log: &Path) -> Outcome {
    println!("\n==> {}: {}", step.name, step.command_line());
    let start = Instant::now();
    let failure = step.needs.and_then(toolchain::Component::missing).or_else(|| {
        let mut command = process::program("cargo");
        command.args(&step.arguments).envs(step.environment.iter().copied());
        command.env(skips::VARIABLE, log);
        process::run(&mut command, "cargo").err()
    });
    let elapsed = start.elapsed();
    match &failure {
        None => println!("<== {}: passed in {:.1} s", step.name, elapsed.as_secs_f64()),
        Some(reason) => println!("<== {}: FAILED in {:.1} s: {reason}", step.name, elapsed.as_secs_f64()),
    }
    Outcome { name: step.name, elapsed, failure }
}
