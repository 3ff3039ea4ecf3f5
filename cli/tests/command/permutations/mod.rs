//! `umbragraph permutations`, `wgsl` and what `check` says of profiles and hosts, as a user meets them.

mod budgets;
mod configurations;
mod formats;
mod lock;
mod shards;

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::property;
use umbragraph_test_support::scratch::ScratchFolder;

const PIPELINE: &str = r#"{
  "format": 1, "name": "small", "profiles": ["webgpu", "vulkan"],
  "features": { "warm": { "type": "bool", "default": false }, "late": { "type": "bool", "default": false } },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}"#;
const AXES: &str = r#"{ "axes": {
  "warm": { "type": "bool", "default": false },
  "late": { "type": "bool", "default": false } } }"#;
const TEMPLATE: &str = "@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn fill() -> @location(0) vec4<f32> {
  return vec4<f32>({{ 1.0 if warm else 0.0 }}, 0.0, 0.0, 1.0);
}
";

/// A folder with a pipeline and its template, in which a test introduces an error.
struct Project {
    folder: ScratchFolder,
}

impl Project {
    fn new(name: &str, pipeline: &str, axes: &str, template: &str) -> Self {
        let project = Self { folder: ScratchFolder::new(name) };
        std::fs::write(project.folder.join("small.json"), pipeline).unwrap();
        std::fs::write(project.folder.join("fill.axes.json"), axes).unwrap();
        std::fs::write(project.folder.join("fill.wgsl.jinja"), template).unwrap();
        project
    }

    fn run(&self, command: &str, further: &[&str]) -> Output {
        let folder = self.folder.to_str().unwrap();
        let pipeline = self.folder.join("small.json");
        let first = [command, pipeline.to_str().unwrap(), "--templates", folder];
        let verbose: &[&str] = if command == "permutations" { &["--verbose"] } else { &[] };
        umbragraph(&[&first, verbose, further].concat())
    }

    /// Runs `permutations`, which must fail with errors that contain all of these texts.
    #[track_caller]
    fn rejected(&self, further: &[&str], says: &[&str]) -> String {
        umbragraph_test_support::command::rejected(&self.run("permutations", further), 1, says)
    }
}

fn umbragraph(arguments: &[&str]) -> Output {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).current_dir(root).output().expect("the command")
}

/// Runs `permutations --verbose`, which prints a line for each pass.
fn verbose(arguments: &[&str]) -> Output {
    umbragraph(&[&["permutations", "--verbose"], arguments].concat())
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stdout)))
}

/// Returns the paths of the pipelines in a folder, relative to the workspace.
fn pipelines(folder: &str) -> Vec<String> {
    let entries =
        std::fs::read_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut paths: Vec<String> =
        names.filter(|name| name.ends_with(".json")).map(|name| format!("{folder}/{name}")).collect();
    paths.sort();
    paths
}

