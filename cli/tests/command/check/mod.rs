//! `umbragraph check`: which configurations it covers, and what it says of them.

mod causes;
mod fix;

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(arguments)
        .current_dir(root())
        .output()
        .expect("the command")
}

/// Returns a pipeline in which each feature adds a pass over the picture; `more` has further passes.
fn pipeline(features: usize, more: &str) -> String {
    let list = |each: &dyn Fn(usize) -> String| (0..features).map(each).collect::<Vec<_>>().join(",\n");
    let declared = list(&|at| format!("\"f{at}\": {{ \"type\": \"bool\", \"default\": false }}"));
    let passes = list(&|at| {
        let after: String = (0..at).map(|before| format!(", \"add{before}\"")).collect();
        format!(
            "\"add{at}\": {{ \"when\": \"=f{at}\", \"after\": [\"paint\"{after}], \"fullscreen\": \
             {{ \"shader\": \"gradient.wgsl.jinja\", \"color\": [{{ \"to\": \"&target\", \"blend\": \"add\" }}] }} }}"
        )
    });
    format!(
        r#"{{
  "format": 1, "name": "features",
  "features": {{ {declared} }},
  "resources": {{
    "spare": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
  }},
  "passes": {{
    "paint": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target", "clear": [0, 0, 0, 1] }}] }} }},
    {passes}{more}
  }}
}}"#
    )
}

const READS_NOTHING: &str = r#",
    "copy": { "when": "=f0 && f2", "after": ["paint", "add0", "add1", "add2"], "fullscreen": {
      "shader": "resample.wgsl.jinja", "bind": { "source": "&spare" }, "color": [{ "to": "&target", "blend": "add" }] } }"#;

#[test]
fn errors_of_a_pipeline_are_no_defect_of_the_compiler() {
    let unwritten = r#"{
  "format": 1, "name": "mips",
  "resources": {
    "levels": { "texture": { "format": "rgba8unorm", "size": [256, 256], "mips": 4 } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "first": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&levels", "mip": 0 }] } },
    "last": { "fullscreen": { "shader": "resample.wgsl.jinja",
      "bind": { "source": { "texture": { "name": "&levels", "mip": 2 } } }, "color": [{ "to": "&target" }] } } }
}"#;
    let folder = ScratchFolder::new("check-errors-verified");
    let path = folder.join("mips.json");
    std::fs::write(&path, unwritten).unwrap();
    let output = run(&["check", "--verify", path.to_str().unwrap()]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("UG0401") && !said.contains("violation"), "{said}");
}

