//! Candidates for formats, where textures are copied or resolved to one another.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{self, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, show, target};
use crate::executing::views::frame;

const RED: [u8; 4] = [255, 0, 0, 255];
const CANDIDATES: &str = r#"["rgba16float", "rgba8unorm"]"#;

fn texture(name: &str, format: &str, more: &str) -> String {
    format!(r#""{name}": {{ "texture": {{ "format": {format}, "size": "=viewport" {more} }} }}"#)
}

fn copy(from: &str, to: &str) -> String {
    format!(r#""{to}": {{ "copy": {{ "from": {{ "name": "&{from}" }}, "to": {{ "name": "&{to}" }} }} }}"#)
}

/// The formats of the resources that are planned, after a frame whose picture is red.
fn formats(resources: &str, passes: &str, with_squares: bool) -> Option<Vec<String>> {
    let gpu = gpu::device()?;
    let plan = plan(&format!("{}, {resources}", target(1)), passes);
    let drawn =
        with_squares.then(|| Squares::new(&gpu.device, &gpu.queue, &[square(squares::RED)], &[[1.0; 4]]));
    let mut executor = executor(&gpu, &plan, drawn.as_ref());
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, drawn.as_ref(), &picture, &frame(&["0"]));
    assert_eq!(color(&gpu, &picture, 0), RED);
    let formats = plan.resources.values().filter_map(|resource| resource.format);
    Some(formats.map(|format| format!("{format:?}")).collect())
}

#[test]
fn textures_that_are_copied_to_one_another_get_one_format() {
    let red = fill("red", r#"{ "to": "&a" }"#, "[1, 0, 0, 1]");
    let passes = [red, copy("a", "b"), copy("b", "c"), copy("c", "target")].join(", ");
    let all = ["a", "b", "c"].map(|name| texture(name, CANDIDATES, "")).join(", ");
    let Some(found) = formats(&all, &passes, false) else { return };
    assert_eq!(found, ["Rgba8Unorm"; 4]);
    // Where nothing wants another, the first candidates stay.
    let shown = r#""show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&b" },
        "color": [{ "to": "&target" }] } }"#;
    let red = fill("red", r#"{ "to": "&a" }"#, "[1, 0, 0, 1]");
    let passes = [red, copy("a", "b"), shown.to_owned()].join(", ");
    let both = ["a", "b"].map(|name| texture(name, CANDIDATES, "")).join(", ");
    let Some(found) = formats(&both, &passes, false) else { return };
    assert_eq!(found, ["Rgba16Float", "Rgba16Float", "Rgba8Unorm"]);
}

#[test]
fn samples_are_resolved_to_a_texture_of_their_format() {
    let samples = texture("samples", CANDIDATES, r#", "samples": 4"#);
    let to = r#"{ "to": "&samples", "clear": [1, 0, 0, 1], "resolve": { "to": "&target" } }"#;
    let Some(found) = formats(&samples, &draw(1, to), true) else { return };
    assert_eq!(found, ["Rgba8Unorm", "Rgba8Unorm"]);
    // A copy would do with another encoding of the same bytes; a resolve does not.
    let samples = texture("samples", r#"["rgba8unorm-srgb", "rgba8unorm"]"#, r#", "samples": 4"#);
    let Some(found) = formats(&samples, &draw(1, to), true) else { return };
    assert_eq!(found, ["Rgba8Unorm", "Rgba8Unorm"]);
}
