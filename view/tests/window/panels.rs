//! Panels that dock: moved, resized, closed, opened again, and put back where they were.

use serde_json::{Value, json};

use crate::start;

/// The corner and the size of a control.
fn rect(state: &Value, name: &str) -> [f64; 4] {
    serde_json::from_value(state["controls"][name].clone()).unwrap_or([f64::NAN; 4])
}

#[test]
fn panels_are_moved_resized_closed_and_reset() {
    let Some(mut hand) = start("dock", &["--scale", "0.25"]) else { return };
    let first = hand.settle();
    assert_eq!(first["panels"], json!(["Values", "Frame", "Graph"]));
    let [graph, frame] = ["tab Graph", "frame"].map(|name| rect(&first, name));
    assert!(graph[1] >= frame[1] + frame[3] && graph[0] >= frame[0] - 1.0, "the graph is below the frame");
    // To the right side of the frame.
    let from = hand.point("tab Graph", [0.3, 0.5]);
    let to = hand.point("frame", [0.93, 0.5]);
    hand.drag(from, to);
    let state = hand.wait("graph at the side", |state| {
        let [graph, frame] = ["tab Graph", "frame"].map(|name| rect(state, name));
        graph[0] >= frame[0] + frame[2] && (graph[1] - frame[1]).abs() < 40.0
    });
    assert!(rect(&state, "frame")[3] > frame[3] + 100.0, "the frame has the room below");
    let moved = rect(&state, "tab Graph");
    // The other panels keep their width: values at the left.
    assert!((rect(&state, "frame")[0] - frame[0]).abs() < 1.0);
    // Closed by its tab, opened by the menu: where it was.
    hand.click_at("tab Graph", [0.88, 0.5]);
    hand.wait("closed graph", |state| state["panels"] == json!(["Values", "Frame"]));
    hand.click("layout menu");
    hand.click("open Graph");
    hand.wait("opened graph", |state| rect(state, "tab Graph") == moved);
    hand.display.press(&[], crate::x11::ESCAPE);
    // Wider values.
    let edge = hand.point("frame", [0.0, 0.5]);
    hand.drag([edge[0] - 1, edge[1]], [edge[0] + 80, edge[1]]);
    let wide = hand.wait("wide values", |state| (rect(state, "frame")[0] - frame[0] - 80.0).abs() < 4.0);
    hand.click("values");
    hand.wait("no values", |state| rect(state, "frame")[0] < 10.0);
    hand.click("values");
    hand.wait("values as wide as before", |state| rect(state, "frame")[0] == rect(&wide, "frame")[0]);
    hand.click("layout menu");
    hand.click("reset layout");
    hand.wait("first layout", |state| {
        state["panels"] == first["panels"]
            && rect(state, "tab Graph") == graph
            && rect(state, "frame") == frame
    });
    assert_eq!(hand.settle()["errors"], json!([]));
}
