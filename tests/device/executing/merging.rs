//! Passes that the plan groups are recorded as one render pass, and come to the same picture.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{GREEN, RED, Square, Squares, square};
use crate::executing::stage::{draw, executor, fill, plan, show, target, texels};
use crate::executing::views::frame;

#[test]
fn neighbours_that_add_to_one_attachment_are_one_render_pass() {
    let Some(gpu) = gpu::device() else { return };
    let add = r#"{ "to": "&target", "blend": "add" }"#;
    let passes = [
        draw(8, add).replace(r#""squares": { "draw""#, r#""squares": { "after": ["three"], "draw""#),
        fill("one", r#"{ "to": "&target" }"#, "[0.2, 0, 0, 1]"),
        fill("three", add, "[0, 0.4, 0, 0]"),
    ];
    let plan = plan(&target(1), &passes.join(","));
    let groups: Vec<_> = plan.passes.iter().map(|pass| (pass.name.as_str(), pass.group)).collect();
    let of = |name: &str| groups.iter().find(|(other, _)| *other == name).map(|(_, group)| *group);
    assert!(of("one") == of("three") && of("three") == of("squares"), "{groups:?}");
    let half = Square { rectangle: [0.0, -1.0, 1.0, 1.0], ..square([0.0, 0.0, 0.6, 0.0]) };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[half], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    let [left, right] = [[51, 102, 0, 255], [51, 102, 153, 255]];
    assert_eq!(texels(&gpu, &target, 0)[..8], [left, left, left, left, right, right, right, right]);
    // Where the device tells.
    if executor.measure_gpu_times(true) {
        show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
        let begun: Vec<String> = executor.gpu_times().into_iter().map(|one| one.pass).collect();
        assert_eq!(begun, ["one"]);
    }
}

#[test]
fn stencil_tested_then_written_is_one_render_pass() {
    let Some(gpu) = gpu::device() else { return };
    let marks =
        r#""marks": { "texture": { "format": "stencil8", "size": "=viewport", "lifetime": "persistent" } }"#;
    let stencil = |pass: &str| {
        format!(
            r#""stencil": {{ "to": "&marks", "front": {{ "compare": "equal", "pass": "{pass}" }} }}, "color": [{{"#
        )
    };
    let tests = fill("tests", r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#, "[0.4, 0, 0, 1]");
    let writes = fill("writes", r#"{ "to": "&target", "blend": "add" }"#, "[0.2, 0, 0, 0]");
    let passes = [
        tests.replace(r#""color": [{"#, &stencil("keep")),
        writes
            .replace(r#""color": [{"#, &stencil("increment-clamp"))
            .replace(r#""writes": {"#, r#""writes": { "after": ["tests"],"#),
    ];
    let plan = plan(&format!("{}, {marks}", target(1)), &passes.join(","));
    assert_eq!(plan.passes[0].group, plan.passes[1].group);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    for wanted in [[153, 0, 0, 255], [0, 0, 255, 255]] {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        assert_eq!(crate::executing::stage::color(&gpu, &target, 0), wanted);
    }
}

#[test]
fn a_full_screen_pass_after_a_view_of_a_part_covers_everything() {
    let Some(gpu) = gpu::device() else { return };
    let add = r#"{ "to": "&target", "blend": "add" }"#;
    let passes = [
        draw(8, r#"{ "to": "&target", "clear": [0, 0, 0, 1] }"#),
        fill("late", add, "[0, 0.4, 0, 0]").replace(r#""late": {"#, r#""late": { "after": ["squares"],"#),
    ];
    let plan = plan(&target(1), &passes.join(","));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 0 0 1 8"]));
    let texels = texels(&gpu, &target, 0);
    assert_eq!(texels[..3], [[255, 102, 0, 255], [0, 102, 0, 255], [0, 102, 0, 255]]);
}

#[test]
fn depth_written_then_tested_is_one_render_pass() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "depth": {{ "texture": {{ "format": "depth32float", "size": "=viewport" }} }}"#,
        target(1)
    );
    let scene = |name: &str, more: &str, color: &str, depth: &str| {
        format!(
            r#""{name}": {{ {more} "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views",
                "shader": "square.wgsl.jinja", "color": [{color}], "depth": {depth} }} }}"#
        )
    };
    let passes = [
        r#""views": { "views": { "to": "&views", "max": 1 } }"#.to_owned(),
        scene(
            "first",
            "",
            r#"{ "to": "&target", "clear": [0, 0, 0, 0] }"#,
            r#"{ "to": "&depth", "clear": 1, "compare": "less" }"#,
        ),
        scene(
            "again",
            r#""after": ["first"],"#,
            r#"{ "to": "&target", "blend": "add" }"#,
            r#"{ "to": "&depth", "write": false, "compare": "equal" }"#,
        ),
    ];
    let plan = plan(&resources, &passes.join(","));
    let group = |name: &str| plan.passes.iter().find(|pass| pass.name == name).map(|pass| pass.group);
    assert_eq!(group("first"), group("again"));
    // The far square is hidden behind the near one, which is added to itself.
    let near = Square { depth: 0.25, ..square([0.4, 0.0, 0.0, 0.5]) };
    let far = Square { depth: 0.75, ..square(GREEN) };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[far, near], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(crate::executing::stage::color(&gpu, &target, 0), [204, 0, 0, 255]);
}

#[test]
fn depth_tested_then_written_is_one_render_pass() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "depth": {{ "texture": {{ "format": "depth32float", "size": "=viewport" }} }}"#,
        target(1)
    );
    let scene = |name: &str, after: &str, shader: &str, color: &str, depth: &str| {
        format!(
            r#""{name}": {{ "after": [{after}], "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views",
                "shader": "{shader}", "color": [{color}], "depth": {depth} }} }}"#
        )
    };
    let add = r#"{ "to": "&target", "blend": "add" }"#;
    let equal =
        |to: &str, write: bool| format!(r#"{{ "to": "&{to}", "write": {write}, "compare": "equal" }}"#);
    let passes = [
        r#""views": { "views": { "to": "&views", "max": 1 } }"#.to_owned(),
        scene(
            "depth",
            "",
            "square_depth.wgsl.jinja",
            "",
            r#"{ "to": "&depth", "clear": 1, "compare": "less" }"#,
        ),
        fill("ground", r#"{ "to": "&target" }"#, "[0, 0, 0, 0]"),
        scene("tests", r#""depth", "ground""#, "square.wgsl.jinja", add, &equal("depth@depth", false)),
        scene("writes", r#""tests""#, "square.wgsl.jinja", add, &equal("depth", true)),
    ];
    let plan = plan(&resources, &passes.join(","));
    let group = |name: &str| plan.passes.iter().find(|pass| pass.name == name).map(|pass| pass.group);
    assert_eq!(group("tests"), group("writes"));
    let near = Square { depth: 0.25, ..square([0.4, 0.0, 0.0, 0.5]) };
    let far = Square { depth: 0.75, ..square(GREEN) };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[far, near], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(crate::executing::stage::color(&gpu, &target, 0), [204, 0, 0, 255]);
}
