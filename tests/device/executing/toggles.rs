//! Toggles, frame by frame: the picture of each state is that of a pipeline without what is off, and nothing is created
//! for a state that came up before.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::{self, Gpu};

use crate::common::gpu::import;
use crate::executing::squares::{GEOMETRY, RED, Squares, square};
use crate::executing::stage::{SIDE, executor, fill, plan_of_text, said, target, texels};
use crate::executing::views::frame;

const RED_FILL: &str = "[1, 0, 0, 1]";
const GREEN_FILL: &str = "[0, 1, 0, 1]";

fn plan(toggles: &str, resources: &str, passes: &str) -> Arc<Plan> {
    let text = format!(
        r#"{{ "format": 1, "name": "test", {GEOMETRY}, "toggles": {{ {toggles} }},
            "resources": {{ {}, {resources} }}, "passes": {{ {passes} }} }}"#,
        target(1)
    );
    plan_of_text(text, SIDE)
}

fn texture(name: &str) -> String {
    format!(r#""{name}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#)
}

/// `fill` with keys that every pass can have.
fn filled(name: &str, common: &str, to: &str, color: &str) -> String {
    let pass = fill(name, to, color);
    pass.replacen(": {", &format!(": {{ {common},"), 1)
}

/// Fills "second" with green, which has "first" as its fallback.
fn effect() -> String {
    let common = r#""toggle": "effect", "passthrough": { "second": "&first" }"#;
    filled("effect", common, r#"{ "to": "&second" }"#, GREEN_FILL)
}

fn show(source: &str) -> String {
    format!(
        r#""show": {{ "fullscreen": {{ "shader": "show.wgsl.jinja", "bind": {{ "picture": "&{source}" }},
            "color": [{{ "to": "&target" }}] }} }}"#
    )
}

struct Stage {
    gpu: Gpu,
    executor: Executor,
    target: wgpu::Texture,
}

use umbragraph::wgpu;

impl Stage {
    fn new(plan: &Arc<Plan>) -> Option<Self> {
        let gpu = gpu::device()?;
        let (executor, target) = (executor(&gpu, plan, None), import(&gpu, plan, "target"));
        Some(Self { gpu, executor, target })
    }

    /// The first texel of the picture with the toggles switched like this.
    fn shows(&mut self, toggles: &[(&str, bool)]) -> [u8; 4] {
        let scope = self.gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &self.target)];
        self.executor
            .record(&mut encoder, &Frame::new(&frame(&[])).imports(&imports).toggles(toggles))
            .expect("a record");
        self.gpu.queue.submit([encoder.finish()]);
        assert!(pollster::block_on(scope.pop()).is_none(), "what was recorded is not valid");
        texels(&self.gpu, &self.target, 0)[0]
    }
}

const RED_TEXEL: [u8; 4] = [255, 0, 0, 255];
const GREEN_TEXEL: [u8; 4] = [0, 255, 0, 255];

#[test]
fn a_copy_under_its_source_s_toggle_copies() {
    let copy = r#""copy": { "toggle": "effect", "after": ["back"],
        "copy": { "from": { "name": "&second" }, "to": { "name": "&target" } } }"#;
    let passes = [
        fill("back", r#"{ "to": "&target" }"#, RED_FILL),
        fill("base", r#"{ "to": "&first" }"#, RED_FILL),
        effect(),
        copy.to_owned(),
    ];
    let resources = [texture("first"), texture("second")].join(", ");
    let plan = plan(r#""effect": { "default": true }"#, &resources, &passes.join(", "));
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("effect", false)]), RED_TEXEL);
}

#[test]
fn a_passthrough_toggles_without_creating_anything() {
    let passes = [fill("base", r#"{ "to": "&first" }"#, RED_FILL), effect(), show("second")];
    let plan = plan(
        r#""effect": { "default": true }"#,
        &[texture("first"), texture("second")].join(","),
        &passes.join(","),
    );
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.executor.skipped().count(), 0);
    assert_eq!(stage.shows(&[("effect", false)]), RED_TEXEL);
    assert_eq!(stage.executor.skipped().collect::<Vec<_>>(), ["effect"]);
    stage.gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    let before = stage.executor.statistics();
    for round in 0..6 {
        let on = round % 2 == 0;
        assert_eq!(stage.shows(&[("effect", on)]), if on { GREEN_TEXEL } else { RED_TEXEL });
    }
    assert_eq!(stage.executor.statistics(), before);
}

#[test]
fn a_chain_of_effects_shows_the_last_one_that_is_on() {
    let effect = |name: &str, to: &str, from: &str, color: &str| {
        let common = format!(r#""toggle": "{name}", "passthrough": {{ "{to}": "&{from}" }}"#);
        filled(name, &common, &format!(r#"{{ "to": "&{to}" }}"#), color)
    };
    let passes = [
        fill("base", r#"{ "to": "&a" }"#, RED_FILL),
        effect("one", "b", "a", GREEN_FILL),
        effect("two", "c", "b", "[0, 0, 1, 1]"),
        show("c"),
    ];
    let plan = plan(
        r#""one": { "default": false }, "two": { "default": false }"#,
        &[texture("a"), texture("b"), texture("c")].join(","),
        &passes.join(","),
    );
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), RED_TEXEL);
    assert_eq!(stage.shows(&[("one", true)]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("one", true), ("two", true)]), [0, 0, 255, 255]);
    assert_eq!(stage.shows(&[("two", true)]), [0, 0, 255, 255]);
    assert_eq!(stage.executor.skipped().collect::<Vec<_>>(), ["one"]);
}

#[test]
fn what_is_drawn_over_by_a_pass_that_is_off_stays() {
    let passes = [
        fill("base", r#"{ "to": "&first" }"#, RED_FILL),
        filled("over", r#""toggle": "over", "after": ["base"]"#, r#"{ "to": "&first" }"#, GREEN_FILL),
        show("first"),
    ];
    let plan = plan(r#""over": { "default": true }"#, &texture("first"), &passes.join(","));
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("over", false)]), RED_TEXEL);
    assert_eq!(stage.shows(&[("over", false), ("over", true)]), GREEN_TEXEL);
}

#[test]
fn two_ways_to_make_the_same_take_turns() {
    let passes = [
        filled("fine", r#""toggle": "fine""#, r#"{ "to": "&first" }"#, GREEN_FILL),
        filled("rough", r#""toggle": "!fine""#, r#"{ "to": "&first" }"#, RED_FILL),
        show("first"),
    ];
    let plan = plan(r#""fine": { "default": true }"#, &texture("first"), &passes.join(","));
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("fine", false)]), RED_TEXEL);
}

#[test]
fn a_copy_takes_the_fallback() {
    let passes = [
        fill("base", r#"{ "to": "&first" }"#, RED_FILL),
        effect(),
        r#""copy": { "copy": { "from": { "name": "&second" }, "to": { "name": "&target" } } }"#.to_owned(),
    ];
    let plan = plan(
        r#""effect": { "default": true }"#,
        &[texture("first"), texture("second")].join(","),
        &passes.join(","),
    );
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("effect", false)]), RED_TEXEL);
}

