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

/// Runs `render --report run` on a pipeline in a folder, and returns the output with the page.
fn reported(folder: &ScratchFolder, pipeline: &str, variables: &[(&str, &str)]) -> (Output, String) {
    std::fs::write(folder.join("own.json"), pipeline).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    let scene = format!("{ROOT}/examples/scenes/figure.glb");
    command.args(["render", "own.json", "--templates", ".", "--scene", &scene, "--size", "16x16"]);
    command.args(["--out", "out.png", "--report", "run"]).envs(variables.iter().copied());
    let output = command.current_dir(folder).output().expect("the command");
    (output, std::fs::read_to_string(folder.join("run/index.html")).unwrap_or_default())
}

/// A pipeline that writes `target`, and has further resources and passes.
fn pipeline(resources: &str, passes: &str) -> String {
    format!(
        r#"{{ "format": 1, "name": "own",
  "parameters": {{ "strength": {{ "type": "f32", "default": 0.25 }} }},
  "resources": {{ {resources}
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ {passes}
    "paint": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }} }}"#
    )
}

#[test]
fn a_run_that_fails_leaves_a_page_with_what_there_is() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("report_of_a_failed_run");
    // Loading fails: no pipeline.
    let (output, page) = reported(&folder, "{ \"format\": 1,\n  \"name\" }", &[]);
    rejected(&output, 1, &["run/index.html: a page of the run"]);
    assert!(page.contains("<b>The run failed.</b>") && page.contains("own.json:2:"), "{page}");
    assert!(!page.contains("<h2>Graph</h2>") && !page.contains("no adapter"));
    // Planning fails: no plan, but parameters.
    let read = r#""take": { "copy": { "from": { "name": "&never" }, "to": { "name": "&target" } } },"#;
    let never = r#""never": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },"#;
    let (output, page) = reported(&folder, &pipeline(never, read), &[]);
    rejected(&output, 1, &["UG0401"]);
    assert!(page.contains("error[UG0401]") && page.contains("<td>strength</td><td>0.25</td>"), "{page}");
    // The executor fails: nobody gives the buffer. The plan is there.
    let given = r#""given": { "buffer": { "size": 64, "lifetime": "imported" } },
        "kept": { "buffer": { "size": 64, "lifetime": "persistent" } },"#;
    let take = r#""take": { "copy": { "from": { "name": "&given" }, "to": { "name": "&kept" } } },"#;
    let (output, page) = reported(&folder, &pipeline(given, take), &[]);
    rejected(&output, 1, &["no buffer for \"given\"", "run/index.html: a page of the run"]);
    for part in ["Diagnostics", "Parameters and features", "Memory", "Passes", "Graph"] {
        assert!(page.contains(&format!("<h2>{part}</h2>")), "{part}");
    }
    assert!(page.contains("no buffer for &quot;given&quot;") && !page.contains("<h2>Frame</h2>"));
    // There is no device.
    let none =
        [("VK_DRIVER_FILES", "/nowhere"), ("VK_ICD_FILENAMES", "/nowhere"), ("WGPU_BACKEND", "vulkan")];
    let (output, page) = reported(&folder, &pipeline("", ""), &none);
    rejected(&output, 1, &["no graphics adapter"]);
    assert!(page.contains("16 by 16 on no adapter") && page.contains("<h2>Graph</h2>"));
}

const VOLUME: &str = "@group(1) @binding(0) var volume: texture_storage_3d<rgba8unorm, write>;
@compute @workgroup_size(4, 4, 4) fn fill(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(volume, at, vec4<f32>(vec3<f32>(at) / 4.0, 1.0));
}";

const LIST: &str = "struct Entry { place: vec3<f32>, count: u32 }
@group(1) @binding(0) var<storage, read_write> entries: array<Entry>;
@compute @workgroup_size(32) fn fill(@builtin(global_invocation_id) at: vec3<u32>) {
    entries[at.x] = Entry(vec3<f32>(f32(at.x)), at.x);
}";

#[test]
fn every_kind_of_resource_is_shown_or_says_why_not() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("report_of_every_kind");
    std::fs::write(folder.join("volume.wgsl.jinja"), VOLUME).unwrap();
    std::fs::write(folder.join("list.wgsl.jinja"), LIST).unwrap();
    let resources = r#"
        "volume": { "texture": { "format": "rgba8unorm", "size": [4, 4], "layers": 4, "view_dimension": "3d" } },
        "smooth": { "texture": { "format": "rgba8unorm", "size": "=viewport", "samples": 4 } },
        "sky": { "texture": { "format": "rgba8unorm", "size": [8, 8], "layers": 6, "view_dimension": "cube" } },
        "gone": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
        "entries": { "buffer": { "size": 512 } },"#;
    let draw = |name: &str, to: &str| {
        format!(
            r#""{name}": {{ "side_effect": true, "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ {to} }}] }} }},"#
        )
    };
    let faces: String = ["+x", "-x", "+y", "-y", "+z", "-z"]
        .iter()
        .enumerate()
        .map(|(at, face)| draw(&format!("face_{at}"), &format!(r#""to": "&sky", "face": "{face}""#)))
        .collect();
    let fill = |name: &str, slot: &str| {
        format!(
            r#""{name}": {{ "side_effect": true, "compute": {{ "shader": "{name}.wgsl.jinja", "workgroups": [1, 1, 1],
              "bind": {{ "{slot}": "&{slot}" }} }} }},"#
        )
    };
    let passes = [
        fill("volume", "volume"),
        r#""list": { "side_effect": true, "compute": { "shader": "list.wgsl.jinja", "workgroups": [1, 1, 1],
            "bind": { "entries": { "buffer": { "name": "&entries", "contents": "discard" } } } } },"#
            .to_owned(),
        draw("soften", r#""to": "&smooth", "clear": [0, 0, 0, 1]"#),
        draw("lose", r#""to": "&gone", "clear": [0, 0, 0, 1], "store": "discard""#),
        faces,
    ];
    let (output, page) = reported(&folder, &pipeline(resources, &passes.concat()), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    for (name, remark) in [
        ("volume@volume", "<p>slice 2 of 4</p>"),
        ("smooth@soften", "<p>sample 0 of 4</p>"),
        ("sky@face_5", "<p>faces +x, -x, +y, -y, +z, -z</p>"),
    ] {
        let figure = page.split("<figure>").find(|figure| figure.contains(&format!("<figcaption>{name}<")));
        let figure = figure.unwrap_or_default();
        assert!(figure.starts_with("<img ") && figure.contains(remark), "{name}: {figure:.300}");
    }
    assert!(page.contains("not shown: a capture reads &quot;gone&quot;, which &quot;lose&quot; discards"));
    let figure = page.split("<figure>").find(|one| one.contains("<figcaption>entries@list<")).unwrap();
    assert!(
        figure
            .contains("512 bytes, array&lt;Entry&gt; (declared by &quot;list&quot;); the first 8 of 32 rows")
    );
    assert!(
        figure.contains("<th>place.x</th>")
            && figure.contains("<td>7</td>")
            && !figure.contains("<td>8</td>")
    );
    assert!(figure.contains("<a download=\"entries_at_list.json\" href=\"data:application/json;base64,"));
}
