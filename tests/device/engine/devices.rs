//! Errors between an engine and a device are values that name the cause, and the next frame is possible.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use umbragraph::draw::{DrawPass, DrawSource};
use umbragraph::frame::{Camera, FrameInput, Light};
use umbragraph::{Error, Executor, Frame, Library, Options, Plan};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

use super::meshes::{DrawnBy, Meshes, frame, plan};

const SIZE: [u32; 2] = [64, 36];

fn codes(error: &Error) -> Vec<&'static str> {
    error.diagnostics().iter().map(|finding| finding.code.id).collect()
}

fn record(
    gpu: &Gpu,
    executor: &mut Executor,
    draws: Option<&dyn DrawSource>,
    imports: &[(&str, &wgpu::Texture)],
) -> Result<(), Error> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let input = frame(SIZE);
    let mut frame = Frame::new(&input).imports(imports);
    frame.draws = draws;
    let result = executor.record(&mut encoder, &frame);
    gpu.queue.submit([encoder.finish()]);
    result
}

/// A pipeline without meshes, whose picture is a gradient.
fn gradient(size: [u32; 2]) -> Arc<Plan> {
    let text = r#"{
      "format": 1, "name": "gradient",
      "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
      "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } } }
    }"#;
    let pipeline = Library::new().load_text("gradient.json", text).unwrap();
    pipeline.plan(&Options::new(size[0], size[1])).unwrap_or_else(|error| panic!("{error}"))
}

/// A device that nobody else has.
fn own_device() -> Option<Gpu> {
    let shared = gpu::device()?;
    let descriptor = wgpu::DeviceDescriptor { required_limits: shared.device.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(shared.adapter.request_device(&descriptor)).unwrap();
    Some(Gpu { device, queue, ..shared })
}

#[test]
fn after_device_loss_another_device_takes_the_same_plan() {
    let Some(lost) = own_device() else { return };
    // Room for one light of two: the pass has something to say.
    let options = Options::new(SIZE[0], SIZE[1]).set("light_capacity", 1).set("cascade_side", 256);
    let plan = plan(false, &options);
    let run = |gpu: &Gpu| -> (Vec<String>, Picture, Executor) {
        let meshes = Meshes::new(gpu, false);
        let target = crate::common::gpu::import(gpu, &plan, "target");
        let mut executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&meshes)).unwrap();
        let mut input = frame(SIZE);
        input.lights.push(Light::point("lamp", [0.0, 3.0, 0.0], [1.0; 3], 10.0));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        let notices = executor.notices().map(|notice| notice.message.clone()).collect();
        (notices, crate::common::gpu::read(gpu, &target), executor)
    };
    let (notices, picture, mut executor) = run(&lost);
    assert!(notices.iter().any(|notice| notice.contains("sun")), "{notices:?}");
    let meshes = Meshes::new(&lost, false);
    lost.device.destroy();
    let again =
        Executor::new(&lost.device, &lost.queue, plan.clone(), Some(&meshes)).err().expect("an error");
    assert_eq!(codes(&again), ["UG0820"], "{again}");
    let again = executor.set_plan(plan.clone()).expect_err("an error");
    assert_eq!(codes(&again), ["UG0820"], "{again}");
    let Some(other) = own_device() else { return };
    let (found, same, _) = run(&other);
    assert_eq!(found, notices);
    assert_eq!(same.differing(&picture, 0), 0);
}

