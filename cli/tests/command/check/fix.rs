//! `umbragraph check --fix`: what is misspelt is mended where it is written.

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

use super::{root, run};

pub(super) const MISSPELT: &str = r#"{
  "format": 1, "name": "misspelt", "include": ["part.json"],
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    // The comment stays.
    "fill": { "fulscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&targt" }] } }
  }
}
"#;

const PART: &str = r#"{ "parameters": { "near": { "type": "f32", "default": 1, "unti": "m" } } }
"#;

#[test]
fn check_fix_mends_several_files_and_then_finds_nothing() {
    let folder = ScratchFolder::new("check-fix");
    let (main, part) = (folder.join("main.json"), folder.join("part.json"));
    std::fs::write(&main, MISSPELT).unwrap();
    std::fs::write(&part, format!("\u{feff}{PART}")).unwrap();
    let path = main.to_str().unwrap();
    let dry = run(&["check", "--fix", "--dry-run", path]);
    let difference = text(&dry.stdout);
    assert_eq!(dry.status.code(), Some(1), "something would change: {}", text(&dry.stderr));
    assert!(difference.contains("\n-    \"fill\": { \"fulscreen\""), "{difference}");
    assert!(difference.contains("\"to\": \"&target\" }] } }\n"), "{difference}");
    assert!(difference.contains("+++ ") && difference.contains("\"unit\": \"m\""), "{difference}");
    assert_eq!(std::fs::read_to_string(&main).unwrap(), MISSPELT, "a dry run writes nothing");

    let output = run(&["check", "--fix", path]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("main.json:6:15: \"fulscreen\" now \"fullscreen\""), "{said}");
    let fixed = MISSPELT.replace("fulscreen", "fullscreen").replace("targt", "target");
    assert_eq!(std::fs::read_to_string(&main).unwrap(), fixed);
    assert_eq!(std::fs::read_to_string(&part).unwrap(), format!("\u{feff}{}", PART.replace("unti", "unit")));
    assert_eq!(std::fs::read_dir(&*folder).unwrap().count(), 2, "no temporary file is left");
    let again = run(&["check", "--fix", path]);
    assert!(!text(&again.stderr).contains("fixed "), "{}", text(&again.stderr));
    let dry = run(&["check", "--fix", "--dry-run", path]);
    assert!(!text(&dry.stdout).contains("@@"), "{}", text(&dry.stdout));
    for output in [&again, &dry] {
        assert_eq!(output.status.code(), Some(0), "there was nothing to do");
        assert!(
            text(&output.stderr).contains("nothing is wrong that can be mended"),
            "{}",
            text(&output.stderr)
        );
    }
}

#[test]
fn errors_that_cannot_be_mended_are_left_with_status_1() {
    let folder = ScratchFolder::new("check-fix-left");
    let path = folder.join("left.json");
    let left = MISSPELT.replace("\"include\": [\"part.json\"],", "").replace("rgba8unorm", "nothing like it");
    std::fs::write(&path, &left).unwrap();
    let path = path.to_str().unwrap();
    let output = run(&["check", "--fix", path]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("fixed "), "{}", text(&output.stderr));
    let dry = run(&["check", "--fix", "--dry-run", path]);
    assert_eq!(dry.status.code(), Some(1), "nothing would change, and an error is left");
    assert_eq!(text(&dry.stdout), "");
}

