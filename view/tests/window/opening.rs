//! The start of a frame: files that are dropped on the window, camera paths, cameras that move by themselves.

use serde_json::Value;

use crate::hand::{Hand, module};
use crate::xdnd::drop_file;
use crate::{PIPELINE, start};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn dropped_scenes_and_pipelines_are_opened() {
    let Some(mut hand) = start("drop", &["--scale", "0.25"]) else { return };
    let first = hand.settle();
    let [middle, aside] = [[0.4, 0.4], [0.6, 0.5]].map(|part| hand.point("frame", part));
    hand.drag(middle, aside);
    hand.click("bookmark");
    let moved = hand.wait("bookmark", |state| state["bookmarks"] == 1);
    assert_ne!(moved["camera"], first["camera"]);
    // Another scene begins at its own camera, with no bookmarks of the one before.
    let scene = module().join("examples/scenes/interior.glb");
    drop_file(&scene, middle);
    let opened = |state: &Value| state["scene"].as_str().is_some_and(|path| path.ends_with("interior.glb"));
    hand.wait("dropped scene", opened);
    let state = hand.settle();
    assert_eq!(state["bookmarks"], 0);
    assert_eq!(state["errors"], serde_json::json!([]));
    let own = umbragraph::scene::load(&scene).unwrap();
    let own = own.frame_input_of(&own.pose(0.0), 1.0, 0.0).camera.position;
    let shown: [f64; 3] = serde_json::from_value(state["camera"]["position"].clone()).unwrap();
    assert!(own.distance(shown.into()) < 1e-3, "{own} {shown:?}");
    // The same scene once more, for its picture; then a pipeline.
    let before = hand.screenshot();
    let other = hand.folder.join("other.json");
    std::fs::write(&other, PIPELINE.replace("\"dead\": {", "\"dead\": { \"side_effect\": true,")).unwrap();
    // It has all values but one that was set.
    let text = std::fs::read_to_string(&other).unwrap();
    std::fs::write(&other, text.replace("\"veil\"", "\"other_veil\"")).unwrap();
    hand.type_into("search");
    hand.display.write("veil");
    hand.click("veil");
    hand.wait("toggle", |state| state["given"]["toggles"]["veil"] == true);
    hand.click("veil");
    hand.wait("toggle back", |state| state["given"]["toggles"]["veil"] == false);
    drop_file(&other, middle);
    hand.wait("dropped pipeline", |state| {
        state["passes"].as_array().is_some_and(|passes| passes.iter().any(|pass| pass == "dead"))
    });
    let state = hand.state();
    assert_eq!(state["given"]["toggles"], serde_json::json!({}));
    assert!(
        state["message"].as_str().is_some_and(|said| said.ends_with("it has no veil")),
        "{}",
        state["message"]
    );
    let state = hand.settle();
    assert!(state["pipeline"].as_str().unwrap().ends_with("other.json"));
    assert_eq!(state["errors"], serde_json::json!([]));
    assert_eq!(hand.screenshot(), before, "the same frame by another file");
    // Something else is rejected, and nothing changes.
    let text = hand.folder.join("notes.txt");
    std::fs::write(&text, "none").unwrap();
    drop_file(&text, middle);
    hand.wait("rejected file", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("notes.txt\" is no pipeline"))
    });
    assert!(hand.state()["pipeline"].as_str().unwrap().ends_with("other.json"));
}

