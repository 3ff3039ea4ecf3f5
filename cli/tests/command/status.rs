//! The command as a user meets it: exit status, diagnostics, and what is written.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn run(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the command")
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).current_dir(root());
    command
}

/// Runs the command, which must fail with this exit status and print all of these texts.
#[track_caller]
fn rejected(arguments: &[&str], status: i32, says: &[&str]) -> String {
    umbragraph_test_support::command::rejected(&run(arguments), status, says)
}

#[test]
fn check_needs_no_adapter_and_says_what_is_valid() {
    let output = command(&["check", "pipelines/nebula.json"])
        .env("UMBRAGRAPH_ADAPTER", "none at all")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("pipelines/nebula.json: 6 passes (0 culled)"),
        "{}",
        text(&output.stdout)
    );
}

#[test]
fn every_pipeline_of_the_tree_is_valid() {
    let mut names: Vec<String> = std::fs::read_dir(root().join("pipelines"))
        .unwrap()
        .flatten()
        .filter(|entry| entry.path().extension().is_some_and(|extension| extension == "json"))
        .map(|entry| format!("pipelines/{}", entry.file_name().to_string_lossy()))
        .collect();
    names.sort();
    assert!(!names.is_empty());
    std::thread::scope(|scope| {
        for name in &names {
            scope.spawn(move || {
                let output = run(&["check", name]);
                assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            });
        }
    });
}

#[test]
fn plan_is_json_on_demand_and_wgsl_is_the_text_of_the_pass() {
    let plan: serde_json::Value =
        serde_json::from_slice(&run(&["plan", "pipelines/nebula.json", "--format", "json"]).stdout).unwrap();
    assert_eq!(plan["passes"].as_array().unwrap().len(), 6);
    let table = text(&run(&["plan", "pipelines/nebula.json"]).stdout);
    let has = |words: &str| {
        let is_line = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ") == words;
        assert!(table.lines().any(is_line), "{words}\n{table}");
    };
    has("nebula: 1280×720, 6 passes (0 culled), 6 resources, in declared order");
    has("3 casters draw directional_light → maps");
    has("maps depth32float 2048×2048 · 4 layers 64.0 MiB texture 0 3 to 4");
    has("eye data blackboard 1 to 5");
    let shaders = text(&run(&["wgsl", "pipelines/nebula.json", "--pass", "casters"]).stdout);
    assert!(
        shaders.contains("fn project(") && shaders.contains("fn cut_out(") && !shaders.contains("fn shade(")
    );
    rejected(
        &["wgsl", "pipelines/nebula.json", "--pass", "caster"],
        1,
        &["UG0207", "did you mean \"casters\"?"],
    );
    // Of a loop those of all its rounds.
    let of =
        |pass: &str| text(&run(&["wgsl", "pipelines/learn/09-loops-and-mips.json", "--pass", pass]).stdout);
    let rounds = of("down");
    assert!(rounds.contains("// pass down.0:") && rounds.contains("// pass down.1:"), "{rounds}");
    assert!(!of("down.1").contains("// pass down.0:"));
}

#[test]
fn a_broken_pass_does_not_hide_the_others() {
    let folder = ScratchFolder::new("command-sound");
    let path = folder.join("broken.json");
    let lesson = std::fs::read_to_string(root().join("pipelines/learn/02-resources.json")).unwrap();
    let broken = lesson.replacen("\"bind\"", "\"bid\"", 1);
    assert_ne!(broken, lesson);
    std::fs::write(&path, broken).unwrap();
    let path = path.to_str().unwrap();
    // What naga rejects is printed with its errors.
    let own = folder.join("templates");
    std::fs::create_dir(&own).unwrap();
    let rejected = "@fragment fn rejected() -> @location(0) vec4<f32> { return 1; }\n";
    std::fs::write(own.join("gradient.wgsl.jinja"), rejected).unwrap();
    let templates = own.to_str().unwrap();
    let output = run(&["wgsl", "pipelines/learn/01-smallest.json", "--templates", templates]);
    let (shown, errors) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(shown.contains("// rejected: gradient.wgsl.jinja") && shown.contains(rejected), "{shown}");
    assert!(errors.contains("gradient.wgsl.jinja:1:"), "{errors}");
    for arguments in [&["plan", path][..], &["wgsl", path], &["graph", path, "--format", "mermaid"]] {
        let output = run(arguments);
        let (shown, errors) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(errors.contains("UG0102") && shown.contains("paint"), "{arguments:?}: {shown}\n{errors}");
        assert_eq!(arguments[0] == "plan", shown.starts_with("The plan without the passes that have errors"));
    }
}

