//! Host data in tests: what a host pass publishes, and the bytes that a shader's block gets of it.

use umbragraph::compiler::Plan;
use umbragraph::data::HostData;
use umbragraph::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::pipeline::ResourceKind;
use umbragraph::work::{BoundSlot, Draw, HostContext, SlotSource, Work};

/// A camera at eye level under a sun, over ten metres of things on a plain.
pub fn sunny_frame() -> FrameInput {
    let bounds = Bounds {
        minimum: glam::DVec3::new(-300.0, 0.0, -300.0),
        maximum: glam::DVec3::new(300.0, 10.0, 300.0),
    };
    FrameInput {
        camera: Camera {
            position: glam::DVec3::new(3.0, 1.7, 11.0),
            rotation: glam::DQuat::from_rotation_y(0.4),
            projection: Projection::Perspective { vertical_fov: 0.9, near: 0.1, far: 1000.0 },
            aspect: 1.5,
        },
        lights: vec![Light {
            name: "sun".into(),
            kind: LightKind::Directional,
            position: glam::DVec3::ZERO,
            direction: glam::DVec3::new(0.3, -0.8, -0.5).normalize(),
            color: glam::Vec3::new(1.0, 0.75, 0.5),
            intensity: 4.0,
            range: f32::INFINITY,
            cast_shadow: true,
            angular_diameter_deg: 0.5,
            radius: 0.0,
            priority: 1.0,
        }],
        caster_bounds: bounds,
        scene_bounds: bounds,
        time: 0.0,
        index: 0,
    }
}

/// What a host pass publishes for a frame.
#[track_caller]
pub fn published(plan: &Plan, pass: &str, frame: &FrameInput) -> HostData {
    let pipeline = &plan.pipeline;
    let handle = pipeline.find_pass(pass).unwrap_or_else(|| panic!("there is no pass {pass}"));
    let Work::Host(host) = &pipeline.pass(handle).work else { panic!("{pass} is no host pass") };
    let ResourceKind::Data(Some(shape)) = &pipeline.resource(host.output).kind else {
        panic!("nothing is published")
    };
    let mut data = HostData::new(shape.clone());
    host.node.run(&HostContext { frame, inputs: &[] }, &mut data);
    assert_eq!(data.refused(), None);
    data
}

/// The numbers of a published value.
#[track_caller]
pub fn floats(data: &HostData, name: &str) -> Vec<f32> {
    data.words(name).unwrap_or_else(|| panic!("no {name}")).iter().map(|word| f32::from_bits(*word)).collect()
}

/// The slots of a pass.
pub fn slots(work: &Work) -> &[BoundSlot] {
    match work {
        Work::Render(render) => match &render.draw {
            Draw::Fullscreen { bindings, .. } => bindings,
            Draw::Scene(scene) => &scene.bindings,
        },
        Work::Compute(compute) => &compute.bindings,
        Work::Host(_) | Work::Copy(_) | Work::Transfer(_) => &[],
    }
}

/// The bytes of a block of host data and values as a pass uploads it.
#[track_caller]
pub fn packed(plan: &Plan, pass: &str, block: &str, data: &HostData) -> Vec<u8> {
    let planned = plan.passes.iter().find(|planned| planned.name == pass).expect("a live pass");
    let slot = slots(&plan.pipeline.pass(planned.handle).work)
        .iter()
        .find(|slot| slot.name == block)
        .expect("a slot");
    let SlotSource::Data { layout, .. } = &slot.source else { panic!("{block} takes no host data") };
    let values =
        planned.blocks.iter().find(|packed| (packed.group, packed.binding) == (slot.group, slot.binding));
    let mut bytes = values.map_or_else(|| vec![0; layout.size as usize], |values| values.bytes.clone());
    layout.pack(data, &mut bytes);
    bytes
}
