//! Hosts that draw what does not exist, or without having said how.
//!
//! wgpu panics by default over a draw without a pipeline or with an offset outside its buffer; whatever the host asks
//! for, what is recorded has to be valid.

use umbragraph::draw::PropertySet;
use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{BLUE, BOTH_SIDES, GREEN, RED, Square, Squares, square};
use crate::executing::stage::{color, draw, executor, plan, show, target};
use crate::executing::views::frame;

const RED_TEXEL: [u8; 4] = [255, 0, 0, 255];

/// The picture that a host's script leaves over blue; the squares are red and green, the materials 1 and 1/5.
fn outcome(
    script: impl Fn(&mut dyn umbragraph::draw::DrawPass, &wgpu::Buffer) + Send + Sync + 'static,
) -> Option<[u8; 4]> {
    let gpu = gpu::device()?;
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = [square(RED), square(GREEN)];
    let squares =
        Squares::new(&gpu.device, &gpu.queue, &squares, &[[1.0; 4], [0.2, 0.2, 0.2, 1.0]]).drawing(script);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    Some(color(&gpu, &target, 0))
}

#[test]
fn a_draw_without_a_choice_takes_the_first_of_everything() {
    let drawn = outcome(|pass, corners| {
        pass.render_pass().set_vertex_buffer(0, corners.slice(..));
        pass.render_pass().draw(0..6, 0..1);
    });
    assert!(drawn.is_none_or(|drawn| drawn == RED_TEXEL), "{drawn:?}");
}

#[test]
fn unknown_properties_are_rejected_and_change_nothing() {
    let drawn = outcome(|pass, corners| {
        pass.render_pass().set_vertex_buffer(0, corners.slice(..));
        assert!(!pass.set_properties(PropertySet(6)));
        pass.render_pass().draw(0..6, 0..1);
    });
    assert!(drawn.is_none_or(|drawn| drawn == RED_TEXEL), "{drawn:?}");
}

#[test]
fn materials_and_objects_that_do_not_exist_change_nothing() {
    let drawn = outcome(|pass, corners| {
        pass.render_pass().set_vertex_buffer(0, corners.slice(..));
        assert!(pass.set_properties(PropertySet(0)));
        for nothing in [2, 3, 1 << 24, u32::MAX] {
            pass.set_material(nothing);
            pass.set_object(nothing);
            pass.render_pass().draw(0..6, 0..1);
        }
    });
    assert!(drawn.is_none_or(|drawn| drawn == RED_TEXEL), "{drawn:?}");
}

#[test]
fn materials_and_objects_are_chosen_by_number() {
    let drawn = outcome(|pass, corners| {
        pass.render_pass().set_vertex_buffer(0, corners.slice(..));
        pass.set_object(1);
        pass.set_material(1);
        pass.render_pass().draw(0..6, 0..1);
    });
    assert!(drawn.is_none_or(|drawn| drawn == [0, 51, 0, 255]), "{drawn:?}");
}

#[test]
fn double_sided_squares_are_seen_from_behind_and_others_are_not() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let behind = Square { rectangle: [1.0, -1.0, -1.0, 1.0], ..square(RED) };
    let target = import(&gpu, &plan, "target");
    for (properties, wanted) in [(PropertySet(0), [0, 0, 255, 255]), (BOTH_SIDES, RED_TEXEL)] {
        let squares =
            Squares::new(&gpu.device, &gpu.queue, &[behind], &[[1.0; 4]]).drawing(move |pass, corners| {
                pass.render_pass().set_vertex_buffer(0, corners.slice(..));
                assert!(pass.set_properties(properties));
                pass.render_pass().draw(0..6, 0..1);
            });
        let mut executor = executor(&gpu, &plan, Some(&squares));
        show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
        assert_eq!(color(&gpu, &target, 0), wanted);
    }
}

#[test]
fn a_host_without_materials_or_property_sets_draws_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let target = import(&gpu, &plan, "target");
    let asked = |_: &mut dyn umbragraph::draw::DrawPass, _: &wgpu::Buffer| panic!("nothing can be drawn");
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(BLUE)], &[[1.0; 4]]).drawing(asked);
    squares.material_count = 0;
    let mut without_materials = executor(&gpu, &plan, Some(&squares));
    show(&gpu, &mut without_materials, Some(&squares), &target, &frame(&["0"]));
    squares.material_count = 1;
    squares.interface.property_sets.clear();
    let mut without_sets = executor(&gpu, &plan, Some(&squares));
    show(&gpu, &mut without_sets, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), [0, 0, 255, 255]);
}

#[test]
fn a_moved_viewport_does_not_reach_into_the_next_view() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let target = import(&gpu, &plan, "target");
    let squares =
        Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]).drawing(|pass, corners| {
            let render_pass = pass.render_pass();
            render_pass.set_vertex_buffer(0, corners.slice(..));
            render_pass.draw(0..6, 0..1);
            render_pass.set_viewport(0.0, 0.0, 1.0, 1.0, 0.0, 1.0);
            render_pass.set_scissor_rect(0, 0, 1, 1);
        });
    let mut executor = executor(&gpu, &plan, Some(&squares));
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 0 0 2 2", "0"]));
    assert_eq!(color(&gpu, &target, 0), RED_TEXEL);
}

/// Passes and what they draw into are labelled as the pipeline names them, so that wgpu's own errors and debuggers do.
#[test]
fn device_errors_name_passes_and_resources() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    // Without the vertex buffer that the pipeline reads.
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]])
        .drawing(|pass, _| pass.render_pass().draw(0..6, 0..1));
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let (input, imports) = (frame(&["0"]), [("target", &target)]);
    let record =
        umbragraph::Frame::new(&input).draws(&squares as &dyn umbragraph::draw::DrawSource).imports(&imports);
    let _ = executor.record(&mut encoder, &record);
    let _ = encoder.finish();
    let error = pollster::block_on(scope.pop()).expect("an error of the device").to_string();
    assert!(error.contains("\"squares\"") || error.contains("'squares'"), "{error}");
}
