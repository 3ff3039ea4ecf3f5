//! Objects that steady frames create, and measurements of passes.

use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu;

use crate::common::gpu::{import, import_on};
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{draw, executor, fill, plan, play, said, show, target};
use crate::executing::views::frame;

#[test]
fn views_come_and_go_without_anything_being_created() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(4), &draw(4, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    let before = executor.statistics();
    for views in [&["0", "1", "2", "3"][..], &["3 1 1 2 2", "3"], &[]] {
        show(&gpu, &mut executor, Some(&squares), &target, &frame(views));
    }
    assert_eq!(executor.statistics(), before);
}

#[test]
fn textures_of_the_host_that_take_turns_are_seen_once_each() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "source": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}"#,
        target(1)
    );
    let show = r#""show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&source" },
        "color": [{ "to": "&target" }] } }"#;
    let plan = plan(&resources, show);
    let mut executor = executor(&gpu, &plan, None);
    let targets = [(); 3].map(|()| import(&gpu, &plan, "target"));
    let sources = [(); 2].map(|()| import(&gpu, &plan, "source"));
    let mut turn = |at: usize| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &targets[at % 3]), ("source", &sources[at % 2])];
        executor.record(&mut encoder, &Frame::new(&frame(&[])).imports(&imports)).expect("a record");
        gpu.queue.submit([encoder.finish()]);
        executor.statistics()
    };
    let first = (0..6).map(&mut turn).last().expect("a turn");
    assert_eq!((first.import_views, first.bind_groups), (5, 2));
    assert_eq!((6..24).map(&mut turn).last(), Some(first));
    // Those that stay away for long are forgotten.
    assert_eq!([0; 6].map(&mut turn)[5], first);
    assert_eq!(turn(1).import_views, first.import_views + 2);
}

#[test]
fn records_in_flight_have_a_buffer_each_and_use_them_again() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    for _ in 0..3 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for _ in 0..5 {
            executor
                .record(&mut encoder, &Frame::new(&frame(&[])).imports(&[("target", &target)]))
                .expect("a record");
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        let statistics = executor.statistics();
        assert_eq!((statistics.buffers, statistics.bind_groups), (5, 5));
        assert_eq!((statistics.bytes, statistics.shader_modules), (5 * 256, 1));
    }
}

#[test]
fn buffers_that_are_long_unused_or_too_small_are_made_again() {
    let (device, queue) = crate::executing::devices::device(wgpu::Features::empty(), |_| {});
    let one = fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]");
    let two = fill("two", r#"{ "to": "&target", "blend": "add" }"#, "[1, 0, 0, 1]");
    let (small, large) = (plan(&target(1), &one), plan(&target(1), &format!("{one}, {two}")));
    let mut executor = Executor::new(&device, &queue, small.clone(), None).expect("an executor");
    let target = import_on(&device, &small, "target");
    // The number of buffers made so far, after so many records in flight at once.
    let made = |executor: &mut Executor, records: usize| {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for _ in 0..records {
            let input = frame(&[]);
            executor
                .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
                .expect("a record");
        }
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        executor.statistics().buffers
    };
    assert_eq!([made(&mut executor, 2), made(&mut executor, 2)], [2, 2]);
    for _ in 0..300 {
        assert_eq!(made(&mut executor, 1), 2);
    }
    assert_eq!(made(&mut executor, 2), 3);
    executor.set_plan(large).expect("another plan");
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    assert_eq!(made(&mut executor, 1), 4);
    assert!(pollster::block_on(scope.pop()).is_none());
}

#[test]
fn times_are_told_for_each_pass_if_asked_for() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]).drawing(|_, _| {
        std::thread::sleep(std::time::Duration::from_millis(5));
    });
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(executor.times().count(), 0);
    executor.measure_times(true);
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    let times: Vec<_> = executor.times().map(|(name, time)| (name.to_owned(), time)).collect();
    assert_eq!(times.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["views", "squares"]);
    assert!(times[1].1 >= std::time::Duration::from_millis(5), "{times:?}");
    let starts: Vec<_> = executor.starts().collect();
    assert!(starts.len() == 2 && starts[0] < starts[1] && starts[1] >= starts[0] + times[0].1, "{starts:?}");
    assert!(!executor.preparation_time().is_zero(), "the block of the view is uploaded");
    executor.measure_times(false);
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!((executor.times().count(), executor.preparation_time().is_zero()), (0, true));
}