#[test]
fn distances_that_a_split_formula_ignores_are_a_warning() {
    let folder = ScratchFolder::new("command-splits");
    let path = folder.join("splits.json");
    let check = |far: &str| {
        let text = format!(
            r#"{{ "format": 1, "name": "splits",
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{
    "sun": {{ "cascades": {{ "to": "&sun", "splits": {{ "scheme": "practical", "count": 3 }}, "far": {far}, "resolution": 512 }} }},
    "paint": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }} }}"#
        );
        std::fs::write(&path, text).unwrap();
        let output = run(&["check", path.to_str().unwrap(), "--config"]);
        assert_eq!(output.status.code(), Some(0), "{}", text_of(&output));
        text_of(&output)
    };
    let said = check("[5, 20, 80]");
    assert!(said.contains("warning[UG0612]") && said.contains("5, 20 m have no effect"), "{said}");
    assert!(said.contains("write \"far\": [80] and \"count\": 3"), "{said}");
    assert!(!check("[80]").contains("UG0612"));
}

fn text_of(output: &std::process::Output) -> String {
    text(&output.stderr)
}

#[test]
fn pipelines_that_come_with_the_command_have_names_of_their_own() {
    let folder = ScratchFolder::new("command-bundled");
    let path = folder.join("own.json");
    let own = r#"{ "format": 1, "name": "own", "extends": "umbragraph:nebula.json", "parameters": { "far": { "default": [9] } } }"#;
    std::fs::write(&path, own).unwrap();
    let path = path.to_str().unwrap();
    let output = run(&["check", path, "umbragraph:nebula.json", "--config"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let why = text(&run(&["why", path, "exposure"]).stdout);
    assert!(why.contains("umbragraph:base/forward.json"), "{why}");
    std::fs::write(path, own.replace("nebula", "nebular")).unwrap();
    rejected(&["check", path], 1, &["UG0001", "nebular.json", "did you mean \"umbragraph:nebula.json\"?"]);
    rejected(&["check", "umbragraph:something.json"], 1, &["UG0001", "there are awsm.json,"]);
    std::fs::write(path, own.replace("nebula.json", "../../../etc/passwd")).unwrap();
    rejected(&["check", path], 1, &["etc/passwd"]);
}

#[test]
fn a_size_that_cannot_be_is_told_at_the_option() {
    rejected(&["check", "pipelines/nebula.json", "--size", "0x10"], 2, &["at least one pixel"]);
    let errors =
        rejected(&["check", "pipelines/nebula.json", "--size", "16384x64"], 1, &["--size 16384x64", "8192"]);
    assert_eq!(errors.matches("error[").count(), 1, "{errors}");
}

#[test]
fn a_command_line_that_cannot_be_understood_exits_with_2() {
    rejected(&["chekc"], 2, &[]);
    rejected(&["check"], 2, &[]);
    rejected(&["check", "pipelines/nebula.json", "--size", "10"], 2, &["WIDTHxHEIGHT"]);
}

#[test]
fn files_that_are_not_there_are_diagnostics() {
    rejected(&["check", "pipelines/nebular.json"], 1, &["UG0001", "pipelines/nebular.json"]);
    let folder = ScratchFolder::new("command-missing-scene");
    let out = folder.join("x.png");
    let out = out.to_str().unwrap();
    rejected(
        &["render", "pipelines/nebula.json", "--scene", "nowhere.glb", "--out", out],
        1,
        &["nowhere.glb"],
    );
    assert!(!Path::new(out).exists());
    let misspelt =
        ["render", "pipelines/nebula.json", "--scene", "examples/scenes/courtyrd.glb", "--out", out];
    rejected(&misspelt, 1, &["UG0700", "did you mean \"courtyard.glb\", which lies beside it?"]);
}

#[test]
fn diagnostics_of_the_pipeline_and_of_the_scene_come_together() {
    let errors = rejected(
        &[
            "render",
            "pipelines/nebula.json",
            "--set",
            "far=[2,1]",
            "--scene",
            "nowhere.glb",
            "--out",
            "/dev/null",
        ],
        1,
        &["UG0205", "nowhere.glb"],
    );
    assert!(errors.contains("2 errors"), "{errors}");
}

#[test]
fn bad_settings_are_diagnostics_at_the_command_line() {
    let set = |setting: &str| {
        vec!["check".to_owned(), "pipelines/nebula.json".to_owned(), "--set".to_owned(), setting.to_owned()]
    };
    for (setting, code, help) in [
        ("resolutoin=1024", "UG0202", "did you mean \"resolution\"?"),
        ("resolution", "UG0005", "NAME=VALUE"),
        ("resolution=9000", "UG0204", "16 to 8192 texel"),
        ("fit=loose", "UG0107", "tight"),
        ("far=[10,5]", "UG0205", "sort the list"),
    ] {
        let arguments = set(setting);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        rejected(&arguments, 1, &[code, help, "<command line>:1:"]);
    }
    rejected(&["check", "pipelines/nebula.json", "--feature", "reverse=true"], 1, &["UG0202"]);
    rejected(
        &["check", "pipelines/nebula.json", "--profile", "webgup"],
        1,
        &["UG0006", "did you mean \"webgpu\"?"],
    );
}

#[test]
fn broken_templates_are_diagnostics_at_their_own_line() {
    let folder = ScratchFolder::new("command-templates");
    let check = |text_of_template: &str, says: &[&str]| {
        std::fs::write(folder.join("tonemap.wgsl.jinja"), text_of_template).unwrap();
        let path = folder.to_str().unwrap();
        rejected(&["check", "pipelines/nebula.json", "--templates", path], 1, says);
    };
    check("{% if %}", &["tonemap.wgsl.jinja:1:"]);
    check("\n{{ no_such_axis }}", &["tonemap.wgsl.jinja:2:", "no_such_axis"]);
    check("\n\nfn broken( {", &["tonemap.wgsl.jinja:3:"]);
    check(
        "@fragment fn show() -> @location(0) vec4<f32> {\n  return vec3<f32>(1.0);\n}",
        &["tonemap.wgsl.jinja:2:"],
    );
}

#[test]
fn a_missing_scene_buffer_is_a_diagnostic_with_its_place() {
    let folder = ScratchFolder::new("command-broken-scene");
    let scene = folder.join("broken.gltf");
    std::fs::write(
        &scene,
        r#"{ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 12, "uri": "gone.bin" }] }"#,
    )
    .unwrap();
    let out = folder.join("x.png");
    rejected(
        &[
            "render",
            "pipelines/nebula.json",
            "--scene",
            scene.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ],
        1,
        &["gone.bin", "/buffers/0"],
    );
    assert!(!out.exists());
}

#[test]
fn without_an_adapter_help_is_told_and_nothing_written() {
    let folder = ScratchFolder::new("command-no-adapter");
    let out = folder.join("x.png");
    let scene = "examples/scenes/courtyard.glb";
    let output =
        command(&["render", "pipelines/nebula.json", "--scene", scene, "--out", out.to_str().unwrap()])
            .env("UMBRAGRAPH_ADAPTER", "an adapter that no machine has")
            .output()
            .unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("UG0801"), "{errors}");
    assert_eq!(std::fs::read_dir(&*folder).unwrap().count(), 0);
}

#[test]
fn render_writes_a_whole_picture_and_says_on_what_and_how_fast() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("command-render");
    let out = folder.join("x.png");
    let scene = "examples/scenes/courtyard.glb";
    let arguments = [
        "render",
        "pipelines/nebula.json",
        "--scene",
        scene,
        "--size",
        "64x48",
        "--out",
        out.to_str().unwrap(),
    ];
    let output = run(&arguments);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for word in ["64 by 48 on ", "check", "load scene", "draw", "together"] {
        assert!(said.contains(word), "{word} is missing in {said}");
    }
    let file = std::io::BufReader::new(std::fs::File::open(&out).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (64, 48));
    assert_eq!(std::fs::read_dir(out.parent().unwrap()).unwrap().count(), 1, "no temporary file is left");
    let blocked = out.join("y.png");
    rejected(
        &[
            "render",
            "pipelines/nebula.json",
            "--scene",
            scene,
            "--size",
            "16x16",
            "--out",
            blocked.to_str().unwrap(),
        ],
        1,
        &["UG0004"],
    );
}

