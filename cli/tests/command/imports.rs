//! `umbragraph render --import`: pictures as textures that passes only read, or the reason why they cannot be.

use std::path::Path;
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

/// A pipeline whose left and right half are the first and the last texel of an import of the given declaration.
fn write_pipeline(folder: &ScratchFolder, palette: &str, (shape, texels): (&str, [&str; 2])) {
    let pipeline = format!(
        r#"{{ "format": 1, "name": "own",
            "resources": {{
              "palette": {{ "texture": {{ {palette}, "lifetime": "imported" }} }},
              "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
            }},
            "passes": {{ "paint": {{ "fullscreen": {{
              "shader": "paint.wgsl.jinja", "bind": {{ "palette": "&palette" }}, "color": [{{ "to": "&target" }}]
            }} }} }} }}"#
    );
    let [left, right] = texels;
    let shader = format!(
        "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
@group(1) @binding(0) var palette: {shape}<f32>;

@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {{
    if covered.uv.x < 0.5 {{
        return textureLoad(palette, {left}, 0);
    }}
    return textureLoad(palette, {right}, 0);
}}
"
    );
    std::fs::write(folder.join("own.json"), pipeline).expect("a pipeline");
    std::fs::write(folder.join("paint.wgsl.jinja"), shader).expect("a template");
}

const ROW: (&str, [&str; 2]) = ("texture_2d", ["vec2<i32>(0, 0)", "vec2<i32>(1, 0)"]);

fn render(folder: &ScratchFolder, arguments: &[&str]) -> Output {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/figure.glb");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["render", "own.json", "--templates", ".", "--size", "8x4", "--out", "out.png", "--scene"]);
    command.arg(scene).args(arguments).current_dir(folder.join(".")).output().expect("the command")
}

fn write_png(folder: &ScratchFolder, name: &str, [width, height]: [u32; 2], rgb: &[[u8; 3]]) {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb.as_flattened())).expect("a PNG");
    std::fs::write(folder.join(name), file).expect("a file");
}

/// The red of the first and the last texel of the frame.
fn reds(folder: &ScratchFolder) -> [u8; 2] {
    let file = std::fs::File::open(folder.join("out.png")).expect("a frame");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a header");
    let channels = reader.info().color_type.samples();
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("pixels");
    [pixels[0], pixels[pixels.len() - channels]]
}

#[test]
fn pictures_fill_imports_in_their_format() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-import");
    write_png(&folder, "row.png", [2, 1], &[[188, 10, 20], [55, 150, 30]]);
    let radiance = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    let radiance: Vec<u8> = radiance.into_iter().chain([128, 64, 32, 128, 64, 0, 0, 128]).collect();
    std::fs::write(folder.join("row.hdr"), radiance).expect("a file");
    // Slices below one another are in the order of a volume; side by side they are brought into it.
    write_png(&folder, "below.png", [1, 4], &[[40; 3], [1; 3], [2; 3], [80; 3]]);
    write_png(&folder, "beside.png", [2, 2], &[[40; 3], [2; 3], [1; 3], [80; 3]]);
    let volume = ("texture_3d", ["vec3<i32>(0, 0, 0)", "vec3<i32>(0, 1, 1)"]);
    let volumes = r#""format": "rgba16float", "size": [1, 2], "layers": 2, "view_dimension": "3d""#;
    for (palette, shape, file, expected) in [
        (r#""format": "rgba8unorm", "size": [2, 1]"#, ROW, "row.png", [188, 55]),
        // 188 of sRGB is half of the light.
        (r#""format": "rgba8unorm-srgb", "size": [2, 1]"#, ROW, "row.png", [128, 10]),
        (r#""format": "rgba16float", "size": [2, 1]"#, ROW, "row.hdr", [128, 64]),
        (volumes, volume, "below.png", [40, 80]),
        (volumes, volume, "beside.png", [40, 80]),
    ] {
        write_pipeline(&folder, palette, shape);
        let output = render(&folder, &["--import", &format!("palette={file}")]);
        assert!(output.status.success(), "{palette} {file}: {}", text(&output.stderr));
        let found = reds(&folder);
        let is_near = found.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 1);
        assert!(is_near, "{palette} {file}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn imports_that_cannot_be_filled_are_told() {
    let folder = ScratchFolder::new("render-import-bad");
    write_png(&folder, "row.png", [2, 1], &[[1; 3]; 2]);
    write_png(&folder, "square.png", [2, 2], &[[1; 3]; 4]);
    std::fs::write(
        folder.join("row.hdr"),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x02\x01\x01\x80\x02\x01\x01\x80",
    )
    .expect("a file");
    std::fs::write(folder.join("notes.png"), "no picture").expect("a file");
    write_pipeline(&folder, r#""format": "rgba8unorm", "size": [2, 1]"#, ROW);
    for (import, words) in [
        ("palette=missing.png", &["missing.png", "cannot be read"][..]),
        ("palette=notes.png", &["UG0829", "notes.png", "neither PNG nor JPEG"]),
        (
            "palette=square.png",
            &["UG0829", "has 2 × 1 texels, and \"square.png\" has 2 × 2", "\"size\": [2, 2]"],
        ),
        ("palette=row.hdr", &["UG0829", "has the format rgba8unorm, and \"row.hdr\" holds floats"]),
        ("palete=row.png", &["UG0829", "imported texture \"palete\"", "only read: palette"]),
        ("target=row.png", &["UG0829", "passes write \"target\"", "only read: palette"]),
    ] {
        rejected(&render(&folder, &["--import", import]), 1, words);
    }
    let twice = ["--import", "palette=row.png", "--import", "palette=square.png"];
    rejected(&render(&folder, &twice), 1, &["\"palette\" has two files, \"row.png\" and \"square.png\""]);
    rejected(&render(&folder, &["--import", "palette"]), 2, &["NAME=FILE"]);
    let layers = r#""format": "rgba8unorm", "size": [1, 1], "layers": 2, "view_dimension": "3d""#;
    write_pipeline(&folder, layers, ("texture_3d", ["vec3<i32>(0)", "vec3<i32>(0, 0, 1)"]));
    let words = ["has 1 × 1 × 2 texels, and \"square.png\" has 2 × 2", "side by side (2 × 1)", "(1 × 2)"];
    rejected(&render(&folder, &["--import", "palette=square.png"]), 1, &words);
    assert!(!folder.join("out.png").exists());
}

#[test]
fn an_import_without_contents_is_a_warning() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-import-none");
    write_pipeline(&folder, r#""format": "rgba8unorm", "size": [2, 1]"#, ROW);
    let output = render(&folder, &[]);
    let said = text(&output.stderr);
    assert!(output.status.success() && said.contains("\"palette\" has no contents"), "{said}");
    assert!(said.contains("--import palette=FILE"), "{said}");
    assert_eq!(reds(&folder), [0, 0]);
}