#[test]
fn every_pipeline_of_the_tree_holds_in_all_its_configurations() {
    let mut names: Vec<String> =
        ["nebula", "caracal", "mantis"].map(|name| format!("pipelines/{name}.json")).to_vec();
    // The others take minutes: `cargo xtask soak` proves them.
    if property::times() > 1 {
        names = ["pipelines", "pipelines/extended"].iter().flat_map(|folder| pipelines(folder)).collect();
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let output = verbose(&names);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    assert!(said.contains("(depth.wgsl.jinja): 4 combinations, 3 distinct texts"), "{said}");
    assert!(said.contains("for webgpu, webgpu-compat, vulkan, metal, dx12"), "{said}");
    assert!(said.lines().last().unwrap().contains("combinations covered by"), "{said}");
}

#[test]
fn modes_cover_what_they_say() {
    let project = Project::new("permutations-modes", PIPELINE, AXES, TEMPLATE);
    let covered = |further: &[&str]| {
        let document = json(&project.run("permutations", &[further, &["--format", "json"]].concat()));
        let templates = document["templates"].as_array().unwrap().clone();
        let own = templates.iter().find(|each| each["template"] == "fill.wgsl.jinja").unwrap().clone();
        (own["covered"]["number"].as_u64().unwrap(), own["variants"].as_array().unwrap().len())
    };
    assert_eq!(covered(&[]), (4, 2));
    assert_eq!(covered(&["--config"]), (1, 1));
    assert_eq!(covered(&["--feature", "warm"]), (1, 1));
    assert_eq!(covered(&["--all"]), (4, 2));
    let said = text(&project.run("permutations", &["--all"]).stderr);
    assert!(said.contains("UG0550") && said.contains("\"late\""), "the dead axis is reported: {said}");
}

#[test]
fn text_that_only_another_template_needs_is_not_called_dead() {
    let template =
        format!("{{% include 'part.wgsl.jinja' %}}\n{}", TEMPLATE.replace("if warm", "if warm and late"));
    let project = Project::new("permutations-shared", PIPELINE, AXES, &template);
    let part = "{% if late and not warm and not late %}\n// never\n{% endif %}\n// part\n";
    std::fs::write(project.folder.join("part.wgsl.jinja"), part).unwrap();
    let said = |project: &Project| text(&project.run("permutations", &["--all"]).stderr);
    assert!(said(&project).contains("UG0551"), "nobody else includes the part: {}", said(&project));
    std::fs::write(project.folder.join("other.wgsl.jinja"), &template).unwrap();
    assert!(!said(&project).contains("UG0551"), "another template may need it: {}", said(&project));
}

#[test]
fn dead_code_of_an_own_file_is_found_in_every_mode() {
    let template = format!(
        "{{% include \"lib/fullscreen.wgsl.jinja\" %}}\n{}",
        TEMPLATE.replace(
            "  return vec4<f32>({{",
            "{% if warm and not warm %}\n// never\n{% endif %}\n  return vec4<f32>({{"
        )
    );
    let project = Project::new("permutations-own", PIPELINE, AXES, &template);
    for mode in [&["--all"][..], &[], &["--config"], &["--feature", "warm"]] {
        let output = project.run("permutations", mode);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("UG0550") && said.contains("\"late\"") && !said.contains("\"warm\""), "{said}");
        assert!(said.contains("UG0551") && said.contains("fill.wgsl.jinja:7:1"), "{said}");
        assert!(
            !said.contains("shaders-templates/"),
            "what comes with the program is not the user's: {said}"
        );
    }
}

