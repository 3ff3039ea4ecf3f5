//! Contents of earlier frames: read frames back, begun with, forgotten, and taken over by other plans.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::{self, Gpu};

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, plan_of_size, play, show, target};
use crate::executing::views::frame;

/// A history of two frames that begins with one 255th of red.
const NUMBERS: &str = r#""numbers": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "history",
    "frames": 2, "initial": ["=1 / 255", 0, 0, 1] } }"#;

/// Each frame is the sum of the two before.
const FIBONACCI: &str = r#""add": { "fullscreen": { "shader": "add.wgsl.jinja",
        "bind": { "one": "&numbers@-1", "other": "&numbers@-2" }, "color": [{ "to": "&numbers" }] } },
    "show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&numbers" }, "color": [{ "to": "&target" }] } }"#;

/// Red of the frames of [`FIBONACCI`], by additions on the processor.
fn fibonacci(frames: usize) -> Vec<u8> {
    let (mut list, mut before) = (Vec::new(), [1u8, 1]);
    for _ in 0..frames {
        before = [before[0] + before[1], before[0]];
        list.push(before[0]);
    }
    list
}

fn fibonacci_plan(side: u32) -> Arc<Plan> {
    plan_of_size(&format!("{NUMBERS}, {}", target(1)), FIBONACCI, side)
}

/// Red after one more frame.
fn next(gpu: &Gpu, executor: &mut Executor, target: &wgpu::Texture) -> u8 {
    show(gpu, executor, None, target, &frame(&[]));
    color(gpu, target, 0)[0]
}

#[test]
fn each_frame_reads_what_the_frames_before_left() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let seen: Vec<u8> = (0..10).map(|_| next(&gpu, &mut executor, &target)).collect();
    assert_eq!(seen, fibonacci(10));
}

#[test]
fn records_of_one_submission_are_frames_of_their_own() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let targets: Vec<wgpu::Texture> = (0..9).map(|_| import(&gpu, &plan, "target")).collect();
    let mut buffers = Vec::new();
    for three in targets.chunks(3) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for target in three {
            executor
                .record(&mut encoder, &Frame::new(&frame(&[])).imports(&[("target", target)]))
                .expect("a record");
        }
        buffers.push(encoder.finish());
    }
    gpu.queue.submit(buffers);
    let seen: Vec<u8> = targets.iter().map(|target| color(&gpu, target, 0)[0]).collect();
    assert_eq!(seen, fibonacci(9));
}

#[test]
fn a_reset_begins_again_and_disturbs_no_record_before_it() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let targets: Vec<wgpu::Texture> = (0..6).map(|_| import(&gpu, &plan, "target")).collect();
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for (at, target) in targets.iter().enumerate() {
        if at == 4 {
            executor.reset_history();
        }
        executor
            .record(&mut encoder, &Frame::new(&frame(&[])).imports(&[("target", target)]))
            .expect("a record");
    }
    gpu.queue.submit([encoder.finish()]);
    let seen: Vec<u8> = targets.iter().map(|target| color(&gpu, target, 0)[0]).collect();
    assert_eq!(seen, [fibonacci(4), fibonacci(2)].concat());
}

#[test]
fn another_size_begins_again_and_the_same_size_goes_on() {
    let Some(gpu) = gpu::device() else { return };
    let (small, large) = (fibonacci_plan(8), fibonacci_plan(16));
    let mut executor = executor(&gpu, &small, None);
    let target = import(&gpu, &small, "target");
    let seen: Vec<u8> = (0..4).map(|_| next(&gpu, &mut executor, &target)).collect();
    assert_eq!(seen, fibonacci(4));
    executor.set_plan(fibonacci_plan(8)).expect("the same plan");
    assert_eq!(next(&gpu, &mut executor, &target), fibonacci(5)[4], "the same size goes on");
    executor.set_plan(large.clone()).expect("a larger plan");
    let target = import(&gpu, &large, "target");
    let seen: Vec<u8> = (0..4).map(|_| next(&gpu, &mut executor, &target)).collect();
    assert_eq!(seen, fibonacci(4), "another size begins again");
}

#[test]
fn in_a_steady_frame_nothing_is_created_however_the_copies_turn() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    for _ in 0..3 {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
    }
    let before = executor.statistics();
    assert_eq!((before.textures, before.bind_groups), (3, 6), "three copies, two passes in three states");
    assert_eq!((before.bytes, before.buffers), (3 * 8 * 8 * 4, 0), "there are no blocks");
    assert_eq!((before.views, before.import_views), (9, 1), "copies are cleared, drawn into and read");
    for _ in 0..8 {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
    }
    assert_eq!(executor.statistics(), before);
}

#[test]
fn a_record_that_fails_is_no_frame() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let seen: Vec<u8> = (0..5)
        .map(|_| {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            assert!(executor.record(&mut encoder, &Frame::new(&frame(&[]))).is_err());
            next(&gpu, &mut executor, &target)
        })
        .collect();
    assert_eq!(seen, fibonacci(5));
}

