//! Outputs that are no picture, and textures that no device makes: a diagnostic, and the window goes on.

use crate::hand::Hand;

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
        (pipeline(&texture("rgba16float"), color, ""), "is Rgba16Float"),
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
