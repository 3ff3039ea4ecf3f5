//! `umbragraph why` as a user meets it: one case for each kind of thing, with exactly what is said.
//!
//! `UMBRAGRAPH_BLESS=1` writes the expected texts under `tests/why/` again.

use std::path::{Path, PathBuf};
use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs `why`. Returns the output of both streams and the exit status as text.
fn said(arguments: &str, more: &[&str]) -> String {
    said_in(&root(), arguments, more)
}

fn said_in(folder: &Path, arguments: &str, more: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .arg("why")
        .args(arguments.split(' '))
        .args(more)
        .current_dir(folder)
        .output()
        .expect("the command");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!("{}{}exit {}\n", text(&output.stdout), text(&output.stderr), output.status.code().unwrap_or(-1))
}

#[track_caller]
fn compare(name: &str, said: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/why/{name}.txt"));
    if std::env::var_os("UMBRAGRAPH_BLESS").is_some() {
        std::fs::write(&path, said).unwrap();
    }
    let wanted = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert_eq!(said, wanted, "{name}");
}

#[track_caller]
fn case(name: &str, arguments: &str) {
    compare(name, &said(&format!("pipelines/learn/{arguments}"), &[]));
}

#[test]
fn a_parameter_takes_the_last_of_default_preset_file_and_option() {
    case(
        "parameter",
        "13-presets.json width --preset low --params pipelines/learn/parts/wide.json --set width=64",
    );
    case("parameter-preset", "13-presets.json height --preset low --params pipelines/learn/parts/wide.json");
}

#[test]
fn a_pass_and_a_feature_of_one_name_are_both_told() {
    case("feature", "10-features.json glow");
    case("feature-on", "10-features.json glow --feature glow");
}

#[test]
fn a_preset_a_subgraph_an_extension_point_and_an_input() {
    case("preset", "13-presets.json low --preset low");
    case("subgraph", "08-subgraph.json through_small");
    case("extension-point", "12-extension-point.json after_paint");
    case("input", "08-subgraph.json coarse.image");
    case("subgraph-parameter", "08-subgraph.json coarse.divisor");
}

#[test]
fn a_resource_through_the_files_that_it_comes_from() {
    case("resource-extends", "06-extends.json painted");
    case("resource-include", "07-include.json canvas");
}

#[test]
fn a_pass_its_chain_to_the_output_and_the_pass_of_an_instance() {
    case("pass-extends", "06-extends.json show");
    case("pass-instance", "08-subgraph.json soft.down");
    case("pass-use", "08-subgraph.json soft");
    case("pass-round", "09-loops-and-mips.json down.0");
    case("pass-loop", "09-loops-and-mips.json down");
    case("pass-extension", "12-extension-point.json show --extension pipelines/learn/parts/echo.json");
    case("extension", "12-extension-point.json echo --extension pipelines/learn/parts/echo.json");
}

#[test]
fn two_resources_that_do_not_share_memory() {
    case("apart", "08-subgraph.json soft.small coarse.small");
    case("apart-json", "08-subgraph.json sharp target --format json");
    case("apart-unknown", "13-presets.json width canvsa");
}

#[test]
fn json_has_the_same_answers() {
    case("json", "06-extends.json painted --format json");
}

#[test]
fn unknown_names_get_a_proposal_and_deleted_ones_their_places() {
    for (name, suggested) in [
        ("soft.smal", "soft.small"),
        ("coarse.dwon", "coarse.down"),
        ("through_smal", "through_small"),
        ("pain", "paint"),
    ] {
        let said = said(&format!("pipelines/learn/08-subgraph.json {name}"), &[]);
        assert!(
            said.contains("UG0008") && said.contains(&format!("did you mean \"{suggested}\"?")),
            "{said}"
        );
        assert!(said.ends_with("exit 1\n"), "{said}");
    }
    assert!(said("pipelines/learn/13-presets.json hihg", &[]).contains("did you mean \"high\"?"));
    assert!(said("pipelines/learn/09-loops-and-mips.json down.3", &[]).contains("UG0008"));
    case("deleted", "06-extends.json keep");
}

const BROKEN: &str = r#"{
  "format": 1,
  "name": "broken",
  "parameters": { "side": { "type": "u32", "default": 8, "unit": "texel", "min": 1, "max": 64 } },
  "toggles": { "bloom": { "default": true } },
  "resources": {
    "a": { "texture": { "format": "rgba8unorm", "size": ["=side", "=side"] } },
    "unread": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "b": { "texture": { "format": "rgba8unorm", "size": ["=side", "=side"] } },
    "c": { "texture": { "format": "rgba8unorm", "size": ["=side", "=side"] } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "first": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&a" }] } },
    "second": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&a" }, "color": [{ "to": "&b" }] } },
    "third": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&b" }, "color": [{ "to": "&c" }] } },
    "aside": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&b" }, "color": [{ "to": "&unread" }] } },
    "show": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&c" }, "color": [{ "to": "&target" }] } },
    "glow": { "toggle": "bloom", "after": ["show"], "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&c" }, "color": [{ "to": "&target", "blend": "add" }] } }
  }
}
"#;

#[test]
fn why_explains_culling_aliasing_toggles_and_errors() {
    let folder = ScratchFolder::new("why");
    let case = |name: &str, text: &str, arguments: &[&str]| {
        std::fs::write(folder.join("small.json"), text).unwrap();
        compare(name, &said_in(&folder, "small.json", arguments));
    };
    case("culled", BROKEN, &["aside"]);
    case("culled-resource", BROKEN, &["unread"]);
    case("shared", BROKEN, &["a"]);
    case("shared-two", BROKEN, &["a", "c"]);
    case("alive-together", BROKEN, &["a", "b"]);
    case("toggle", BROKEN, &["bloom"]);
    case("toggled", BROKEN, &["glow"]);
    let errors =
        BROKEN.replace("\"source\": \"&a\"", "\"source\": \"&aa\"").replace("\"max\": 64", "\"max\": 4");
    case("errors-pass", &errors, &["second"]);
    case("errors-resource", &errors, &["a"]);
    case("errors-two", &errors, &["a", "c"]);
    case("errors-parameter", &errors, &["side", "--set", "side=3"]);
}

#[test]
fn presets_and_defaults_that_an_extending_file_replaces() {
    let folder = ScratchFolder::new("why-layers");
    std::fs::write(folder.join("base.json"), BROKEN).unwrap();
    std::fs::write(
        folder.join("over.json"),
        r#"{
  "extends": "base.json", "name": "over",
  "parameters": { "side": { "default": 16 } },
  "presets": { "tiny": { "parameters": { "side": 2 } } },
  "passes": { "aside": { "fullscreen": { "bind": null } } }
}"#,
    )
    .unwrap();
    compare("layers-parameter", &said_in(&folder, "over.json", &["side", "--preset", "tiny"]));
    let pass = said_in(&folder, "over.json", &["aside"]);
    assert!(
        pass.contains("fullscreen.bind") && pass.contains("deleted") && pass.contains("base.json:17:"),
        "{pass}"
    );
}

#[test]
fn data_tells_its_values_and_a_setting_its_shaders() {
    let eye = said("pipelines/nebula.json eye", &[]);
    assert!(eye.contains("publishes   clip_from_world: mat4x4<f32>, world to clip space"), "{eye}");
    let settings = said("pipelines/awsm.json rotate_taps", &[]);
    assert!(settings.contains("used by  shade "), "{settings}");
}
