use glam::{DQuat, DVec3};
use std::path::Path;
use std::sync::Arc;
use umbragraph_pipeline::frame::Bounds;
use umbragraph_test_support::gpu::{self, Gpu};

use super::*;
use crate::mesh::Primitive;
use crate::morph::MorphTarget;
use crate::node::{Node, NodeId};

/// The vertex streams of a scene, and the [`Skinning`] that writes positions and normals.
struct Streams {
    geometry: Geometry,
    skinning: Skinning,
}

impl Streams {
    fn new(gpu: &Gpu, scene: &Scene) -> Self {
        let geometry = Geometry::new(&gpu.device, scene);
        Self { skinning: Skinning::new(&gpu.device, scene, &geometry), geometry }
    }

    fn is_on_device(&self) -> bool {
        self.skinning.device.is_some()
    }

    /// Writes a pose, and reads back all positions (in metres) and normals.
    fn in_pose(&mut self, gpu: &Gpu, scene: &Scene, pose: &Pose) -> [Vec<f32>; 2] {
        self.skinning.write(&gpu.queue, &self.geometry, scene, pose);
        [&self.geometry.positions, &self.geometry.normals].map(|stream| read(gpu, stream))
    }
}

fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<f32> {
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    copy.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("a mapped buffer"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    let mapped = copy.slice(..).get_mapped_range().expect("a mapped buffer");
    bytemuck::cast_slice(&mapped).to_vec()
}

/// A device, and a second one of the same adapter with too few storage buffers, so that the CPU skins vertices for it.
/// `None` without an adapter.
fn devices() -> Option<[Gpu; 2]> {
    let gpu = gpu::device()?;
    let few = wgpu::Limits { max_storage_buffers_per_shader_stage: 3, ..gpu.device.limits() };
    let other = gpu.with_limits(few);
    Some([gpu, other])
}

fn figure() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/figure.glb");
    crate::load(&path).expect("a scene")
}

/// Asserts that the device computes the same vertices as the CPU in each pose. Returns the largest difference of a
/// coordinate, relative to the largest coordinate.
#[track_caller]
fn assert_alike(scene: &Scene, poses: &[Pose]) -> f64 {
    let Some(gpus) = devices() else { return 0.0 };
    let [mut device, mut host] = gpus.each_ref().map(|gpu| Streams::new(gpu, scene));
    assert!(device.is_on_device() && !host.is_on_device());
    let mut farthest = 0.0_f64;
    let mut seen: Vec<Vec<f32>> = Vec::new();
    for pose in poses {
        let [positions, normals] = device.in_pose(&gpus[0], scene, pose);
        let [wanted, wanted_normals] = host.in_pose(&gpus[1], scene, pose);
        let max = wanted.iter().fold(1.0_f32, |max, value| max.max(value.abs()));
        for (found, wanted) in positions.iter().zip(&wanted) {
            farthest = farthest.max(f64::from((found - wanted).abs() / max));
        }
        assert!(farthest < 1e-5, "positions are {farthest} of {max} m off");
        for (at, (found, wanted)) in normals.iter().zip(&wanted_normals).enumerate() {
            assert!((found - wanted).abs() < 1e-4, "normal {}: {found}, not {wanted}", at / 3);
        }
        assert!(!seen.contains(&wanted), "poses are alike");
        seen.push(wanted);
    }
    farthest
}

#[test]
fn the_device_moves_the_figure_as_the_processor_does() {
    let scene = figure();
    let poses: Vec<Pose> = [0.0, 0.3, 1.2, 2.7].map(|time| scene.pose(time)).into();
    println!("the figure: {:.1e} of the largest coordinate", assert_alike(&scene, &poses));
}

