//! Blend equations, their constant, and masks of channels, in texels.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::stage::{SIDE, color, executor, fill, plan, show, target, try_plan_with};
use crate::executing::views::frame;

/// The blend of a fill over another color, 255 for 1.
#[track_caller]
fn combined(there: &str, settings: &str, drawn: &str) -> Option<[u8; 4]> {
    let gpu = gpu::device()?;
    let passes = [
        fill("below", r#"{ "to": "&target" }"#, there),
        fill("above", &format!(r#"{{ "to": "&target", {settings} }}"#), drawn),
    ];
    let plan = plan(&target(1), &passes.join(","));
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    Some(color(&gpu, &target, 0))
}

#[test]
fn each_equation_is_the_one_that_is_written() {
    let (there, drawn) = ("[0.2, 0.4, 0.6, 0.8]", "[0.6, 0.2, 0.4, 0.4]");
    let equation = |color: &str, more: &str| format!(r#""blend": {{ "color": {{ {color} }}{more} }}"#);
    let constant = r#", "constant": [0.5, 1, 0, 0.5]"#;
    let cases = [
        (r#""blend": "multiply""#.to_owned(), [31, 20, 61, 82]),
        (r#""blend": "min""#.to_owned(), [51, 51, 102, 102]),
        (r#""blend": "max""#.to_owned(), [153, 102, 153, 204]),
        (equation(r#""operation": "max""#, ""), [153, 102, 153, 204]),
        (equation(r#""operation": "subtract", "dst_factor": "one""#, ""), [102, 0, 0, 0]),
        (equation(r#""operation": "reverse-subtract", "dst_factor": "one""#, ""), [0, 51, 51, 102]),
        (equation(r#""src_factor": "one-minus-dst-alpha", "dst_factor": "one""#, ""), [82, 112, 173, 224]),
        (
            equation(r#""src_factor": "constant", "dst_factor": "one-minus-constant""#, constant),
            [102, 51, 153, 153],
        ),
        (
            equation(r#""src_factor": "one""#, r#", "alpha": { "src_factor": "zero", "dst_factor": "one" }"#),
            [153, 51, 102, 204],
        ),
    ];
    for (settings, expected) in cases {
        let Some(found) = combined(there, &settings, drawn) else { return };
        let apart = (0..4).map(|at| found[at].abs_diff(expected[at])).max();
        assert!(apart <= Some(1), "{settings}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn clear_values_and_blend_constants_follow_live_parameters() {
    let Some(gpu) = gpu::device() else { return };
    let to = r#"{ "to": "&target", "clear": ["=red", 0, 0, 1], "blend": { "color": { "src_factor": "constant", "dst_factor": "one" },
                "constant": [0, "=green", 0, 1] } }"#;
    let parameters = ["red", "green"]
        .map(|name| format!(r#""{name}": {{ "type": "f32", "default": 0.2, "min": 0, "max": 1 }}"#));
    let text = format!(
        r#"{{ "format": 1, "name": "test", "parameters": {{ {} }}, "resources": {{ {} }}, "passes": {{ {} }} }}"#,
        parameters.join(","),
        target(1),
        fill("all", to, "[1, 1, 1, 1]")
    );
    let plan = try_plan_with(text, SIDE, wgpu::Features::empty()).unwrap_or_else(|said| panic!("{said}"));
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let [red, green] =
        ["red", "green"].map(|name| executor.parameter::<f32>(name).expect("a live parameter"));
    for (value, other, expected) in [(0.2, 0.2, [51, 51]), (0.6, 0.2, [153, 51]), (0.6, 1.0, [153, 255])] {
        executor.set(red, value).expect("a value");
        executor.set(green, other).expect("a value");
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        assert_eq!(color(&gpu, &target, 0), [expected[0], expected[1], 0, 255]);
    }
}

#[test]
fn channels_that_are_masked_stay() {
    let mask =
        |channels: &str| combined("[1, 1, 0, 0]", &format!(r#""write_mask": [{channels}]"#), "[0, 0, 1, 1]");
    let Some(some) = mask(r#""red", "blue""#) else { return };
    assert_eq!(some, [0, 255, 255, 0]);
    assert_eq!(mask(""), Some([255, 255, 0, 0]));
    assert_eq!(mask(r#""alpha""#), Some([255, 255, 0, 255]));
}

/// The text of a fill and one over it that blends, by a shader.
fn over(shader: &str, blend: &str) -> String {
    let below = fill("below", r#"{ "to": "&target" }"#, "[0.4, 0.4, 0.4, 0.8]");
    let above = fill("above", &format!(r#"{{ "to": "&target", "blend": {blend} }}"#), "[0.2, 0.2, 0.2, 0.2]");
    let above = above.replace("fill.wgsl.jinja", shader);
    format!(
        r#"{{ "format": 1, "name": "test", "resources": {{ {} }}, "passes": {{ {below}, {above} }} }}"#,
        target(1)
    )
}

#[test]
fn a_second_color_is_a_factor_where_the_device_has_the_feature() {
    let dual = wgpu::Features::DUAL_SOURCE_BLENDING;
    let blend = r#"{ "color": { "dst_factor": "src1" }, "alpha": { "dst_factor": "one-minus-src1-alpha" } }"#;
    let rejected = |shader: &str, features: wgpu::Features| {
        try_plan_with(over(shader, blend), SIDE, features).expect_err("a diagnostic")
    };
    let found = rejected("fill.wgsl.jinja", wgpu::Features::empty());
    assert!(found.contains("for which the profile webgpu lacks \"dual-source-blending\""), "{found}");
    let found = rejected("fill.wgsl.jinja", dual);
    assert!(found.contains("writes no @location(0) @blend_src(1), with which the pass blends"), "{found}");
    let found = rejected("two_sources.wgsl.jinja", wgpu::Features::empty());
    assert!(found.contains("dual") || found.contains("DUAL"), "{found}");
    let spare = format!("{}, {}", target(1), target(1).replace("target", "spare"));
    let text = over("two_sources.wgsl.jinja", blend).replace(&target(1), &spare);
    let text = text.replace(r#""color": [{"#, r#""color": [{ "to": "&spare" }, {"#);
    let found = try_plan_with(text, SIDE, dual).expect_err("a diagnostic");
    assert!(found.contains("for which a pass has one color attachment only"), "{found}");
    let plan = try_plan_with(over("two_sources.wgsl.jinja", blend), SIDE, dual);
    let plan = plan.unwrap_or_else(|diagnostics| panic!("{diagnostics}"));
    let Some(gpu) = gpu::device() else { return };
    if !gpu.device.features().contains(dual) {
        let rejected = umbragraph::Executor::new(&gpu.device, &gpu.queue, plan, None);
        assert!(rejected.is_err());
        return;
    }
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    // 0.2 and of what is there all, half and nothing; of its alpha three quarters.
    let (found, expected) = (color(&gpu, &target, 0), [153, 102, 51, 204]);
    assert!(found.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 1), "{found:?}");
}
