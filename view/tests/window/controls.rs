//! Each control once.

use serde_json::{Value, json};

use crate::x11::{BACKSPACE, CONTROL, ESCAPE, F1, F2, HOME, RIGHT, SHIFT};
use crate::{PIPELINE, start};

const SMALL: &[&str] = &["--scale", "0.25"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn the_camera_turns_pans_zooms_flies_and_goes_back() {
    let Some(mut hand) = start("camera", SMALL) else { return };
    let home = hand.settle()["camera"].clone();
    let [middle, aside] = [[0.4, 0.4], [0.6, 0.5]].map(|part| hand.point("frame", part));
    hand.drag(middle, aside);
    let turned = hand.wait("turned camera", |state| state["camera"]["position"] != home["position"]);
    assert_eq!(turned["camera"]["target"], home["target"], "an orbit keeps its point");
    hand.move_to(middle);
    hand.display.button(4, true);
    hand.display.button(4, false);
    let before = turned["camera"].clone();
    let nearer = hand.wait("nearer camera", |state| state["camera"] != before)["camera"].clone();
    assert_eq!(nearer["target"], home["target"]);
    hand.display.key(SHIFT, true);
    hand.drag(middle, aside);
    hand.display.key(SHIFT, false);
    hand.wait("panned camera", |state| state["camera"]["target"] != home["target"]);
    // Bookmarks.
    hand.click("bookmark");
    let marked = hand.wait("bookmark", |state| state["bookmarks"] == 1)["camera"].clone();
    // Flying: turning keeps the position, keys move it.
    hand.display.press(&[], u32::from('o'));
    hand.wait("flying", |state| state["fly"] == true);
    hand.drag(middle, aside);
    let flown = hand.wait("turned head", |state| state["camera"]["target"] != marked["target"]);
    assert_eq!(flown["camera"]["position"], marked["position"]);
    hand.display.key(u32::from('w'), true);
    hand.wait("way ahead", |state| state["camera"]["position"] != marked["position"]);
    hand.display.key(u32::from('w'), false);
    hand.display.press(&[], u32::from('1'));
    hand.wait("visited bookmark", |state| state["camera"]["position"] == marked["position"]);
    hand.display.press(&[], HOME);
    hand.wait("home", |state| state["camera"] == home);
    hand.display.press(&[CONTROL], u32::from('b'));
    hand.wait("saved camera", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("own.camera.json"))
    });
    let text = std::fs::read_to_string(hand.folder.join("own.camera.json")).unwrap();
    let path: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(path["keys"].as_array().map(Vec::len), Some(2));
}