/// The figure three times in one scene, each with its own skin: unchanged, scaled unevenly and far from the origin, and
/// mirrored and almost flat.
fn crowd() -> Scene {
    let mut scene = figure();
    let skinned: Vec<Draw> = scene.draws().filter(|draw| draw.skin.is_some()).collect();
    let far = DMat4::from_scale_rotation_translation(
        DVec3::new(0.3, 2.0, 1.0),
        DQuat::from_rotation_x(0.7),
        DVec3::new(900.0, 3.0, -400.0),
    );
    for transform in [far, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1e-3))] {
        for draw in &skinned {
            let mut skin = scene.skins[draw.skin.expect("a skin")].clone();
            for (at, inverse_bind) in skin.inverse_bind.iter_mut().enumerate() {
                *inverse_bind = *inverse_bind * transform * DMat4::from_rotation_z(0.05 * at as f64);
            }
            let skin_index = Some(scene.skins.len());
            scene.skins.push(skin);
            let node = NodeId(scene.nodes.len() as u32);
            scene.nodes.push(Node { skin: skin_index, ..scene.nodes[draw.node.index()].clone() });
            scene.draws.push(Draw { node, skin: skin_index, ..*draw });
            scene.finest += 1;
        }
    }
    scene
}

#[test]
fn skinning_holds_under_uneven_scale_mirror_and_distance() {
    let scene = crowd();
    let poses: Vec<Pose> = [0.0, 1.2].map(|time| scene.pose(time)).into();
    println!("changed joints: {:.1e} of the largest coordinate", assert_alike(&scene, &poses));
}

/// A morph target that displaces every vertex by `by`, in metres.
fn target(primitive: &Primitive, by: [f32; 3]) -> MorphTarget {
    let bounds = Bounds { min: DVec3::ZERO, max: DVec3::from_array(by.map(f64::from)) };
    MorphTarget { positions: vec![by; primitive.positions.len()], normals: Vec::new(), bounds }
}

#[test]
fn joints_move_morphed_vertices_others_morph_in_place() {
    let (mut morphed, mut modelled) = (figure(), figure());
    for mesh in Arc::make_mut(&mut morphed.meshes) {
        mesh.primitives.iter_mut().for_each(|one| one.targets = vec![target(one, [0.0, 0.5, 0.25])]);
    }
    morphed.nodes.iter_mut().filter(|node| node.mesh.is_some()).for_each(|node| node.weights = vec![2.0]);
    for position in Arc::make_mut(&mut modelled.meshes)
        .iter_mut()
        .flat_map(|mesh| &mut mesh.primitives)
        .flat_map(|one| &mut one.positions)
    {
        *position = [position[0], position[1] + 1.0, position[2] + 0.5];
    }
    let Some([gpu, _]) = devices() else { return };
    let [mut found, mut wanted] = [&morphed, &modelled].map(|scene| Streams::new(&gpu, scene));
    assert!(!found.is_on_device() && wanted.is_on_device());
    for time in [0.0, 1.2] {
        let [positions, normals] = found.in_pose(&gpu, &morphed, &morphed.pose(time));
        let [expected, expected_normals] = wanted.in_pose(&gpu, &modelled, &modelled.pose(time));
        // Static draws follow in another order: each has vertices of its own.
        let skinned = 3 * wanted.geometry.skinned_vertices as usize;
        assert!(skinned > 0);
        for (found, wanted) in positions[..skinned].iter().zip(&expected) {
            assert!((found - wanted).abs() < 1e-4, "{found}, not {wanted}");
        }
        for (found, wanted) in normals[..skinned].iter().zip(&expected_normals) {
            assert!((found - wanted).abs() < 1e-4, "{found}, not {wanted}");
        }
    }
    // The ground stands where it is, half a metre higher at half the weight.
    let ground =
        morphed.draws().enumerate().find(|(_, draw)| draw.skin.is_none()).expect("a draw without joints");
    let first = found.geometry.part(&morphed, ground.0, ground.1).expect("a part").first_vertex as usize;
    let heights = |weight: f32, scene: &mut Scene, streams: &mut Streams| {
        scene.nodes[ground.1.node.index()].weights = vec![weight];
        streams.in_pose(&gpu, scene, &scene.pose(0.0))[0][3 * first + 1]
    };
    let rest = morphed.primitive(ground.1).positions[0][1];
    assert_eq!(heights(0.0, &mut morphed, &mut found), rest);
    assert_eq!(heights(1.0, &mut morphed, &mut found), rest + 0.5);
}
