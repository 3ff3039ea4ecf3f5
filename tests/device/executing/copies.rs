//! Copies of subresource ranges: several mips, several layers, boxes, slices of volumes, faces of cubes, aspects, rows
//! of a buffer.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, show, target, texels};
use crate::executing::views::frame;

const BLACK: [u8; 4] = [0; 4];

/// The layers of the picture after a frame with passes that copy into it, and squares in the left half if there are
/// any. The layers that are named are black before.
fn pictures(layers: u32, blank: &[u32], resources: &str, passes: &str) -> Option<Vec<Vec<[u8; 4]>>> {
    let gpu = gpu::device()?;
    let resources = format!("{}, {resources}", target(layers));
    let blank = blank.iter().map(|layer| {
        let to = format!(r#"{{ "to": "&target", "layer": {layer} }}"#);
        fill(&format!("blank{layer}"), &to, "[0, 0, 0, 0]") + ", "
    });
    let plan = plan(&resources, &format!("{}{passes}", blank.collect::<String>()));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0 0 0 4 8"]));
    Some((0..layers).map(|layer| texels(&gpu, &picture, layer)).collect())
}

/// Fills of the layers of a texture with successive reds.
fn reds(name: &str, layers: u32, mip: u32) -> String {
    let fills = (0..layers).map(|layer| {
        let to = format!(r#"{{ "to": "&{name}", "layer": {layer}, "mip": {mip} }}"#);
        let red = mip * 100 + layer + 1;
        fill(&format!("{name}_{mip}_{layer}"), &to, &format!(r#"["={red} / 255", 0, 0, 1]"#))
    });
    fills.collect::<Vec<_>>().join(", ")
}

fn red(value: u8) -> [u8; 4] {
    [value, 0, 0, 255]
}

/// A picture of 8 by 8 texels: black but for boxes, each with its first texel, its extent and its color.
fn boxes(list: &[([usize; 2], [usize; 2], [u8; 4])]) -> Vec<[u8; 4]> {
    let mut picture = vec![BLACK; 64];
    for ([left, top], [width, height], color) in list {
        for y in *top..top + height {
            picture[y * 8 + left..y * 8 + left + width].fill(*color);
        }
    }
    picture
}

#[test]
fn several_mips_of_several_layers_are_copied_at_once() {
    let resources = r#"
        "a": { "texture": { "format": "rgba8unorm", "size": [16, 16], "layers": 3, "mips": 3 } },
        "b": { "texture": { "format": "rgba8unorm", "size": [8, 8], "layers": 2, "mips": 2 } }"#;
    let passes = format!(
        r#"{}, {}, "copy": {{ "copy": {{ "from": {{ "name": "&a", "mip": 1, "mips": 2, "layer": 1, "layers": 2 }},
             "to": {{ "name": "&b", "mips": 2 }} }} }},
           "large": {{ "copy": {{ "from": {{ "name": "&b", "layer": 1 }}, "to": {{ "name": "&target", "layer": 0 }} }} }},
           "small": {{ "copy": {{ "from": {{ "name": "&b", "mip": 1, "layer": 0 }}, "extent": [4, 4],
             "to": {{ "name": "&target", "layer": 0, "origin": [2, 3] }} }} }}"#,
        reds("a", 3, 1),
        reds("a", 3, 2),
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[([0, 0], [8, 8], red(103)), ([2, 3], [4, 4], red(202))]));
}

#[test]
fn a_box_of_a_volume_is_copied_to_layers() {
    let resources = r#"
        "layers": { "texture": { "format": "rgba8unorm", "size": [6, 6], "layers": 4 } },
        "volume": { "texture": { "format": "rgba8unorm", "size": [6, 6], "layers": 4, "view_dimension": "3d" } }"#;
    let passes = format!(
        r#"{}, "fill": {{ "copy": {{ "from": {{ "name": "&layers" }}, "to": {{ "name": "&volume" }} }} }},
           "box": {{ "after": ["blank1", "blank2"], "copy": {{ "from": {{ "name": "&volume", "layer": 1, "layers": 2, "origin": [1, 2] }},
             "extent": ["=viewport.width / 4", 3],
             "to": {{ "name": "&target", "layer": 1, "layers": 2, "origin": ["=viewport.width - 2", 5] }} }} }}"#,
        reds("layers", 4, 0),
    );
    let Some(found) = pictures(3, &[0, 1, 2], resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[]));
    assert_eq!(found[1], boxes(&[([6, 5], [2, 3], red(2))]));
    assert_eq!(found[2], boxes(&[([6, 5], [2, 3], red(3))]));
}

#[test]
fn a_face_of_a_cube_is_copied() {
    let resources = r#""cube": { "texture": { "format": "rgba8unorm", "size": [8, 8], "layers": 12 } }"#;
    let passes = format!(
        r#"{}, "face": {{ "copy": {{ "from": {{ "name": "&cube", "layer": 1, "face": "-y" }},
             "to": {{ "name": "&target", "layer": 0 }} }} }}"#,
        reds("cube", 12, 0),
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[([0, 0], [8, 8], red(6 + 3 + 1))]));
}

