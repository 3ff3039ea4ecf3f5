//! `umbragraph render` captures buffers as shaders declare them.

use std::process::{Command, Output};

use serde_json::{Value, json};
use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// A pipeline with buffers that two shaders declare in different ways (`entries`), that one declares (`total`), and
/// that none does (`copied`).
const LIST: &str = r#"{
  "format": 1, "name": "list",
  "parameters": { "count": { "type": "u32", "default": 4 } },
  "resources": {
    "entries": { "buffer": { "size": "=16 * count" } },
    "copied": { "buffer": { "size": "=16 * count", "lifetime": "persistent" } },
    "total": { "buffer": { "size": 32, "lifetime": "persistent" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "fill": { "compute": { "shader": "fill.wgsl.jinja", "workgroups": ["=ceil(count / 64)", 1, 1],
      "bind": { "entries": { "buffer": { "name": "&entries", "contents": "discard" } } } } },
    "keep": { "copy": { "from": { "name": "&entries" }, "to": { "name": "&copied" } } },
    "raise": { "side_effect": true, "compute": { "shader": "raise.wgsl.jinja", "workgroups": [1, 1, 1],
      "bind": { "words": "&entries", "total": { "buffer": { "name": "&total", "contents": "discard" } } } } },
    "paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }
  }
}"#;

const FILL: &str = "struct Entry { place: vec3<f32>, count: u32 }
@group(1) @binding(0) var<storage, read_write> entries: array<Entry>;
@compute @workgroup_size(64) fn fill(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x < arrayLength(&entries) {
        entries[at.x] = Entry(vec3<f32>(f32(at.x) + 0.1, 0.5, -2.0), at.x * 3u);
    }
}";

const RAISE: &str = "struct Total { sum: u32, parts: mat2x2<f32>, more: array<u32, 2> }
@group(1) @binding(0) var<storage, read_write> words: array<u32>;
@group(1) @binding(1) var<storage, read_write> total: Total;
@compute @workgroup_size(1) fn raise() {
    words[3] += 1u;
    total = Total(7u, mat2x2<f32>(1.0, 2.0, 3.0, 4.5), array<u32, 2>(8u, 9u));
}";

/// Runs `render` in a folder with the pipeline `list.json`.
fn render(folder: &ScratchFolder, arguments: &[&str]) -> Output {
    for (name, text) in [("list.json", LIST), ("fill.wgsl.jinja", FILL), ("raise.wgsl.jinja", RAISE)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let scene = format!("{ROOT}/examples/scenes/figure.glb");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["render", "list.json", "--templates", ".", "--scene", &scene, "--size", "16x16"]);
    command.args(["--out", "out.png"]).args(arguments).current_dir(folder).output().expect("the command")
}

fn json_of(folder: &ScratchFolder, name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn a_buffer_is_written_as_its_shader_declares_it() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("captures-buffers");
    let files =
        ["entries@fill=filled.json", "entries=last.csv", "entries@raise=words.csv", "total=total.json"];
    let arguments: Vec<&str> = files.iter().flat_map(|file| ["--capture", file]).collect();
    let output = render(&folder, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for line in [
        "filled.json: entries@fill, 64 bytes, array<Entry> (declared by \"fill\", others have array<u32>), before \"raise\" \
         overwrites it\n",
        "words.csv: entries@raise, 64 bytes, array<u32> (declared by \"raise\", others have array<Entry>)\n",
        "total.json: total, 32 bytes, Total (declared by \"raise\")\n",
    ] {
        assert!(said.contains(line), "{line} is missing in {said}");
    }
    let filled = json_of(&folder, "filled.json");
    assert_eq!(filled["type"], "array<Entry>");
    assert_eq!(filled["contents"][1], json!({ "place": [1.1, 0.5, -2], "count": 3 }));
    let total = json_of(&folder, "total.json");
    assert_eq!(total["contents"], json!({ "sum": 7, "parts": [[1, 2], [3, 4.5]], "more": [8, 9] }));
    let table = std::fs::read_to_string(folder.join("last.csv")).unwrap();
    assert_eq!(
        table.lines().collect::<Vec<_>>(),
        ["place.x,place.y,place.z,count", "0.1,0.5,-2,1", "1.1,0.5,-2,3", "2.1,0.5,-2,6", "3.1,0.5,-2,9"]
    );
    assert!(std::fs::read_to_string(folder.join("words.csv")).unwrap().starts_with("value\n1036831949\n"));
}

#[test]
fn every_buffer_is_captured_with_the_textures() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("captures-all");
    // Above the number of scalars that a file holds.
    let output = render(&folder, &["--capture-all", "all", "--set", "count=300000"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("(no shader binds it), without the last 151424 elements\n"), "{said}");
    let mut names: Vec<String> = std::fs::read_dir(folder.join("all"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["copied.json", "entries.json", "target.png", "total.json"]);
    let entries = json_of(&folder, "all/entries.json");
    let all = entries["contents"].as_array().unwrap().len() + entries["left_out"].as_u64().unwrap() as usize;
    assert_eq!(all, 300_000);
    assert_eq!(json_of(&folder, "all/copied.json")["type"], "array<u32>");
    // The page of the graph shows the first rows.
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["graph", "list.json", "--templates", ".", "--captures", "all", "--out", "page.html"]);
    let output = command.current_dir(&folder).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    let observed = page.split("id=\"observed\">").nth(1).and_then(|rest| rest.split("</script>").next());
    let observed: Value = serde_json::from_str(observed.unwrap()).unwrap();
    let rows = observed["buffers"]["entries"].as_str().unwrap();
    assert!(
        rows.starts_with("4800000 bytes, array<Entry>\n{\"place\":[0.1,0.5,-2],\"count\":1}\n"),
        "{rows}"
    );
    assert_eq!(rows.lines().count(), 9);
}

#[test]
fn impossible_captures_of_buffers_are_rejected() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("captures-impossible");
    let wrong = ["total=a.csv", "entries=b.png", "entries:1=c.json", "entris=d.json", "target=e.json"];
    let arguments: Vec<&str> = wrong.iter().flat_map(|file| ["--capture", file]).collect();
    let says = [
        "\"total\" is `Total`, no array of elements of one size, so it is no table",
        "\"entries\" is a buffer, of which there is no picture",
        "which has no mip levels, layers or faces",
        "did you mean \"entries\"?",
        "--capture: the extension of \"e.json\"",
    ];
    rejected(&render(&folder, &arguments), 1, &says);
    assert!(!folder.join("out.png").exists());
}
