//! Plans that replace one another.

use umbragraph::Plan;
use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, plan_of_size, said, show, target};
use crate::executing::views::frame;

const HISTORY: &str =
    r#""history": { "texture": { "format": "rgba8unorm", "size": [8, 8], "lifetime": "persistent" } }"#;

/// Adds a fifth of red to what outlives frames, and shows it.
fn accumulate() -> String {
    format!(
        r#"{}, "show": {{ "fullscreen": {{ "shader": "show.wgsl.jinja", "bind": {{ "picture": "&history" }},
            "color": [{{ "to": "&target" }}] }} }}"#,
        fill("grow", r#"{ "to": "&history", "blend": "add" }"#, "[0.2, 0, 0, 0.2]")
    )
}

#[test]
fn the_same_plan_again_creates_no_texture_and_no_pipeline() {
    let Some(gpu) = gpu::device() else { return };
    let passes = format!("{}, {}", draw(8, r#"{ "to": "&target", "blend": "add" }"#), accumulate());
    let plan = plan(
        &format!("{HISTORY}, {}", target(1)),
        &passes.replace(r#""squares": { "#, r#""squares": { "after": ["show"], "#),
    );
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    let before = executor.statistics();
    executor.set_plan(plan.clone()).expect("the same plan");
    let after = executor.statistics();
    assert_eq!(
        (after.textures, after.buffers, after.samplers, after.shader_modules, after.layouts, after.pipelines),
        (
            before.textures,
            before.buffers,
            before.samplers,
            before.shader_modules,
            before.layouts,
            before.pipelines
        )
    );
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
}

#[test]
fn pipelines_are_kept_only_for_plans_that_return_soon() {
    let Some(gpu) = gpu::device() else { return };
    let one = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let other = plan(&target(1), &fill("one", r#"{ "to": "&target", "blend": "add" }"#, "[1, 0, 0, 1]"));
    let mut executor = executor(&gpu, &one, None);
    let mut created = |plans: &[&std::sync::Arc<Plan>]| {
        let before = executor.statistics().pipelines;
        for plan in plans {
            executor.set_plan((*plan).clone()).expect("a plan");
        }
        executor.statistics().pipelines - before
    };
    assert_eq!(created(&[&other]), 1);
    assert_eq!(created(&[&one, &other]), 0);
    assert_eq!(created(&[&other; 8]), 0);
    assert_eq!(created(&[&one]), 1);
}

#[test]
fn another_size_keeps_pipelines_and_persistent_resources() {
    let Some(gpu) = gpu::device() else { return };
    let scratch = r#""scratch": { "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let resources = format!("{HISTORY}, {scratch}, {}", target(1));
    let passes = format!(
        r#"{}, {}, "copy": {{ "copy": {{ "from": {{ "name": "&scratch" }}, "to": {{ "name": "&target" }} }} }}"#,
        fill("grow", r#"{ "to": "&history", "blend": "add" }"#, "[0.2, 0, 0, 0.2]"),
        r#""show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&history" }, "color": [{ "to": "&scratch" }] } }"#
    );
    let small = plan_of_size(&resources, &passes, 4);
    let large = plan_of_size(&resources, &passes, 8);
    let mut executor = executor(&gpu, &small, None);
    show(&gpu, &mut executor, None, &import(&gpu, &small, "target"), &frame(&[]));
    show(&gpu, &mut executor, None, &import(&gpu, &small, "target"), &frame(&[]));
    let before = executor.statistics();
    executor.set_plan(large.clone()).expect("a plan");
    let after = executor.statistics();
    assert_eq!((after.textures, after.pipelines), (before.textures + 1, before.pipelines));
    let target = import(&gpu, &large, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    // Two frames of the small plan and one of the large one.
    assert_eq!(color(&gpu, &target, 0), [153, 0, 0, 153]);
}

#[test]
fn a_renamed_persistent_resource_begins_empty() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!("{HISTORY}, {}", target(1));
    let first = plan(&resources, &accumulate());
    let renamed = plan(&resources.replace("history", "memory"), &accumulate().replace("history", "memory"));
    let mut executor = executor(&gpu, &first, None);
    let target = import(&gpu, &first, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    assert_eq!(color(&gpu, &target, 0), [102, 0, 0, 102]);
    executor.set_plan(renamed).expect("a plan");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    assert_eq!(color(&gpu, &target, 0), [51, 0, 0, 51]);
}

#[test]
fn a_plan_that_the_device_rejects_leaves_the_one_before() {
    let Some(gpu) = gpu::device() else { return };
    let good = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let mut executor = executor(&gpu, &good, None);
    let mut plan = (*good).clone();
    let beyond = gpu.device.limits().max_texture_dimension_2d + 1;
    let size = umbragraph::low_level::compiler::TextureSize::new(beyond, 1);
    plan.textures.push(umbragraph::low_level::compiler::PhysicalTexture {
        label: "wide".into(),
        format: wgpu::TextureFormat::Rgba8Unorm,
        size,
        volume: false,
        usages: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_format: None,
        spare_layer: false,
        bytes: u64::from(beyond) * 4,
    });
    let diagnostics = executor.set_plan(plan.clone().into()).expect_err("a diagnostic");
    assert_eq!(said(&diagnostics)[0].0, "UG0804");
    // The device itself, where nothing beforehand tells: three samples.
    plan.textures[0].size = umbragraph::low_level::compiler::TextureSize { width: 4, samples: 3, ..size };
    let diagnostics = executor.set_plan(plan.into()).expect_err("a diagnostic");
    assert_eq!(said(&diagnostics)[0].0, "UG0803");
    let target = import(&gpu, &good, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    assert_eq!(color(&gpu, &target, 0), [255, 0, 0, 255]);
    assert_eq!(executor.plan().textures.len(), 0);
}
