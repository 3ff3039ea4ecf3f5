//! The pictures of docs/viewer.md, taken of the screen; with `UMBRAGRAPH_BLESS=1` they are written there.

use std::path::{Path, PathBuf};

use crate::hand::{Hand, SIZE, module};
use crate::{PIPELINE, start};

/// Takes a picture of the window and writes it as a JPEG file.
fn photograph(hand: &mut Hand, folder: &Path, name: &str) {
    // Away from whatever says something under the pointer.
    hand.move_to([SIZE[0] as i16 - 3, SIZE[1] as i16 - 3]);
    hand.settle();
    std::thread::sleep(std::time::Duration::from_millis(700));
    let [x, y] = hand.corner;
    let rgb = hand.display.picture([x, y], SIZE);
    let colors = rgb.chunks(3).collect::<std::collections::BTreeSet<_>>().len();
    assert!(colors > 500, "{name}: {colors} colors");
    let image = image::RgbImage::from_raw(SIZE[0].into(), SIZE[1].into(), rgb).expect("a picture");
    let mut jpeg = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 88);
    image.write_with_encoder(encoder).unwrap();
    std::fs::write(folder.join(format!("{name}.jpg")), jpeg).unwrap();
}

#[test]
fn pictures_of_the_page_are_taken() {
    let is_blessed = std::env::var_os("UMBRAGRAPH_BLESS").is_some();
    let Some(mut hand) = start("pictures", &["--scale", if is_blessed { "1" } else { "0.25" }]) else {
        return;
    };
    let folder: PathBuf = if is_blessed { module().join("docs/viewer") } else { hand.folder.clone() };
    std::fs::create_dir_all(&folder).unwrap();
    hand.settle();
    photograph(&mut hand, &folder, "window");
    let [from, to] = [[0.05, 0.5], [0.25, 0.5]].map(|part| hand.point("constant_bias", part));
    hand.drag(from, to);
    hand.click("fxaa");
    hand.wait("feature", |state| state["given"]["features"]["fxaa"] == true);
    hand.click("only given");
    hand.display.press(&[], u32::from('g'));
    hand.wait("no graph", |state| state["below"].is_null());
    photograph(&mut hand, &folder, "values");
    hand.click("only given");
    hand.click("reset all");
    hand.click("graph");
    hand.wait("graph", |state| state["below"] == "Graph");
    // The graph and the contents need the room.
    hand.click("values");
    hand.wait("no values", |state| state["panel"]["open"] == false);
    hand.click("resource maps");
    hand.wait("contents", |state| state["contents"]["of"][0] == "maps@casters");
    let at = hand.point("contents", [0.4, 0.4]);
    hand.move_to(at);
    hand.wait("value", |state| state["contents"]["cursor"].is_array());
    photograph(&mut hand, &folder, "contents");
    hand.click("resource color");
    hand.wait("contents", |state| state["contents"]["of"][0] == "color@sky");
    hand.click("side difference");
    hand.wait("difference", |state| state["contents"]["side"] == "difference");
    photograph(&mut hand, &folder, "difference");
    hand.click("close inspector");
    hand.click("times");
    hand.click("play");
    std::thread::sleep(std::time::Duration::from_secs(6));
    hand.click("play");
    hand.wait("pause", |state| state["playing"] == false);
    photograph(&mut hand, &folder, "times");
    let broken = PIPELINE.replace("\"blend\": \"add\"", "\"blend\": \"ad\"");
    std::fs::write(hand.folder.join("own.json"), broken).unwrap();
    hand.wait("error", |state| state["errors"].as_array().is_some_and(|errors| !errors.is_empty()));
    photograph(&mut hand, &folder, "broken");
}