#[test]
fn every_feature_configuration_is_covered_and_verified() {
    let folder = ScratchFolder::new("check-configurations");
    let path = folder.join("features.json");
    let path = path.to_str().unwrap();
    std::fs::write(path, pipeline(6, "")).unwrap();
    let output = run(&["check", "--verify", path]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(said.contains("64 configurations, plans verified"), "{said}");
    assert!(text(&run(&["check", path, "--feature", "f1=false"]).stdout).contains(", 32 configurations,"));
    assert!(text(&run(&["check", path, "--config"]).stdout).contains(", 1 configuration,"));

    std::fs::write(path, pipeline(12, "")).unwrap();
    let said = text(&run(&["check", path]).stdout);
    assert!(
        said.contains("configurations of 4096 (more than 256, so every value of a feature with"),
        "{said}"
    );
    let json = run(&["check", path, "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["pipelines"][0]["cover"], "pairs");
    assert_eq!(json["pipelines"][0]["reachable"], 4096);
}

#[test]
fn diagnostics_of_some_configurations_name_their_choices_once() {
    let folder = ScratchFolder::new("check-some");
    let path = folder.join("features.json");
    let path = path.to_str().unwrap();
    std::fs::write(path, pipeline(3, READS_NOTHING)).unwrap();
    let output = run(&["check", path]);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(errors.matches("UG0401").count(), 1, "{errors}");
    let told = "in 2 of 8 configurations; the fewest choices that show it: f0=true, f2=true";
    assert!(errors.contains(told), "{errors}");
    assert_eq!(run(&["check", path, "--config"]).status.code(), Some(0), "the defaults are sound");
    let chosen = run(&["check", path, "--config", "--feature", "f0", "--feature", "f2"]);
    assert_eq!(chosen.status.code(), Some(1));
    assert!(!text(&chosen.stderr).contains("configurations"), "{}", text(&chosen.stderr));
}

#[test]
fn a_preset_is_a_configuration_of_its_own() {
    let folder = ScratchFolder::new("check-presets");
    let path = folder.join("features.json");
    let path = path.to_str().unwrap();
    let presets = r#""presets": { "all": { "features": { "f0": true, "f1": true } } }, "resources""#;
    let constrained = pipeline(2, "")
        .replace("\"resources\"", presets)
        .replace("\"f1\": { ", "\"f1\": { \"excludes\": [\"f0\"], ");
    std::fs::write(path, constrained).unwrap();
    let errors = text(&run(&["check", path]).stderr);
    assert!(errors.contains("UG0206") && errors.contains("with --preset all"), "{errors}");
}

#[test]
fn parts_of_pipelines_are_checked_as_what_they_are() {
    let folder = ScratchFolder::new("check-parts");
    let part = |name: &str| root().join("pipelines").join(name).display().to_string();
    for (name, what) in [
        ("learn/parts/overlay.json", "an extension"),
        ("learn/parts/through_small.json", "a subgraph"),
        ("learn/parts/wide.json", "a parameter file"),
        ("params/lore_contact_sun.json", "a parameter file"),
    ] {
        let output = run(&["check", &part(name)]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
        assert!(text(&output.stdout).contains(&format!(": {what} of the form")), "{}", text(&output.stdout));
    }
    let broken = folder.join("broken.json");
    let overlay = std::fs::read_to_string(part("learn/parts/overlay.json")).unwrap();
    std::fs::write(&broken, overlay.replace("\"bind\"", "\"bnid\"")).unwrap();
    let output = run(&["check", &broken.display().to_string()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("unknown key \"bnid\""), "{}", text(&output.stderr));
}

const CHOSEN: &str = r#"{
  "format": 1, "name": "chosen",
  "parameters": {
    "way": { "type": "enum", "values": ["plain", "shown"], "default": "plain" },
    "strength": { "type": "f32", "default": 1, "unit": "1", "min": 0, "max": 2 }
  },
  "resources": {
    "spare": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "aside": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&spare" }] } },
    "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } },
    "show": { "when": "=way == 'shown'", "after": ["fill"], "fullscreen": { "shader": "resample.wgsl.jinja",
      "bind": { "SOURCE": "&spare" }, "color": [{ "to": "&target",
        "blend": { "color": { "src_factor": "constant", "dst_factor": "one" }, "constant": "=[strength, 1, 1, 0]" } }] } }
  }
}
"#;

#[test]
fn unused_and_unchecked_parts_are_listed_below_the_line() {
    let folder = ScratchFolder::new("check-remarks");
    let path = folder.join("chosen.json");
    let path = path.to_str().unwrap();
    std::fs::write(path, CHOSEN.replace("SOURCE", "source")).unwrap();
    let output = run(&["check", path, "--verbose"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let quiet = run(&["check", path]);
    assert_eq!(text(&quiet.stdout).lines().collect::<Vec<_>>(), [said.lines().next().unwrap()]);
    assert_eq!(text(&quiet.stderr), "", "nothing on a pipe");
    assert!(said.contains("\n  culled: nothing reads what aside writes: spare\n"), "{said}");
    assert!(said.contains("\n  parameters without effect here: strength\n"), "{said}");
    assert!(said.contains("\n  not checked: 1 configurations with other values of parameters"), "{said}");
    let folder = folder.join("");
    let templates = text(&run(&["check", path, "--verbose", "--templates", folder.to_str().unwrap()]).stdout);
    let named = format!("`umbragraph permutations {path} --templates {}`", folder.display());
    assert!(templates.contains(&named), "{templates}");
    let shown = text(&run(&["check", path, "--verbose", "--set", "way=shown"]).stdout);
    assert!(!shown.contains("culled:") && !shown.contains("without effect"), "{shown}");

    // What only a parameter reaches is found by `permutations`, as the line says.
    std::fs::write(path, CHOSEN.replace("SOURCE", "sorce")).unwrap();
    assert_eq!(run(&["check", path]).status.code(), Some(0));
    assert_eq!(run(&["permutations", path]).status.code(), Some(1));
}

#[test]
fn a_missing_file_is_compared_with_neighbours_and_bundled_files() {
    let folder = ScratchFolder::new("check-files");
    std::fs::write(folder.join("lighting.json"), "{}").unwrap();
    let path = folder.join("slip.json");
    for (name, meant) in [
        ("lightning.json", "\"lighting.json\", which lies beside it?"),
        ("nebula.json", "\"umbragraph:nebula.json\"?"),
        ("parts/blurr.json", "\"umbragraph:parts/blur.json\"?"),
        ("umbragraph:nebla.json", "\"umbragraph:nebula.json\"?"),
    ] {
        std::fs::write(&path, format!(r#"{{ "format": 1, "name": "slip", "extends": "{name}" }}"#)).unwrap();
        let said = text(&run(&["check", path.to_str().unwrap()]).stderr);
        assert!(said.contains(&format!("help: did you mean {meant}")), "{name}: {said}");
    }
    // So is one that the command line names.
    for (name, meant) in
        [("lighting.jsn", "lighting.json\", which lies beside"), ("nebla.json", "umbragraph:nebula.json\"")]
    {
        let said = text(&run(&["check", folder.join(name).to_str().unwrap()]).stderr);
        assert!(said.contains(&format!("help: did you mean \"{meant}")), "{name}: {said}");
    }
}

#[test]
fn a_feature_set_as_a_parameter_is_named_and_the_reverse() {
    for (option, given, said) in [
        (
            "--set",
            "light_filter=hard",
            "\"light_filter\" is a feature: it stands under \"features\", or behind --feature",
        ),
        ("--set", "light_filtr=hard", "\"light_filter\" is a feature"),
        (
            "--feature",
            "exposure=2",
            "\"exposure\" is a parameter: it stands under \"parameters\", or behind --set",
        ),
        ("--feature", "light_filtr=hard", "did you mean \"light_filter\"?"),
    ] {
        let found = text(&run(&["check", "umbragraph:awsm.json", "--config", option, given]).stderr);
        assert!(found.contains(&format!("help: {said}")), "{given}: {found}");
    }
}

#[test]
fn a_dispatch_that_covers_less_than_it_writes_is_named() {
    let folder = ScratchFolder::new("check-dispatch");
    let shader = "@group(0) @binding(0) var image: texture_storage_2d<rgba8unorm, write>;\n\
        @compute @workgroup_size(8, 8) fn paint(@builtin(global_invocation_id) at: vec3<u32>) {\n\
        textureStore(image, at.xy, vec4<f32>(1.0)); }\n";
    std::fs::write(folder.join("paint.wgsl.jinja"), shader).unwrap();
    let path = folder.join("small.json");
    let document = r#"{ "format": 1, "name": "small",
      "resources": { "image": { "texture": { "format": "rgba8unorm", "size": [64, 64], "lifetime": "persistent" } } },
      "passes": { "paint": { "side_effect": true, "compute": { "shader": "paint.wgsl.jinja", "bind": { "image": "&image" },
        "workgroups": [7, 8, 1] } } } }"#;
    let said = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let output =
            run(&["check", path.to_str().unwrap(), "--templates", folder.to_str().unwrap(), "--verbose"]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let words = "paint has 56 by 64 for image of 64 by 64";
    assert!(said(document).contains(words), "{}", said(document));
    assert!(!said(&document.replace("[7, 8, 1]", "[8, 8, 1]")).contains("invocations"));
    assert!(
        !said(&document.replace("\"workgroups\": [7, 8, 1]", "\"dispatch_over\": \"&image\""))
            .contains("invocations")
    );
}

#[test]
fn a_filter_that_scenes_do_not_know_is_found_without_a_scene() {
    let folder = ScratchFolder::new("check-filter");
    let path = folder.join("slip.json");
    let document = r#"{ "format": 1, "name": "slip", "extends": "umbragraph:nebula.json",
      "passes": { "shade": { "draw": { "mesh_filter": "opaqe" } } } }"#;
    std::fs::write(&path, document).unwrap();
    let output = run(&["check", path.to_str().unwrap()]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for words in ["error[UG0805]", "knows no filter \"opaqe\"", "slip.json:2:55", "did you mean \"opaque\"?"]
    {
        assert!(said.contains(words), "{words} is missing in {said}");
    }
    std::fs::write(&path, document.replace("opaqe", "what else")).unwrap();
    let said = text(&run(&["check", path.to_str().unwrap()]).stderr);
    assert!(
        said.contains("it knows all, opaque, transparent, moving, casters, static_casters, dynamic_casters"),
        "{said}"
    );
}

#[test]
fn a_folder_is_no_file_to_include() {
    let folder = ScratchFolder::new("check-include-folder");
    let path = folder.join("main.json");
    std::fs::write(&path, fix::MISSPELT.replace("part.json", ".")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(["check", "main.json"])
        .current_dir(&*folder)
        .output()
        .unwrap();
    let errors = text(&output.stderr);
    assert!(errors.contains("the file \".\" cannot be read: it is a folder"), "{errors}");
}

#[test]
fn check_gives_its_diagnostics_as_sarif() {
    let output = run(&["check", "pipelines/nebula.json", "--set", "far=[]", "--format", "sarif"]);
    assert_eq!(output.status.code(), Some(1));
    let log: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(log["version"], "2.1.0");
    let results = log["runs"][0]["results"].as_array().unwrap();
    assert!(!results.is_empty() && results.iter().all(|result| result["message"]["text"].is_string()));
}

#[test]
fn switching_on_a_grouped_feature_switches_the_default_off() {
    let path = "pipelines/learn/19-feature-groups.json";
    let said = text(&run(&["check", path]).stdout);
    assert!(said.contains(", 3 configurations,"), "{said}");
    let bright = run(&["plan", path, "--feature", "bright"]);
    assert_eq!(bright.status.code(), Some(0), "{}", text(&bright.stderr));
    assert!(text(&bright.stdout).contains(" again "), "{}", text(&bright.stdout));
    let both = run(&["check", path, "--feature", "bright", "--feature", "covered"]);
    let errors = text(&both.stderr);
    assert!(errors.contains("UG0217") && errors.contains("<command line>:1:1"), "{errors}");
}

#[test]
fn features_and_booleans_take_on_off_true_and_false() {
    let path = "pipelines/learn/19-feature-groups.json";
    let plan = |settings: &[&str]| {
        let output = run(&[&["plan", path], settings].concat());
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let words = plan(&["--feature", "plain=off", "--feature", "bright=on"]);
    assert_eq!(words, plan(&["--feature", "plain=false", "--feature", "bright=true"]));
    assert!(words.1.contains(" again ") && words.2.is_empty(), "{words:?}");
    assert_ne!(words, plan(&["--feature", "plain=on", "--feature", "bright=off"]));
    let parameter = r#""features": { "#;
    let document = pipeline(1, "").replace(
        parameter,
        &[r#""parameters": { "wide": { "type": "bool", "default": true } }, "#, parameter].concat(),
    );
    let folder = ScratchFolder::new("check-on-off");
    let file = folder.join("features.json");
    std::fs::write(&file, document.replace("},\n    ,", "},\n    ")).unwrap();
    for (word, code) in [("wide=off", 0), ("wide=true", 0), ("wide=1", 1)] {
        let output = run(&["check", file.to_str().unwrap(), "--set", word]);
        assert_eq!(output.status.code(), Some(code), "{word}: {}", text(&output.stderr));
    }
    for word in ["ON", "yes", "0", "of", "[]", ""] {
        let (code, _, said) = plan(&["--feature", &format!("bright={word}")]);
        assert_eq!(code, Some(1), "{word}");
        assert!(said.contains("UG0203") && said.contains("on, off, true or false"), "{word}: {said}");
        assert!(said.contains("write bright=on or bright=off") && said.ends_with("1 error\n"), "{said}");
    }
}

#[test]
fn an_unused_declaration_is_a_note_that_fails_no_check() {
    let folder = ScratchFolder::new("check-unused");
    let part = r#"{ "inputs": { "image": "what is measured" }, "parameters": { "by": { "type": "u32", "default": 2 }, "idle": { "type": "u32", "default": 2 } },
  "resources": { "less": { "texture": { "format": "rgba8unorm", "size": "=image / by" } } },
  "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&less" }] }, "side_effect": true } } }"#;
    let pipeline = r#"{ "format": 1, "name": "unused",
  "parameters": {
    "side": { "type": "u32", "default": 64, "description": "Not spare." }, "spare": { "type": "f32", "default": 1 },
    "by": { "type": "u32", "default": 2 }, "around": { "type": "u32", "default": 2 }, "shadowed": { "type": "u32", "default": 2 }
  },
  "features": {
    "multisampled": { "type": "bool", "default": false }, "left": { "type": "bool", "default": false },
    "tied": { "type": "bool", "default": false, "excludes": ["multisampled"] }
  },
  "presets": { "one": { "parameters": { "spare": 2 }, "features": { "left": true } } },
  "subgraphs": { "inner": { "parameters": { "shadowed": { "type": "u32", "default": 2 } },
    "resources": { "own": { "texture": { "format": "rgba8unorm", "size": ["=around", "=shadowed"] } } },
    "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&own" }] }, "side_effect": true } } } },
  "resources": {
    "color": { "texture": { "format": "rgba8unorm", "size": ["=side", 64], "samples": "=multisampled ? 4 : 1" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&color" }] } },
    "show": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" }, "bind": { "source": "&color" }, "color": [{ "to": "&target" }] } },
    "a": { "use": "inner" }, "b": { "use": "part.json", "with": { "image": "&color" } } } }"#;
    for (name, text) in [("part.json", part), ("unused.json", pipeline)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let path = folder.join("unused.json");
    let path = path.to_str().unwrap();
    let output = run(&["check", path]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(text(&output.stdout).contains("valid for"), "{said}");
    let mut named: Vec<&str> = said
        .lines()
        .filter_map(|line| {
            line.strip_prefix("note[UG0220]: the ")?.strip_suffix(" is declared, but nothing uses it")
        })
        .collect();
    named.sort_unstable();
    let expected = [
        "feature \"left\"",
        "parameter \"by\"",
        "parameter \"idle\"",
        "parameter \"shadowed\"",
        "parameter \"spare\"",
    ];
    assert_eq!(named, expected, "{said}");
    assert!(said.contains("part.json:1:"), "{said}");
    // A misspelt use is the diagnostic; that nothing else uses it only follows.
    std::fs::write(path, pipeline.replace("[\"=side\", 64]", "[\"=sied\", 64]")).unwrap();
    let said = text(&run(&["check", path]).stderr);
    assert!(said.contains("did you mean \"side\"?") && !said.contains("UG0220"), "{said}");
}

#[test]
fn a_broken_pipeline_hides_no_note_about_another() {
    let folder = ScratchFolder::new("check-unused-beside");
    let spare = "\"parameters\": { \"idle\": { \"type\": \"f32\", \"default\": 1 } },\n  \"resources\"";
    let fine = pipeline(1, "").replacen("\"resources\"", spare, 1);
    let cut = fine.replacen('{', "{ \"include\": \"gone.json\",", 1);
    for (name, text) in [("fine.json", fine), ("cut.json", cut)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let paths = ["fine.json", "cut.json"].map(|name| folder.join(name).to_str().unwrap().to_owned());
    let said = text(&run(&["check", &paths[0], &paths[1]]).stderr);
    assert!(said.contains("error[UG0001]") && said.contains("fine.json:"), "{said}");
    assert_eq!(said.matches("note[UG0220]").count(), 1, "{said}");
}

#[test]
fn passes_whose_template_is_broken_are_counted_as_such() {
    let folder = ScratchFolder::new("check-broken-template");
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    write("broken.wgsl.jinja", "{% if %}");
    let document = pipeline(
        0,
        ", \"blur\": { \"fullscreen\": { \"shader\": \"broken.wgsl.jinja\", \"color\": [{ \"to\": \"&target\" }] } }",
    );
    let path = write("features.json", &document.replace("},\n    ,", "},\n    "));
    let templates = folder.join("");
    let output = run(&["check", &path, "--templates", templates.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    let (said, diagnostics) = (text(&output.stdout), text(&output.stderr));
    assert!(
        said.ends_with("features.json: 1 of 2 passes could not be checked, because of errors\n"),
        "{said}"
    );
    assert!(diagnostics.contains("UG0501") && diagnostics.ends_with("1 error\n"), "{diagnostics}");
}

/// The pass "show" reads the version of "paint", which this frame has written before "scratch" discards it. The
/// attachment names the mip level, the reader does not.
#[test]
fn what_is_discarded_after_it_was_read_is_no_diagnostic() {
    let folder = ScratchFolder::new("check-discarded-later");
    let path = folder.join("pipeline.json");
    let check = |toggle: &str| {
        let text = format!(
            r#"{{ "format": 1, "name": "later", "toggles": {{ "paint": {{ "default": true }} }},
  "resources": {{
    "kept": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" }} }},
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
  }},
  "passes": {{
    "paint": {{ {toggle} "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&kept", "clear": [0, 0, 0, 0] }}] }} }},
    "show": {{ "fullscreen": {{ "shader": "resample.wgsl.jinja", "bind": {{ "source": "&kept@paint" }},
      "color": [{{ "to": "&target" }}] }} }},
    "scratch": {{ "after": ["show"], "fullscreen": {{ "shader": "gradient.wgsl.jinja",
      "color": [{{ "to": "&kept", "clear": [0, 0, 0, 0], "store": "discard" }}] }} }}
  }} }}"#
        );
        std::fs::write(&path, text).unwrap();
        text_of_check(&path)
    };
    assert!(check("").contains("valid for webgpu"));
    let toggled = check(r#""toggle": "paint","#);
    assert!(toggled.contains("\"show\" reads \"kept\" of the frame before"), "{toggled}");
}

fn text_of_check(path: &std::path::Path) -> String {
    let output = run(&["check", &path.to_string_lossy()]);
    [text(&output.stdout), text(&output.stderr)].concat()
}

#[test]
fn more_configurations_than_64_bits_hold_are_no_crash() {
    let folder = ScratchFolder::new("check-many");
    let path = folder.join("many.json");
    let path = path.to_str().unwrap();
    let more = |at: usize| format!("\"g{at}\": {{ \"type\": \"bool\", \"default\": false }}, ");
    let features: String = (1..80).map(more).collect();
    std::fs::write(path, pipeline(1, "").replace("\"f0\": {", &format!("{features}\"f0\": {{"))).unwrap();
    let output = run(&["check", path, "--format", "json"]);
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(said["pipelines"][0]["reachable"], "1208925819614629174706176", "{said}");
}