#[test]
fn a_layer_is_copied_to_another_layer_of_its_texture() {
    let passes = format!(
        r#"{}, "move": {{ "copy": {{ "from": {{ "name": "&own", "layer": 0 }}, "to": {{ "name": "&own", "layer": 1 }} }} }},
           "show": {{ "copy": {{ "from": {{ "name": "&own" }}, "to": {{ "name": "&target" }} }} }}"#,
        reds("own", 1, 0),
    );
    let resources = r#""own": { "texture": { "format": "rgba8unorm", "size": "=viewport", "layers": 2, "lifetime": "persistent" } }"#;
    let Some(found) = pictures(2, &[], resources, &passes) else { return };
    assert!(found.iter().all(|layer| *layer == boxes(&[([0, 0], [8, 8], red(1))])), "{found:?}");
}

/// A mask whose left half is marked with 3, and passes that mark it.
fn marked(format: &str, depth: &str) -> (String, String) {
    let resources = format!(
        r#""mask": {{ "texture": {{ "format": "{format}", "size": "=viewport" }} }}, "bytes": {{ "buffer": {{ "size": 2048 }} }},
           "scratch": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#
    );
    let mark = draw(1, r#"{ "to": "&scratch", "clear": [0, 0, 0, 0] }"#).replace(
        r#""color":"#,
        &format!(
            r#"{depth} "stencil": {{ "to": "&mask", "clear": 0, "reference": 3, "front": {{ "pass": "replace" }} }}, "color":"#
        ),
    );
    (resources, mark)
}

/// Shows a texture as the picture.
fn shown(name: &str) -> String {
    format!(
        r#""shown": {{ "fullscreen": {{ "shader": "show.wgsl.jinja", "bind": {{ "picture": "&{name}" }},
             "color": [{{ "to": "&target" }}] }} }}"#
    )
}

#[test]
fn the_stencil_beside_depth_is_copied_alone() {
    let (resources, mark) =
        marked("depth24plus-stencil8", r#""depth": { "to": "&mask", "clear": 1, "compare": "less-equal" },"#);
    let resources =
        format!(r#"{resources}, "grey": {{ "texture": {{ "format": "r8unorm", "size": "=viewport" }} }}"#);
    let passes = format!(
        r#"{mark},
           "down": {{ "copy": {{ "from": {{ "name": "&mask", "aspect": "stencil-only" }}, "to": {{ "name": "&bytes" }} }} }},
           "up": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&grey" }} }} }}, {}"#,
        shown("grey")
    );
    let Some(found) = pictures(1, &[], &resources, &passes) else { return };
    let wanted = boxes(&[([0, 0], [4, 8], red(3)), ([4, 0], [4, 8], red(0))]);
    assert_eq!(found[0], wanted);
}

#[test]
fn a_stencil_is_filled_from_a_buffer() {
    let (resources, mark) = marked("stencil8", "");
    let resources =
        format!(r#"{resources}, "other": {{ "texture": {{ "format": "stencil8", "size": "=viewport" }} }}"#);
    let passes = format!(
        r#"{mark},
           "down": {{ "copy": {{ "from": {{ "name": "&mask" }}, "to": {{ "name": "&bytes" }} }} }},
           "up": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&other" }} }} }},
           "colored": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja",
             "bind": {{ "settings": {{ "values": {{ "color": [1, 0, 0, 1] }} }} }},
             "stencil": {{ "to": "&other", "reference": 3, "front": {{ "compare": "equal" }} }},
             "color": [{{ "to": "&target" }}] }} }}"#
    );
    let Some(found) = pictures(1, &[0], &resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[([0, 0], [4, 8], red(255))]));
}

#[test]
fn depth_and_stencil_are_copied_together() {
    let (resources, mark) =
        marked("depth24plus-stencil8", r#""depth": { "to": "&mask", "clear": 1, "compare": "less-equal" },"#);
    let resources = format!(
        r#"{resources}, "other": {{ "texture": {{ "format": "depth24plus-stencil8", "size": "=viewport" }} }}"#
    );
    let passes = format!(
        r#"{mark}, "both": {{ "copy": {{ "from": {{ "name": "&mask" }}, "to": {{ "name": "&other" }} }} }},
           "colored": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja",
             "bind": {{ "settings": {{ "values": {{ "color": [1, 0, 0, 1] }} }} }},
             "stencil": {{ "to": "&other", "reference": 3, "front": {{ "compare": "equal" }} }},
             "color": [{{ "to": "&target" }}] }} }}"#
    );
    let Some(found) = pictures(1, &[0], &resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[([0, 0], [4, 8], red(255))]));
}

