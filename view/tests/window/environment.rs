//! `--environment` and `--adapter`, as `umbragraph render` has them.

use std::process::Command;

use crate::hand::{Hand, module};
use crate::read_back::pixels;

/// A Radiance picture of 4 by 2 texels of one color: the mantissas of 0.5, 0.25 and 0.125.
fn dusk() -> Vec<u8> {
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    header.into_iter().chain([128, 64, 32, 128].repeat(8)).collect()
}

#[test]
fn an_environment_is_the_background_of_the_frame() {
    let text = r#"{ "format": 1, "name": "own", "extends": "umbragraph:umbra.json" }"#;
    let hand = Hand::start_with("environment", text, |folder| {
        std::fs::write(folder.join("sky.hdr"), dusk()).unwrap();
        let scene = module().join("examples/scenes/figure.glb").to_string_lossy().into_owned();
        let arguments = ["--environment", "sky.hdr", "--set", "tone_map=none", "--feature", "bloom=off"];
        let more = ["--scale", "0.25", "--scene", &scene];
        arguments.into_iter().chain(more).map(str::to_owned).collect()
    });
    let Some(mut hand) = hand else { return };
    let state = hand.settle();
    assert_eq!(state["errors"], serde_json::json!([]));
    assert!(!state["warnings"].to_string().contains("no contents"), "{}", state["warnings"]);
    hand.screenshot();
    let is_sky = |pixels: &[[u8; 3]]| pixels[0].iter().zip([188, 137, 99]).all(|(a, b)| a.abs_diff(b) <= 1);
    let (_, first) = pixels(&hand.folder.join("frame-001.png"));
    assert!(is_sky(&first), "the sky is {:?}", first[0]);
    // Another plan, and another size: the picture is there still.
    hand.click("values");
    hand.settle();
    hand.screenshot();
    let (_, second) = pixels(&hand.folder.join("frame-002.png"));
    assert!(first.len() < second.len() && is_sky(&second), "the sky is {:?}", second[0]);
    hand.click("copy command");
    hand.wait("command", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("--environment sky.hdr"))
    });
}

#[test]
fn a_missing_environment_or_adapter_is_a_diagnostic() {
    if std::env::var_os("DISPLAY").is_none() {
        return;
    }
    let scene = module().join("examples/scenes/figure.glb");
    let run = |more: [&str; 2]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph-view"));
        command
            .env_remove("WAYLAND_DISPLAY")
            .args(["umbragraph:umbra.json", "--scene"])
            .arg(&scene)
            .args(more);
        let output = command.output().expect("the viewer");
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = run(["--environment", "missing.hdr"]);
    assert!(said.contains("\"missing.hdr\" is not there") && said.contains("equirectangular"), "{said}");
    let said = run(["--adapter", "an adapter that no machine has"]);
    let words = ["UG0801", "no graphics adapter is called \"an adapter that no machine has\"", "there are"];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
}
