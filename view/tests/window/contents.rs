//! Contents that are no plain texture: fields of a buffer, the stencil, faces of a cube.

use serde_json::{Value, json};

use crate::hand::Hand;
use crate::x11::{DOWN, END, F6, HOME, PAGE_DOWN, PAGE_UP, TAB, UP};

const PIPELINE: &str = r#"{
  "format": 1, "name": "own",
  "resources": {
    "numbers": { "buffer": { "size": 48 } },
    "sky": { "texture": { "format": "rgba8unorm", "size": [32, 32], "layers": 6, "view_dimension": "cube" } },
    "mask": { "texture": { "format": "depth24plus-stencil8", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "empty": { "clear": { "buffer": "&numbers" } },
    "count": {
      "side_effect": true,
      "compute": { "shader": "count.wgsl.jinja", "bind": { "numbers": "&numbers" }, "workgroups": [1, 1, 1] }
    },
    FACES
    "mark": {
      "fullscreen": {
        "shader": "gradient.wgsl.jinja",
        "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }],
        "stencil": { "to": "&mask", "clear": 0, "reference": 5, "front": { "pass": "replace" } }
      }
    },
    "again": {
      "fullscreen": {
        "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target", "blend": "add" }],
        "stencil": { "to": "&mask", "reference": 5, "front": { "compare": "equal" } }
      }
    }
  }
}
"#;

const COUNT: &str = "struct Entry {
    place: vec3<f32>,
    count: u32,
}

struct Numbers {
    total: i32,
    entries: array<Entry>,
}

@group(1) @binding(0) var<storage, read_write> numbers: Numbers;

@compute @workgroup_size(1)
fn count() {
    numbers.total = -3;
    numbers.entries[1] = Entry(vec3<f32>(1.5, -2.0, 0.25), 7u);
}
";

const BLUE: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}
@fragment
fn fill() -> @location(0) vec4<f32> {
    return vec4<f32>(0.0, 0.0, 1.0, 1.0);
}
";

#[test]
fn buffers_stencil_and_faces_are_shown() {
    let faces = ["+x", "-x", "+y", "-y", "+z", "-z"].map(|face| {
        let shader = if face == "-y" { "blue" } else { "gradient" };
        let name = face.replace('+', "plus_").replace('-', "minus_");
        format!(
            r#""{name}": {{ "side_effect": true, "fullscreen": {{ "shader": "{shader}.wgsl.jinja", "color": [{{ "to": "&sky", "face": "{face}" }}] }} }},"#
        )
    });
    let pipeline = PIPELINE.replace("FACES", &faces.concat());
    let hand = Hand::start_with("contents", &pipeline, |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        std::fs::write(folder.join("shaders/count.wgsl.jinja"), COUNT).unwrap();
        std::fs::write(folder.join("shaders/blue.wgsl.jinja"), BLUE).unwrap();
        ["--scale", "0.25", "--templates", "shaders"].map(str::to_owned).to_vec()
    });
    let Some(mut hand) = hand else { return };
    assert_eq!(hand.settle()["errors"], json!([]));
    // Without the panel of values all of the graph is in view.
    hand.click("values");
    hand.wait("no values", |state| state["panel"]["open"] == false);
    let search = |hand: &mut Hand, name: &str| {
        hand.type_into("search graph");
        hand.display.press(&[crate::x11::CONTROL], u32::from('a'));
        hand.display.press(&[], crate::x11::BACKSPACE);
        hand.display.write(name);
        hand.click(&format!("resource {name}"));
    };
    // A buffer by its fields, after and before the pass that wrote them.
    search(&mut hand, "numbers");
    let state = hand.wait("fields", |state| {
        state["contents"]["of"] == json!(["numbers@count"]) && state["contents"]["layout"] == "Numbers"
    });
    let expected = json!([
        ["total", "-3"],
        ["entries[0].place", "(0, 0, 0)"],
        ["entries[0].count", "0"],
        ["entries[1].place", "(1.5, -2, 0.25)"],
        ["entries[1].count", "7"]
    ]);
    assert_eq!(state["contents"]["fields"], expected);
    hand.click("side difference");
    hand.wait("changed fields", |state| {
        state["contents"]["fields"]
            == json!([
                ["total", "0 → -3"],
                ["entries[1].place", "(0, 0, 0) → (1.5, -2, 0.25)"],
                ["entries[1].count", "0 → 7"]
            ])
    });
    hand.click("close inspector");
    // The stencil, of a texture whose depth nobody writes.
    search(&mut hand, "mask");
    let mean = |state: &Value| state["contents"]["channels"][0]["mean"].clone();
    let has = |name: &'static str| {
        move |state: &Value| state["contents"]["of"][0].as_str().is_some_and(|of| of.starts_with(name))
    };
    hand.wait("no depth", |state| {
        state["not_captured"].as_str().is_some_and(|said| said.contains("reads the depth of \"mask\""))
    });
    hand.click("stencil");
    let state = hand.wait("stencil", |state| state["contents"]["stencil"] == true && mean(state) == 5.0);
    assert_eq!(state["contents"]["channels"].as_array().map(Vec::len), Some(1));
    hand.click("close inspector");
    // A face of a cube.
    search(&mut hand, "sky");
    hand.wait("cube", has("sky"));
    hand.click("layer");
    hand.click("layer=3");
    let state = hand.wait("face", |state| state["contents"]["layer"] == 3);
    let means: Vec<&Value> =
        state["contents"]["channels"].as_array().unwrap().iter().map(|channel| &channel["mean"]).collect();
    assert_eq!(means, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(hand.state()["errors"], json!([]));
}

