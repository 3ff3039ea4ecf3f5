//! Looks at contents: what is shown is that of the shown frame, and a look changes nothing.

use serde_json::{Value, json};

use crate::hand::Hand;

const PIPELINE: &str = r#"{
  "format": 1, "name": "own",
  "resources": {
    "steps": { "buffer": { "size": 16, "lifetime": "persistent" } },
    "trail": { "texture": { "format": "r32float", "size": [4, 4], "lifetime": "history", "initial": [0, 0, 0, 1] } },
    "two": { "texture": { "format": "r32float", "size": [4, 4] } },
    "coat": { "texture": { "format": "rgba16float", "size": [4, 4] } },
    "volume": { "texture": { "format": "rgba8unorm", "size": [8, 8], "layers": 4, "view_dimension": "3d" } },
    "many": { "texture": { "format": "rgba16float", "size": "=viewport", "samples": 4 } },
    "given": { "texture": { "format": "rgba8unorm", "size": [4, 4], "lifetime": "imported" } },
    "copied": { "texture": { "format": "rgba8unorm", "size": [4, 4] } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "count": {
      "side_effect": true,
      "compute": { "shader": "count.wgsl.jinja", "bind": { "steps": "&steps" }, "workgroups": [1, 1, 1] }
    },
    "trace": {
      "side_effect": true,
      "fullscreen": { "shader": "trace.wgsl.jinja", "bind": { "before": "&trail@-1" }, "color": [{ "to": "&trail" }] }
    },
    "second": { "side_effect": true, "fullscreen": { "shader": "two.wgsl.jinja", "color": [{ "to": "&two" }] } },
    "paint": { "fullscreen": { "shader": "thin.wgsl.jinja", "color": [{ "to": "&coat" }] } },
    "thicken": {
      "side_effect": true, "fullscreen": { "shader": "thin.wgsl.jinja", "color": [{ "to": "&coat", "blend": "add" }] }
    },
    "fill": {
      "side_effect": true,
      "compute": {
        "shader": "fill.wgsl.jinja", "workgroups": [2, 2, 4],
        "bind": { "volume": { "texture": { "name": "&volume", "contents": "discard" } } }
      }
    },
    "sample": { "side_effect": true, "fullscreen": { "shader": "sample.wgsl.jinja", "color": [{ "to": "&many" }] } },
    "take": { "side_effect": true, "copy": { "from": { "name": "&given" }, "to": { "name": "&copied" } } },
    "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }
  }
}
"#;

/// The shaders, each by the name of its file.
fn shaders() -> [(&'static str, String); 6] {
    let fragment = |bindings: &str, arguments: &str, value: &str| {
        format!(
            "{{% include \"lib/fullscreen.wgsl.jinja\" %}}\n{bindings}\n@fragment\nfn fill({arguments}) -> @location(0) vec4<f32> {{\n    return {value};\n}}\n"
        )
    };
    let before = "@group(1) @binding(0) var before: texture_2d<f32>;";
    [
        (
            "count",
            "@group(1) @binding(0) var<storage, read_write> steps: array<u32>;\n\n@compute @workgroup_size(1)\nfn count() {\n    steps[0] = steps[0] + 1u;\n}\n".to_owned(),
        ),
        ("trace", fragment(before, "", "textureLoad(before, vec2<u32>(0u, 0u), 0) + vec4<f32>(1.0)")),
        ("two", fragment("", "", "vec4<f32>(2.0)")),
        ("thin", fragment("", "", "vec4<f32>(0.0, 0.0, 0.0, 0.25)")),
        (
            "fill",
            "@group(1) @binding(0) var volume: texture_storage_3d<rgba8unorm, write>;\n\n@compute @workgroup_size(4, 4, 1)\nfn fill(@builtin(global_invocation_id) at: vec3<u32>) {\n    textureStore(volume, at, vec4<f32>(f32(at.z) / 4.0, 0.0, 0.0, 1.0));\n}\n".to_owned(),
        ),
        (
            "sample",
            fragment("", "@builtin(sample_index) index: u32", "vec4<f32>(f32(index), 0.0, 0.0, 1.0)"),
        ),
    ]
}

fn start() -> Option<Hand> {
    Hand::start_with("looking", PIPELINE, |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        for (name, text) in shaders() {
            std::fs::write(folder.join(format!("shaders/{name}.wgsl.jinja")), text).unwrap();
        }
        ["--scale", "0.25", "--templates", "shaders"].map(str::to_owned).to_vec()
    })
}

