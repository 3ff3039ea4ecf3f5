//! Views that draw into layers.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{GREEN, RED, Square, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, show, target, texels};
use crate::executing::views::frame;

const CLEARED: [u8; 4] = [0, 0, 255, 255];
const DRAWN: [u8; 4] = [255, 0, 0, 255];

#[test]
fn each_view_draws_into_its_layer_and_the_others_are_cleared() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(4), &draw(4, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["2", "0"]));
    let layers: Vec<_> = (0..4).map(|layer| color(&gpu, &target, layer)).collect();
    assert_eq!(layers, [DRAWN, CLEARED, DRAWN, CLEARED]);
}

#[test]
fn a_frame_without_views_clears_what_the_frame_before_drew() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(3), &draw(3, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0", "1", "2"]));
    assert_eq!(color(&gpu, &target, 2), DRAWN);
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&[]));
    assert!((0..3).all(|layer| color(&gpu, &target, layer) == CLEARED));
}

#[test]
fn a_pass_that_loads_leaves_the_layers_that_no_view_draws_into() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(3), &draw(3, r#"{ "to": "&target" }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0", "1"]));
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["2"]));
    assert!((0..3).all(|layer| color(&gpu, &target, layer) == DRAWN));
}

#[test]
fn a_layer_that_is_drawn_into_again_keeps_what_is_there() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(3), &draw(3, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 0 0 4 8", "1", "0 4 0 4 8"]));
    assert_eq!(color(&gpu, &target, 0), DRAWN);
    assert_eq!(color(&gpu, &target, 1), DRAWN);
}

#[test]
fn one_layer_beside_several_is_cleared_once() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": 2 }} }}"#,
        target(1)
    );
    let draw = r#""views": { "views": { "to": "&views", "max": 2 } },
        "squares": { "draw": { "geometry": "squares", "mesh_filter": "all", "views": "&views", "shader": "square.wgsl.jinja",
            "color": [{ "to": "&target", "clear": [0, 0, 1, 1] }],
            "depth": { "to": "&maps", "clear": 1, "compare": "less" } } }"#;
    let plan = plan(&resources, draw);
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 0 0 4 8", "1 4 0 4 8"]));
    assert_eq!(color(&gpu, &target, 0), DRAWN);
}

#[test]
fn several_layers_after_one_layer_are_cleared_each() {
    let Some(gpu) = gpu::device() else { return };
    let flat =
        r#""flat": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" } }"#;
    let to = r#"{ "to": "&flat", "clear": [0, 0, 0, 1] }, { "to": "&target", "clear": [0, 0, 1, 1] }"#;
    let twice = draw(2, to).replace("square.wgsl.jinja", "square_twice.wgsl.jinja");
    let plan = plan(&format!("{}, {flat}", target(2)), &twice);
    let half = Square { rectangle: [-1.0, -1.0, 0.0, 1.0], ..square(RED) };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[half], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    let (drawn, cleared) = ([DRAWN, CLEARED], [CLEARED, CLEARED]);
    for (views, wanted) in
        [(&["0"][..], [drawn, cleared]), (&["1"], [cleared, drawn]), (&["0", "1"], [drawn, drawn])]
    {
        show(&gpu, &mut executor, Some(&squares), &target, &frame(views));
        let seen = [0, 1].map(|layer| {
            let texels = texels(&gpu, &target, layer);
            [texels[0], texels[7]]
        });
        assert_eq!(seen, wanted, "{views:?}");
    }
}

#[test]
fn depth_layers_without_fragment_stage_are_cleared_each() {
    let Some(gpu) = gpu::device() else { return };
    for (views, wanted) in [(&["1"][..], [255, 64]), (&["0", "1"][..], [64, 64]), (&[][..], [255, 255])] {
        for (layer, wanted) in [0, 1].into_iter().zip(wanted) {
            let resources = format!(
                r#"{}, "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": 2 }} }}"#,
                target(1)
            );
            let passes = format!(
                r#""views": {{ "views": {{ "to": "&views", "max": 2 }} }},
                "casters": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views",
                    "shader": "square_depth.wgsl.jinja",
                    "depth": {{ "to": "&maps", "clear": 1, "compare": "less" }} }} }},
                "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
                    "bind": {{ "settings": {{ "values": {{ "layer": {layer} }} }}, "maps": "&maps" }},
                    "color": [{{ "to": "&target" }}] }} }}"#
            );
            let plan = plan(&resources, &passes);
            let quarter = Square { depth: 0.25, ..square(GREEN) };
            let squares = Squares::new(&gpu.device, &gpu.queue, &[quarter], &[[1.0; 4]]);
            let mut executor = executor(&gpu, &plan, Some(&squares));
            let target = import(&gpu, &plan, "target");
            show(&gpu, &mut executor, Some(&squares), &target, &frame(views));
            assert_eq!(color(&gpu, &target, 0)[0], wanted, "layer {layer} with views {views:?}");
        }
    }
}