#[test]
fn values_change_live_or_plan_anew_and_are_saved() {
    let Some(mut hand) = start("values", SMALL) else { return };
    let plans = hand.settle()["plans"].clone();
    // A slider of a live parameter: another picture, the same plan.
    hand.type_into("search");
    hand.display.write("exposure");
    hand.wait("search", |state| state["panel"]["search"] == "exposure");
    let [from, to] = [[0.05, 0.5], [0.3, 0.5]].map(|part| hand.point("exposure", part));
    hand.drag(from, to);
    let state = hand.wait("slider", |state| state["given"]["parameters"]["exposure"].is_number());
    assert_ne!(number(&state["given"]["parameters"]["exposure"]), 1.0);
    assert_eq!(hand.settle()["plans"], plans, "a live value plans nothing");
    hand.click("reset exposure");
    hand.wait("reset", |state| state["given"]["parameters"] == json!({}));
    let search = |hand: &mut crate::hand::Hand, text: &str| {
        hand.type_into("search");
        hand.display.press(&[CONTROL], u32::from('a'));
        hand.display.press(&[], BACKSPACE);
        hand.display.write(text);
        let text = text.to_owned();
        hand.wait("search", move |state| state["panel"]["search"] == text.as_str());
    };
    // A preset, a feature: other plans.
    search(&mut hand, "");
    hand.click("preset");
    hand.click("preset=coarse");
    hand.wait("preset", |state| number(&state["planned"]["resolution"]) == 64.0);
    search(&mut hand, "fxaa");
    let before = hand.settle();
    hand.click("fxaa");
    hand.wait("feature", |state| state["given"]["features"]["fxaa"] == true);
    hand.wait("plan of the feature", |state| {
        number(&state["plans"]) > number(&before["plans"]) && state["features"]["fxaa"] == true
    });
    assert_eq!(before["features"]["fxaa"], false);
    // A toggle: another frame of the same plan.
    search(&mut hand, "veil");
    let before = hand.settle();
    hand.click("veil");
    hand.wait("toggle", |state| state["given"]["toggles"]["veil"] == true);
    let after = hand.settle();
    assert_eq!(before["plans"], after["plans"]);
    assert!(number(&after["frames"]) > number(&before["frames"]));
    // Only what was changed.
    search(&mut hand, "");
    hand.click("only given");
    hand.wait("only changed", |state| {
        state["panel"]["only given"] == true && state["controls"].get("exposure").is_none()
    });
    hand.click("only given");
    // A parameter file, and the document with its comments.
    hand.click("save as parameter file");
    hand.wait("saved file", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("own.params.json"))
    });
    let file: Value =
        serde_json::from_str(&std::fs::read_to_string(hand.folder.join("own.params.json")).unwrap()).unwrap();
    assert_eq!(file, json!({ "format": 1, "preset": "coarse", "features": { "fxaa": true } }));
    hand.click("save into document");
    hand.wait("saved document", |state| state["message"] == "saved into own.json");
    let text = std::fs::read_to_string(hand.folder.join("own.json")).unwrap();
    assert!(text.starts_with("// A comment that stays.") && text.contains("// metres"), "{text}");
    assert!(text.contains("\"resolution\": { \"default\": 64 }") && text.contains("\"fxaa\""), "{text}");
    // The document's values count again, so that an edit of the file shows.
    hand.wait("values of the file", |state| {
        state["given"]["features"] == json!({}) && state["given"]["toggles"] == json!({})
    });
    let followed = hand.settle();
    assert_eq!(followed["features"]["fxaa"], true);
    // What was saved is there without the values of the window, too.
    hand.click("reset all");
    hand.wait("reset", |state| {
        state["given"] == json!({ "preset": null, "parameters": {}, "features": {}, "toggles": {} })
    });
    let saved = hand.settle();
    assert_eq!(number(&saved["planned"]["resolution"]), 64.0);
    assert_eq!(saved["features"]["fxaa"], true);
}

