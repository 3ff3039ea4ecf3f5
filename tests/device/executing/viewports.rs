//! Views that draw into parts of their attachments.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{GREEN, RED, Squares, square};
use crate::executing::stage::{at, color, draw, executor, plan, play, said, show, target, texels};
use crate::executing::views::frame;

const CLEARED: [u8; 4] = [0, 0, 255, 255];
const DRAWN: [u8; 4] = [255, 0, 0, 255];

#[test]
fn a_view_draws_into_its_texels_only() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 2 1 3 4", "0 7 7 1 1"]));
    for y in 0..8 {
        for x in 0..8 {
            let is_inside = ((2..5).contains(&x) && (1..5).contains(&y)) || (x, y) == (7, 7);
            assert_eq!(at(&gpu, &target, x, y), if is_inside { DRAWN } else { CLEARED }, "{x}, {y}");
        }
    }
    let (_, counts) = executor.pass_counts().next().expect("a pass that draws");
    assert_eq!((counts.views, counts.draws, counts.texels), (2, 2, 3 * 4 + 1));
}

#[test]
fn a_whole_view_after_one_of_a_part_is_whole() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 0 0 1 1", "0"]));
    assert_eq!(color(&gpu, &target, 0), DRAWN);
}

#[test]
fn each_view_has_its_own_matrix() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(3), &draw(3, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    // The second view moves the square by half its width, the third out of sight.
    show(
        &gpu,
        &mut executor,
        Some(&squares),
        &target,
        &frame(&["0 0 0 8 8 0", "1 0 0 8 8 1", "2 0 0 8 8 2"]),
    );
    assert_eq!((color(&gpu, &target, 0), color(&gpu, &target, 2)), (DRAWN, CLEARED));
    let half = &texels(&gpu, &target, 1)[..8];
    assert_eq!(half, [CLEARED, CLEARED, CLEARED, CLEARED, DRAWN, DRAWN, DRAWN, DRAWN]);
}

#[test]
fn one_layer_views_draw_into_it_whatever_layer_they_name() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["7 0 0 4 8", "3 4 0 4 8"]));
    assert_eq!(color(&gpu, &target, 0), DRAWN);
}

#[test]
fn an_empty_part_draws_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0 8 8 0 0", "0 0 0 8 0", "0 0 0 0 8"]));
    assert_eq!(color(&gpu, &target, 0), CLEARED);
    // Nor is the host asked to.
    assert!(executor.pass_counts().all(|(_, counts)| counts.draws == 0));
}

#[test]
fn a_view_outside_its_attachments_is_rejected_for_one_frame() {
    let Some(gpu) = gpu::device() else { return };
    let layered = plan(&target(4), &draw(4, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#));
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(GREEN)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &layered, Some(&squares));
    let target = import(&gpu, &layered, "target");
    let mut rejected = |view: &str| {
        let result = play(&gpu, &mut executor, Some(&squares), &target, &frame(&["0", view]));
        said(&result.expect_err("a diagnostic"))
    };
    let wanted = "view 1 of \"squares\" is drawn into layer 4 of 4";
    assert_eq!(rejected("4"), [("UG0807", wanted.to_owned())]);
    let wanted = "view 1 of \"squares\" is drawn into 4 by 4 texels from 5, 0 on, of 8 by 8";
    assert_eq!(rejected("0 5 0 4 4"), [("UG0807", wanted.to_owned())]);
    assert_eq!(rejected("0 4294967295 0 4294967295 1").len(), 1);
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["3"]));
    assert_eq!(color(&gpu, &target, 3), [0, 255, 0, 255]);
}
