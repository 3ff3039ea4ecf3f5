//! Subresource ranges of resources: stencil beside depth, faces, aspects, view formats, and passes that only some
//! viewport breaks.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, show, target, texels, try_plan_of_text};
use crate::executing::views::frame;

const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];

/// The squares mark the left half of the stencil, and a fill colors what is, or is not, marked.
fn masked(format: &str, depth: &str, test: &str) -> Vec<[u8; 4]> {
    let Some(gpu) = gpu::device() else { return Vec::new() };
    let resources = format!(
        r#"{}, "mask": {{ "texture": {{ "format": "{format}", "size": "=viewport" }} }},
           "scratch": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#,
        target(1)
    );
    let mark = draw(1, r#"{ "to": "&scratch", "clear": [0, 0, 0, 0] }"#).replace(
        r#""color":"#,
        &format!(
            r#"{depth} "stencil": {{ "to": "&mask", "clear": 0, "reference": 255, "front": {{ "pass": "replace" }} }}, "color":"#
        ),
    );
    let passes = format!(
        r#"{mark}, {}, "colored": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja",
             "bind": {{ "settings": {{ "values": {{ "color": [0, 1, 0, 1] }} }} }},
             "stencil": {{ "to": "&mask", {test} }}, "color": [{{ "to": "&target" }}] }} }}"#,
        fill("back", r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#, "[0, 0, 1, 1]"),
    );
    let plan = plan(&resources, &passes);
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0 0 0 4 8"]));
    texels(&gpu, &picture, 0)
}

fn halves(left: [u8; 4], right: [u8; 4]) -> Vec<[u8; 4]> {
    (0..64).map(|at| if at % 8 < 4 { left } else { right }).collect()
}

#[test]
fn a_stencil_mask_lets_through_what_is_marked() {
    let equal = r#""reference": 255, "front": { "compare": "equal" }"#;
    let other = r#""reference": 255, "front": { "compare": "not-equal" }"#;
    let masked_bits = r#""reference": 1, "read_mask": 1, "front": { "compare": "equal" }"#;
    for (test, expected) in
        [(equal, halves(GREEN, BLUE)), (other, halves(BLUE, GREEN)), (masked_bits, halves(GREEN, BLUE))]
    {
        let found = masked("stencil8", "", test);
        assert!(found.is_empty() || found == expected, "{test}: {found:?}");
    }
}

#[test]
fn depth_and_stencil_of_one_texture_are_used_apart() {
    let depth = r#""depth": { "to": "&mask", "clear": 1, "compare": "less-equal" },"#;
    let found = masked("depth24plus-stencil8", depth, r#""reference": 255, "front": { "compare": "equal" }"#);
    assert!(found.is_empty() || found == halves(GREEN, BLUE), "{found:?}");
}

#[test]
fn a_shader_sees_the_bound_layers_mips_and_aspect() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "scratch": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
           "mask": {{ "texture": {{ "format": "depth24plus-stencil8", "size": "=viewport" }} }},
           "stack": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "layers": 5, "mips": 4, "lifetime": "persistent" }} }}"#,
        target(1)
    );
    let shown = |shader: &str, bind: &str| {
        format!(
            r#""show": {{ "fullscreen": {{ "shader": "{shader}", "bind": {{ {bind} }}, "color": [{{ "to": "&target" }}] }} }}"#
        )
    };
    let mark = draw(1, r#"{ "to": "&scratch", "clear": [0, 0, 0, 0] }"#).replace(
        r#""color":"#,
        r#""depth": { "to": "&mask", "clear": 1, "compare": "less" },
           "stencil": { "to": "&mask", "clear": 0, "reference": 3, "front": { "pass": "replace" } }, "color":"#,
    );
    let part =
        r#""pictures": { "texture": { "name": "&stack", "layer": 1, "layers": 2, "mip": 1, "mips": 3 } }"#;
    let stencil = r#""marks": { "texture": { "name": "&mask", "aspect": "stencil-only" } }"#;
    let filled = fill("filled", r#"{ "to": "&stack", "layer": 1, "mip": 1 }"#, "[1, 0, 0, 1]");
    for (before, shown, wanted) in [
        (filled, shown("extent.wgsl.jinja", part), [2, 3, 0, 255]),
        (mark, shown("show_stencil.wgsl.jinja", stencil), [3, 0, 0, 255]),
    ] {
        let plan = plan(&resources, &format!("{before}, {shown}"));
        let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
        let mut executor = executor(&gpu, &plan, Some(&squares));
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0"]));
        assert_eq!(color(&gpu, &picture, 0), wanted, "{shown}");
    }
}

