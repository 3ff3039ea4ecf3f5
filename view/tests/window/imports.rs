//! `--import NAME=FILE`: a picture as a texture that passes only read, read again when the file changes.

use std::path::Path;

use serde_json::json;

use crate::hand::Hand;
use crate::read_back::pixels;

const PIPELINE: &str = r#"{
  "format": 1, "name": "own",
  "resources": {
    "palette": { "texture": { "format": "rgba8unorm", "size": [2, 1], "lifetime": "imported" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "paint": {
      "fullscreen": { "shader": "paint.wgsl.jinja", "bind": { "palette": "&palette" }, "color": [{ "to": "&target" }] }
    }
  }
}
"#;

const PAINT: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}
@group(1) @binding(0) var palette: texture_2d<f32>;

@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {
    return textureLoad(palette, vec2<i32>(i32(covered.uv.x * 2.0), 0), 0);
}
";

/// Writes a PNG of one row of RGB texels.
fn write_png(path: &Path, row: &[[u8; 3]]) {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, row.len() as u32, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(row.as_flattened()).unwrap();
    std::fs::write(path, file).unwrap();
}

/// The first and the last texel of the frame.
fn ends(hand: &mut Hand) -> [[u8; 3]; 2] {
    hand.settle();
    let name = format!("frame-{:03}.png", hand.files("frame-").len() + 1);
    hand.screenshot();
    let (_, pixels) = pixels(&hand.folder.join(name));
    [pixels[0], pixels[pixels.len() - 1]]
}

#[test]
fn pictures_fill_imports_and_are_read_again() {
    let (red, green, blue) = ([200, 10, 20], [10, 150, 30], [0, 50, 250]);
    let start = |name: &str, arguments: &[&str]| {
        let arguments: Vec<String> = arguments.iter().map(|one| (*one).to_owned()).collect();
        Hand::start_with(name, PIPELINE, |folder| {
            std::fs::create_dir(folder.join("shaders")).unwrap();
            std::fs::write(folder.join("shaders/paint.wgsl.jinja"), PAINT).unwrap();
            write_png(&folder.join("palette.png"), &[red, green]);
            let always = ["--scale", "0.25", "--templates", "shaders"].map(str::to_owned);
            always.into_iter().chain(arguments).collect()
        })
    };
    let Some(mut hand) =
        start("import", &["--import", "palette=palette.png", "--import", "other=palette.png"])
    else {
        return;
    };
    let state = hand.settle();
    assert_eq!(state["errors"], json!([]));
    let warnings = state["warnings"].to_string();
    assert!(warnings.contains("no pass uses an imported texture \\\"other\\\""), "{warnings}");
    assert!(!warnings.contains("no contents"), "{warnings}");
    assert_eq!(ends(&mut hand), [red, green]);
    let path = hand.folder.join("palette.png");
    write_png(&path, &[blue, red]);
    // Nothing else tells the test that the file was read.
    let before = hand.state()["frames"].clone();
    hand.wait("another frame", |state| state["frames"] != before);
    assert_eq!(ends(&mut hand), [blue, red]);
    // Broken or of another size, it keeps the last picture.
    std::fs::write(&path, "no picture").unwrap();
    let has =
        |words: &'static str| move |state: &serde_json::Value| state["errors"].to_string().contains(words);
    hand.wait("broken file", has("the picture cannot be read"));
    assert_eq!(ends(&mut hand), [blue, red]);
    write_png(&path, &[red; 3]);
    hand.wait("other size", has("has 2 × 1 texels, and"));
    write_png(&path, &[green, blue]);
    hand.wait("mended file", |state| state["errors"] == json!([]));
    assert_eq!(ends(&mut hand), [green, blue]);
    hand.click("copy command");
    hand.wait("command", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("--import palette=palette.png"))
    });
    drop(hand);
    let Some(mut hand) = start("import-none", &[]) else { return };
    let warnings = hand.settle()["warnings"].to_string();
    assert!(warnings.contains("\\\"palette\\\" has no contents: passes read zeros from it"), "{warnings}");
}
