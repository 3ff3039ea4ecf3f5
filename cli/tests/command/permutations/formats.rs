//! Output for CI: one line where all is well, JUnit, annotations of GitHub with its limits, and the summary of a step.

use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

use super::{umbragraph, verbose};

/// Returns a pipeline with the given number of errors: passes that refer to missing resources.
fn broken(errors: usize) -> String {
    let pass = |at: usize| {
        format!(
            r#""p{at}": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&none<{at}>|" }}] }} }}"#
        )
    };
    let passes: Vec<String> = (0..errors).map(pass).collect();
    format!(
        r#"{{ "format": 1, "name": "broken",
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }}{}
  {} }} }}"#,
        if errors > 0 { "," } else { "" },
        passes.join(",\n    ")
    )
}

fn run(folder: &ScratchFolder, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).current_dir(&**folder).env("GITHUB_STEP_SUMMARY", folder.join("summary.md"));
    command.output().expect("the command")
}

#[test]
fn a_green_run_says_one_line_for_each_pipeline() {
    for command in ["permutations", "check"] {
        let pipelines = [
            "pipelines/nebula.json",
            "pipelines/learn/10-features.json",
            "pipelines/learn/31-constraints.json",
        ];
        let output = umbragraph(&[&[command], &pipelines[..], &["--no-cache"]].concat());
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert_eq!(said.lines().count(), 3, "{said}");
        assert!(said.lines().zip(pipelines).all(|(line, path)| line.starts_with(path)), "{said}");
        assert_eq!(text(&output.stderr), "", "no bar on a pipe, no notes");
    }
    let said = text(&verbose(&["pipelines/nebula.json"]).stderr);
    assert!(said.contains("note[UG0223]: \"scroll\" keeps what a map holds"), "{said}");
}

#[test]
fn junit_has_a_case_for_each_pipeline_pass_and_error() {
    let folder = ScratchFolder::new("formats-junit");
    std::fs::write(folder.join("fine.json"), broken(0)).unwrap();
    std::fs::write(folder.join("broken.json"), broken(2)).unwrap();
    for command in ["check", "permutations"] {
        let output = run(&folder, &[command, "fine.json", "--format", "junit"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let (count, passes) = match command {
            "check" => (1, ""),
            _ => (
                2,
                r#"    <testsuite name="fine.json" tests="1" skipped="0" errors="0" failures="0">
        <testcase name="fill" classname="fine.json"/>
    </testsuite>
"#,
            ),
        };
        let expected = format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<testsuites name="umbragraph" tests="{count}" skipped="0" failures="0" errors="0">
    <testsuite name="pipelines" tests="1" skipped="0" errors="0" failures="0">
        <testcase name="fine.json"/>
    </testsuite>
{passes}</testsuites>
"#
        );
        assert_eq!(text(&output.stdout), expected);
        let output = run(&folder, &[command, "fine.json", "broken.json", "--format", "junit"]);
        assert_eq!((output.status.code(), &*text(&output.stderr)), (Some(1), ""));
        let said = text(&output.stdout);
        assert!(said.contains(r#"<testsuites name="umbragraph" tests="#), "{said}");
        assert!(
            said.contains(r#"<testsuite name="broken.json" tests="2" skipped="0" errors="0" failures="2">"#),
            "{said}"
        );
        assert!(said.contains(r#"classname="broken.json""#), "{said}");
        assert_eq!(said.matches("<failure message=").count(), 2, "{said}");
        assert!(said.contains("&lt;0>") || said.contains("&lt;0&gt;"), "{said}");
        assert!(!run(&folder, &[command, "fine.json", "--format", "junit"]).stdout.is_empty());
    }
}

#[test]
fn annotations_keep_to_the_limits_of_github() {
    let folder = ScratchFolder::new("formats-github");
    std::fs::write(folder.join("broken.json"), broken(13)).unwrap();
    for command in ["check", "permutations"] {
        let output = run(&folder, &[command, "broken.json", "--format", "github"]);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1));
        assert_eq!(said.lines().filter(|line| line.starts_with("::error ")).count(), 10, "{said}");
        assert!(
            said.contains("\n3 more errors without an annotation, since GitHub shows 10 of a step:\n"),
            "{said}"
        );
        assert_eq!(said.lines().filter(|line| line.starts_with("error[")).count(), 3, "{said}");
        let summary = std::fs::read_to_string(folder.join("summary.md")).unwrap();
        std::fs::remove_file(folder.join("summary.md")).unwrap();
        assert!(summary.starts_with("### umbragraph: 13 errors\n"), "{summary}");
        let rows: Vec<&str> = summary.lines().filter(|line| line.starts_with("| error UG")).collect();
        assert_eq!(rows.len(), 13, "{summary}");
        assert!(rows.iter().all(|row| row.contains("| broken.json:") && row.ends_with(" |")), "{summary}");
        assert!(rows[0].contains("none&lt;0>\\|"), "names make no markup: {summary}");
    }
}

#[test]
fn a_green_step_has_a_summary_with_and_without_a_cache() {
    let folder = ScratchFolder::new("formats-summary");
    std::fs::write(folder.join("fine.json"), broken(0)).unwrap();
    for command in ["check", "permutations"] {
        let github = [command, "fine.json", "--cache", "cache", "--format", "github"];
        assert!(run(&folder, &github).status.success());
        let first = std::fs::read_to_string(folder.join("summary.md")).unwrap();
        assert!(first.starts_with("### umbragraph: no errors\n\n- fine.json: "), "{first}");
        assert!(run(&folder, &github).status.success());
        let both = std::fs::read_to_string(folder.join("summary.md")).unwrap();
        assert_eq!(both, first.repeat(2), "a step adds to what is there");
        std::fs::remove_file(folder.join("summary.md")).unwrap();
        // The second is known.
        for _ in 0..2 {
            assert!(run(&folder, &github[..4]).status.success());
        }
        assert!(!folder.join("summary.md").exists(), "only with annotations");
    }
}
