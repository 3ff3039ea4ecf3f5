//! Edits under the running window: a broken one keeps the last good frame, a click opens its line, a mend mends it.

use crate::{PIPELINE, start};

#[test]
fn a_broken_edit_keeps_the_frame_and_is_mended_by_a_click() {
    let Some(mut hand) = start("reload", &["--scale", "0.25"]) else { return };
    let good = hand.settle();
    hand.click("screenshot");
    hand.wait("picture", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("frame-001.png"))
    });
    let path = hand.folder.join("own.json");
    // A word that has one mend.
    let broken = PIPELINE.replace("\"blend\": \"add\"", "\"blend\": \"ad\"");
    std::fs::write(&path, &broken).unwrap();
    let state =
        hand.wait("error", |state| state["errors"].as_array().is_some_and(|errors| !errors.is_empty()));
    assert_eq!(state["below"], "Notices", "the diagnostics come up by themselves");
    assert_eq!(state["passes"], good["passes"], "the last good plan goes on");
    hand.click("screenshot");
    hand.wait("picture", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("frame-002.png"))
    });
    let pictures: Vec<_> = [1, 2]
        .iter()
        .map(|at| std::fs::read(hand.folder.join(format!("frame-00{at}.png"))).unwrap())
        .collect();
    let is_same = pictures[0] == pictures[1];
    hand.click("open 0");
    let line = 1 + broken[..broken.find("\"ad\"").unwrap()].matches('\n').count();
    let opened = format!("opened own.json:{line}");
    hand.wait("editor", |state| state["message"] == opened.as_str());
    hand.click("mend 0");
    hand.wait("mend", |state| state["message"] == "mended own.json");
    hand.wait("no error", |state| state["errors"] == serde_json::json!([]));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), PIPELINE);
    // Another pass shows up.
    let more = PIPELINE.replace("\"dead\": {", "\"dead\": { \"side_effect\": true,");
    std::fs::write(&path, more).unwrap();
    hand.wait("new pass", |state| {
        state["passes"].as_array().is_some_and(|passes| passes.iter().any(|pass| pass == "dead"))
    });
    // The panel grew in between, so that the frame may have another size; of one size the picture is the same.
    assert!(is_same || pictures[0].len() != pictures[1].len(), "the frame changed while the file was broken");
}