/// A buffer with more fields than the inspector has rows.
const LONG: &str = r#"{
  "format": 1, "name": "own",
  "resources": {
    "long": { "buffer": { "size": 4000 } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "empty": { "clear": { "buffer": "&long" } },
    "count": {
      "side_effect": true,
      "compute": { "shader": "long.wgsl.jinja", "bind": { "numbers": "&long" }, "workgroups": [1, 1, 1] }
    },
    "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }
  }
}
"#;

const LONG_COUNT: &str = "@group(1) @binding(0) var<storage, read_write> numbers: array<u32>;

@compute @workgroup_size(1)
fn count() {
    for (var at = 0u; at < 1000u; at++) {
        numbers[at] = at * 2u;
    }
}
";

#[test]
fn long_buffers_scroll_by_keyboard() {
    let hand = Hand::start_with("long", LONG, |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        std::fs::write(folder.join("shaders/long.wgsl.jinja"), LONG_COUNT).unwrap();
        ["--scale", "0.25", "--templates", "shaders"].map(str::to_owned).to_vec()
    });
    let Some(mut hand) = hand else { return };
    assert_eq!(hand.settle()["errors"], json!([]));
    hand.click("resource long");
    let start = hand.wait("fields", |state| state["contents"]["fields"][1] == json!(["[1]", "2"]));
    hand.press_until("inspector", (&[], F6), 8, |state| state["keyboard"] == "panel Inspector");
    hand.press_until("fields", (&[], TAB), 30, |state| state["keyboard"] == "fields");
    assert!(hand.state()["contents"]["row"].is_null());
    let number = |value: &Value| value.as_u64().unwrap_or(u64::MAX);
    let row = |state: &Value| number(&state["contents"]["row"]);
    let is_seen = |state: &Value| {
        let rows = &state["contents"]["rows"];
        state["controls"][format!("field [{}]", row(state))].is_array()
            && (number(&rows[0])..number(&rows[1])).contains(&row(state))
    };
    let mut press = |key: u32, wanted: &dyn Fn(u64) -> bool| {
        hand.display.press(&[], key);
        let state = hand.wait("chosen row in view", |state| wanted(row(state)) && is_seen(state));
        assert_eq!(state["keyboard"], "fields");
        row(&state)
    };
    press(DOWN, &|row| row == 0);
    press(DOWN, &|row| row == 1);
    let page = press(PAGE_DOWN, &|row| row > 5) - 1;
    press(PAGE_DOWN, &|row| row == 1 + 2 * page);
    press(PAGE_UP, &|row| row == 1 + page);
    press(END, &|row| row == 999);
    press(DOWN, &|row| row == 999);
    press(UP, &|row| row == 998);
    press(HOME, &|row| row == 0);
    press(END, &|row| row == 999);
    // The keys did nothing else.
    let state = hand.state();
    assert_eq!((&state["contents"]["of"], &state["camera"]), (&start["contents"]["of"], &start["camera"]));
    hand.click("field [990]");
    hand.wait("clicked row", |state| row(state) == 990 && state["keyboard"] == "fields");
}
