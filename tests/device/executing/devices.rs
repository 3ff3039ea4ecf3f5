//! Devices that cannot run a plan, and devices that are lost. None of these tests needs a driver.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::{Executor, Frame};

use crate::executing::stage::{fill, plan, said, target};
use crate::executing::views::frame;

/// A device on the noop backend.
pub(crate) fn device(
    features: wgpu::Features,
    change: impl FnOnce(&mut wgpu::Limits),
) -> (wgpu::Device, wgpu::Queue) {
    let mut limits = wgpu::Limits::default();
    change(&mut limits);
    wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_features: features,
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    })
}

fn instantiate(
    plan: &Arc<Plan>,
    (device, queue): &(wgpu::Device, wgpu::Queue),
) -> Result<Executor, umbragraph::Error> {
    Executor::new(device, queue, plan.clone(), None)
}

#[track_caller]
fn rejected(plan: &Arc<Plan>, device: &(wgpu::Device, wgpu::Queue)) -> Vec<(&'static str, String)> {
    said(&instantiate(plan, device).err().expect("a diagnostic"))
}

/// Fills a texture of a format and size, and shows it.
fn through(format: &str, size: &str, show: &str) -> Arc<Plan> {
    let resources =
        format!(r#""between": {{ "texture": {{ "format": "{format}", "size": {size} }} }}, {}"#, target(1));
    let passes = format!(
        r#"{}, "show": {{ "fullscreen": {{ "shader": "{show}", "bind": {{ "picture": "&between" }},
            "color": [{{ "to": "&target" }}] }} }}"#,
        fill("one", r#"{ "to": "&between" }"#, "[1, 0, 0, 1]")
    );
    plan(&resources, &passes)
}

#[test]
fn a_texture_that_is_too_large_is_named_with_the_limit() {
    let plan = through("rgba8unorm", "[512, 512]", "show.wgsl.jinja");
    let small = device(wgpu::Features::empty(), |limits| limits.max_texture_dimension_2d = 256);
    let wanted = "\"between\" is 512 by 512 with 1 layers; the device allows 256 and 256";
    assert_eq!(rejected(&plan, &small), [("UG0804", wanted.to_owned())]);
    assert!(instantiate(&plan, &device(wgpu::Features::empty(), |_| {})).is_ok());
}

