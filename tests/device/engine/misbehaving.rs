//! A driver that misbehaves: a device that is lost in the middle of a frame, a shader or a pipeline that it rejects.
//! Each is an error value that names the pass, and an executor made anew draws the next frame.
//!
//! The tests run on whatever driver there is; `cargo xtask test` runs them on a second one where it is installed.

use std::sync::Arc;

use umbragraph::draw::{DrawPass, DrawSource};
use umbragraph::work::Work;
use umbragraph::{Error, Executor, Frame, Options, Plan};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

use super::meshes::{DrawnBy, Meshes, frame, plan};
use crate::common::gpu::{import, read};

const SIZE: [u32; 2] = [64, 36];

fn small_plan() -> Arc<Plan> {
    plan(false, &Options::new(SIZE[0], SIZE[1]).set("cascade_side", 128))
}

/// Records a frame and submits it, after `between`; wgpu's own errors of a lost device are caught.
fn draw(
    gpu: &Gpu,
    executor: &mut Executor,
    draws: &dyn DrawSource,
    target: &wgpu::Texture,
    between: impl FnOnce(),
) -> Result<(), Error> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let input = frame(SIZE);
    let result =
        executor.record(&mut encoder, &Frame::new(&input).draws(draws).imports(&[("target", target)]));
    between();
    gpu.queue.submit([encoder.finish()]);
    drop(pollster::block_on(scope.pop()));
    result
}

/// The picture of a plan on a device of its own.
fn picture(plan: &Arc<Plan>) -> Option<Picture> {
    let gpu = gpu::device()?;
    let meshes = Meshes::new(&gpu, false);
    let target = import(&gpu, plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&meshes))
        .unwrap_or_else(|error| panic!("{error}"));
    draw(&gpu, &mut executor, &meshes, &target, || {}).unwrap_or_else(|error| panic!("{error}"));
    Some(read(&gpu, &target))
}

#[track_caller]
fn is_lost(error: &Error) {
    assert!(error.diagnostics().iter().any(|one| one.code.id == "UG0820"), "{error}");
    assert!(error.to_string().contains("make a new device"), "{error}");
}

#[test]
fn a_device_lost_in_the_middle_of_a_frame_is_an_error() {
    let plan = small_plan();
    let Some(wanted) = picture(&plan) else { return };
    // While passes are recorded, before they are submitted, and while the device works on them.
    for moment in 0..3 {
        let Some(gpu) = gpu::device() else { return };
        let meshes = Meshes::new(&gpu, false);
        let target = import(&gpu, &plan, "target");
        let losing = DrawnBy {
            meshes: &meshes,
            draw: |meshes: &Meshes, pass: &mut dyn DrawPass| {
                meshes.draw(pass);
                gpu.device.destroy();
            },
        };
        let draws: &dyn DrawSource = if moment == 0 { &losing } else { &meshes };
        let mut executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&meshes)).unwrap();
        let between = || {
            if moment == 1 {
                gpu.device.destroy();
            }
        };
        let _ = draw(&gpu, &mut executor, draws, &target, between);
        if moment == 2 {
            gpu.device.destroy();
        }
        let error = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&meshes)).err();
        is_lost(&error.unwrap_or_else(|| panic!("moment {moment}: no error")));
        let error = executor.set_plan(plan.clone()).expect_err("a lost device");
        is_lost(&error);
        assert_eq!(picture(&plan).unwrap().differing(&wanted, 0), 0, "moment {moment}");
    }
}

/// A plan whose pass `shade` was changed after it was checked, so that the device finds what nobody else did.
fn changed(plan: &Plan, change: impl Fn(&mut umbragraph::low_level::pipeline::TypedPipeline)) -> Arc<Plan> {
    let mut pipeline = (*plan.pipeline).clone();
    change(&mut pipeline);
    let mut plan = plan.clone();
    plan.pipeline = Arc::new(pipeline);
    Arc::new(plan)
}

#[track_caller]
fn rejected_by_the_device(bad: &Arc<Plan>, good: &Arc<Plan>, words: &str) {
    let Some(gpu) = gpu::device() else { return };
    let meshes = Meshes::new(&gpu, false);
    let error = Executor::new(&gpu.device, &gpu.queue, bad.clone(), Some(&meshes)).err().expect("an error");
    let named =
        error.diagnostics().iter().find(|one| one.code.id == "UG0803" && one.pointer == "/passes/shade");
    let said = &named.unwrap_or_else(|| panic!("{error}")).message;
    assert!(said.contains("the device rejected what \"shade\" needs") && said.contains(words), "{said}");
    // The device is as it was.
    let target = import(&gpu, good, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, good.clone(), Some(&meshes)).unwrap();
    let error = executor.set_plan(bad.clone()).expect_err("the same");
    assert!(error.to_string().contains("\"shade\""), "{error}");
    draw(&gpu, &mut executor, &meshes, &target, || {}).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(picture(good).unwrap().differing(&read(&gpu, &target), 0), 0);
}

#[test]
fn a_shader_that_the_device_rejects_names_its_pass() {
    let good = small_plan();
    let bad = changed(&good, |pipeline| {
        let shade = pipeline.passes.iter().find(|pass| pass.name == "shade").unwrap();
        let program = shade.work().program().unwrap();
        for variant in &mut pipeline.programs[program.index()].variants {
            let mut module = (*variant.module).clone();
            module.wgsl = "fn shade() { no_such_function(); }".into();
            module.hash[0] ^= 255;
            variant.module = Arc::new(module);
        }
    });
    rejected_by_the_device(&bad, &good, "no_such_function");
}

#[test]
fn a_pipeline_that_the_device_rejects_names_its_pass() {
    let good = small_plan();
    let bad = changed(&good, |pipeline| {
        let shade = pipeline.passes.iter_mut().find(|pass| pass.name == "shade").unwrap();
        if let Work::Render(render) = shade.tamper().0 {
            render.color[0].format = Some(wgpu::TextureFormat::Rgba8Uint);
        }
    });
    rejected_by_the_device(&bad, &good, "Rgba8Uint");
}
