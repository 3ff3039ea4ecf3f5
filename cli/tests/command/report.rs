//! `render --report`: one page that shows a run and needs nothing else.

use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::scratch::ScratchFolder;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn render(folder: &ScratchFolder, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.current_dir(folder).args(["render", &format!("{ROOT}/pipelines/learn/28-bloom.json")]);
    command.args([
        "--scene",
        &format!("{ROOT}/examples/scenes/courtyard.glb"),
        "--size",
        "64x36",
        "--root",
        ROOT,
    ]);
    command.args(more).output().expect("the command")
}

#[test]
fn report_is_one_page_with_everything_of_a_run() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("report_is_one_page");
    let plain = render(&folder, &["--out", "plain.png"]);
    assert!(plain.status.success(), "{}", text(&plain.stderr));
    let output = render(&folder, &["--out", "out.png", "--report", "run"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("run/index.html: a page of the run"), "{}", text(&output.stdout));
    let pictures = ["plain.png", "out.png"].map(|name| std::fs::read(folder.join(name)).unwrap());
    assert!(pictures[0] == pictures[1], "a report changes no pixel");
    assert_eq!(std::fs::read_dir(folder.join("run")).unwrap().count(), 1);
    let page = std::fs::read_to_string(folder.join("run/index.html")).unwrap();
    for part in ["Frame", "Diagnostics", "Parameters and features", "Times", "Memory", "Passes", "Graph"] {
        assert!(page.contains(&format!("<h2>{part}</h2>")), "{part}");
    }
    assert!(page.contains("64 by 36 on ") && page.contains("--report run"));
    let plan = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(["plan", &format!("{ROOT}/pipelines/learn/28-bloom.json"), "--root", ROOT, "--format", "json"])
        .output()
        .unwrap();
    let plan: serde_json::Value = serde_json::from_slice(&plan.stdout).unwrap();
    let passes = plan["passes"].as_array().unwrap();
    for pass in passes {
        let name = pass["name"].as_str().unwrap();
        assert!(page.contains(&format!("<summary><b>{name}</b>")), "{name}");
    }
    // Each pass with its inputs and outputs, the frame, and once more on the page of the graph.
    assert!(page.matches("src=\"data:image/png;base64,").count() > passes.len());
    assert!(page.contains("<iframe title=\"the graph\" srcdoc=\"&lt;!doctype html&gt;"));
    for elsewhere in ["src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(!page.contains(elsewhere), "{elsewhere}");
    }
}

#[test]
fn report_names_a_folder_that_cannot_be_made() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("report_names_a_folder");
    std::fs::write(folder.join("run"), "a file").unwrap();
    rejected(&render(&folder, &["--out", "out.png", "--report", "run"]), 1, &["UG0004", "run"]);
}
