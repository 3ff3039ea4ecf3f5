//! `umbragraph check`: one diagnostic for one cause, and what was silent.

use super::{run, text};
use umbragraph_test_support::scratch::ScratchFolder;

const LUM: &str = "\
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var result: texture_storage_2d<rgba16float, write>;
@compute @workgroup_size(8, 8) fn measure(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = vec4<f32>(0.0);
    for (var tap = 0; tap < {{ taps }}; tap++) { sum += textureLoad(image, id.xy, 0); }
    textureStore(result, id.xy, sum);
}
";

const AXES: &str = r#"{ "axes": { "taps": { "type": "integer", "min": 1, "max": 8, "default": 4 } } }"#;

const PIPELINE: &str = r#"{
  "format": 1, "name": "c",
  "parameters": { "taps": { "type": "u32", "default": 4, "min": 1, "max": 8 } },
  "features": { "twice": { "type": "bool", "default": true } },
  "resources": {
    "color": { "texture": { "format": "rgba16float", "size": "=viewport" } },
    "grey": { "texture": { "format": "rgba16float", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&color" }] } },
    "measure": { "compute": { "shader": "lum.wgsl.jinja", "bind": { "image": "&color", "result": "&grey" }, "dispatch_over": "&grey" } },
    "show": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&grey" }, "color": [{ "to": "&target" }] } },
    "veil": { "after": ["show"], "when": "=twice", "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&color" },
      "color": [{ "to": "&target", "blend": "add" }] } }
  }
}"#;

/// The output of `check` for the pipeline with replacements in its files.
fn said(name: &str, edits: &[(&str, &str)], with_templates: bool) -> String {
    let folder = ScratchFolder::new(name);
    std::fs::create_dir(folder.join("shaders")).unwrap();
    for (file, whole) in
        [("c.json", PIPELINE), ("shaders/lum.wgsl.jinja", LUM), ("shaders/lum.axes.json", AXES)]
    {
        let edit = |whole: String, (from, to): &(&str, &str)| whole.replacen(from, to, 1);
        std::fs::write(folder.join(file), edits.iter().fold(whole.to_owned(), edit)).unwrap();
    }
    let (path, shaders) = (folder.join("c.json"), folder.join("shaders"));
    let mut arguments = vec!["check", path.to_str().unwrap()];
    if with_templates {
        arguments.extend(["--templates", shaders.to_str().unwrap()]);
    }
    let output = run(&arguments);
    [text(&output.stdout), text(&output.stderr)].concat()
}

fn assert_one(said: &str, parts: &[&str]) {
    let count =
        said.matches("error[").count() + said.matches("warning[").count() + said.matches("note[").count();
    assert_eq!(count, 1, "{said}");
    parts.iter().for_each(|part| assert!(said.contains(part), "{part}: {said}"));
}

#[test]
fn readers_of_one_cause_share_one_error() {
    let discarded = said(
        "causes-discard",
        &[("[{ \"to\": \"&color\" }]", "[{ \"to\": \"&color\", \"store\": \"discard\" }]")],
        true,
    );
    assert_one(
        &discarded,
        &["UG0412", "\"veil\" reads \"color\", which \"paint\" discards", "\"measure\" reads"],
    );
    let mips =
        said("causes-mips", &[("\"size\": \"=viewport\" }", "\"size\": \"=viewport\", \"mips\": 3 }")], true);
    assert_one(&mips, &["UG0401", "\"veil\" reads mips 1 to 2", "or give \"color\" fewer"]);
}

#[test]
fn a_shader_error_is_not_told_again_by_the_device() {
    let large = said("causes-workgroup", &[("@workgroup_size(8, 8)", "@workgroup_size(32, 32)")], true);
    assert_one(&large, &["UG0530", "@workgroup_size(16, 16)"]);
    let both = said("causes-storage", &[("rgba16float, write>", "rgba16float, read_write>")], true);
    assert_one(&both, &["UG0409", "reads and writes", "declared here"]);
}

#[test]
fn templates_beside_a_pipeline_are_found() {
    let without = said("causes-folder", &[], false);
    assert_one(&without, &["UG0500", "lum.wgsl.jinja lies in", "--templates"]);
}

#[test]
fn what_was_silent_is_said() {
    let over =
        said("causes-over", &[("\"dispatch_over\": \"&grey\"", "\"dispatch_over\": \"&target\"")], true);
    assert_one(&over, &["warning[UG0406]", "not under its \"bind\"", "\"result\""]);
    let twin = said(
        "causes-twin",
        &[("\"taps\": {", "\"color\": { \"type\": \"bool\", \"default\": true }, \"taps\": {")],
        true,
    );
    assert!(
        twin.contains("error[UG0201]") && twin.contains("\"color\" is a resource and a parameter"),
        "{twin}"
    );
}

#[test]
fn what_is_deleted_and_used_is_told_at_the_null() {
    let folder = ScratchFolder::new("causes-deleted");
    std::fs::write(folder.join("base.json"), PIPELINE.replace("lum.wgsl.jinja", "luminance.wgsl.jinja"))
        .unwrap();
    let path = folder.join("top.json");
    let text = r#"{ "format": 1, "extends": "base.json", "resources": { "color": null }, "passes": { "measure": null } }"#;
    std::fs::write(&path, text).unwrap();
    let output = run(&["check", path.to_str().unwrap()]);
    let said = super::text(&output.stderr);
    assert!(
        said.contains("\"color\" is deleted here, but it is used") && said.contains("top.json:1:"),
        "{said}"
    );
    assert_eq!(said.matches("is deleted here").count(), 1, "{said}");
}
