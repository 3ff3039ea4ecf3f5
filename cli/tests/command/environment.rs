//! `umbragraph render --environment`: a picture as background and light, kept from frame to frame, or what is wrong
//! with it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

fn render(pipeline: &str, out: &Path, arguments: &[&str]) -> Output {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command
        .args(["render", pipeline, "--scene", "examples/scenes/figure.glb", "--size", "64x36", "--out"])
        .arg(out);
    command.args(arguments).current_dir(root).output().expect("the command")
}

/// Returns a Radiance picture of 4 by 2 texels of one color: the mantissas of 0.5, 0.25 and 0.125.
fn dusk() -> Vec<u8> {
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    header.into_iter().chain([128, 64, 32, 128].repeat(8)).collect()
}

#[test]
fn an_environment_that_cannot_be_used_is_told() {
    let folder = ScratchFolder::new("render-environment-bad");
    let (picture, out) = (folder.join("sky.hdr"), folder.join("x.png"));
    let name = picture.to_str().expect("a path");
    let umbra = "pipelines/umbra.json";
    rejected(&render(umbra, &out, &["--environment", name]), 1, &["sky.hdr", "cannot be read"]);
    std::fs::write(&picture, "not a picture\n").expect("a file");
    rejected(&render(umbra, &out, &["--environment", name]), 1, &["UG0815", "\"#?\""]);
    std::fs::write(&picture, &dusk()[..60]).expect("a file");
    rejected(&render(umbra, &out, &["--environment", name]), 1, &["UG0815", "in row"]);
    std::fs::write(&picture, [&[0x76, 0x2f, 0x31, 0x01][..], &[2; 40]].concat()).expect("a file");
    rejected(&render(umbra, &out, &["--environment", name]), 1, &["UG0815"]);
    rejected(&render(umbra, &out, &["--feature", "environment"]), 1, &["UG0815", "--environment FILE"]);
    rejected(&render("pipelines/nebula.json", &out, &["--environment", name]), 1, &["environment"]);
    assert!(!out.exists());
}

/// The command must reject a pipe without a writer, from which a read would never return.
#[cfg(unix)]
#[test]
fn a_pipe_is_no_environment() {
    let folder = ScratchFolder::new("render-environment-pipe");
    let pipe = folder.join("sky.hdr");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    let arguments = ["--environment", pipe.to_str().expect("a path")];
    let output = render("pipelines/umbra.json", &folder.join("x.png"), &arguments);
    rejected(&output, 1, &["sky.hdr", "cannot be read: it is no regular file", "--environment names"]);
}

#[test]
fn an_environment_is_the_background_of_every_frame() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-environment");
    let picture = folder.join("sky.hdr");
    std::fs::write(&picture, dusk()).expect("a file");
    let arguments = [
        "--environment",
        picture.to_str().expect("a path"),
        "--frames",
        "2",
        "--fps",
        "1000",
        "--set",
        "tone_map=none",
        "--feature",
        "bloom=off",
    ];
    let out = folder.join("frame-#.png");
    let output = render("pipelines/umbra.json", &out, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let pixels = [0, 1].map(|index| {
        let file = std::fs::File::open(folder.join(format!("frame-{index}.png"))).expect("a picture");
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a header");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("pixels");
        pixels
    });
    let off = |[first, second]: [&u8; 2]| first.abs_diff(*second);
    // In sRGB.
    for (found, wanted) in pixels[0].iter().zip(&[188, 137, 99]) {
        assert!(off([found, wanted]) <= 1, "the sky is {:?}", &pixels[0][..3]);
    }
    // The figure walks, in a thousandth of a second not far.
    let changed =
        pixels[0].iter().zip(&pixels[1]).filter(|(first, second)| off([*first, *second]) > 8).count();
    assert!(changed < pixels[0].len() / 50, "{changed} of {} values change", pixels[0].len());
}
