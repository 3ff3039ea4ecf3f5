//! Blackboard data in tests: what a CPU pass publishes, and the bytes that a shader's block gets of it.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::data::BlackboardData;
use umbragraph::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::low_level::compiler::CpuPasses;
use umbragraph::work::{BoundSlot, Work};

/// A camera at eye level under a sun, over ten metres of things on a plain.
pub fn sunny_frame() -> FrameInput {
    let bounds =
        Bounds { min: glam::DVec3::new(-300.0, 0.0, -300.0), max: glam::DVec3::new(300.0, 10.0, 300.0) };
    FrameInput::new(Camera::new(
        glam::DVec3::new(3.0, 1.7, 11.0),
        glam::DQuat::from_rotation_y(0.4),
        Projection::Perspective { vertical_fov: 0.9, near: 0.1, far: 1000.0 },
        1.5,
    ))
    .lights(vec![
        Light::new("sun", LightKind::Directional)
            .direction(glam::DVec3::new(0.3, -0.8, -0.5).normalize())
            .color(glam::Vec3::new(1.0, 0.75, 0.5))
            .intensity(4.0)
            .property("cast_shadow")
            .angular_diameter(0.5_f32.to_radians()),
    ])
    .filter_bounds("casters", bounds)
    .scene_bounds(bounds)
}

/// A light of the colour of the sun.
fn lamp(name: String, kind: LightKind) -> Light {
    Light::new(name, kind).color([1.0, 0.75, 0.5]).property("cast_shadow")
}

/// The same light by another name.
fn named(mut light: Light, name: String) -> Light {
    light.name = name.into();
    light
}

/// The same place with more lights of every kind than most pipelines have room for.
pub fn crowded_frame() -> FrameInput {
    let mut frame = sunny_frame();
    // They do not say how large they are seen.
    let point = frame.lights[0].clone().angular_diameter(0.0);
    frame.lights.extend((1..6).map(|at| named(point.clone(), format!("sun {at}"))));
    let near = frame.camera.position - glam::DVec3::new(1.0, 0.0, 2.0);
    for at in 0..240 {
        let position = near + glam::DVec3::new(0.1 * f64::from(at % 20), 1.0, 0.0);
        let light = |name: String, kind: LightKind| {
            let light = lamp(name, kind).position(position).intensity(5000.0).range(30.0);
            light.angular_diameter(0.5_f32.to_radians())
        };
        let spot = LightKind::Spot { inner_angle: 0.4, outer_angle: 0.8 };
        frame.lights.push(light(format!("spot {at}"), spot));
        if at < 20 {
            frame.lights.push(light(format!("lamp {at}"), LightKind::Point));
        }
    }
    frame
}

/// The same place with a spot near by and one far away.
pub fn quiet_frame() -> FrameInput {
    let mut frame = sunny_frame();
    let spot = |name: &str, distance: f64| {
        let ahead = frame.camera.rotation * glam::DVec3::new(0.0, 0.0, -distance);
        lamp(name.to_owned(), LightKind::Spot { inner_angle: 0.4, outer_angle: 0.8 })
            .position(frame.camera.position + ahead)
            .direction(frame.lights[0].direction)
            .intensity(500.0)
            .range(12.0)
            .angular_diameter(0.5_f32.to_radians())
    };
    let spots = [spot("near", 1.0), spot("far", 400.0)];
    frame.lights.extend(spots);
    frame
}

/// The data that a CPU pass publishes for a frame, planned again with the sizes that it wants.
#[track_caller]
pub fn published(plan: &Plan, pass: &str, frame: &FrameInput) -> BlackboardData {
    let mut passes = CpuPasses::new(Arc::new(plan.clone()));
    passes.run(frame, &[]).expect("data as declared");
    if let Some(sizes) = passes.wanted_sizes() {
        let mut again = plan.clone();
        again.data_sizes = sizes;
        passes.set_plan(Arc::new(again));
        passes.run(frame, &[]).expect("data as declared");
    }
    let pipeline = &plan.pipeline;
    let handle = pipeline.find_pass(pass).unwrap_or_else(|| panic!("there is no pass {pass}"));
    let Work::Cpu(cpu) = pipeline.pass(handle).work() else { panic!("{pass} is no CPU pass") };
    passes.data(&pipeline.resource(cpu.output.resource).name).expect("published data").clone()
}

/// The numbers of a published value.
#[track_caller]
pub fn floats(data: &BlackboardData, name: &str) -> Vec<f32> {
    data.words(name).unwrap_or_else(|| panic!("no {name}")).iter().map(|word| f32::from_bits(*word)).collect()
}

/// The slots of a pass.
pub fn slots(work: &Work) -> &[BoundSlot] {
    match work {
        Work::Render(render) => render.draw.bound().1,
        Work::Compute(compute) => &compute.bindings,
        Work::Nothing | Work::Cpu(_) | Work::Transfer(_) => &[],
    }
}

/// The bytes of a block of blackboard data and values as a pass uploads it.
#[track_caller]
pub fn packed(plan: &Plan, pass: &str, block: &str, data: &BlackboardData) -> Vec<u8> {
    let planned = plan.passes.iter().find(|planned| planned.name == pass).expect("a live pass");
    let work = plan.pipeline.pass(planned.handle).work();
    let slot = slots(work).iter().find(|slot| slot.name == block).expect("a slot");
    let program = match work {
        Work::Render(render) => render.draw.bound().0,
        Work::Compute(compute) => compute.program,
        Work::Nothing | Work::Cpu(_) | Work::Transfer(_) => panic!("{pass} has no shader"),
    };
    let layout = plan.pipeline.block_layout(plan.pipeline.program(program), slot).expect("blackboard data");
    let values =
        planned.blocks.iter().find(|packed| (packed.group, packed.binding) == (slot.group, slot.binding));
    let mut bytes = values.map_or_else(|| vec![0; layout.size as usize], |values| values.bytes.clone());
    layout.pack(data, &mut bytes);
    bytes
}
