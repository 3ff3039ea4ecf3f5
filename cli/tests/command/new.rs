//! `umbragraph new`: each kind of folder is checked, laid out and drawn as it is written.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::scratch::ScratchFolder;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.current_dir(folder).args(arguments).output().expect("the command")
}

#[track_caller]
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn each_kind_of_new_pipeline_is_sound_and_renders() {
    let folder = ScratchFolder::new("each_kind_of_new_pipeline");
    let is_drawn = umbragraph_test_support::gpu::device().is_some();
    for kind in ["post", "shadows", "system"] {
        let said = succeeds(&folder, &["new", kind, "--kind", kind]);
        let own = folder.join(kind);
        for command in ["check", "render", "watch", "view"] {
            assert!(said.contains(&format!("umbragraph {command} {kind}.json")), "{said}");
        }
        let settings = std::fs::read_to_string(own.join(".vscode/settings.json")).unwrap();
        let settings: serde_json::Value = serde_json::from_str(&settings).unwrap();
        assert_eq!(settings["umbragraph.files"][0], format!("**/{kind}.json"));
        let pipeline = format!("{kind}.json");
        let checked = run(&own, &["check", &pipeline, "--templates", "shaders", "--config"]);
        assert!(checked.status.success() && checked.stderr.is_empty(), "{}", text(&checked.stderr));
        succeeds(&own, &["fmt", "--check", &pipeline]);
        succeeds(&own, &["schema", "--check", "pipeline.schema.json"]);
        for file in ["README.md", ".github/workflows/pipelines.yml", ".vscode/tasks.json", "scene.gltf"] {
            let text = std::fs::read_to_string(own.join(file)).unwrap();
            assert!(!text.contains("NAME"), "{file}");
            if file.ends_with("tasks.json") {
                serde_json::from_str::<serde_json::Value>(&text).unwrap();
            }
        }
        if is_drawn {
            let render = ["render", &pipeline, "--templates", "shaders", "--scene", "scene.gltf"];
            // The preset of the system's file has few passes.
            let params: &[&str] = if kind == "system" { &["--params", "look.params.json"] } else { &[] };
            succeeds(&own, &[&render[..], params, &["--size", "96x54", "--out", "out.png"]].concat());
            let picture = Picture::load(&own.join("out.png")).unwrap();
            let colors: BTreeSet<[u8; 4]> = picture.rgba_pixels().collect();
            assert!(colors.len() > 20, "{kind}: {} colors", colors.len());
        }
    }
}

#[test]
fn new_writes_over_nothing_and_wants_a_name() {
    let folder = ScratchFolder::new("new_writes_over_nothing");
    std::fs::create_dir(folder.join("mine")).unwrap();
    std::fs::write(folder.join("mine/mine.json"), "{}").unwrap();
    rejected(&run(&folder, &["new", "mine"]), 1, &["UG0004", "mine/mine.json", "is there already"]);
    assert_eq!(std::fs::read_dir(folder.join("mine")).unwrap().count(), 1);
    rejected(&run(&folder, &["new", "9 lives"]), 1, &["UG0201", "9 lives", "begin with a letter"]);
    std::fs::create_dir(folder.join("here")).unwrap();
    succeeds(&folder.join("here"), &["new", "."]);
    assert!(folder.join("here/here.json").is_file());
}
