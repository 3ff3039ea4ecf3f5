//! Live parameters in everything that a frame sets anew, and in every type that they have.

use std::sync::Arc;

use umbragraph::Executor;
use umbragraph::Plan;
use umbragraph::executor::ParameterValue;
use umbragraph_test_support::gpu::{self, Gpu};

use crate::common::gpu::import;
use crate::executing::squares::{GEOMETRY, RED, Squares, square};
use crate::executing::stage::{SIDE, draw, executor, fill, plan_of_text, show, target, texels};
use crate::executing::views::frame;

/// A plan over passes that see a parameter `live`.
#[track_caller]
fn plan(parameter: &str, passes: &str) -> Arc<Plan> {
    let target = target(1);
    let text = format!(
        r#"{{ "format": 1, "name": "test", {GEOMETRY}, "parameters": {{ "live": {{ {parameter} }} }}, "resources": {{ {target},
               "depth": {{ "texture": {{ "format": "depth32float", "size": "=viewport" }} }},
               "stencil": {{ "texture": {{ "format": "stencil8", "size": "=viewport" }} }} }},
             "passes": {{ {passes} }} }}"#
    );
    plan_of_text(text, SIDE)
}

/// The picture of a frame with one square, in a view of its left half.
fn picture(gpu: &Gpu, executor: &mut Executor, squares: &Squares) -> Vec<[u8; 4]> {
    let target = import(gpu, executor.plan(), "target");
    show(gpu, executor, Some(squares), &target, &frame(&["0 0 0 4 8"]));
    texels(gpu, &target, 0)
}