#[test]
fn depth_of_sixteen_bits_is_filled_from_a_buffer() {
    let resources = r#"
        "red": { "texture": { "format": "rg8unorm", "size": "=viewport" } }, "bytes": { "buffer": { "size": 2048 } },
        "maps": { "texture": { "format": "depth16unorm", "size": "=viewport", "layers": 1, "view_dimension": "2d-array" } }"#;
    // The low and the high byte of 65,535 × 0.2 are both 51.
    let passes = format!(
        r#"{}, "down": {{ "copy": {{ "from": {{ "name": "&red" }}, "to": {{ "name": "&bytes" }} }} }},
           "up": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&maps" }} }} }},
           "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
             "bind": {{ "settings": {{ "values": {{ "layer": 0 }} }}, "maps": "&maps" }}, "color": [{{ "to": "&target" }}] }} }}"#,
        fill("fill", r#"{ "to": "&red" }"#, "[0.2, 0.2, 0, 1]"),
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    assert_eq!(found[0], boxes(&[([0, 0], [8, 8], [51, 51, 51, 255])]));
}

#[test]
fn all_samples_are_copied() {
    let resources = r#"
        "samples": { "texture": { "format": "rgba8unorm", "size": "=viewport", "samples": 4 } },
        "others": { "texture": { "format": "rgba8unorm", "size": "=viewport", "samples": 4 } }"#;
    let to = r#"{ "to": "&samples", "clear": [0, 0, 1, 1] }"#;
    let passes = format!(
        r#"{}, "copy": {{ "copy": {{ "from": {{ "name": "&samples" }}, "to": {{ "name": "&others" }} }} }},
           {}"#,
        draw(1, to),
        fill(
            "resolve",
            r#"{ "to": "&others", "blend": "add", "resolve": { "to": "&target", "layer": 0 } }"#,
            "[0, 0, 0, 0]"
        )
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    let right = ([4, 0], [4, 8], [0, 0, 255, 255]);
    assert_eq!(found[0], boxes(&[([0, 0], [4, 8], red(255)), right]));
}

#[test]
fn depth_is_copied_to_a_buffer() {
    let resources = r#"
        "depth": { "texture": { "format": "depth32float", "size": "=viewport" } }, "bytes": { "buffer": { "size": 2048 } },
        "grey": { "texture": { "format": "r32float", "size": "=viewport" } },
        "scratch": { "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let drawn = draw(1, r#"{ "to": "&scratch", "clear": [0, 0, 0, 0] }"#).replace(
        r#""color":"#,
        r#""depth": { "to": "&depth", "clear": 0.2, "compare": "less-equal" }, "color":"#,
    );
    let passes = format!(
        r#"{drawn}, "down": {{ "copy": {{ "from": {{ "name": "&depth", "aspect": "depth-only" }}, "to": {{ "name": "&bytes" }} }} }},
           "up": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&grey" }} }} }}, {}"#,
        shown("grey")
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    assert_eq!(found[0][63], red(51));
}

#[test]
fn rows_and_images_of_a_buffer_lie_as_far_apart_as_is_said() {
    let resources = r#""layers": { "texture": { "format": "rgba8unorm", "size": [8, 2], "layers": 2 } },
        "bytes": { "buffer": { "size": 8192 } }"#;
    // Two layers of two rows, 512 bytes a row and 3 rows an image: the second layer begins at byte 256 + 1536.
    let passes = format!(
        r#"{}, "start": {{ "clear": {{ "buffer": "&bytes" }} }},
           "down": {{ "copy": {{ "from": {{ "name": "&layers" }},
             "to": {{ "name": "&bytes", "offset": 256, "size": 2560, "bytes_per_row": 512, "rows_per_image": 3 }} }} }},
           "up": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&target" }} }} }}"#,
        reds("layers", 2, 0)
    );
    let Some(found) = pictures(1, &[], resources, &passes) else { return };
    // As texels of 256 bytes a row, of which the picture shows the first eight.
    let rows = [([0, 1], [8, 1], red(1)), ([0, 3], [8, 1], red(1)), ([0, 7], [8, 1], red(2))];
    assert_eq!(found[0], boxes(&rows));
}

#[test]
fn layers_of_different_last_usages_are_copied_at_once() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "pair": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "layers": 3 }} }},
           "seen": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#,
        target(3)
    );
    let passes = [
        fill("one", r#"{ "to": "&pair", "layer": 0 }"#, "[1, 0, 0, 1]"),
        r#""two": { "copy": { "from": { "name": "&pair@one", "layer": 0 }, "to": { "name": "&pair", "layer": 1 } } }"#.to_owned(),
        fill("three", r#"{ "to": "&pair", "layer": 2 }"#, "[0, 0, 1, 1]"),
        r#""sample": { "side_effect": true, "fullscreen": { "shader": "show.wgsl.jinja",
            "bind": { "picture": { "texture": { "name": "&pair", "layer": 2 } } }, "color": [{ "to": "&seen" }] } }"#
            .to_owned(),
        r#""shown": { "after": ["sample"], "copy": { "from": { "name": "&pair" }, "to": { "name": "&target" } } }"#.to_owned(),
    ];
    let plan = plan(&resources, &passes.join(", "));
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    let red = [255, 0, 0, 255];
    assert_eq!([0, 1, 2].map(|layer| color(&gpu, &picture, layer)), [red, red, [0, 0, 255, 255]]);
}
