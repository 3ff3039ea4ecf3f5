//! A whole inspection without the pointer.

use serde_json::Value;

use crate::start;
use crate::x11::{CONTROL, DOWN, ENTER, ESCAPE, F1, F6, PAGE_DOWN, PAGE_UP, RIGHT, SHIFT, TAB};

#[test]
fn an_inspection_needs_no_pointer() {
    let Some(mut hand) = start("keyboard", &["--scale", "0.25"]) else { return };
    hand.settle();
    let has_keys = |name: &'static str| move |state: &Value| state["keyboard"] == name;
    // From panel to panel.
    for panel in ["panel Values", "panel Frame", "panel Graph", "panel Values"] {
        hand.display.press(&[], F6);
        hand.wait(panel, has_keys(panel));
    }
    hand.display.press(&[], TAB);
    hand.wait("first control of the panel", has_keys("search"));
    // A resource of the graph.
    hand.display.press(&[CONTROL], u32::from('f'));
    hand.wait("search", |state| state["typing"] == true && state["keyboard"] == "search graph");
    hand.display.write("half");
    hand.display.press(&[], TAB);
    let first = hand
        .wait("first pass", |state| state["keyboard"].as_str().is_some_and(|name| name.starts_with("pass ")));
    hand.display.press(&[], RIGHT);
    hand.wait("pass beside it", |state| {
        state["keyboard"] != first["keyboard"]
            && state["keyboard"].as_str().is_some_and(|name| name.starts_with("pass "))
    });
    assert!(hand.state()["selected"].is_null(), "arrows open nothing");
    hand.display.press(&[], DOWN);
    hand.wait("resource below", has_keys("resource half"));
    hand.display.press(&[], ENTER);
    let of = |reference: &'static str| move |state: &Value| state["contents"]["of"][0] == reference;
    hand.wait("contents", of("half@quarter"));
    // Its versions, sides, levels and channels.
    let what = |name: &'static str, value: Value| move |state: &Value| state["contents"][name] == value;
    hand.display.press(&[], PAGE_UP);
    hand.wait("version before", of("half@halve"));
    hand.display.press(&[], PAGE_DOWN);
    hand.wait("version after", of("half@quarter"));
    for side in ["before", "difference", "after"] {
        hand.display.press(&[], u32::from('x'));
        hand.wait(side, what("side", side.into()));
    }
    hand.display.press(&[], u32::from('m'));
    hand.wait("mip level", what("mip", 1.into()));
    hand.display.press(&[SHIFT], u32::from('m'));
    hand.wait("whole level", what("mip", 0.into()));
    hand.display.press(&[], u32::from('v'));
    hand.wait("channel", what("channel", 0.into()));
    hand.display.press(&[SHIFT], u32::from('v'));
    hand.wait("all channels", what("channel", Value::Null));
    hand.display.press(&[], u32::from('y'));
    hand.wait("first number of the range", |state| {
        state["keyboard"] == "range min" && state["typing"] == true
    });
    hand.display.press(&[CONTROL], u32::from('a'));
    hand.display.write("0.25");
    hand.display.press(&[], ENTER);
    hand.wait("range", |state| state["contents"]["range"][0] == 0.25);
    // The value of a texel.
    hand.press_until("inspector", (&[], F6), 8, has_keys("panel Inspector"));
    hand.press_until("contents", (&[], TAB), 30, has_keys("contents"));
    let at = |state: &Value| state["contents"]["cursor"][0][0].as_u64();
    let state = hand.wait("texel", |state| at(state).is_some());
    hand.display.press(&[], RIGHT);
    let next = hand.wait("texel beside it", |beside| at(beside) == at(&state).map(|at| at + 1));
    assert_eq!(next["keyboard"], "contents");
    // Out of the control, then out of the inspector.
    hand.display.press(&[], ESCAPE);
    hand.wait("no control", |state| state["keyboard"].is_null() && state["selected"].is_string());
    hand.display.press(&[], ESCAPE);
    hand.wait("no inspector", |state| state["selected"].is_null());
    hand.display.press(&[], RIGHT);
    hand.wait("first pass", |state| state["selected"].as_str().is_some_and(|one| one.starts_with("pass ")));
    // A value.
    hand.display.press(&[], u32::from('/'));
    hand.wait("search", has_keys("search"));
    hand.display.write("exposure");
    hand.press_until("slider", (&[], TAB), 12, has_keys("exposure"));
    hand.display.press(&[], RIGHT);
    hand.wait("value", |state| state["given"]["parameters"]["exposure"].is_number());
    hand.display.press(&[], F1);
    hand.wait("help", |state| state["help"] == true);
    hand.display.press(&[], F1);
    hand.wait("no help", |state| state["help"] == false);
}
