//! Plans that are prepared off the caller's thread, and executors that share what they made.

use umbragraph::executor::{PlanPreparer, PreparedPlan};
use umbragraph::{Executor, Frame, Options};
use umbragraph_test_support::gpu;

use super::meshes::{Meshes, frame, plan};

const SIZE: [u32; 2] = [64, 36];

#[test]
fn a_plan_prepared_on_another_thread_creates_no_pipeline_later() {
    fn is_sent<T: Send + Sync + 'static>() {}
    is_sent::<PlanPreparer>();
    is_sent::<PreparedPlan>();
    let Some(gpu) = gpu::device() else { return };
    let options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256);
    let [first, second, third] = ["hard", "pcss", "poisson16"]
        .map(|filter| plan(false, &options.clone().feature("light_filter", filter)));
    let meshes = Meshes::new(&gpu, false);
    let target = crate::common::gpu::import(&gpu, &first, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, first, Some(&meshes)).unwrap();
    let input = frame(SIZE);
    let record = |executor: &mut Executor| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        crate::common::gpu::read(&gpu, &target)
    };
    let preparation = executor.preparer();
    let prepared = std::thread::scope(|scope| {
        let worker = scope.spawn(|| preparation.prepare(second.clone(), Some(&meshes)));
        // Frames go on meanwhile.
        record(&mut executor);
        worker.join().expect("no panic").unwrap_or_else(|error| panic!("{error}"))
    });
    let before = executor.statistics();
    let made = prepared.statistics();
    assert!(made.pipelines > 0);
    executor.set_prepared_plan(prepared).unwrap();
    let after = executor.statistics();
    let counted = (before.pipelines + made.pipelines, before.shader_modules + made.shader_modules);
    assert_eq!((after.pipelines, after.shader_modules), counted, "nothing but what was prepared");
    let picture = record(&mut executor);
    // An executor beside it makes no pipeline either, and draws the same.
    let mut beside = Executor::with_shared_cache(&executor, second, Some(&meshes)).unwrap();
    assert_eq!((beside.statistics().pipelines, beside.statistics().shader_modules), (0, 0));
    assert_eq!(record(&mut beside).differing(&picture, 0), 0);
    executor.set_plan(third).unwrap();
    assert!(
        executor.statistics().pipelines > after.pipelines,
        "a plan that is set makes its pipelines there"
    );
}
