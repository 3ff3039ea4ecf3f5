//! Hosts whose meshes change, or are not what the pipelines were built for.

use umbragraph::Executor;
use umbragraph::draw::{DrawSource, HostResourceKind};
use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, plan, play, said, show, target};
use crate::executing::views::frame;

const RED_TEXEL: [u8; 4] = [255, 0, 0, 255];

fn clearing() -> String {
    draw(8, r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#)
}

#[test]
fn another_generation_binds_again_and_the_same_does_not() {
    let Some(gpu) = gpu::device() else { return };
    let twice = draw(8, r#"{ "to": "&target@squares" }"#);
    let again = twice.split_once(r#""squares":"#).expect("a draw").1;
    let plan = plan(&target(1), &format!("{}, \"again\":{again}", clearing()));
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square([1.0; 4])], &[RED]);
    let other = Squares::new(&gpu.device, &gpu.queue, &[square([1.0; 4])], &[[0.0, 1.0, 0.0, 1.0]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), RED_TEXEL);
    squares.material_blocks = other.material_blocks.clone();
    let before = executor.statistics();
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(executor.statistics(), before);
    squares.generation += 1;
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), [0, 255, 0, 255]);
    // One material and the objects, which both passes bind.
    assert_eq!(executor.statistics().bind_groups, before.bind_groups + 2);
}

#[test]
fn a_missing_host_binding_is_named_and_the_next_frame_is_fine() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &clearing());
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    squares.lacks_material = true;
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    let diagnostics =
        play(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"])).expect_err("a diagnostic");
    let wanted = "the host gives nothing for \"material\" of material 0";
    assert_eq!(said(&diagnostics), [("UG0608", wanted.to_owned())]);
    squares.lacks_material = false;
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), RED_TEXEL);
}

#[test]
fn a_host_texture_for_a_block_is_a_diagnostic() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &clearing());
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    squares.confuses_material = true;
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    for _ in 0..2 {
        let diagnostics =
            play(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"])).expect_err("a diagnostic");
        assert_eq!(said(&diagnostics)[0].0, "UG0803");
    }
    squares.confuses_material = false;
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), RED_TEXEL);
}

#[test]
fn another_interface_wants_the_plan_again() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &clearing());
    let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    squares.interface.property_sets.truncate(1);
    let diagnostics =
        play(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"])).expect_err("a diagnostic");
    assert_eq!(said(&diagnostics)[0].0, "UG0608");
    executor.set_plan_and_source(plan.clone(), &squares).expect("a plan that fits");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), RED_TEXEL);
}

#[test]
fn own_materials_are_bound_only_if_a_shader_reads_them() {
    let Some(gpu) = gpu::device() else { return };
    let depth = r#""depth": { "texture": { "format": "depth32float", "size": "=viewport", "view_dimension": "2d-array" } }"#;
    let passes = r#""views": { "views": { "to": "&views", "max": 1 } },
        "squares": { "draw": { "geometry": "squares", "mesh_filter": "all", "views": "&views", "shader": "square_depth.wgsl.jinja",
            "depth": { "to": "&depth", "clear": 1, "compare": "less" } } },
        "show": { "fullscreen": { "shader": "show_depth.wgsl.jinja",
            "bind": { "settings": { "values": { "layer": 0 } }, "maps": "&depth" }, "color": [{ "to": "&target" }] } }"#;
    let plan = plan(&format!("{}, {depth}", target(1)), passes);
    let mut squares =
        Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]).drawing(|pass, corners| {
            pass.render_pass().set_vertex_buffer(0, corners.slice(..));
            pass.render_pass().draw(0..6, 0..1);
        });
    let block = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    squares.interface = squares.interface.material_layout([block]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &target, &frame(&["0"]));
    assert_eq!(color(&gpu, &target, 0), [128, 128, 128, 255]);
}

#[test]
fn a_frame_without_meshes_is_rejected_where_they_are_drawn() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan(&target(1), &clearing());
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let target = import(&gpu, &plan, "target");
    let diagnostics = play(&gpu, &mut executor, None, &target, &frame(&["0"])).expect_err("a diagnostic");
    let wanted = "\"squares\" draws meshes, but the host gave none";
    assert_eq!(said(&diagnostics), [("UG0608", wanted.to_owned())]);
}

#[test]
fn a_new_executor_finds_host_layouts_that_do_not_fit() {
    let Some(gpu) = gpu::device() else { return };
    let wrong = |change: &dyn Fn(&mut Squares), passes: &str| {
        let plan = plan(&target(1), passes);
        let mut squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
        change(&mut squares);
        let source: &dyn DrawSource = &squares;
        let made = Executor::new(&gpu.device, &gpu.queue, plan, Some(source));
        said(&made.err().expect("a diagnostic"))
    };
    let said = wrong(&|squares| squares.interface.vertex_buffers.clear(), &clearing());
    assert_eq!(said[0].0, "UG0608");
    assert!(said[0].1.contains("\"corner\""), "{said:?}");
    let stride = |squares: &mut Squares| {
        if let HostResourceKind::Block { stride, .. } = &mut squares.interface.object[0].kind {
            *stride = 100;
        }
    };
    let said = wrong(&stride, &clearing());
    assert_eq!(said[0].1, "the host's blocks \"object\" lie 100 bytes apart, which is no multiple of 256");
    let said = wrong(&|_| {}, &clearing().replace("\"all\"", "\"round\""));
    assert_eq!(said, [("UG0805", "the host knows no filter \"round\"".to_owned())]);
}