/// A pipeline of several files that misspells a name of each kind; the correct names are in brackets.
const EVERYWHERE: [(&str, &str); 4] = [
    (
        "base.json",
        r#"{ "format": 1, "name": "base",
  "parameters": { "side": { "type": "u32", "default": 64, "unit": "texel" }, "spare": { "type": "f32", "default": 1 } },
  "features": { "half": { "type": "bool", "default": true, "requires": ["whloe<whole>"] }, "whole": { "type": "bool", "default": true } },
  "toggles": { "debug": { "default": true } },
  "extension_points": { "at_the_end": { "after": ["fill"] } },
  "presets": { "low": { "parameters": { "sdie<side>": 32 } } },
  "subgraphs": { "copy": { "inputs": { "image": "what is copied" }, "parameters": { "divisor": { "type": "u32", "default": 2 } },
    "resources": { "small": { "texture": { "format": "rgba8unrom<rgba8unorm>", "size": "=iamge<image> / divisor" } } },
    "passes": { "down": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&image" }, "color": [{ "to": "&smlal<small>" }] }, "side_effect": true } } } },
  "resources": {
    "first": { "texture": { "format": "rgba8unorm", "size": ["=side", "=max(sdie<side>, 8)"] } },
    "second": { "texture": { "format": "rgba8unorm", "size": ["=frist<first>.width", "=first.hieght<first.height>"] } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "fill": { "fullscreen": { "shader": "gradeint<gradient>.wgsl.jinja", "color": [{ "to": "&first" }] } },
    "more": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&first@flil<fill>" }, "color": [{ "to": "&second" }] }, "toggle": "!debgu<debug>", "passthrough": { "second": "&frist<first>" } },
    "small": { "use": "cpoy<copy>", "with": { "image": "&secnod<second>", "divisor": "=sdie<side> / 32" } },
    "show": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&second" }, "color": [{ "to": "&target" }] }, "after": ["flil<fill>"] } } }
"#,
    ),
    (
        "main.json",
        r#"{ "format": 1, "name": "main", "extends": "base.json", "paremeters<parameters>": { "spaer<spare>": null } }
"#,
    ),
    (
        "more.json",
        r#"{ "format": 1, "name": "more", "inserts": { "at_teh_end<at_the_end>": {
  "mark": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&traget<target>", "blend": "add" }] }, "after": ["shwo<show>"] } } } }
"#,
    ),
    (
        "params.json",
        r#"{ "preset": "lwo<low>", "paramters<parameters>": { "sdie<side>": 128 }, "features": { "hlaf<half>": true } }
"#,
    ),
];

#[test]
fn a_name_misspelt_anywhere_is_mended_where_it_is_written() {
    let folder = ScratchFolder::new("check-fix-everywhere");
    // Each name as it is written, and as it is meant.
    let read = |text: &str, is_right: bool| -> String {
        let mut pieces = text.split('<');
        let mut result = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            let (right, rest) = piece.split_once('>').unwrap();
            if is_right {
                let start = result
                    .rfind(|c: char| !c.is_alphanumeric() && c != '_' && (c != '.' || !right.contains('.')));
                result.truncate(start.map_or(0, |at| at + 1));
                result += right;
            }
            result += rest;
        }
        result
    };
    for (name, text) in EVERYWHERE {
        std::fs::write(folder.join(name), read(text, false)).unwrap();
    }
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (main, more, params) = (path("main.json"), path("more.json"), path("params.json"));
    let output = run(&["check", "--fix", &main, "--extension", &more, "--params", &params]);
    let said = text(&output.stderr);
    for (name, text) in EVERYWHERE {
        assert_eq!(std::fs::read_to_string(folder.join(name)).unwrap(), read(text, true), "{said}");
    }
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[test]
fn diagnostics_of_a_subgraph_file_are_placed_and_fixed_in_it() {
    let folder = ScratchFolder::new("check-subgraph-file");
    let read = |name: &str| std::fs::read_to_string(root().join("pipelines/learn").join(name)).unwrap();
    std::fs::create_dir(folder.join("parts")).unwrap();
    let (pipeline, part) = (folder.join("pipeline.json"), folder.join("parts/through_small.json"));
    let sound = read("parts/through_small.json");
    std::fs::write(&pipeline, read("21-subgraph-file.json")).unwrap();
    std::fs::write(&part, sound.replacen("\"color\":", "\"colour\":", 1)).unwrap();
    let path = pipeline.to_string_lossy().into_owned();
    let output = run(&["check", &path, "--format", "json"]);
    let diagnostics: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let [diagnostic] = &diagnostics["diagnostics"].as_array().unwrap()[..] else { panic!("{diagnostics}") };
    assert_eq!(diagnostic["place"]["file"], *part.to_string_lossy());
    assert_eq!(diagnostic["place"]["pointer"], "/passes/down/fullscreen/colour");
    let sarif = text(&run(&["check", &path, "--format", "sarif"]).stdout);
    assert!(sarif.contains("\"/passes/down/fullscreen/colour\""), "{sarif}");
    assert_eq!(run(&["check", &path, "--fix"]).status.code(), Some(0));
    assert_eq!(std::fs::read_to_string(&part).unwrap(), sound);
}