#[test]
fn blackboard_data_of_a_pass_that_is_off_is_that_of_the_other() {
    let passes = r#""few": { "views": { "to": "&few", "max": 4 } },
        "many": { "toggle": "many", "passthrough": { "many": "&few" }, "views": { "to": "&many", "max": 4 } },
        "squares": { "draw": { "geometry": "squares", "mesh_filter": "all", "views": "&many", "shader": "square.wgsl.jinja",
            "color": [{ "to": "&target", "clear": [0, 0, 1, 1] }] } }"#;
    let plan = plan(r#""many": { "default": true }"#, &texture("unused"), passes);
    let Some(gpu) = gpu::device() else { return };
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    for on in [true, false, true] {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (imports, input) = ([("target", &target)], frame(&["0"]));
        let toggles = [("many", on)];
        let frame = Frame::new(&input).draws(&squares).imports(&imports).toggles(&toggles);
        executor.record(&mut encoder, &frame).expect("a record");
        gpu.queue.submit([encoder.finish()]);
        let views = |name: &str| executor.data(name).map_or(0, |data| data.views().len());
        assert_eq!((views("few"), views("many")), (1, usize::from(on)));
        assert_eq!(texels(&gpu, &target, 0)[0], RED_TEXEL, "{on}");
    }
}

#[test]
fn an_unknown_toggle_is_an_error_and_the_next_frame_is_fine() {
    let passes = [
        fill("base", r#"{ "to": "&target" }"#, RED_FILL),
        filled("over", r#""toggle": "over", "after": ["base"]"#, r#"{ "to": "&target" }"#, GREEN_FILL),
    ];
    let plan = plan(r#""over": { "default": true }"#, &texture("unused"), &passes.join(","));
    let Some(mut stage) = Stage::new(&plan) else { return };
    let mut encoder = stage.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let imports = [("target", &stage.target)];
    let diagnostics = stage
        .executor
        .record(&mut encoder, &Frame::new(&frame(&[])).imports(&imports).toggles(&[("ovre", false)]))
        .expect_err("a diagnostic");
    assert_eq!(said(&diagnostics), [("UG0214", "the pipeline \"test\" has no toggle \"ovre\"".to_owned())]);
    assert_eq!(stage.shows(&[("over", false)]), RED_TEXEL);
}

#[test]
fn a_subgraph_s_toggle_and_passthrough_reach_its_passes() {
    let text = format!(
        r#"{{ "format": 1, "name": "test", {GEOMETRY}, "toggles": {{ "effect": {{ "default": true }} }},
            "resources": {{ {}, {}, {} }},
            "subgraphs": {{ "paint": {{ "inputs": {{ "to": "what is painted" }}, "passes": {{ {}, {} }} }} }},
            "passes": {{ {}, "effect": {{ "toggle": "effect", "passthrough": {{ "second": "&first" }},
                "use": "paint", "with": {{ "to": "&second" }} }}, {} }} }}"#,
        target(1),
        texture("first"),
        texture("second"),
        fill("under", r#"{ "to": "&to" }"#, RED_FILL),
        filled("over", r#""after": ["under"]"#, r#"{ "to": "&to" }"#, GREEN_FILL),
        fill("base", r#"{ "to": "&first" }"#, RED_FILL),
        show("second"),
    );
    let plan = plan_of_text(text, SIDE);
    assert!(plan.passes.iter().any(|pass| pass.name == "effect.over" && pass.toggle.is_some()));
    let Some(mut stage) = Stage::new(&plan) else { return };
    assert_eq!(stage.shows(&[]), GREEN_TEXEL);
    assert_eq!(stage.shows(&[("effect", false)]), RED_TEXEL);
}