#[test]
fn a_missing_feature_is_named() {
    let resources = format!(
        r#""sum": {{ "texture": {{ "format": "rgba32float", "size": "=viewport", "lifetime": "persistent" }} }}, {}"#,
        target(1)
    );
    // Blending is not checked by the profile of this test's own plan: the plan is changed by hand.
    let mut plan = (*plan(&resources, &fill("one", r#"{ "to": "&sum" }"#, "[1, 0, 0, 1]"))).clone();
    let mut pipeline = (*plan.pipeline).clone();
    for pass in &mut pipeline.passes {
        if let umbragraph::work::Work::Render(render) = pass.tamper().0 {
            render.color[0].blend = Some(wgpu::BlendState::ALPHA_BLENDING);
        }
    }
    plan.pipeline = Arc::new(pipeline);
    let plan = Arc::new(plan);
    let said = rejected(&plan, &device(wgpu::Features::empty(), |_| {}));
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].0 == "UG0804" && said[0].1.contains("FLOAT32_BLENDABLE"), "{said:?}");
    assert!(instantiate(&plan, &device(wgpu::Features::FLOAT32_BLENDABLE, |_| {})).is_ok());
}

#[test]
fn bind_groups_and_blocks_beyond_the_device_are_named() {
    let plan = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let few = device(wgpu::Features::empty(), |limits| limits.max_bind_groups = 1);
    let wanted = "fill.wgsl.jinja has 2 bind groups; the device allows 1";
    assert_eq!(rejected(&plan, &few), [("UG0804", wanted.to_owned())]);
    let short = device(wgpu::Features::empty(), |limits| limits.max_uniform_buffer_binding_size = 12);
    let wanted = "\"settings\" of fill.wgsl.jinja has 16 bytes; the device allows 12";
    assert_eq!(rejected(&plan, &short), [("UG0804", wanted.to_owned())]);
}

/// A limit of a device.
type Limit = fn(&mut wgpu::Limits, u32);

#[test]
fn a_limit_may_be_met_exactly_and_not_be_exceeded_by_one() {
    let resources = format!(
        r#""sums": {{ "buffer": {{ "size": 1024 }} }},
           "between": {{ "texture": {{ "format": "rgba8unorm", "size": [512, 300] }} }},
           "stack": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "layers": 5, "lifetime": "persistent" }} }}, {}"#,
        target(1)
    );
    let passes = format!(
        r#"{}, {}, "none": {{ "clear": {{ "buffer": "&sums" }} }},
           "sum": {{ "compute": {{ "shader": "shared.wgsl.jinja", "bind": {{ "sums": "&sums" }}, "workgroups": [3, 1, 1] }} }},
           "show": {{ "fullscreen": {{ "shader": "show.wgsl.jinja", "bind": {{ "picture": "&between" }},
             "color": [{{ "to": "&target" }}] }} }},
           "word": {{ "fullscreen": {{ "shader": "word.wgsl.jinja", "bind": {{ "words": "&sums" }},
             "color": [{{ "to": "&target", "blend": "add" }}] }} }}"#,
        fill("one", r#"{ "to": "&between" }"#, "[1, 0, 0, 1]"),
        fill("top", r#"{ "to": "&stack", "layer": 4 }"#, "[1, 0, 0, 1]")
    );
    let plan = plan(&resources, &passes);
    let limits: [(u32, Limit); 12] = [
        (512, |limits, to| limits.max_texture_dimension_2d = to),
        (5, |limits, to| limits.max_texture_array_layers = to),
        (1024, |limits, to| limits.max_buffer_size = to.into()),
        (16, |limits, to| limits.max_uniform_buffer_binding_size = to.into()),
        (2, |limits, to| limits.max_bind_groups = to),
        (1, |limits, to| limits.max_color_attachments = to),
        (16, |limits, to| limits.max_compute_workgroup_size_x = to),
        (4, |limits, to| limits.max_compute_workgroup_size_y = to),
        (2, |limits, to| limits.max_compute_workgroup_size_z = to),
        (128, |limits, to| limits.max_compute_invocations_per_workgroup = to),
        (512, |limits, to| limits.max_compute_workgroup_storage_size = to),
        (3, |limits, to| limits.max_compute_workgroups_per_dimension = to),
    ];
    for (at, (needed, limit)) in limits.into_iter().enumerate() {
        let with = |allowed| device(wgpu::Features::empty(), |limits| limit(limits, allowed));
        if let Err(error) = instantiate(&plan, &with(needed)) {
            panic!("limit {at}, {needed}: {:?}", said(&error));
        }
        let found = rejected(&plan, &with(needed - 1));
        assert!(
            !found.is_empty() && found.iter().all(|(code, _)| *code == "UG0804"),
            "limit {at}: {found:?}"
        );
    }
}

#[test]
fn device_errors_are_placed_at_the_resource_or_the_pass() {
    let noop = device(wgpu::Features::empty(), |_| {});
    let places = |plan: Plan| -> Vec<String> {
        let rejected = instantiate(&Arc::new(plan), &noop).err().expect("a diagnostic");
        assert!(rejected.iter().all(|one| one.message.lines().count() == 1), "{rejected}");
        rejected.iter().map(|one| format!("{} {}", one.code.id, one.pointer)).collect()
    };
    let plan = (*through("rgba8unorm", r#""=viewport""#, "show.wgsl.jinja")).clone();
    let mut of_resource = plan.clone();
    of_resource.textures[0].size.samples = 3;
    assert_eq!(places(of_resource)[0], "UG0803 /resources/between");
    let mut pipeline = (*plan.pipeline).clone();
    for pass in &mut pipeline.passes {
        if let umbragraph::work::Work::Render(render) = pass.tamper().0 {
            render.color[0].format = Some(wgpu::TextureFormat::Rgba8Uint);
        }
    }
    let mut of_passes = plan;
    of_passes.pipeline = Arc::new(pipeline);
    assert_eq!(places(of_passes), ["UG0803 /passes/one", "UG0803 /passes/show"]);
}

#[test]
fn a_lost_device_is_said_and_no_panic() {
    lose(&device(wgpu::Features::empty(), |_| {}), true);
    lose(&device(wgpu::Features::empty(), |_| {}), false);
    if let Some(gpu) = umbragraph_test_support::gpu::device() {
        lose(&(gpu.device, gpu.queue), true);
    }
}

/// Loses a device after a frame, whose buffers are free again or still in flight, and goes on.
fn lose(gpu: &(wgpu::Device, wgpu::Queue), waits: bool) {
    let made = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let Ok(mut executor) = instantiate(&made, gpu) else { panic!("no executor") };
    let target = gpu.0.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let mut record = || {
        let mut encoder = gpu.0.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = executor.record(&mut encoder, &Frame::new(&frame(&[])).imports(&[("target", &target)]));
        gpu.1.submit([encoder.finish()]);
        result
    };
    record().expect("a frame");
    if waits {
        gpu.0.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    }
    gpu.0.destroy();
    // What wgpu says of this is its own affair; it may not panic. Once something has to be made, the loss is said.
    let lost = [("UG0820", "the device is lost".to_owned())];
    let last = (0..3).map(|_| record()).last().and_then(Result::err).expect("a diagnostic");
    assert!(said(&last).contains(&lost[0]), "{last}");
    assert_eq!(rejected(&made, gpu), lost);
}

#[test]
fn a_block_with_too_many_views_is_rejected_unallocated() {
    let geometry = crate::executing::stage::draw(8, r#"{ "to": "&target", "clear": [0, 0, 0, 1] }"#);
    let plan = plan(&target(1), &geometry.replace("\"max\": 8", "\"max\": 100000"));
    let noop = device(wgpu::Features::empty(), |limits| limits.max_buffer_size = 1 << 20);
    let squares = crate::executing::squares::Squares::new(&noop.0, &noop.1, &[], &[]);
    let made = Executor::new(&noop.0, &noop.1, plan, Some(&squares));
    let said = said(&made.err().expect("a diagnostic"));
    assert_eq!(said.len(), 1);
    assert!(said[0].0 == "UG0804" && said[0].1.contains("25600000 bytes"), "{said:?}");
}