#[test]
fn a_stencil_is_cleared_to_what_a_parameter_says_now() {
    let Some(gpu) = gpu::device() else { return };
    let text = format!(
        r#"{{ "format": 1, "name": "test",
          "parameters": {{ "mark": {{ "type": "u32", "default": 0, "min": 0, "max": 255 }} }},
          "resources": {{ {}, "mask": {{ "texture": {{ "format": "stencil8", "size": "=viewport" }} }} }},
          "passes": {{ {}, "marked": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja",
              "bind": {{ "settings": {{ "values": {{ "color": [0, 1, 0, 1] }} }} }},
              "stencil": {{ "to": "&mask", "clear": "=mark", "reference": 3, "front": {{ "compare": "equal" }} }},
              "color": [{{ "to": "&target" }}] }} }} }} }}"#,
        target(1),
        fill("back", r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#, "[0, 0, 1, 1]"),
    );
    let plan = try_plan_of_text(text, 8).unwrap_or_else(|said| panic!("{said}"));
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    let mark = executor.parameter::<u32>("mark").expect("a live parameter");
    for (value, wanted) in [(0, BLUE), (3, GREEN), (2, BLUE)] {
        executor.set(mark, value).expect("a value");
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        assert_eq!(color(&gpu, &picture, 0), wanted, "cleared to {value}");
    }
}

#[test]
fn a_face_by_its_name_is_a_layer() {
    let Some(gpu) = gpu::device() else { return };
    let passes: Vec<String> = (["+x", "-x", "+y", "-y", "+z", "-z"].iter().enumerate())
        .map(|(at, face)| {
            let to = format!(r#"{{ "to": "&target", "face": "{face}" }}"#);
            fill(
                &format!("face{at}"),
                &to,
                &format!("[{at} / 255, 0, 0, 1]").replace('[', "[\"=").replace(" / 255,", " / 255\","),
            )
        })
        .collect();
    let plan = plan(&target(6), &passes.join(", "));
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    for layer in 0..6u8 {
        assert_eq!(color(&gpu, &picture, u32::from(layer)), [layer, 0, 0, 255]);
    }
}

#[test]
fn a_texture_is_written_and_seen_in_the_format_of_the_view() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "linear": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#,
        target(1)
    );
    let show_as = |format: &str| {
        format!(
            r#"{}, "shown": {{ "fullscreen": {{ "shader": "show.wgsl.jinja",
               "bind": {{ "picture": {{ "texture": {{ "name": "&linear" {format} }} }} }}, "color": [{{ "to": "&target" }}] }} }}"#,
            fill("half", r#"{ "to": "&linear" }"#, "[0.5, 0.5, 0.5, 1]")
        )
    };
    let mut seen = Vec::new();
    for format in ["", r#", "format": "rgba8unorm-srgb""#] {
        let plan = plan(&resources, &show_as(format));
        let mut executor = executor(&gpu, &plan, None);
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        seen.push(color(&gpu, &picture, 0)[0]);
    }
    // ((0.5 + 0.055) / 1.055)^2.4 = 0.214
    assert!(seen[0].abs_diff(128) <= 1 && seen[1].abs_diff(55) <= 1, "{seen:?}");
}

#[test]
fn a_storage_texture_is_seen_as_srgb_too() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "image": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#,
        target(1)
    );
    let passes = format!(
        r#"{}, "half": {{ "compute": {{ "shader": "half.wgsl.jinja", "workgroups": [1, 1, 1],
             "bind": {{ "image": {{ "texture": {{ "name": "&image", "contents": "load" }} }} }} }} }},
           "shown": {{ "fullscreen": {{ "shader": "show.wgsl.jinja",
             "bind": {{ "picture": {{ "texture": {{ "name": "&image", "format": "rgba8unorm-srgb" }} }} }},
             "color": [{{ "to": "&target" }}] }} }}"#,
        fill("grey", r#"{ "to": "&image" }"#, "[0.5, 0.5, 0.5, 1]")
    );
    let plan = plan(&resources, &passes);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    let found = texels(&gpu, &picture, 0);
    // The compute pass writes the left half; grey of 0.5 is 0.214 as sRGB.
    assert_eq!(found[0], GREEN);
    assert!(found[7][0].abs_diff(55) <= 1, "{:?}", found[7]);
}
