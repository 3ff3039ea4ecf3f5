//! Clips, bookmarks and copied commands: each gives back what the window showed.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::hand::module;
use crate::read_back::pixels;
use crate::start;
use crate::x11::F2;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The path of the command `umbragraph`: the value of `UMBRAGRAPH_COMMAND`, or else the command built by this call.
pub(crate) fn command() -> PathBuf {
    if let Some(path) = std::env::var_os("UMBRAGRAPH_COMMAND") {
        return path.into();
    }
    let mut build = Command::new("cargo");
    build.args(["build", "--quiet", "--locked", "-p", "umbragraph-cli"]).current_dir(module());
    for name in ["CARGO_TARGET_DIR", "RUSTUP_TOOLCHAIN", "CARGO"] {
        build.env_remove(name);
    }
    assert!(build.status().expect("cargo").success());
    module().join("target/debug/umbragraph")
}

#[test]
fn the_copied_command_draws_the_frame() {
    let Some(mut hand) = start("command", &["--scale", "0.25"]) else { return };
    hand.settle();
    let [middle, aside] = [[0.4, 0.4], [0.47, 0.43]].map(|part| hand.point("frame", part));
    hand.drag(middle, aside);
    hand.click("bookmark");
    hand.wait("bookmark", |state| state["bookmarks"] == 1);
    hand.settle();
    let marked = hand.screenshot();
    // Elsewhere than the bookmark, at another time, with other values.
    hand.drag(middle, aside);
    hand.click("step");
    hand.wait("step", |state| number(&state["time"]) > 0.0);
    hand.type_into("search");
    hand.display.write("exposure");
    hand.wait("search", |state| state["panel"]["search"] == "exposure");
    let [from, to] = [[0.05, 0.5], [0.3, 0.5]].map(|part| hand.point("exposure", part));
    hand.drag(from, to);
    hand.wait("slider", |state| state["given"]["parameters"]["exposure"].is_number());
    hand.leave_text();
    hand.settle();
    let seen = hand.screenshot();
    assert_ne!(seen, marked);
    hand.click("copy command");
    let state = hand.wait("command", |state| {
        state["message"].as_str().is_some_and(|said| said.starts_with("copied: umbragraph render own.json"))
    });
    let line = state["message"].as_str().unwrap().trim_start_matches("copied: umbragraph");
    let output = Command::new("sh")
        .args(["-c", &format!("\"$0\" {line}")])
        .arg(command())
        .current_dir(&hand.folder)
        .output()
        .expect("sh");
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    let ((one_size, one), (other_size, other)) =
        (pixels(&hand.folder.join("frame.png")), pixels(&hand.folder.join("frame-002.png")));
    assert_eq!(one_size, other_size);
    let differ = one.iter().zip(&other).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "pixels of {}", one.len());
    // Back at the bookmark, with the values of then.
    hand.click("reset all");
    hand.display.press(&[], crate::x11::BACKSPACE);
    hand.wait("restart", |state| number(&state["time"]) == 0.0);
    hand.display.press(&[], u32::from('1'));
    hand.settle();
    assert!(hand.screenshot() == marked, "a bookmark is the very place");
}

#[test]
fn a_clip_plays_as_fast_as_the_animation() {
    let Some(mut hand) = start("clip", &[]) else { return };
    hand.settle();
    // It begins with a still frame, which is finer than those of an animation are by themselves.
    hand.display.press(&[], u32::from('r'));
    let still = hand.wait("first frame", |state| number(&state["clip"]) >= 1.0);
    hand.settle();
    hand.click("play");
    let begin = hand.wait("clip", |state| number(&state["clip"]) >= 2.0);
    let end = hand.wait("clip", |state| number(&state["clip"]) >= 8.0);
    let passed = |name| number(&end[name]) - number(&begin[name]);
    assert!((passed("time") - 0.05 * passed("clip")).abs() < 0.051, "{begin} {end}");
    assert_eq!(end["size"], still["size"]);
    hand.display.press(&[], u32::from('r'));
    let state = hand.wait("written clip", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("clip-001.png: "))
    });
    hand.display.press(&[], F2);
    let file = std::fs::File::open(hand.folder.join("clip-001.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let frames = reader.info().animation_control.expect("an animation").num_frames;
    assert!(frames >= 8 && state["message"].as_str().unwrap().ends_with(&format!(": {frames} frames")));
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    for frame in 0..frames {
        reader.next_frame(&mut bytes).unwrap();
        let control = reader.info().frame_control.unwrap();
        let delay = u32::from(control.delay_num) * 1000 / u32::from(control.delay_den);
        // The still frame is shown until the animation begins.
        assert!(delay == 50 || number(&still["clip"]) > f64::from(frame), "frame {frame}: {delay} ms");
    }
}
