//! Outputs that are no picture, and textures that no device makes: a diagnostic, and the window goes on. Outputs of
//! other formats than a screen's are shown as `umbragraph render` writes them.

use std::process::Command;

use crate::hand::{Hand, module};
use crate::output::command;
use crate::read_back::pixels;

/// The document of a pipeline with one pass and its own output texture. `more` declares further resources.
fn pipeline(texture: &str, pass: &str, more: &str) -> String {
    format!(
        r#"{{
  "format": 1, "name": "own",
  "resources": {{ "target": {{ "texture": {{ {texture}, "lifetime": "imported" }} }} {more} }},
  "passes": {{ "fill": {{ "fullscreen": {{ {pass} }} }} }}
}}"#
    )
}

const COUNT: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@fragment
fn fill(covered: Covered) -> @location(0) vec4<u32> {
    return vec4<u32>(u32(covered.uv.x * 9.0));
}
"#;

#[test]
fn an_output_that_is_no_picture_is_a_diagnostic() {
    let color = r#""shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }]"#;
    let texture = |format: &str| format!("\"format\": \"{format}\", \"size\": \"=viewport\"");
    let good = pipeline(&texture("rgba8unorm"), color, "");
    let huge = r#", "huge": { "texture": { "format": "rgba32float", "size": [8192, 8192], "layers": 256, "lifetime": "imported" } }"#;
    let count = r#""shader": "count.wgsl.jinja", "color": [{ "to": "&target" }]"#;
    let depth = r#""shader": "gradient.wgsl.jinja", "color": [{ "to": "&other", "clear": [0, 0, 0, 1] }], "depth": { "to": "&target", "clear": 1, "compare": "always" }"#;
    let other = r#", "other": { "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let samples = format!("{}, \"samples\": 4", texture("rgba8unorm"));
    let Some(mut hand) = Hand::start_with("formats", &pipeline(&texture("r32uint"), count, ""), |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        std::fs::write(folder.join("shaders/count.wgsl.jinja"), COUNT).unwrap();
        vec!["--templates".to_owned(), "shaders".to_owned(), "--scale".to_owned(), "0.25".to_owned()]
    }) else {
        return;
    };
    let says = |words: &'static str| {
        move |state: &serde_json::Value| {
            state["errors"]
                .as_array()
                .into_iter()
                .flatten()
                .any(|one| one.as_str().unwrap_or("").contains(words))
        }
    };
    hand.wait("unsigned integers", says("is R32Uint"));
    let path = hand.folder.join("own.json");
    for (text, words) in [
        (pipeline(&texture("depth32float"), depth, other), "is Depth32Float"),
        (pipeline(&samples, color, ""), "4 samples"),
        (pipeline("\"format\": \"rgba8unorm\", \"size\": [64, 64]", color, ""), "is 64 by 64"),
        (good.replace("\"passes\"", "\"unused\": {}, \"passes\""), "unused"),
    ] {
        std::fs::write(&path, text).unwrap();
        hand.wait(words, says(words));
    }
    std::fs::write(&path, &good).unwrap();
    hand.wait("a picture", |state| state["errors"] == serde_json::json!([]) && state["size"].is_array());
    // More memory than there is.
    let text = pipeline(&texture("rgba8unorm"), color, huge).replace("\"passes\": {", "\"passes\": {\n\"more\": { \"fullscreen\": { \"shader\": \"gradient.wgsl.jinja\", \"color\": [{ \"to\": \"&huge\", \"layer\": 0, \"clear\": [0, 0, 0, 1] }] } },");
    std::fs::write(&path, text).unwrap();
    hand.wait("rejected texture", says("the device rejected"));
    std::fs::write(&path, &good).unwrap();
    hand.wait("the picture again", |state| state["errors"] == serde_json::json!([]));
    hand.settle();
    hand.click("screenshot");
    hand.wait("screenshot", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("frame-001.png"))
    });
    assert!(!hand.said().contains("panicked"), "{}", hand.said());
}

const BRIGHT: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@fragment
fn fill(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(6.0 * covered.uv.x, covered.uv.y, 0.1 / covered.uv.x, 1.0);
}
"#;

#[test]
fn pictures_of_other_formats_are_those_of_render() {
    let text = |format: &str| {
        let texture = format!("\"format\": \"{format}\", \"size\": \"=viewport\"");
        pipeline(&texture, r#""shader": "bright.wgsl.jinja", "color": [{ "to": "&target" }]"#, "")
    };
    let Some(mut hand) = Hand::start_with("floats", &text("rgba16float"), |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        std::fs::write(folder.join("shaders/bright.wgsl.jinja"), BRIGHT).unwrap();
        ["--templates", "shaders", "--scale", "0.25"].map(str::to_owned).to_vec()
    }) else {
        return;
    };
    for (at, format) in ["rgba16float", "r32float", "bgra8unorm-srgb"].into_iter().enumerate() {
        std::fs::write(hand.folder.join("own.json"), text(format)).unwrap();
        // The note is there with the plan of a format of floats alone.
        let is_float = format.ends_with("float");
        hand.wait("plan of the format", |state| {
            let notes = state["warnings"].to_string();
            state["plans"].as_u64() > Some(at as u64) && notes.contains("tone mapped") == is_float
        });
        let state = hand.settle();
        assert_eq!(state["errors"], serde_json::json!([]), "{format}");
        hand.screenshot();
        let out = format!("{format}.png");
        let size = format!("{}x{}", state["size"][0], state["size"][1]);
        let output = Command::new(command())
            .args(["render", "own.json", "--templates", "shaders", "--size", &size, "--out", &out])
            .arg("--scene")
            .arg(module().join("examples/scenes/courtyard.glb"))
            .current_dir(&hand.folder)
            .output()
            .expect("the command");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let (shown, rendered) =
            (pixels(&hand.folder.join(format!("frame-{:03}.png", at + 1))), pixels(&hand.folder.join(&out)));
        assert_eq!(shown.0, rendered.0);
        let far = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
        let differ = shown.1.iter().zip(&rendered.1).filter(|pair| far(*pair)).count();
        assert_eq!(differ, 0, "{format}: pixels of {}", shown.1.len());
        let white = shown.1.iter().filter(|pixel| pixel[0] == 255).count();
        assert!(!is_float || white * 2 < shown.1.len(), "{format}: bright colors differ from one another");
    }
}
