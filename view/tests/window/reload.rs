//! Edits under the running window: a broken one keeps the last good frame, a click opens its line, a mend mends it.

use crate::{PIPELINE, start};

#[test]
fn a_broken_edit_keeps_the_frame_and_is_mended_by_a_click() {
    let Some(mut hand) = start("reload", &["--scale", "0.25"]) else { return };
    // Without the panel below, whose height would change the size of the frame.
    hand.display.press(&[], u32::from('g'));
    hand.wait("no panel", |state| state["below"].is_null());
    let good = hand.settle();
    let first = hand.screenshot();
    let path = hand.folder.join("own.json");
    // A word that has one mend.
    let broken = PIPELINE.replace("\"blend\": \"add\"", "\"blend\": \"ad\"");
    std::fs::write(&path, &broken).unwrap();
    let is_broken =
        |state: &serde_json::Value| state["errors"].as_array().is_some_and(|errors| !errors.is_empty());
    // The diagnostics come up by themselves, in the frame after the first with an error.
    let state = hand.wait("notices", |state| is_broken(state) && state["below"] == "Notices");
    assert_eq!(state["passes"], good["passes"], "the last good plan goes on");
    hand.display.press(&[], u32::from('n'));
    hand.wait("no panel", |state| state["below"].is_null());
    let state = hand.settle();
    assert_eq!(state["size"], good["size"]);
    assert_eq!(hand.screenshot(), first, "the frame changed while the file was broken");
    hand.display.press(&[], u32::from('n'));
    hand.wait("diagnostics", |state| state["below"] == "Notices");
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
}

#[test]
fn a_value_of_a_parameter_that_leaves_the_file_goes() {
    let Some(mut hand) = start("gone", &["--scale", "0.25", "--set", "gain=2"]) else { return };
    let before = hand.settle();
    assert_eq!(before["given"]["parameters"], serde_json::json!({ "gain": 2 }));
    let start = PIPELINE.find(",\n    \"gain\"").unwrap();
    let end = start + PIPELINE[start..].find("\n  },").unwrap();
    let without = format!("{}{}", &PIPELINE[..start], &PIPELINE[end..]);
    std::fs::write(hand.folder.join("own.json"), without).unwrap();
    let state = hand.wait("no value", |state| state["given"]["parameters"] == serde_json::json!({}));
    let said = "dropped the values of \"gain\": the files no longer declare them";
    assert_eq!(state["message"], said);
    hand.wait("no error", |state| state["errors"] == serde_json::json!([]));
}