#[test]
fn dropped_values_cameras_and_broken_files_keep_the_frame() {
    let Some(mut hand) = start("drop-others", &["--scale", "0.25"]) else { return };
    // Without the panel below, whose height would change the size of the frame.
    hand.display.press(&[], u32::from('g'));
    hand.wait("no panel", |state| state["below"].is_null());
    let first = hand.settle();
    let middle = hand.point("frame", [0.4, 0.4]);
    let values = hand.folder.join("soft.params.json");
    std::fs::write(&values, "{ \"format\": 1, \"parameters\": { \"resolution\": 64 } } // soft\n").unwrap();
    drop_file(&values, middle);
    hand.wait("values", |state| number(&state["planned"]["resolution"]) == 64.0);
    assert_eq!(hand.state()["pipeline"], first["pipeline"]);
    // Saving goes into the file in use, and keeps what it holds.
    hand.type_into("search");
    hand.display.write("fxaa");
    hand.click("fxaa");
    hand.wait("feature", |state| state["given"]["features"]["fxaa"] == true);
    hand.click("save as parameter file");
    hand.wait("saved", |state| state["message"].as_str().is_some_and(|said| said.starts_with("saved into ")));
    let text = std::fs::read_to_string(&values).unwrap();
    assert!(
        text.contains("\"resolution\": 64") && text.ends_with("// soft\n") && text.contains("fxaa"),
        "{text}"
    );
    hand.leave_text();
    let path = hand.folder.join("way.json");
    let keys = "{ \"keys\": [{ \"time\": 0, \"position\": [2, 4, 16], \"target\": [0.125, 1, 0] }] }";
    std::fs::write(&path, keys).unwrap();
    drop_file(&path, middle);
    hand.wait("camera", |state| state["camera"]["position"] == serde_json::json!([2.0, 4.0, 16.0]));
    hand.settle();
    let good = hand.screenshot();
    let before = hand.state();
    for (name, text) in [("bad.json", "{ \"format\": 1, \"passes\": {"), ("bad.glb", "no scene")] {
        let bad = hand.folder.join(name);
        std::fs::write(&bad, text).unwrap();
        drop_file(&bad, middle);
        hand.wait("error", |state| state["errors"].as_array().is_some_and(|errors| !errors.is_empty()));
        // The first error opens the notices.
        if name == "bad.json" {
            hand.wait("notices", |state| state["below"] == "Notices");
            hand.display.press(&[], u32::from('n'));
        }
        hand.wait("no panel", |state| state["below"].is_null());
        let state = hand.settle();
        assert_eq!(state["camera"], before["camera"], "{name}");
        assert_eq!(state["pipeline"], before["pipeline"], "{name}");
        assert!(hand.screenshot() == good, "{name}: not the last good frame");
    }
    let bad = hand.folder.join("bad.camera.json");
    std::fs::write(&bad, "{").unwrap();
    drop_file(&bad, middle);
    hand.wait("rejected path", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("bad.camera.json is not opened"))
    });
}

#[test]
fn a_moving_camera_goes_on_until_it_is_moved_by_hand() {
    for path in ["orbit", "walk"] {
        let Some(mut hand) = start(&format!("moving-{path}"), &["--scale", "0.25", "--camera", path]) else {
            return;
        };
        let home = hand.settle();
        assert_eq!(home["moving"], true);
        hand.click("play");
        let away = hand.wait("moved camera", |state| number(&state["time"]) > 1.0);
        hand.click("play");
        let paused = hand.settle();
        assert_ne!(away["camera"]["position"], home["camera"]["position"]);
        // A walk goes straight on; an orbit turns to what it goes around.
        let direction = |state: &Value, axis: usize| {
            number(&state["camera"]["target"][axis]) - number(&state["camera"]["position"][axis])
        };
        let is_straight = (0..3).all(|axis| (direction(&paused, axis) - direction(&home, axis)).abs() < 0.01);
        assert_eq!(is_straight, path == "walk", "{path}: {} {}", home["camera"], paused["camera"]);
        assert_eq!(hand.settle()["camera"], paused["camera"], "it stands while the time stands");
        hand.display.press(&[], crate::x11::BACKSPACE);
        let again = hand.wait("restart", |state| number(&state["time"]) == 0.0);
        assert_eq!(again["camera"], home["camera"]);
        let [middle, aside] = [[0.4, 0.4], [0.5, 0.45]].map(|part| hand.point("frame", part));
        hand.drag(middle, aside);
        let state = hand.wait("moved by hand", |state| state["moving"] == false);
        hand.click("play");
        hand.wait("time", |state| number(&state["time"]) > 0.2);
        hand.click("play");
        hand.wait("pause", |state| state["playing"] == false);
        assert_eq!(hand.state()["camera"]["position"], state["camera"]["position"]);
    }
}

#[test]
fn a_camera_path_gives_the_start_and_bookmarks() {
    let key = |x: f64| serde_json::json!({ "time": x, "position": [x, 4, 16], "target": [0.125, 1, 0] });
    let hand = Hand::start_with("path", PIPELINE, |folder| {
        let text = serde_json::json!({ "keys": [key(1.0), key(2.0)] }).to_string();
        std::fs::write(folder.join("path.json"), text).unwrap();
        ["--scale", "0.25", "--camera", "path.json"].map(str::to_owned).to_vec()
    });
    let Some(mut hand) = hand else { return };
    let state = hand.settle();
    assert_eq!(state["bookmarks"], 2);
    assert_eq!(
        state["camera"],
        serde_json::json!({ "position": [1.0, 4.0, 16.0], "target": [0.125, 1.0, 0.0] })
    );
    hand.display.press(&[], u32::from('2'));
    hand.wait("second key", |state| state["camera"]["position"] == serde_json::json!([2.0, 4.0, 16.0]));
}