#[test]
fn gpu_times_are_told_per_pass_from_the_first_pass_on() {
    let Some(gpu) = gpu::device() else { return };
    let between = r#""between": { "texture": { "format": "rgba8unorm", "size": [512, 512] } }"#;
    let shown = r#""show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&between" },
        "color": [{ "to": "&target" }] } }"#;
    let kept =
        r#""kept": { "texture": { "format": "rgba8unorm", "size": [512, 512], "lifetime": "persistent" } }"#;
    let copied = r#""copy": { "after": ["show"], "copy": { "from": { "name": "&between" }, "to": { "name": "&kept" } } }"#;
    let passes = format!("{}, {shown}, {copied}", fill("one", r#"{ "to": "&between" }"#, "[1, 0, 0, 1]"));
    let plan = plan(&format!("{between}, {kept}, {}", target(1)), &passes);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let between_passes = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);
    let can = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
    assert_eq!(executor.measure_gpu_times(true), can);
    if !can {
        return;
    }
    for _ in 0..2 {
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        let times = executor.gpu_times();
        let names: Vec<&str> = times.iter().map(|one| one.pass.as_str()).collect();
        assert_eq!(names, &["one", "show", "copy"][..if between_passes { 3 } else { 2 }]);
        assert!(times[0].start.is_zero() && times.is_sorted_by_key(|one| one.start), "{times:?}");
        assert!(!times[0].time.is_zero() && !times[1].start.is_zero(), "{times:?}");
        assert_eq!(executor.gpu_times(), [], "asked a second time");
    }
    executor.measure_gpu_times(false);
    show(&gpu, &mut executor, None, &target, &frame(&[]));
    assert_eq!(executor.gpu_times(), []);
}

#[test]
fn undeclared_data_of_a_cpu_pass_is_found() {
    let Some(gpu) = gpu::device() else { return };
    let passes = r#""views": { "views": { "to": "&views", "max": 1, "lies": true } },
        "show": { "fullscreen": { "shader": "clock.wgsl.jinja", "bind": { "views": "&views" }, "color": [{ "to": "&target" }] } }"#;
    let plan = plan(&target(1), passes);
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let diagnostics = play(&gpu, &mut executor, None, &target, &frame(&[])).expect_err("a diagnostic");
    let wanted = "\"views\" publishes the value \"undeclared\", which was not declared";
    assert_eq!(said(&diagnostics), [("UG0807", wanted.to_owned())]);
    let diagnostics =
        play(&gpu, &mut executor, None, &target, &frame(&["0", "0"])).expect_err("a diagnostic");
    assert_eq!(said(&diagnostics)[0].0, "UG0807");
}

#[test]
fn a_camera_that_cannot_be_used_is_a_warning() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let mut executor = executor(&gpu, &plan, None);
    let target = import(&gpu, &plan, "target");
    let mut input = frame(&[]);
    show(&gpu, &mut executor, None, &target, &input);
    assert!(executor.notices().next().is_none());
    input.camera.position.x = f64::NAN;
    show(&gpu, &mut executor, None, &target, &input);
    let found: Vec<_> = executor.notices().map(|notice| notice.code.id).collect();
    assert_eq!(found, ["UG0806"]);
}

/// Executors and what makes them can be moved to another thread.
#[test]
fn executors_move_between_threads_and_are_seen_by_several() {
    fn moves<T: Send + Sync>(_: &T) {}
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &fill("one", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]"));
    let made = Executor::new(&gpu.device, &gpu.queue, plan, None);
    let Ok(executor) = made else { panic!("no executor") };
    moves(&executor);
}