const WHITE: [u8; 4] = [255; 4];

/// Stencil of two layers.
const MARKS: &str = r#""marks": { "texture": { "format": "stencil8", "size": "=viewport", "layers": 2, "lifetime": "persistent" } }"#;

/// A pass that paints a layer white where its stencil is a number.
fn shown(layer: u32, mark: u32) -> String {
    let to = format!(r#"{{ "to": "&target", "layer": {layer} }}"#);
    let equal = format!(
        r#""stencil": {{ "to": "&marks", "layer": {layer}, "reference": {mark}, "front": {{ "compare": "equal" }} }}, "color": [{{"#
    );
    fill(&format!("show_{layer}"), &to, "[1, 1, 1, 1]").replace(r#""color": [{"#, &equal)
}

#[test]
fn stencil_alone_is_cleared_in_each_layer() {
    let Some(gpu) = gpu::device() else { return };
    let marking = r#""views": { "views": { "to": "&views", "max": 2 } },
        "squares": { "draw": { "geometry": "squares", "mesh_filter": "all", "views": "&views", "shader": "square_depth.wgsl.jinja",
            "stencil": { "to": "&marks", "clear": 3, "front": { "pass": "increment-clamp" } } } }"#;
    let passes = [marking.to_owned(), shown(0, 3), shown(1, 4)].join(", ");
    let plan = plan(&format!("{}, {MARKS}", target(2)), &passes);
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    for _ in 0..2 {
        show(&gpu, &mut executor, Some(&squares), &target, &frame(&["1"]));
        assert_eq!([0, 1].map(|layer| color(&gpu, &target, layer)), [WHITE; 2]);
    }
}

#[test]
fn layers_of_stencil_are_cleared_each_on_its_own() {
    let Some(gpu) = gpu::device() else { return };
    for (views, marks_shown, wanted) in [
        // What is drawn counts from 3 to 4, and the rest is 3.
        (&["0"][..], [4, 3], [[WHITE, CLEARED], [WHITE, WHITE]]),
        (&["1"], [3, 4], [[WHITE, WHITE], [WHITE, CLEARED]]),
        (&["0", "1"], [4, 4], [[WHITE, CLEARED], [WHITE, CLEARED]]),
        (&["0", "1"], [3, 3], [[DRAWN, WHITE], [DRAWN, WHITE]]),
    ] {
        let count = r#""stencil": { "to": "&marks", "clear": 3, "reference": 3,
            "front": { "compare": "equal", "pass": "increment-clamp" } }, "color": [{"#;
        let squares =
            draw(2, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#).replace(r#""color": [{"#, count);
        let passes = [squares, shown(0, marks_shown[0]), shown(1, marks_shown[1])].join(", ");
        let plan = plan(&format!("{}, {MARKS}", target(2)), &passes);
        let half = Square { rectangle: [-1.0, -1.0, 0.0, 1.0], ..square(RED) };
        let squares = Squares::new(&gpu.device, &gpu.queue, &[half], &[[1.0; 4]]);
        let mut executor = executor(&gpu, &plan, Some(&squares));
        let target = import(&gpu, &plan, "target");
        for _ in 0..2 {
            show(&gpu, &mut executor, Some(&squares), &target, &frame(views));
            let seen = [0, 1].map(|layer| {
                let texels = texels(&gpu, &target, layer);
                [texels[0], texels[7]]
            });
            assert_eq!(seen, wanted, "{views:?}, where stencil is {marks_shown:?}");
        }
    }
}

#[test]
fn more_layers_than_a_machine_word_has_bits_are_cleared() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(200), &draw(200, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["150"]));
    assert_eq!(
        [0, 127, 128, 149, 150, 199].map(|layer| color(&gpu, &target, layer)),
        [CLEARED, CLEARED, CLEARED, CLEARED, DRAWN, CLEARED]
    );
}

#[test]
fn a_mip_of_a_layer_can_be_attached() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "chain": {{ "texture": {{ "format": "rgba8unorm", "size": [16, 16], "mips": 2 }} }}"#,
        target(1)
    );
    let passes = format!(
        r#"{}, "show": {{ "fullscreen": {{ "shader": "show.wgsl.jinja",
            "bind": {{ "picture": {{ "texture": {{ "name": "&chain", "mip": 1 }} }} }}, "color": [{{ "to": "&target" }}] }} }}"#,
        draw(8, r#"{ "to": "&chain", "mip": 1, "clear": [0, 0, 1, 1] }"#)
    );
    let plan = plan(&resources, &passes);
    let half = Square { rectangle: [-1.0, -1.0, 0.0, 1.0], ..square(RED) };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[half], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    let row = &texels(&gpu, &target, 0)[..8];
    assert_eq!(row, [DRAWN, DRAWN, DRAWN, DRAWN, CLEARED, CLEARED, CLEARED, CLEARED]);
}
