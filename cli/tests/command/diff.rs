//! `umbragraph diff`: pipelines, kept reports, and what is said of one side alone.

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(arguments)
        .current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .expect("the command")
}

fn lines(arguments: &[&str]) -> Vec<String> {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn a_kept_report_is_compared_as_its_pipeline_would_be() {
    let folder = ScratchFolder::new("diff-kept");
    let kept = folder.join("nebula.json");
    let kept = kept.to_str().unwrap();
    let output = run(&["graph", "pipelines/nebula.json", "--format", "json", "--out", kept]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(lines(&["diff", kept, "pipelines/nebula.json"]), ["the plans are the same"]);
    assert_eq!(
        lines(&["diff", kept, "pipelines/caracal.json"]),
        lines(&["diff", "pipelines/nebula.json", "pipelines/caracal.json"])
    );
}

#[test]
fn a_pipeline_is_compared_with_itself_in_other_settings() {
    let nebula = "pipelines/nebula.json";
    let found = lines(&["diff", nebula, "--after-feature", "reverse_z=off"]);
    assert!(
        found.contains(&"the pass shade has the clear of depth 1.0, it was 0.0".to_owned()),
        "{found:#?}"
    );
    let found = lines(&["diff", nebula, "--set", "exposure=2", "--after-set", "exposure=3"]);
    assert_eq!(found, ["the pass present has the value settings.exposure 3, it was 2"]);
    let found = lines(&["diff", nebula, nebula, "--after-size", "640x360"]);
    assert_eq!(found[0], "the viewport is 640×360, it was 1280×720");
    assert_eq!(lines(&["diff", nebula, nebula, "--set", "exposure=3"]), ["the plans are the same"]);
}

#[test]
fn only_the_axes_that_changed_are_named() {
    let found = lines(&["diff", "pipelines/nebula.json", "--after-set", "debug_view=cascades"]);
    let variants: Vec<&String> = found.iter().filter(|line| line.contains("variant")).collect();
    assert!(!variants.is_empty(), "{found:#?}");
    for line in variants {
        assert!(line.contains("debug_") && !line.contains("cascade_count"), "{line}");
    }
}

#[test]
fn the_state_of_attachments_and_draws_is_part_of_a_plan() {
    let folder = ScratchFolder::new("diff-state");
    let write = |name: &str, attachment: &str| {
        let path = folder.join(name);
        let text = format!(
            r#"{{ "format": 1, "name": "state",
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target", {attachment} }}] }} }} }} }}"#
        );
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let add = write("add.json", r#""clear": [0, 0, 0, 1], "blend": "add""#);
    let alpha = write("alpha.json", r#""clear": [0, 0, 0.5, 1], "blend": "alpha""#);
    let found = lines(&["diff", &add, &alpha]);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].starts_with("the pass fill has the blend of target color (srcFactor src-alpha"),
        "{found:#?}"
    );
    assert_eq!(found[1], "the pass fill has the clear of target [0.0,0.0,0.5,1.0], it was [0.0,0.0,0.0,1.0]");
}

#[test]
fn what_is_neither_a_pipeline_nor_a_report_is_rejected() {
    let folder = ScratchFolder::new("diff-plan");
    let plan = folder.join("plan.json");
    std::fs::write(&plan, run(&["plan", "pipelines/nebula.json", "--format", "json"]).stdout).unwrap();
    let output = run(&["diff", plan.to_str().unwrap(), "pipelines/nebula.json"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("error[UG0009]") && said.contains("--format json"), "{said}");
    assert_eq!(said.matches("error[").count(), 1, "{said}");
    assert_eq!(run(&["diff", "pipelines/nebula.json"]).status.code(), Some(2), "nothing to compare with");
}
