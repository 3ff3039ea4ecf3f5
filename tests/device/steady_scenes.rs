//! Heap allocations of a steady frame of the example scenes: `awsm`, recorded by the module and by hand, and the CPU
//! passes alone. The frame by hand is that of `benches/record`; both run the same CPU passes and draw the same meshes.

#[path = "../../benches/record/hand/mod.rs"]
mod hand;

use allocation_counter::measure;
use hand::ByHand;
use umbragraph::low_level::compiler::CpuPasses;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;

const SIZE: [u32; 2] = [128, 72];

/// Frames before anything is counted: by then lights have their tiles, pools and caches what they need.
const WARM: usize = 8;

#[test]
fn steady_frames_of_scenes_allocate_no_more_than_by_hand() {
    let Some(gpu) = gpu::device() else { return };
    let pipeline = Library::new().load("umbragraph:awsm.json").unwrap_or_else(|error| panic!("{error}"));
    for name in ["courtyard", "interior"] {
        let scene =
            crate::common::gpu::scene(&crate::common::root().join(format!("examples/scenes/{name}.glb")));
        let source = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0))
            .expect("a scene that fits");
        let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
        let mut options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256).set("cube_side", 64);
        let plan = |options: &Options| pipeline.plan(options).unwrap_or_else(|error| panic!("{error}"));
        // As large as the lights want it.
        let mut cpu = CpuPasses::new(plan(&options));
        for _ in 0..WARM {
            cpu.run(&input, &[]).expect("data");
            let Some(sizes) = cpu.wanted_sizes() else { break };
            options = options.data_sizes(sizes);
            cpu.set_plan(plan(&options));
        }
        let plan = plan(&options);
        let mut cpu = CpuPasses::new(plan.clone());
        let targets = [(), ()].map(|()| crate::common::gpu::import(&gpu, &plan, "target"));
        let made = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&source));
        let mut executor = made.unwrap_or_else(|error| panic!("{error}"));
        let mut by_hand = ByHand::new(&gpu, &plan, &source, &targets[1]);
        let mut counts = Vec::new();
        for round in 0..WARM + 3 {
            let imports = [("target", &targets[0])];
            let frame = Frame::new(&input).draws(&source).imports(&imports);
            let descriptor = wgpu::CommandEncoderDescriptor::default();
            let mut encoder = gpu.device.create_command_encoder(&descriptor);
            let ours = measure(|| {
                executor.record(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
            });
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
            let mut encoder = gpu.device.create_command_encoder(&descriptor);
            let theirs = measure(|| by_hand.record(&mut encoder, &input, &source));
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
            let alone = measure(|| cpu.run(&input, &[]).expect("data"));
            if round >= WARM {
                counts.push([ours, theirs, alone].map(|measured| measured.count_total));
            }
        }
        println!("{name}: allocations of a record, of one by hand, and of the CPU passes alone: {counts:?}");
        assert!(counts.iter().all(|[_, theirs, _]| *theirs > 0), "the counter counts: {counts:?}");
        assert!(counts.iter().all(|[ours, theirs, _]| ours <= theirs), "{name}: {counts:?}");
        assert!(counts.iter().all(|[.., alone]| *alone == 0), "{name}: {counts:?}");
    }
}
