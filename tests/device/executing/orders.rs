//! Declared orders and versions, as they are drawn.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::stage::{color, executor, fill, plan, show, target};
use crate::executing::views::frame;

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];

const SUM: &str =
    r#""sum": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" } }"#;
/// Adds a fifth of red.
const ADD: &str = r#"{ "to": "&sum", "blend": "add" }"#;

fn copy(name: &str, from: &str) -> String {
    format!(r#""{name}": {{ "copy": {{ "from": {{ "name": "&{from}" }}, "to": {{ "name": "&target" }} }} }}"#)
}

fn after(pass: &str, name: &str, others: &str) -> String {
    pass.replace(&format!(r#""{name}": {{"#), &format!(r#""{name}": {{ "after": [{others}], "#))
}

/// The red of the picture in the first frames.
fn reds(resources: &str, passes: &str) -> Option<Vec<u8>> {
    let gpu = gpu::device()?;
    let plan = plan(&format!("{}, {resources}", target(1)), passes);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    let one = |_| {
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        color(&gpu, &picture, 0)[0]
    };
    Some((0..3).map(one).collect())
}

#[test]
fn a_sum_cleared_at_the_end_of_the_frame_is_cleared_last() {
    let reset = fill("reset", r#"{ "to": "&sum" }"#, "[0, 0, 0, 0]");
    let reset = after(&reset, "reset", r#""shown""#);
    let count = fill("count", ADD, "[0.2, 0, 0, 0]");
    for read in ["sum@count", "sum"] {
        let shown = copy("shown", read);
        for passes in [[&reset, &count, &shown], [&count, &shown, &reset]] {
            let passes = passes.map(String::as_str).join(", ");
            let Some(found) = reds(SUM, &passes) else { return };
            assert_eq!(found, [51, 51, 51], "{passes}");
        }
    }
}

#[test]
fn a_single_clear_goes_first_where_nothing_says_otherwise() {
    let reset = fill("reset", r#"{ "to": "&sum" }"#, "[0, 0, 0, 0]");
    let count = fill("count", ADD, "[0.2, 0, 0, 0]");
    let passes = [&count, &copy("shown", "sum"), &reset].map(String::as_str).join(", ");
    let Some(found) = reds(SUM, &passes) else { return };
    assert_eq!(found, [51, 51, 51]);
}

#[test]
fn contents_before_the_first_write_have_a_name() {
    let count = fill("count", ADD, "[0.2, 0, 0, 0]");
    let again = after(&fill("again", ADD, "[0.2, 0, 0, 0]"), "again", r#""count""#);
    let passes = [count, again, copy("shown", "sum@0")].join(", ");
    let Some(found) = reds(SUM, &passes) else { return };
    assert_eq!(found, [0, 102, 204]);
}

#[test]
fn what_the_host_gave_can_be_read_before_it_is_drawn_over() {
    let Some(gpu) = gpu::device() else { return };
    let kept =
        r#""kept": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" } }"#;
    let keep = r#""keep": { "copy": { "from": { "name": "&target@0" }, "to": { "name": "&kept" } } }"#;
    let more = fill("more", r#"{ "to": "&target", "layer": 0, "blend": "add" }"#, "[0.2, 0, 0, 0]");
    let last = fill("last", r#"{ "to": "&target", "layer": 0 }"#, "[0, 1, 0, 1]");
    let last = after(&last, "last", r#""more", "keep""#);
    let plan = plan(&format!("{}, {kept}", target(1)), &[last, more, keep.to_owned()].join(", "));
    assert_eq!(plan.passes.iter().map(|pass| pass.name.as_str()).collect::<Vec<_>>(), ["keep", "last"]);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    assert_eq!(color(&gpu, &picture, 0), GREEN);
}

#[test]
fn a_version_means_the_same_in_every_order_of_the_keys() {
    let Some(gpu) = gpu::device() else { return };
    let pair = r#""pair": { "texture": { "format": "rgba8unorm", "size": "=viewport", "layers": 2 } }"#;
    let first = fill("first", r#"{ "to": "&pair", "layer": 0 }"#, "[1, 0, 0, 1]");
    let again =
        after(&fill("again", r#"{ "to": "&pair", "layer": 0 }"#, "[0, 1, 0, 1]"), "again", r#""first""#);
    let second = fill("second", r#"{ "to": "&pair", "layer": 1 }"#, "[0, 0, 1, 1]");
    let shown = copy("shown", "pair@first");
    let keys = [&first, &again, &second, &shown].map(String::as_str);
    let orders = [[0, 1, 2, 3], [2, 0, 1, 3], [3, 2, 1, 0], [1, 3, 2, 0]];
    for order in orders {
        let passes = order.map(|at| keys[at]).join(", ");
        let plan = plan(&format!("{}, {pair}", target(2)), &passes);
        let mut executor = executor(&gpu, &plan, None);
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        assert_eq!([0, 1].map(|layer| color(&gpu, &picture, layer)), [RED, BLUE], "{passes}");
    }
}

#[test]
fn an_order_given_through_a_pass_that_is_not_there_holds() {
    let Some(gpu) = gpu::device() else { return };
    let to = r#"{ "to": "&target", "layer": 0 }"#;
    let first = fill("first", to, "[1, 0, 0, 1]");
    let between = fill("between", to, "[0, 0, 1, 1]");
    let between =
        between.replace(r#""between": {"#, r#""between": { "when": "=1 > 2", "after": ["first"], "#);
    let last = after(&fill("last", to, "[0, 1, 0, 1]"), "last", r#""between""#);
    for passes in [[&last, &between, &first], [&first, &between, &last]] {
        let plan = plan(&target(1), &passes.map(String::as_str).join(", "));
        let mut executor = executor(&gpu, &plan, None);
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        assert_eq!(color(&gpu, &picture, 0), GREEN);
    }
}

#[test]
fn ranges_cleared_apart_are_cleared_before_they_are_added_to() {
    let Some(gpu) = gpu::device() else { return };
    let image = r#""image": { "texture": { "format": "rgba8unorm", "size": "=viewport", "layers": 2 } }"#;
    let clear = |layer: u32, color: &str| {
        let to = format!(r#"{{ "to": "&image", "layer": {layer} }}"#);
        fill(&format!("clear{layer}"), &to, color)
    };
    let (red, blue) = (clear(0, "[1, 0, 0, 1]"), clear(1, "[0, 0, 1, 1]"));
    // Both storage passes may write every layer; the second makes the left half blue again.
    let half = |name: &str, common: &str| {
        format!(
            r#""{name}": {{ {common} "compute": {{ "shader": "halves.wgsl.jinja", "workgroups": [1, 1, 2],
                "bind": {{ "image": "&image" }} }} }}"#
        )
    };
    let (first, second) = (half("first", ""), half("second", r#""after": ["first"],"#));
    let shown = copy("shown", "image");
    let keys = [&red, &blue, &first, &second, &shown].map(String::as_str);
    for order in [[0, 1, 2, 3, 4], [3, 2, 4, 1, 0], [4, 3, 2, 1, 0], [2, 0, 3, 1, 4]] {
        let passes = order.map(|at| keys[at]).join(", ");
        let plan = plan(&format!("{}, {image}", target(2)), &passes);
        let names: Vec<&str> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
        let at = |name: &str| names.iter().position(|known| *known == name);
        assert!(at("clear0").max(at("clear1")) < at("first") && at("first") < at("second"), "{names:?}");
        let mut executor = executor(&gpu, &plan, None);
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
        for (layer, color) in [(0, RED), (1, BLUE)] {
            let texels = crate::executing::stage::texels(&gpu, &picture, layer);
            assert_eq!((texels[0], texels[7]), (GREEN, color), "layer {layer} of {passes}");
        }
    }
    // Who clears what a clear has cleared is not known.
    let again = clear(0, "[0, 0, 0, 1]").replace("clear0", "again");
    let passes = [&red, &again, &first, &shown].map(String::as_str).join(", ");
    let text = format!(
        r#"{{ "format": 1, "name": "test", "resources": {{ {}, {image} }}, "passes": {{ {passes} }} }}"#,
        target(2)
    );
    let said = crate::executing::stage::try_plan_of_text(text, crate::executing::stage::SIDE)
        .expect_err("a diagnostic");
    assert!(said.contains("UG0402") && said.contains(r#""clear0" and "again""#), "{said}");
}