#[test]
fn a_record_whose_meshes_lack_something_is_no_frame() {
    let Some(gpu) = gpu::device() else { return };
    let passes = FIBONACCI.replace(r#"{ "to": "&target" }"#, r#"{ "to": "&target", "layer": 0 }"#);
    let squares = draw(1, r#"{ "to": "&target", "layer": 1 }"#);
    let plan = plan(&format!("{NUMBERS}, {}", target(2)), &format!("{passes}, {squares}"));
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    let seen: Vec<u8> = (0..5)
        .map(|at| {
            if at % 2 == 1 {
                (squares.lacks_material, squares.generation) = (true, at);
                assert!(play(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"])).is_err());
                squares.lacks_material = false;
            }
            show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
            color(&gpu, &target, 0)[0]
        })
        .collect();
    assert_eq!(seen, fibonacci(5));
}

#[test]
fn the_executor_tells_which_copy_is_whose() {
    let Some(gpu) = gpu::device() else { return };
    let plan = fibonacci_plan(8);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let mut written = Vec::new();
    for _ in 0..5 {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        written.push(executor.texture("numbers").expect("this frame's").clone());
        let earlier = |back: usize| executor.texture(&format!("numbers@-{back}")).cloned();
        for back in 1..written.len().min(3) {
            assert_eq!(earlier(back), written.get(written.len() - 1 - back).cloned());
        }
    }
    assert_eq!(written[0], written[3]);
    assert_ne!(written[0], written[1]);
}

#[test]
fn every_mip_and_layer_and_depth_begin_with_the_initial_value() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#""all": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "layers": 2, "mips": 3, "lifetime": "history",
            "initial": [0.2, 0.4, 0.6, 1] }} }},
           "depth": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": 2, "lifetime": "history", "initial": 0.4 }} }},
           {}"#,
        target(2)
    );
    let passes = format!(
        r#""show": {{ "fullscreen": {{ "shader": "sum_of_all.wgsl.jinja", "bind": {{ "pictures": "&all@-1" }},
                "color": [{{ "to": "&target", "layer": 0 }}] }} }},
           "depths": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
                "bind": {{ "settings": {{ "values": {{ "layer": 1 }} }}, "maps": "&depth@-1" }},
                "color": [{{ "to": "&target", "layer": 1 }}] }} }},
           {}"#,
        fill("write", r#"{ "to": "&all", "layer": 0 }"#, "[1, 1, 1, 1]")
    );
    let plan = plan(&resources, &passes);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    assert_eq!(color(&gpu, &target, 0), [51, 102, 153, 255]);
    assert_eq!(color(&gpu, &target, 1), [102, 102, 102, 255]);
}

#[test]
fn buffers_begin_with_their_initial_words() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#""words": {{ "buffer": {{ "size": 64, "lifetime": "history", "frames": 3, "initial": {{ "u32": 51 }} }} }},
           "zeros": {{ "buffer": {{ "size": 64, "lifetime": "history", "initial": {{ "f32": 0 }} }} }}, {}"#,
        target(1)
    );
    let passes = r#""show": { "fullscreen": { "shader": "words.wgsl.jinja",
        "bind": { "words": "&words@-2", "zeros": "&zeros@-1" }, "color": [{ "to": "&target" }] } }"#;
    let plan = plan(&resources, passes);
    assert_eq!(plan.buffers.len(), 4 + 2);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    for _ in 0..5 {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        assert_eq!(color(&gpu, &target, 0), [51, 0, 0, 255]);
    }
}

#[test]
fn words_are_carried_over_only_to_a_plan_of_the_same_size() {
    let Some(gpu) = gpu::device() else { return };
    let counted = |size: u32| {
        let resources = format!(
            r#""words": {{ "buffer": {{ "size": {size}, "lifetime": "history", "initial": {{ "u32": 50 }} }} }}, {}"#,
            target(1)
        );
        let passes = r#""keep": { "copy": { "from": { "name": "&words@-1" }, "to": { "name": "&words" } } },
            "bump": { "compute": { "shader": "bump.wgsl.jinja", "workgroups": [1, 1, 1],
                "bind": { "words": "&words@keep", "settings": { "values": { "number": 1 } } } } },
            "show": { "fullscreen": { "shader": "word.wgsl.jinja", "bind": { "words": "&words@bump" }, "color": [{ "to": "&target" }] } }"#;
        plan(&resources, passes)
    };
    let mut executor = executor(&gpu, &counted(16), None);
    let target = import(&gpu, executor.plan(), "target");
    let mut seen = Vec::new();
    for size in [16, 16, 32] {
        executor.set_plan(counted(size)).expect("another plan");
        seen.extend([(); 2].map(|()| next(&gpu, &mut executor, &target)));
    }
    assert_eq!(seen, [51, 52, 53, 54, 51, 52]);
}

#[test]
fn a_frame_with_its_writer_off_is_no_frame_of_the_history() {
    let Some(gpu) = gpu::device() else { return };
    let passes = FIBONACCI.replacen(
        r#""add": {"#,
        r#""add": { "toggle": "advance", "passthrough": { "numbers": "&numbers@-1" },"#,
        1,
    );
    let text = format!(r#"{passes} }}, "toggles": {{ "advance": {{ "default": true }}"#);
    let plan = plan(&format!("{NUMBERS}, {}", target(1)), &text);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let mut seen = Vec::new();
    for on in [false, true, true, true, false, false, true, true] {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(
                &mut encoder,
                &Frame::new(&frame(&[])).imports(&[("target", &target)]).toggles(&[("advance", on)]),
            )
            .expect("a record");
        gpu.queue.submit([encoder.finish()]);
        seen.push(color(&gpu, &target, 0)[0]);
    }
    assert_eq!(seen, [1, 2, 3, 5, 5, 5, 8, 13]);
}