#[test]
fn record_finds_textures_of_another_device_and_unknown_ones() {
    let (Some(gpu), Some(other)) = (gpu::device(), own_device()) else { return };
    let plan = gradient(SIZE);
    let [own, foreign] = [&gpu, &other].map(|gpu| crate::common::gpu::import(gpu, &plan, "target"));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let error = record(&gpu, &mut executor, None, &[("target", &foreign)]).expect_err("a foreign texture");
    assert_eq!(codes(&error), ["UG0802"]);
    assert!(error.to_string().contains("the texture for \"target\" is of another device"), "{error}");
    let error =
        record(&gpu, &mut executor, None, &[("target", &own), ("targte", &own)]).expect_err("a surplus one");
    assert!(error.to_string().contains("\"targte\"") && error.to_string().contains("target"), "{error}");
    record(&gpu, &mut executor, None, &[("target", &own)]).unwrap_or_else(|error| panic!("{error}"));
    assert!(crate::common::gpu::read(&gpu, &own).rgba_pixels().any(|pixel| pixel[0] > 100));
    // A texture that is gone when it comes up for the first time.
    let gone = crate::common::gpu::import(&gpu, executor.plan(), "target");
    gone.destroy();
    let error = record(&gpu, &mut executor, None, &[("target", &gone)]).expect_err("a destroyed texture");
    assert!(error.to_string().contains("destroyed"), "{error}");
    record(&gpu, &mut executor, None, &[("target", &own)]).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn imports_of_a_wrong_kind_are_named_with_both_values() {
    let Some(gpu) = gpu::device() else { return };
    let plan = gradient(SIZE);
    let own = crate::common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let like = wgpu::TextureDescriptor {
        label: None,
        size: own.size(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: own.format(),
        usage: own.usage(),
        view_formats: &[],
    };
    let larger = wgpu::Extent3d { width: 65, ..own.size() };
    let wrong = [
        (
            wgpu::TextureDescriptor { format: wgpu::TextureFormat::R8Unorm, ..like.clone() },
            ["R8Unorm", "Rgba8Unorm"],
        ),
        (wgpu::TextureDescriptor { size: larger, ..like.clone() }, ["65 by 36", "64 by 36"]),
        (
            wgpu::TextureDescriptor {
                sample_count: 4,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                ..like.clone()
            },
            ["4 samples", "needs 1 and 1"],
        ),
        (
            wgpu::TextureDescriptor { usage: wgpu::TextureUsages::COPY_SRC, ..like.clone() },
            ["without the usage", "RENDER_ATTACHMENT"],
        ),
    ];
    for (descriptor, words) in wrong {
        let texture = gpu.device.create_texture(&descriptor);
        let error = record(&gpu, &mut executor, None, &[("target", &texture)]).expect_err("a wrong texture");
        assert_eq!(codes(&error), ["UG0802"], "{error}");
        let said = error.to_string();
        assert!(
            said.contains("\"target\"") && words.iter().all(|word| said.contains(word)),
            "{words:?}: {said}"
        );
        record(&gpu, &mut executor, None, &[("target", &own)]).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn another_size_in_each_of_1000_frames_leaves_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let mut executor = Executor::new(&gpu.device, &gpu.queue, gradient(SIZE), None).unwrap();
    let before = executor.statistics().pipelines;
    let held = || gpu.device.generate_allocator_report().map_or(0, |report| report.total_allocated_bytes);
    let mut counted = Vec::new();
    let plans: Vec<Arc<Plan>> = (0..20).map(|at| gradient([1 + at * 37 % 200, 1 + at * 53 % 120])).collect();
    for at in 0..1000usize {
        executor.set_plan(plans[at * 7 % plans.len()].clone()).unwrap();
        let target = crate::common::gpu::import(&gpu, executor.plan(), "target");
        record(&gpu, &mut executor, None, &[("target", &target)])
            .unwrap_or_else(|error| panic!("frame {at}: {error}"));
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        counted.extend((at % 100 == 99).then(held));
    }
    assert_eq!(executor.statistics().pipelines, before);
    // The frames drew into 24 MB: textures that nobody frees would stay.
    let (first, last) = (counted[0], counted[counted.len() - 1]);
    assert!(last <= first + 1_000_000, "bytes of the device grow: {counted:?}");
}

#[test]
fn draws_that_fail_or_panic_name_their_pass_and_recover() {
    let Some(gpu) = gpu::device() else { return };
    let options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256).feature("cached", true);
    let plan = plan(false, &options);
    let meshes = Meshes::new(&gpu, false);
    // 0: draws as it should, 1: says that it failed, 2: panics.
    let fails = AtomicU8::new(0);
    let failing = DrawnBy {
        meshes: &meshes,
        draw: |meshes: &Meshes, pass: &mut dyn DrawPass| match fails.load(Ordering::Relaxed) {
            1 => pass.fail("the vertex buffer is gone".to_owned()),
            2 => panic!("no such mesh"),
            _ => meshes.draw(pass),
        },
    };
    let target = crate::common::gpu::import(&gpu, &plan, "target");
    let mut wanted = None;
    for how in [1, 2] {
        let mut executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&failing)).unwrap();
        fails.store(how, Ordering::Relaxed);
        let error =
            record(&gpu, &mut executor, Some(&failing), &[("target", &target)]).expect_err("a failure");
        assert!(codes(&error).iter().all(|code| *code == "UG0821"), "{error}");
        let said = if how == 1 { "the vertex buffer is gone" } else { "it panicked: no such mesh" };
        let text = error.to_string();
        assert!(text.contains("the host's draws of \"shade\" failed") && text.contains(said), "{text}");
        fails.store(0, Ordering::Relaxed);
        record(&gpu, &mut executor, Some(&failing), &[("target", &target)])
            .unwrap_or_else(|error| panic!("{error}"));
        let picture = crate::common::gpu::read(&gpu, &target);
        let wanted = wanted.get_or_insert_with(|| {
            let mut fresh = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&failing)).unwrap();
            record(&gpu, &mut fresh, Some(&failing), &[("target", &target)]).unwrap();
            crate::common::gpu::read(&gpu, &target)
        });
        assert_eq!(picture.differing(wanted, 0), 0, "kept maps were not drawn again");
    }
}

