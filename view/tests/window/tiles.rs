//! The tiles of a shadow atlas: each has the name of its light, and a choice of one shows its rectangle.

use serde_json::Value;
use umbragraph::Library;
use umbragraph::data::View;

use crate::hand::{Hand, module};
use crate::read_back::{Fresh, captured};
use crate::x11::SHIFT;

/// Tiles of one size, since the sizes of others depend on the frames before.
const TEXT: &str = r#"{
  "format": 1, "name": "own", "extends": "umbragraph:awsm.json",
  "parameters": { "tile_min_side": { "default": 256 }, "tile_max_side": { "default": 256 } }
}"#;

/// The rectangle in a label such as "3 lamp: 256 × 256 at (0, 512), layer 1": x, y, width and height.
fn area(label: &str) -> [u32; 4] {
    let rest = label.rsplit_once(": ").map_or("", |(_, rest)| rest);
    let numbers = rest.split(|one: char| !one.is_ascii_digit()).filter_map(|one| one.parse().ok());
    let numbers: Vec<u32> = numbers.collect();
    [numbers[2], numbers[3], numbers[0], numbers[1]]
}

#[test]
fn tiles_have_their_lights_and_rectangles() {
    let scene = module().join("examples/scenes/interior.glb");
    let hand = Hand::start_with("tiles", TEXT, |_| {
        vec!["--scale".into(), "0.25".into(), "--scene".into(), scene.to_string_lossy().into_owned()]
    });
    let Some(mut hand) = hand else { return };
    assert_eq!(hand.settle()["errors"], serde_json::json!([]));
    hand.click("values");
    hand.wait("no values", |state| state["panel"]["open"] == false);
    hand.type_into("search graph");
    hand.display.write("atlas");
    hand.click("resource atlas");
    let state = hand.wait("contents", |state| {
        let is_atlas = state["contents"]["of"][0].as_str().is_some_and(|of| of.starts_with("atlas@"));
        let tiles = state["contents"]["tiles"].as_array().map_or(0, Vec::len);
        is_atlas && tiles > 0 && state["busy"] == false
    });
    let labels: Vec<String> = serde_json::from_value(state["contents"]["tiles"].clone()).unwrap();
    let reference = state["contents"]["of"][0].as_str().unwrap().to_owned();
    // The module's own frame: the atlas, and the places of its views.
    let fresh = Fresh::of(&scene);
    let size: [u32; 2] = serde_json::from_value(state["size"].clone()).unwrap();
    let views = fresh.views(&Library::new().load_text("own.json", TEXT).unwrap(), size, "spots");
    assert_eq!(views.len(), labels.len(), "{labels:?}");
    let atlas = captured(&fresh, TEXT, size, &reference);
    assert!(labels.len() > 2, "{labels:?}");
    for (at, label) in labels.iter().enumerate() {
        let [_, _, width, height] = area(label);
        // A tile of the same light, wherever it lies in the other atlas.
        let is_of =
            |view: &&View| label.starts_with(&format!("{at} {}: ", fresh.nearest_spot(view.position)));
        let view = views.iter().find(is_of).unwrap_or_else(|| panic!("no spot is that of {label}"));
        let [x, y, ..] = view.viewport.expect("a tile");
        assert_eq!([width, height], [256; 2], "{label}");
        hand.click("tile");
        hand.click(&format!("tile={at}"));
        let shown = hand.wait("tile", |state| state["contents"]["tile"] == at);
        assert_eq!(shown["contents"]["size"][0], width, "{label}");
        assert_eq!(shown["contents"]["size"][1], height, "{label}");
        let texels = (y..y + height).flat_map(|row| {
            let start = ((view.layer * atlas.height + row) * atlas.width + x) as usize;
            &atlas.values[start..start + width as usize]
        });
        let depths: Vec<f32> = texels.map(|texel| texel[0]).collect();
        let number = |name: &str| shown["contents"]["channels"][0][name].as_f64().unwrap_or(f64::NAN);
        let mean = depths.iter().map(|depth| f64::from(*depth)).sum::<f64>() / depths.len() as f64;
        let [min, max] = [f32::min, f32::max].map(|of| depths.iter().copied().reduce(of).unwrap_or(f32::NAN));
        for (name, wanted) in [("min", f64::from(min)), ("max", f64::from(max)), ("mean", mean)] {
            assert!((number(name) - wanted).abs() < 1e-4, "{label}: {name} {}, not {wanted}", number(name));
        }
    }
    // The next tile by its key, and the texel under the pointer counts from the corner of the atlas.
    hand.leave_text();
    hand.display.press(&[SHIFT], u32::from('j'));
    let before = labels.len() - 2;
    hand.wait("tile before", |state| state["contents"]["tile"] == before);
    let middle = hand.point("contents", [0.5, 0.5]);
    hand.move_to(middle);
    let [x, y, width, height] = area(&labels[before]);
    let is_within = |at: &Value| {
        let at: [u32; 2] = serde_json::from_value(at.clone()).unwrap_or_default();
        (x..x + width).contains(&at[0]) && (y..y + height).contains(&at[1])
    };
    hand.wait("texel of the tile", |state| is_within(&state["contents"]["cursor"][0]));
}
