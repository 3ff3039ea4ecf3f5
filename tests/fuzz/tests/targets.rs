//! Some inputs of each target that is a function, and each way of failing, which is noticed.

use std::path::Path;
use std::process::{Command, Output};

use umbragraph_test_support::scratch::ScratchFolder;

fn worker(target: &str, [first, count]: [u64; 2], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph-fuzz"));
    command.args(["worker", target, &first.to_string(), &count.to_string()]).arg(folder);
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")).output().unwrap()
}

fn takes(target: &str, count: u64) {
    let folder = ScratchFolder::new(&format!("fuzz-{target}"));
    let output = worker(target, [0, count], &folder);
    let said = String::from_utf8_lossy(&output.stdout);
    // Time is asked for by `cargo xtask fuzz` alone: other tests run beside this one.
    let failed: Vec<&str> = said.lines().filter(|line| !line.contains(" took ")).collect();
    assert!(failed.is_empty() && matches!(output.status.code(), Some(0 | 1)), "{said}{output:?}");
}

#[test]
fn some_documents_are_taken() {
    takes("documents", 40);
    takes("overlays", 20);
    takes("parameters", 40);
}

#[test]
fn some_templates_are_taken() {
    takes("templates", 20);
}

#[test]
fn some_expressions_and_cameras_are_taken() {
    takes("expressions", 2_000);
    takes("cameras", 200);
}

#[test]
fn some_scenes_and_images_are_taken() {
    takes("scenes", 20);
    takes("images", 200);
}

#[test]
fn panics_and_slow_inputs_are_told_by_number() {
    let folder = ScratchFolder::new("fuzz-planted");
    let output = worker("planted", [60, 20], &folder);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let panicked = said.lines().find(|line| line.ends_with(": planted")).unwrap();
    let number = panicked.split(' ').nth(1).unwrap();
    assert_eq!(std::fs::read_to_string(folder.join(number)).unwrap().len(), 2, "{said}");
    assert!(!cfg!(unix) || said.contains(" took "), "{said}");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
#[cfg(target_os = "linux")]
fn an_input_that_eats_memory_ends_the_worker() {
    let folder = ScratchFolder::new("fuzz-memory");
    let output = worker("planted", [0, 20], &folder);
    assert_eq!(output.status.code(), None, "{output:?}");
    assert_eq!(std::fs::read_to_string(folder.join("at")).unwrap().trim(), "1");
}
