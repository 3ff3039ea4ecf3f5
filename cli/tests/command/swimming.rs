//! Shadows lie still while the camera moves: `umbragraph score --frames` over the courtyard.
//!
//! Two hundred frames of a walk, and as many of a turn, in parts of four; ordinary tests take one part of each, which
//! one the seed says. Texels are wider than pixels here, so that a step of a texel shows.

use std::path::PathBuf;
use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::{gpu, property};

const PART: u32 = 4;

/// A camera path of 200 frames, as key frames.
const WALK: &str = r#"{ "keys": [ { "time": 0, "position": [1.9, 4, 16.2], "target": [0.2, 2.66, -3.8] },
    { "time": 6.7, "position": [4.9, 4, 12.2], "target": [3.2, 2.66, -7.8] } ] }"#;
const TURN: &str = r#"{ "keys": [ { "time": 0, "position": [1.9, 4, 16.2], "target": [-8, 2.66, -3.8] },
    { "time": 6.7, "position": [1.9, 4, 16.2], "target": [10, 2.66, -3.8] } ] }"#;

/// Scores a part of a camera path. Returns the number of points seen twice, and of those whose shadow term changes.
fn measured(folder: &ScratchFolder, path: &str, snap: &str, part: u32) -> [u64; 2] {
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let keys = file("keys.json");
    std::fs::write(&keys, path).unwrap();
    let (frames, at) = ((PART + 1).to_string(), (f64::from(part * PART) / 30.0).to_string());
    let snap = format!("snap={snap}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["score", "pipelines/lore.json", "--scene", "examples/scenes/courtyard.glb"]);
    command.args(["--size", "320x180", "--format", "json", "--camera", &keys]);
    command.args(["--frames", &frames, "--at", &at, "--set", "fit=sphere", "--set", &snap]);
    command.args(["--set", "shadow_filter=hard", "--set", "resolutions=[512, 512, 512, 512]"]);
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let output = command.current_dir(root).output().expect("the command");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let scores: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(scores["frames"].as_array().unwrap().len(), PART as usize + 1);
    assert_eq!(scores["frames"][0]["changes"]["points"], 0);
    ["points", "changed"].map(|name| scores["together"]["changes"][name].as_u64().unwrap())
}

#[test]
fn shadows_lie_still_on_the_worlds_grid_and_swim_without() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("swimming");
    for (name, path) in [("translation", WALK), ("rotation", TURN)] {
        let mut sums = [[0; 2]; 2];
        for part in property::part(0..200 / PART, u64::from(200 / PART)) {
            for (sum, snap) in sums.iter_mut().zip(["world", "none"]) {
                let [points, changed] = measured(&folder, path, snap, part);
                *sum = [sum[0] + points, sum[1] + changed];
            }
        }
        let [still, swimming] = sums.map(|[points, changed]| 100.0 * changed as f64 / points as f64);
        println!("{name}: {still:.4} % of {} points change; without a grid {swimming:.4} %", sums[0][0]);
        assert!(sums[0][0] > 50_000, "{sums:?}");
        assert!(still <= 0.05, "{name}: {still} %");
        assert!(swimming > 2.0 * still, "{name}: {still} % and {swimming} %");
    }
}
