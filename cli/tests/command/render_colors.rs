//! `umbragraph render` where the format of the target is none of a screen.

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

fn render(folder: &ScratchFolder, format: &str, out: &str) -> Output {
    let document = format!(
        r#"{{ "format": 1, "name": "colors",
            "resources": {{ "target": {{ "texture": {{ "format": "{format}", "size": "=viewport", "lifetime": "imported" }} }} }},
            "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }} }}"#
    );
    let pipeline = folder.join("colors.json");
    std::fs::write(&pipeline, document).expect("a file");
    Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(["render", "--scene", "examples/scenes/figure.glb", "--size", "16x8", "--out"])
        .args([folder.join(out), pipeline])
        .current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .expect("the command")
}

#[test]
fn floats_are_tone_mapped_with_a_note_or_written_as_exr() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-colors");
    for format in ["rgba16float", "rgba32float"] {
        let output = render(&folder, format, "x.png");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(
            text(&output.stderr).contains("colors above 0.8 are tone mapped"),
            "{}",
            text(&output.stderr)
        );
        let output = render(&folder, format, "x.exr");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("tone mapped"), "{}", text(&output.stderr));
        let bytes = std::fs::read(folder.join("x.exr")).expect("the picture");
        assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01], "{format}");
    }
}

#[test]
fn other_formats_of_a_screen_are_written_without_a_note() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-screens");
    let mut pictures = Vec::new();
    for format in ["rgba8unorm", "bgra8unorm", "rgb10a2unorm"] {
        let output = render(&folder, format, "x.png");
        assert_eq!(output.status.code(), Some(0), "{format}: {}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("tone mapped"), "{}", text(&output.stderr));
        let file = std::fs::File::open(folder.join("x.png")).expect("the picture");
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("a frame");
        pictures.push(pixels);
    }
    assert_eq!(pictures[0], pictures[1]);
    assert!(pictures[0].iter().zip(&pictures[2]).all(|(one, other)| one.abs_diff(*other) <= 1));
}

#[test]
fn integers_are_no_picture() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-integers");
    let document = r#"{ "format": 1, "name": "words",
        "resources": { "target": { "texture": { "format": "r32uint", "size": "=viewport", "lifetime": "imported" } },
            "image": { "texture": { "format": "r32uint", "size": "=viewport" } } },
        "passes": { "copy": { "copy": { "from": { "name": "&image" }, "to": { "name": "&target" } } } } }"#;
    let pipeline = folder.join("words.json");
    std::fs::write(&pipeline, document).expect("a file");
    let output = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(["render", "--scene", "examples/scenes/figure.glb", "--size", "16x8", "--out"])
        .args([folder.join("x.png"), pipeline])
        .current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .expect("the command");
    assert_ne!(output.status.code(), Some(0));
    let said = text(&output.stderr);
    assert!(!folder.join("x.png").exists() && said.contains("error["), "{said}");
}