#[test]
fn resizing_no_viewport_and_dropped_encoders_are_fine() {
    let Some(gpu) = gpu::device() else { return };
    let mut executor = Executor::new(&gpu.device, &gpu.queue, gradient(SIZE), None).unwrap();
    let before = executor.statistics().pipelines;
    for width in [64, 65, 1, 300, 64] {
        executor.set_plan(gradient([width, 36])).unwrap();
        let target = crate::common::gpu::import(&gpu, executor.plan(), "target");
        record(&gpu, &mut executor, None, &[("target", &target)]).unwrap_or_else(|error| panic!("{error}"));
    }
    assert_eq!(executor.statistics().pipelines, before);
    let library = Library::new();
    let awsm = library.load("umbragraph:awsm.json").unwrap();
    let error = awsm.plan(&Options::new(0, 36)).expect_err("no viewport");
    let says = error.to_string();
    assert_eq!(codes(&error), ["UG0321"], "one error, not one for each texture");
    assert!(says.contains("a picture of 0 by 36 texels has none"), "{says}");
    let plan = gradient(SIZE);
    let [one, two] = [(), ()].map(|()| crate::common::gpu::import(&gpu, &plan, "target"));
    let mut second = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let input = FrameInput::new(Camera::look_at([1.0; 3], [0.0; 3], 1.0, 1.0));
    let frame = |texture| [("target", texture)];
    let descriptor = wgpu::CommandEncoderDescriptor::default();
    let mut dropped = gpu.device.create_command_encoder(&descriptor);
    executor.set_plan(second.plan().clone()).unwrap();
    executor.record(&mut dropped, &Frame::new(&input).imports(&frame(&one))).unwrap();
    drop(dropped);
    let mut encoder = gpu.device.create_command_encoder(&descriptor);
    for (executor, texture) in [(&mut executor, &one), (&mut second, &two)] {
        executor.record(&mut encoder, &Frame::new(&input).imports(&frame(texture))).unwrap();
    }
    gpu.queue.submit([encoder.finish()]);
    let [one, two] = [one, two].map(|texture| crate::common::gpu::read(&gpu, &texture));
    assert!(one.differing(&two, 0) == 0 && one.rgba_pixels().any(|pixel| pixel[0] > 100));
}

/// A texture of 64 GiB, for which no device has room.
#[test]
fn too_little_memory_names_the_resource_and_recovers() {
    let Some(gpu) = own_device() else { return };
    let text = |layers: u32| {
        format!(
            r#"{{ "format": 1, "name": "memory",
              "resources": {{
                "huge": {{ "texture": {{ "format": "rgba32float", "size": [8192, 8192], "layers": {layers}, "view_dimension": "2d-array" }} }},
                "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
              }},
              "passes": {{
                "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&huge", "layer": 0 }}] }} }},
                "show": {{ "fullscreen": {{
                  "shader": "show.wgsl.jinja", "bind": {{ "huge": {{ "texture": {{ "name": "&huge", "layer": 0 }} }} }}, "color": [{{ "to": "&target" }}]
                }} }}
              }} }}"#
        )
    };
    let shader = "{% include 'lib/fullscreen.wgsl.jinja' %}
@group(1) @binding(0) var huge: texture_2d<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return textureLoad(huge, vec2<i32>(0), 0); }
";
    let library = Library::new().template("show.wgsl.jinja", shader);
    let plan = |layers| {
        let pipeline = library.load_text("memory.json", &text(layers));
        let plan = pipeline.and_then(|pipeline| pipeline.plan(&Options::new(16, 16)));
        plan.unwrap_or_else(|error| panic!("{error}"))
    };
    let Err(error) = Executor::new(&gpu.device, &gpu.queue, plan(64), None) else {
        println!("skipped: this device lends 64 GiB");
        return;
    };
    let shown = error.to_string();
    assert!(shown.contains("not enough memory for \"huge\"") && shown.contains("memory.json:3"), "{shown}");
    let executor = Executor::new(&gpu.device, &gpu.queue, gradient([16, 16]), None);
    let mut executor = executor.unwrap_or_else(|error| panic!("{error}"));
    // The executor goes on with the plan before.
    let error = executor.set_plan(plan(64)).unwrap_err();
    assert!(error.to_string().contains("not enough memory"), "{error}");
    let target = crate::common::gpu::import(&gpu, executor.plan(), "target");
    record(&gpu, &mut executor, None, &[("target", &target)]).unwrap_or_else(|error| panic!("{error}"));
}