#[test]
fn what_a_pipeline_cannot_reach_is_no_diagnostic_of_it() {
    let pipeline = PIPELINE.replace(r#""late": { "type""#, r#""late": { "excludes": ["warm"], "type""#);
    let template = TEMPLATE
        .replace("return vec4<f32>({{", "{% if warm and late %}broken{% endif %} return vec4<f32>({{");
    let project = Project::new("permutations-reach", &pipeline, AXES, &template);
    let reached = project.run("permutations", &[]);
    assert_eq!(reached.status.code(), Some(0), "{}", text(&reached.stderr));
    project.rejected(&["--all"], &["UG0520", "fill.wgsl.jinja:5:", "late=true, warm=true"]);
}

#[test]
fn the_outcome_is_the_same_with_any_number_of_threads() {
    let broken = TEMPLATE.replace("0.0, 0.0, 1.0);\n}\n", "{% if late %}nothing{% endif %}, 0.0, 1.0);\n}\n");
    for template in [TEMPLATE, &broken] {
        let project = Project::new("permutations-threads", PIPELINE, AXES, template);
        let run = |threads: &str| {
            let output = project.run("permutations", &["--threads", threads, "--format", "json"]);
            (output.status.code(), text(&output.stdout), text(&output.stderr))
        };
        let one = run("1");
        assert!(["2", "3", "16"].into_iter().all(|threads| run(threads) == one));
    }
}

#[test]
fn diagnostics_stand_in_the_template_in_every_format() {
    let template = TEMPLATE
        .replace("return vec4<f32>({{", "{% if warm %}let x: f32 = 1u;{% endif %}\n  return vec4<f32>({{");
    let project = Project::new("permutations-formats", PIPELINE, AXES, &template);
    project.rejected(&[], &["fill.wgsl.jinja:5:", "provoked by warm=true"]);
    let output = project.run("permutations", &["--format", "json"]);
    assert_eq!(output.status.code(), Some(1));
    let diagnostic = json(&output)["diagnostics"][0].clone();
    assert_eq!(diagnostic["place"]["line"], 5, "{diagnostic}");
    assert_eq!(diagnostic["variants"], 1, "{diagnostic}");
    assert_eq!(diagnostic["provoked_by"], serde_json::json!({ "warm": true }), "{diagnostic}");
    assert_eq!(diagnostic["profiles"], serde_json::json!(["vulkan", "webgpu"]), "{diagnostic}");
    let whole = &diagnostic["templates"][0];
    assert_eq!(
        (&whole["template"], &whole["of_variants"]),
        (&"fill.wgsl.jinja".into(), &2.into()),
        "{diagnostic}"
    );
    let output = project.run("permutations", &["--format", "github"]);
    let said = text(&output.stdout);
    let line = said.lines().next().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(line.starts_with("::error file=") && line.contains("fill.wgsl.jinja,line=5,"), "{said}");
    assert!(line.contains("warm=true") && line.contains("%0A"), "{said}");
}

#[test]
fn a_profile_that_rejects_a_variant_fails_every_check() {
    let wide = TEMPLATE.replace(
        "@fragment",
        "@group(0) @binding(0) var<uniform> block: array<vec4<f32>, {{ 2000 if warm else 4 }}>;\n@fragment",
    );
    let wide = wide
        .replace("), 0.0, 0.0, 1.0);", "), block[0].x, 0.0, 1.0);")
        .replace("}}, 0.0, 0.0, 1.0)", "}}, block[0].x, 0.0, 1.0)");
    let bound = PIPELINE.replace(r#""color": ["#, r#""bind": { "block": "&data" }, "color": ["#).replace(
        r#""resources": {"#,
        r#""resources": { "data": { "buffer": { "size": 65536, "lifetime": "imported" } }, "#,
    );
    let claims = |profiles: &str| {
        let pipeline = bound.replace(r#"["webgpu", "vulkan"]"#, profiles);
        Project::new("permutations-profiles", &pipeline, AXES, &wide)
    };
    let project = claims(r#"["webgpu", "webgpu-compat"]"#);
    project.rejected(&[], &["UG0530", "webgpu-compat", "warm=true"]);
    let output = project.run("check", &["--feature", "warm"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("UG0530"), "{}", text(&output.stderr));
    let fine = project.run("permutations", &["--profile", "webgpu"]);
    assert_eq!(fine.status.code(), Some(0), "{}", text(&fine.stderr));
    claims(r#"["webgpu", "vulcan"]"#).rejected(&[], &["UG0006", "did you mean \"vulkan\"?", "small.json:2:"]);
    project.rejected(&["--profile", "metla"], &["UG0006", "did you mean \"metal\"?", "<command line>:1:"]);
}

#[test]
fn misspelt_axes_are_found_wherever_they_stand() {
    let in_template = TEMPLATE.replace("if warm", "if wram");
    Project::new("permutations-slip-1", PIPELINE, AXES, &in_template)
        .rejected(&[], &["UG0502", "wram", "fill.wgsl.jinja:5:"]);
    let in_pipeline = PIPELINE.replace(r#""color": ["#, r#""axes": { "wram": "=warm" }, "color": ["#);
    Project::new("permutations-slip-2", &in_pipeline, AXES, TEMPLATE)
        .rejected(&[], &["UG0602", "did you mean \"warm\"?", "small.json:5:"]);
    Project::new("permutations-slip-3", PIPELINE, AXES, TEMPLATE)
        .rejected(&["--feature", "wram"], &["UG0202", "did you mean \"warm\"?", "<command line>:1:"]);
}

#[test]
fn of_a_file_that_cannot_be_read_nothing_else_is_said() {
    let project = Project::new("permutations-bytes", PIPELINE, AXES, TEMPLATE);
    std::fs::write(project.folder.join("fill.wgsl.jinja"), b"// \xff\n").unwrap();
    let errors = project.rejected(&[], &["UG0002", "fill.wgsl.jinja:1:4", "1 error"]);
    assert!(!errors.contains("UG0500"), "{errors}");
    let project = Project::new("permutations-bytes-of-axes", PIPELINE, AXES, TEMPLATE);
    std::fs::write(project.folder.join("fill.axes.json"), b"{ \"\xff\" }").unwrap();
    let errors = project.rejected(&[], &["UG0002", "fill.axes.json:1:4", "1 error"]);
    assert!(!errors.contains("UG0502") && !errors.contains("UG0500"), "{errors}");
}

#[test]
fn an_axis_is_compared_with_its_values() {
    let axes = AXES.replace(
        r#""warm":"#,
        r#""mode": { "type": "enum", "values": ["hard", "soft"], "default": "hard" }, "warm":"#,
    );
    let template = TEMPLATE.replace("if warm", "if warm or mode == 'sofd'");
    let project = Project::new("permutations-compared", PIPELINE, &axes, &template);
    for mode in [&["--all"][..], &[]] {
        let errors = project.rejected(mode, &["UG0518", "fill.wgsl.jinja:5:", "did you mean \"soft\"?"]);
        assert!(!errors.contains("UG0550"), "what follows from it is withheld: {errors}");
    }
}

#[test]
fn constraints_that_clash_are_named() {
    let axes = AXES.replace(
        "} } }",
        r#"} }, "constraints": [{ "one_of": ["warm"] }, { "when": "warm", "excludes": ["warm"] }] }"#,
    );
    let project = Project::new("permutations-clash", PIPELINE, &axes, TEMPLATE);
    for further in [&["--all"][..], &[]] {
        let errors = project.rejected(further, &["UG0516", "fill.axes.json:3:", "warm excludes warm"]);
        assert_eq!(errors.matches("UG0516").count(), 1, "a clash is said once: {errors}");
    }
}

#[cfg(unix)]
#[test]
fn external_validators_may_be_missing_crash_or_hang() {
    let project = Project::new("permutations-external", PIPELINE, AXES, TEMPLATE);
    let accepts = project.run("permutations", &["--also", "true {}"]);
    assert_eq!(accepts.status.code(), Some(0), "{}", text(&accepts.stderr));
    project.rejected(&["--also", "/nowhere/tint {}"], &["UG0560", "<command line>:1:"]);
    project.rejected(&["--also", "sh -c 'kill -9 $$' {}"], &["UG0561", "fill.wgsl.jinja"]);
    project.rejected(
        &["--also", "sh -c 'sleep 60' {}", "--also-time-limit", "1"],
        &["UG0562", "fill.wgsl.jinja"],
    );
    project.rejected(
        &["--also", "sh -c 'echo $0:5:3: error: not so; exit 1' {}"],
        &["not so", "fill.wgsl.jinja:5:"],
    );
    for unusable in ["tint", "", "tint '{}"] {
        assert_eq!(project.run("permutations", &["--also", unusable]).status.code(), Some(2), "{unusable}");
    }
}

#[test]
fn texts_are_written_whole_under_names_that_say_what_they_are() {
    let project = Project::new("permutations-write", PIPELINE, AXES, TEMPLATE);
    let out = project.folder.join("new/out");
    let output = project.run("permutations", &["--write", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut names: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names.len(), 2, "{names:?}");
    assert!(
        names[0].starts_with("small.fill.warm=false.") && names[1].starts_with("small.fill.warm=true."),
        "{names:?}"
    );
    assert!(std::fs::read_to_string(out.join(&names[1])).unwrap().contains("vec4<f32>(1.0, 0.0, 0.0, 1.0)"));
    let blocked = project.folder.join("small.json/out");
    project.rejected(&["--write", blocked.to_str().unwrap()], &["UG0004"]);
}

#[test]
fn axes_are_listed_with_values_defaults_and_constraints() {
    let output = umbragraph(&["permutations", "--axes", "pipelines/nebula.json"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0));
    assert!(said.contains("tone_map: none, reinhard, filmic, pbr_neutral or agx (default filmic)"), "{said}");
    let listed = json(&umbragraph(&["permutations", "--axes", "--format", "json"]));
    assert!(listed.as_array().unwrap().iter().any(|each| each["template"] == "depth.wgsl.jinja"), "{listed}");
    for arguments in [
        &["permutations"][..],
        &["permutations", "x.json", "--threads", "0"],
        &["permutations", "--all", "--set", "a=1"],
    ] {
        assert_eq!(umbragraph(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn scene_data_is_compared_with_shaders_without_a_device() {
    let folder = ScratchFolder::new("permutations-host");
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let geometry =
        std::fs::read_to_string(root.join("shaders-templates/lib/scene_blocks.wgsl.jinja")).unwrap();
    std::fs::create_dir_all(folder.join("lib")).unwrap();
    let moved = geometry.replace("    emissive: vec3<f32>,", "    @size(32) emissive: vec3<f32>,");
    assert_ne!(moved, geometry);
    std::fs::write(folder.join("lib/scene_blocks.wgsl.jinja"), moved).unwrap();
    for command in ["check", "permutations"] {
        let output = umbragraph(&[command, "pipelines/nebula.json", "--templates", folder.to_str().unwrap()]);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(errors.contains("\"material.alpha_cutoff\" lies at byte 28 on the host"), "{errors}");
    }
}

#[test]
fn a_variant_is_shown_in_a_target_language_with_its_map() {
    let show = |further: &[&str]| {
        umbragraph(&[&["wgsl", "pipelines/nebula.json", "--pass", "casters"], further].concat())
    };
    let spirv = show(&["--target", "spirv"]).stdout;
    assert_eq!(spirv.get(..4), Some(&0x0723_0203_u32.to_le_bytes()[..]));
    assert!(text(&show(&["--target", "msl"]).stdout).contains("#include <metal_stdlib>"));
    assert!(text(&show(&["--target", "hlsl"]).stdout).contains("cbuffer"));
    assert!(text(&show(&["--target", "glsl"]).stdout).contains("#version"));
    let mapped = text(&show(&["--map", "--properties=alpha_masked"]).stdout);
    assert!(mapped.contains("lib/meshes.wgsl.jinja:2") && mapped.contains("fn cut_out("), "{mapped}");
    assert!(!text(&show(&["--properties="]).stdout).contains("fn cut_out("));
    assert_eq!(show(&["--target", "spriv"]).status.code(), Some(2));
    assert!(text(&show(&["--properties=alpha_maskd"]).stderr).contains("did you mean \"alpha_masked\"?"));
}

#[test]
fn a_second_run_proves_nothing_and_a_changed_one_what_changed() {
    let project = Project::new("permutations-cache", PIPELINE, AXES, TEMPLATE);
    let folder = project.folder.join("cache");
    let cache = ["--cache", folder.to_str().unwrap()];
    let last = |further: &[&str]| {
        let output = project.run("permutations", &[&cache[..], further].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let first = last(&[]);
    assert!(first.contains("all of them proven now"), "{first}");
    let second = last(&[]);
    assert!(second.contains("nothing had to be proven again"), "{second}");
    let said =
        |text: &str| text.lines().map(|line| line.split("; ").next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(said(&first), said(&second));
    // Other arguments are another run, of which all declarations are known.
    let third = last(&["--threads", "1"]);
    assert!(third.contains("nothing had to be proven again"), "{third}");
    let json: serde_json::Value = serde_json::from_str(&last(&["--format", "json"])).unwrap();
    assert_eq!((&json["proven"], &json["texts"]), (&0.into(), &2.into()));
    // Files that are cut short or changed are not there.
    for entry in std::fs::read_dir(&folder).unwrap().flatten() {
        let mut bytes = std::fs::read(entry.path()).unwrap();
        let at = bytes.len() / 2;
        bytes[at] ^= 1;
        std::fs::write(entry.path(), bytes).unwrap();
    }
    assert_eq!(last(&[]), first);
    let changed = TEMPLATE.replace("0.0, 0.0, 1.0);", "0.5, 0.0, 1.0);");
    assert_ne!(changed, TEMPLATE);
    std::fs::write(project.folder.join("fill.wgsl.jinja"), changed).unwrap();
    assert!(last(&[]).contains("proven now"));
    let without = project.run("permutations", &["--no-cache"]);
    assert!(text(&without.stdout).contains("all of them proven now"));
    assert_eq!(project.run("permutations", &["--cache", "x", "--no-cache"]).status.code(), Some(2));
    let blocked = project.folder.join("small.json/cache");
    let output = project.run("permutations", &["--cache", blocked.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn every_text_can_be_proven_by_itself_with_the_same_outcome() {
    let template = TEMPLATE
        .replace("return vec4<f32>({{", "{% if warm %}let x: f32 = 1u;{% endif %}\n  return vec4<f32>({{");
    for template in [TEMPLATE, &template] {
        let project = Project::new("permutations-exhaustive", PIPELINE, AXES, template);
        let run = |further: &[&str]| {
            let output = project.run("permutations", further);
            (output.status.code(), text(&output.stderr))
        };
        assert_eq!(run(&["--exhaustive"]), run(&[]));
    }
}