#[test]
fn the_graph_leads_to_passes_and_contents() {
    let Some(mut hand) = start("graph", SMALL) else { return };
    hand.settle();
    hand.type_into("search graph");
    hand.display.write("half");
    hand.click("resource half");
    let of = |state: &Value, reference: &str| state["contents"]["of"][0] == reference;
    let state = hand.wait("contents", |state| of(state, "half@quarter"));
    assert_eq!(state["selected"], "resource half");
    hand.click("version before");
    let halved = hand.wait("version before", |state| of(state, "half@halve"));
    hand.click("version after");
    hand.wait("version after", |state| of(state, "half@quarter"));
    // A mip level by dragging its number.
    let [from, to] = [[0.5, 0.5], [3.0, 0.5]].map(|part| hand.point("mip", part));
    hand.drag(from, to);
    let quarter = hand.wait("mip level", |state| state["contents"]["mip"] == 1 && of(state, "half@quarter"));
    let width = |state: &Value| number(&state["contents"]["size"][0]);
    assert!((width(&quarter) * 2.0 - width(&halved)).abs() <= 2.0, "half as wide");
    for side in ["before", "difference"] {
        hand.click(&format!("side {side}"));
        hand.wait(side, |state| state["contents"]["side"] == side);
    }
    hand.click("side after");
    hand.click("own range");
    hand.wait("range", |state| state["controls"].get("range min").is_some());
    // A value under the pointer.
    let at = hand.point("contents", [0.5, 0.5]);
    hand.move_to(at);
    hand.wait("value", |state| state["contents"]["cursor"].is_array());
    // The declaration opens in the editor.
    hand.click("declared");
    let line = 1 + PIPELINE[..PIPELINE.find("\"half\": {").unwrap()].matches('\n').count();
    let opened = format!("opened own.json:{line}");
    hand.wait("editor", |state| state["message"] == opened.as_str());
    let begin = std::time::Instant::now();
    while !hand.folder.join(format!("opened.txt.own.json.{line}")).is_file() {
        assert!(begin.elapsed().as_secs() < 20, "the editor was not started at the line {line}");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    hand.leave_text();
    // Passes: by key from one to the next, and what one writes.
    hand.display.press(&[], ESCAPE);
    hand.wait("closed", |state| state["selected"].is_null());
    hand.display.press(&[], RIGHT);
    let first = hand.wait("first pass", |state| state["selected"].is_string())["selected"].clone();
    hand.display.press(&[], RIGHT);
    hand.wait("second pass", |state| state["selected"].is_string() && state["selected"] != first);
    hand.click("times");
    hand.wait("times", |state| state["below"] == "Times" && state["timed"] == true);
    hand.wait("chart", |state| {
        state["controls"].get("chart").is_some() && number(&state["times"]["sky"]) >= 2.0
    });
    hand.click("time sky");
    hand.wait("pass of the table", |state| state["selected"] == "pass sky");
    hand.click("after color");
    hand.wait("what it leaves", |state| of(state, "color@sky"));
    hand.click("close inspector");
    hand.wait("closed", |state| state["selected"].is_null());
}

#[test]
fn frames_are_written_animated_and_repeated() {
    let Some(mut hand) = start("output", SMALL) else { return };
    hand.settle();
    hand.click("screenshot");
    hand.wait("screenshot", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("frame-001.png"))
    });
    hand.display.press(&[], F2);
    hand.wait("second", |state| state["message"].as_str().is_some_and(|said| said.contains("frame-002.png")));
    let files = hand.files("frame-");
    assert_eq!(files.len(), 2);
    let colors = crate::read_back::colors(&files[0]);
    assert!(colors > 200, "{colors} colors");
    hand.click("step");
    let stepped = hand.wait("step", |state| number(&state["time"]) > 0.0)["time"].clone();
    hand.click("clip");
    hand.click("play");
    hand.wait("clip", |state| number(&state["clip"]) >= 3.0 && number(&state["time"]) > number(&stepped));
    hand.click("clip");
    hand.wait("written clip", |state| {
        state["message"].as_str().is_some_and(|said| said.contains("clip-001.png"))
    });
    hand.click("play");
    hand.wait("pause", |state| state["playing"] == false);
    hand.click_at("time", [0.1, 0.5]);
    hand.wait("time", |state| number(&state["time"]) > 0.0 && number(&state["time"]) < 4.0);
    hand.display.press(&[], BACKSPACE);
    hand.wait("restart", |state| number(&state["time"]) == 0.0);
}

#[test]
fn panels_resolution_and_help_follow_buttons_and_keys() {
    let Some(mut hand) = start("panels", &[]) else { return };
    hand.settle();
    for (name, key, panel) in [("notices", 'n', "Notices"), ("graph", 'g', "Graph"), ("times", 't', "Times")]
    {
        if hand.state()["below"] != panel {
            hand.click(name);
        }
        hand.wait(panel, |state| state["below"] == panel);
        hand.display.press(&[], u32::from(key));
        // Behind it is the panel that was open before, until that is closed, too.
        hand.wait("closed panel", |state| state["below"] != panel);
    }
    hand.wait("none", |state| state["below"].is_null());
    hand.click("values");
    hand.wait("no values", |state| state["panel"]["open"] == false);
    hand.display.press(&[], u32::from('/'));
    hand.wait("search", |state| state["panel"]["open"] == true && state["typing"] == true);
    hand.display.write("bias");
    hand.wait("written search", |state| state["panel"]["search"] == "bias");
    let at = hand.point("frame", [0.5, 0.5]);
    hand.press_at(at);
    hand.wait("keys for the window", |state| state["typing"] == false);
    hand.display.press(&[], F1);
    hand.wait("help", |state| state["help"] == true);
    hand.display.press(&[], ESCAPE);
    hand.wait("no help", |state| state["help"] == false);
    hand.click("resolution");
    hand.click("resolution=0.5");
    hand.wait("half", |state| number(&state["scale"]) == 0.5);
    let wide = hand.settle()["size"][0].clone();
    hand.display.press(&[], u32::from('-'));
    hand.wait("coarser", |state| number(&state["size"][0]) < number(&wide));
}