/// Selects a resource in the graph.
fn select(hand: &mut Hand, name: &str) {
    hand.type_into("search graph");
    hand.display.press(&[crate::x11::CONTROL], u32::from('a'));
    hand.display.press(&[], crate::x11::BACKSPACE);
    hand.display.write(name);
    hand.click(&format!("resource {name}"));
}

fn is_of(state: &Value, name: &str) -> bool {
    state["contents"]["of"][0].as_str().is_some_and(|of| of.split('@').next() == Some(name))
}

/// The mean of a channel of the shown texture.
fn mean(state: &Value, channel: usize) -> f64 {
    state["contents"]["channels"][channel]["mean"].as_f64().unwrap_or(f64::NAN)
}

/// The number of steps that the buffer shows.
fn steps(state: &Value) -> f64 {
    let text = state["contents"]["fields"][0][1].as_str();
    text.and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

#[test]
fn looks_show_the_frame_and_advance_nothing() {
    let Some(mut hand) = start() else { return };
    hand.settle();
    let given = hand.state()["warnings"].to_string();
    assert!(given.contains("no contents for \\\"given\\\""), "{given}");
    hand.click("values");
    hand.wait("no values", |state| state["panel"]["open"] == false);
    assert_eq!(hand.settle()["kept_bytes"], 0, "nothing is copied while nobody looks");
    // The inspector takes its room from the frame, which is drawn anew.
    select(&mut hand, "steps");
    hand.wait("steps", |state| is_of(state, "steps"));
    let state = hand.settle();
    assert!(state["kept_bytes"].as_u64() >= Some(16), "{}", state["kept_bytes"]);
    let frames = state["frames"].clone();
    let count = frames.as_f64().unwrap();
    hand.wait("all steps", |state| steps(state) == count && state["frames"] == frames);
    select(&mut hand, "trail");
    hand.wait("trail of the frame", |state| is_of(state, "trail") && mean(state, 0) == count);
    // Once more, with a look at something else between.
    select(&mut hand, "steps");
    let again = hand.wait("steps", |state| is_of(state, "steps") && steps(state) > 0.0);
    assert_eq!((steps(&again), &again["frames"]), (count, &frames), "looks advance nothing");
    // The next frames go on from there.
    hand.click("step");
    hand.wait("step", |state| state["frames"] != frames);
    let later = hand.settle()["frames"].clone();
    let passed = later.as_f64().unwrap() - frames.as_f64().unwrap();
    hand.wait("later steps", |state| steps(state) == count + passed);
    select(&mut hand, "trail");
    hand.wait("later trail", |state| is_of(state, "trail") && mean(state, 0) == count + passed);
    // A difference with another texture.
    hand.click("side difference");
    hand.click("against");
    hand.click("against two");
    hand.wait("difference", |state| {
        state["contents"]["of"] == json!(["trail@trace", "two@second"])
            && mean(state, 0) == count + passed - 2.0
    });
    // A difference of alpha alone.
    select(&mut hand, "coat");
    hand.click("side difference");
    let state = hand.wait("alpha", |state| is_of(state, "coat") && (mean(state, 3) - 0.25).abs() < 1e-3);
    assert_eq!(mean(&state, 0), 0.0);
    hand.click("channel");
    hand.click("channel=A");
    hand.wait("channel", |state| state["contents"]["channel"] == 3 && (mean(state, 0) - 0.25).abs() < 1e-3);
    // A slice of a volume.
    select(&mut hand, "volume");
    let state = hand.wait("volume", |state| is_of(state, "volume") && state["contents"]["size"].is_array());
    assert_eq!(state["contents"]["size"][2], 4);
    hand.click("layer");
    hand.click("layer=3");
    hand.wait("slice", |state| state["contents"]["layer"] == 3 && (mean(state, 0) - 0.75).abs() < 0.01);
    // Single samples.
    select(&mut hand, "many");
    hand.wait("sample", |state| is_of(state, "many") && mean(state, 0) == 0.0);
    let [from, to] = [[0.5, 0.5], [3.0, 0.5]].map(|part| hand.point("sample", part));
    hand.drag(from, to);
    hand.wait("another sample", |state| {
        let sample = state["contents"]["sample"].as_f64().unwrap_or(0.0);
        sample > 0.0 && mean(state, 0) == sample
    });
    assert_eq!(hand.state()["frames"], later);
    hand.click("close inspector");
    hand.wait("no copies", |state| state["selected"].is_null() && state["kept_bytes"] == 0);
    assert_eq!(hand.state()["errors"], json!([]));
}