#[test]
fn whatever_a_live_parameter_sets_draws_what_a_new_plan_draws() {
    let Some(gpu) = gpu::device() else { return };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    // A green fill, with more that is said of its target and of the pass.
    let fills = |shader: &str, to: &str, more: &str| {
        let text = fill("fill", &format!(r#"{{ "to": "&target", {to} }}"#), "[0, 0.6, 0, 1]");
        text.replace("fill.wgsl.jinja", shader).replace(r#""color": [{"#, &format!(r#"{more} "color": [{{"#))
    };
    let blue = r#""clear": [0, 0, 1, 1]"#;
    let depth = r#""depth": { "to": "&depth", "clear": "=live", "compare": "less" },"#;
    let stencil = |clear: &str, reference: &str| {
        format!(
            r#""stencil": {{ "to": "&stencil", "clear": {clear}, "reference": {reference}, "front": {{ "compare": "equal" }} }},"#
        )
    };
    let constant = r#""clear": [0, 0, 1, 1], "blend": { "color": { "src_factor": "constant" }, "constant": "=[live, live, live, 1]" }"#;
    let half = r#""half": { "compute": { "shader": "half.wgsl.jinja", "workgroups": ["=live", 1, 1],
        "bind": { "image": { "texture": { "name": "&target", "contents": "load" } } } } }"#;
    let triangle = r#""triangle": { "mesh": { "shader": "left_triangles.wgsl.jinja", "count": COUNT, "instances": INSTANCES,
        "bind": { "settings": { "values": { "color": [1, 0, 0, 1] } } },
        "color": [{ "to": "&target", "clear": [0, 0, 1, 1] }] } }"#;
    let squares_of = |to: &str| draw(1, &format!(r#"{{ "to": "&target", {to} }}"#));
    let share = r#""type": "f32", "default": DEFAULT, "min": 0, "max": 1"#;
    let count = r#""type": "u32", "default": DEFAULT, "min": 0, "max": 3"#;
    for (what, parameter, [before, after], passes) in [
        (
            "the clear color of a fill",
            share,
            [0.2, 1.0],
            fills("left.wgsl.jinja", r#""clear": "=[live, 0, 0, 1]""#, ""),
        ),
        ("the clear depth of a fill", share, [0.2, 1.0], fills("own_triangle.wgsl.jinja", blue, depth)),
        (
            "the clear value of stencil",
            count,
            [0.0, 1.0],
            fills("fill.wgsl.jinja", blue, &stencil(r#""=live""#, "1")),
        ),
        (
            "the stencil reference",
            count,
            [0.0, 1.0],
            fills("fill.wgsl.jinja", blue, &stencil("1", r#""=live""#)),
        ),
        (
            "the number of vertices",
            count,
            [0.0, 3.0],
            triangle.replace("COUNT", r#""=live""#).replace("INSTANCES", "1"),
        ),
        (
            "the number of instances",
            count,
            [0.0, 1.0],
            triangle.replace("COUNT", "3").replace("INSTANCES", r#""=live""#),
        ),
        ("the blend constant", share, [0.2, 1.0], fills("fill.wgsl.jinja", constant, "")),
        (
            "a workgroup count",
            count,
            [1.0, 2.0],
            format!(r#"{}, {half}"#, fill("blue", r#"{ "to": "&target" }"#, "[0, 0, 1, 1]")),
        ),
        ("the clear color of meshes", share, [0.2, 1.0], squares_of(r#""clear": "=[live, 0, 0, 1]""#)),
        (
            "the clear depth of meshes",
            share,
            [0.2, 1.0],
            squares_of(blue).replace(r#""color": [{"#, &format!(r#"{depth} "color": [{{"#)),
        ),
    ] {
        let made = |default: f64| plan(&parameter.replace("DEFAULT", &default.to_string()), &passes);
        let [first, second] = [before, after].map(|value| {
            let mut executor = executor(&gpu, &made(value), Some(&squares));
            picture(&gpu, &mut executor, &squares)
        });
        assert!(first != second, "{what}");
        let mut executor = executor(&gpu, &made(before), Some(&squares));
        let live = executor.parameter::<f64>("live").expect("a live parameter");
        assert!(picture(&gpu, &mut executor, &squares) == first, "{what}");
        for (value, wanted) in [(after, second), (before, first)] {
            executor.set(live, value).expect("a value in its range");
            assert!(picture(&gpu, &mut executor, &squares) == wanted, "{what} set to {value}");
        }
    }
}

/// Red with a parameter at its default, and set to a value of a type.
#[track_caller]
fn reds<T: ParameterValue>(gpu: &Gpu, parameter: &str, red: &str, value: T) -> [u8; 2] {
    let plan = plan(parameter, &fill("fill", r#"{ "to": "&target" }"#, &format!(r#""=[{red}, 0, 0, 1]""#)));
    let mut executor = executor(gpu, &plan, None);
    let target = import(gpu, &plan, "target");
    let red = |executor: &mut Executor| {
        show(gpu, executor, None, &target, &frame(&[]));
        texels(gpu, &target, 0)[0][0]
    };
    let before = red(&mut executor);
    let live = executor.parameter::<T>("live").expect("a parameter of this type");
    executor.set(live, value).expect("a value of the parameter");
    [before, red(&mut executor)]
}

#[test]
fn parameters_are_set_only_in_their_declared_type() {
    let Some(gpu) = gpu::device() else { return };
    let flag = r#""type": "bool", "default": false"#;
    let word = r#""type": "enum", "values": ["none", "a little", "all"], "default": "none""#;
    let list = r#""type": "f32[]", "default": [0, 0], "min": 0, "max": 1, "min_length": 1, "max_length": 3"#;
    let whole = r#""type": "u32", "default": 0, "min": 0, "max": 5"#;
    assert_eq!(reds(&gpu, flag, "live ? 1 : 0", true), [0, 255]);
    assert_eq!(reds(&gpu, word, "live == 'all' ? 1 : live == 'none' ? 0 : 0.2", "all"), [0, 255]);
    assert_eq!(reds(&gpu, word, "live == 'all' ? 1 : live == 'none' ? 0 : 0.2", "a little"), [0, 51]);
    assert_eq!(reds(&gpu, list, "live[1]", &[0.0, 1.0][..]), [0, 255]);
    assert_eq!(reds(&gpu, list, "live[1]", [1.0, 0.2]), [0, 51]);
    assert_eq!(reds(&gpu, whole, "live / 5", 1_u32), [0, 51]);
    for (parameter, red, own) in [
        (flag, "live ? 1 : 0", "bool"),
        (word, "live == 'all' ? 1 : 0", "text"),
        (list, "live[1]", "list"),
        (whole, "live / 5", "number"),
    ] {
        let plan =
            plan(parameter, &fill("fill", r#"{ "to": "&target" }"#, &format!(r#""=[{red}, 0, 0, 1]""#)));
        let executor = executor(&gpu, &plan, None);
        let has = [
            ("bool", executor.parameter::<bool>("live").is_ok()),
            ("text", executor.parameter::<&str>("live").is_ok()),
            ("list", executor.parameter::<&[f32]>("live").is_ok()),
            ("list", executor.parameter::<[f32; 2]>("live").is_ok()),
            ("number", executor.parameter::<u32>("live").is_ok()),
            ("a number of another type", executor.parameter::<i32>("live").is_ok()),
            ("a list of flags", executor.parameter::<&[bool]>("live").is_ok()),
            ("a list of three", executor.parameter::<[f32; 3]>("live").is_ok()),
        ];
        for (name, is_of) in has {
            assert_eq!(is_of, name == own, "{name} of {parameter}");
        }
    }
}