#[test]
fn a_pipeline_that_makes_no_picture_is_not_rendered() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("command-no-picture");
    let (pipeline, out) = (folder.join("none.json"), folder.join("x.png"));
    std::fs::write(&pipeline, r#"{ "format": 1, "name": "none", "passes": {} }"#).unwrap();
    let (pipeline, out) = (pipeline.to_str().unwrap(), out.to_str().unwrap());
    rejected(
        &["render", pipeline, "--scene", "examples/scenes/figure.glb", "--size", "32x32", "--out", out],
        1,
        &["UG0808", "0 imported textures"],
    );
    assert!(!Path::new(out).exists());
}

#[test]
fn render_says_which_transparent_things_a_pipeline_leaves_out() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("command-transparent");
    let out = folder.join("x.png");
    let render = |pipeline: &str| {
        let scene = "examples/scenes/foliage.glb";
        let output =
            run(&["render", pipeline, "--scene", scene, "--size", "32x32", "--out", out.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    let said = render("pipelines/nebula.json");
    assert!(said.contains("UG0722") && said.contains("1 transparent draw is left out"), "{said}");
    let said = render("pipelines/awsm.json");
    assert!(!said.contains("UG0722"), "{said}");
}

#[test]
fn without_the_gpu_feature_nothing_of_wgpu_core_is_built() {
    for package in ["umbragraph", "umbragraph-cli"] {
        let output = Command::new(env!("CARGO"))
            .args([
                "tree",
                "--edges",
                "normal",
                "--no-default-features",
                "--prefix",
                "none",
                "--package",
                package,
            ])
            .current_dir(root())
            .output()
            .expect("cargo");
        let tree = text(&output.stdout);
        assert!(tree.contains("naga v"), "{tree}{}", text(&output.stderr));
        for crate_name in ["wgpu-core", "wgpu-hal", "wgpu v"] {
            assert!(!tree.lines().any(|line| line.starts_with(crate_name)), "{package} builds {crate_name}");
        }
    }
}

#[test]
fn the_committed_schema_is_the_one_of_the_types_and_node_kinds() {
    let output = run(&["schema", "--check", "pipeline.schema.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let schema: serde_json::Value = serde_json::from_slice(&run(&["schema"]).stdout).unwrap();
    for kind in ["camera", "cascades", "compute", "copy", "draw", "fullscreen"] {
        let pass = &schema["$defs"]["Pass"]["properties"][kind];
        assert!(pass.is_object(), "{kind} is not among the kinds of passes");
    }
    let far = &schema["$defs"]["Cascades"]["properties"]["far"]["description"];
    assert!(far.as_str().is_some_and(|text| !text.is_empty()), "settings are explained");
}

#[test]
fn the_schema_of_each_kind_of_file_is_printed() {
    for (kind, required) in [("extension", "inserts"), ("subgraph", "passes"), ("pipeline", "passes")] {
        let output = run(&["schema", "--of", kind]);
        let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        // What has to be there is asked of files that extend no others.
        let whole = &schema["else"]["allOf"][1];
        assert!(whole["required"].as_array().unwrap().iter().any(|key| key == required), "{kind}");
        assert!(schema["$defs"]["Pass"]["properties"]["copy"].is_object(), "{kind}");
    }
    let output = run(&["schema", "--of", "parameters"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(schema["properties"]["preset"].is_object() && schema["properties"]["passes"].is_null());
    assert_eq!(run(&["schema", "--of", "nothing"]).status.code(), Some(2));
    let output = run(&["schema", "--of", "parameters", "--check", "pipeline.schema.json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("umbragraph schema --of parameters >"), "{}", text(&output.stderr));
}

#[test]
fn every_command_with_a_pipeline_takes_an_extension() {
    let pipeline = "pipelines/learn/12-extension-point.json";
    let extension = "pipelines/learn/parts/echo.json";
    let output = run(&["plan", pipeline, "--extension", extension]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("shrink"), "{}", text(&output.stdout));
    let checked = run(&["check", pipeline, "--extension", extension]);
    assert!(text(&checked.stdout).contains("4 passes (0 culled)"), "{}", text(&checked.stdout));
    rejected(&["check", "pipelines/nebula.json", "--extension", extension], 1, &["after_paint"]);
}

#[test]
fn check_gives_its_diagnostics_as_json_and_as_annotations() {
    let arguments = ["check", "pipelines/nebula.json", "--set", "far=[]", "--format"];
    let json = run(&[&arguments[..], &["json"]].concat());
    assert_eq!(json.status.code(), Some(1));
    let value: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert!(value["diagnostics"][0]["code"].as_str().unwrap().starts_with("UG"), "{value}");
    let github = run(&[&arguments[..], &["github"]].concat());
    assert!(text(&github.stdout).starts_with("::error "), "{}", text(&github.stdout));
    let fine = run(&["check", "pipelines/nebula.json", "--format", "json"]);
    let value: serde_json::Value = serde_json::from_slice(&fine.stdout).unwrap();
    assert_eq!(value["diagnostics"].as_array().unwrap().len(), 0);
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_text() {
    let scratch = ScratchFolder::new("byte-order-mark");
    let path = scratch.join("marked.json");
    let source = std::fs::read_to_string(root().join("pipelines/learn/01-smallest.json")).unwrap();
    std::fs::write(&path, format!("\u{feff}{source}")).unwrap();
    let output = run(&["check", &path.to_string_lossy()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn options_that_would_have_no_effect_are_rejected() {
    let pipeline = "pipelines/learn/01-smallest.json";
    rejected(&["wgsl", pipeline, "--target", "msl", "--map"], 2, &["--map shows the lines of WGSL"]);
    rejected(&["graph", pipeline, "--compare", pipeline], 2, &["add --format html"]);
    rejected(&["graph", pipeline, "--format", "json", "--compare", pipeline], 2, &["add --format html"]);
    assert_eq!(run(&["wgsl", pipeline, "--target", "wgsl", "--map"]).status.code(), Some(0));
}

/// Tests the memory and pass counts of the presets of `umbra` in the table of `docs/shadows.md`.
#[test]
fn presets_of_the_flagship_take_the_memory_that_docs_say() {
    let page = std::fs::read_to_string(root().join("docs/shadows.md")).unwrap();
    for preset in ["phone", "console", "desktop", "workstation"] {
        let output = run(&[
            "graph",
            "pipelines/umbra.json",
            "--preset",
            preset,
            "--size",
            "1920x1080",
            "--format",
            "json",
        ]);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a report");
        let mebibytes = report["memory"]["created"].as_f64().unwrap() / f64::from(1 << 20);
        let end = format!("| {mebibytes:.0} MiB | {} |", report["passes"].as_array().unwrap().len());
        let row = page.lines().find(|line| line.starts_with(&format!("| `{preset}`")));
        assert!(row.is_some_and(|row| row.ends_with(&end)), "{row:?} does not end with {end}");
    }
}
