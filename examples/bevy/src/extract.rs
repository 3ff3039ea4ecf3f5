//! Bevy's entities in the render world: pipelines by camera, objects by mesh, lights. Nothing here is umbragraph's.

use std::ops::Range;

use bevy::camera::primitives::Aabb;
use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy::render::Extract;
use bevy::render::render_resource::{BufferUsages, RawBufferVec};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::sync_world::RenderEntity;

use crate::{Graph, Pipeline, Tint};

/// A directional light extracted from the Bevy world.
pub(crate) struct Sun {
    pub(crate) direction: [f64; 3],
    pub(crate) color: [f32; 3],
    pub(crate) illuminance: f32,
    pub(crate) casts_shadows: bool,
}

/// The data that a frame needs from the Bevy world.
#[derive(Resource)]
pub(crate) struct Scene {
    pub(crate) pipelines: EntityHashMap<umbragraph::Pipeline>,
    pub(crate) suns: Vec<Sun>,
    /// The minimum and maximum corner of the bounding box of all meshes, in metres; `None` without meshes.
    pub(crate) bounds: Option<[[f64; 3]; 2]>,
    pub(crate) index: u64,
    /// The objects, sorted by mesh: world matrix, matrix for normals, and colour of each.
    pub(crate) objects: RawBufferVec<[f32; 4]>,
    /// The meshes to draw, each with the range of its objects in `objects`.
    pub(crate) batches: Vec<(AssetId<Mesh>, Range<u32>)>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            pipelines: EntityHashMap::default(),
            suns: Vec::new(),
            bounds: None,
            index: 0,
            objects: RawBufferVec::new(BufferUsages::STORAGE),
            batches: Vec::new(),
        }
    }
}

pub(crate) fn extract(
    mut scene: ResMut<Scene>,
    pipelines: Extract<Res<Assets<Pipeline>>>,
    cameras: Extract<Query<(RenderEntity, &Graph)>>,
    meshes: Extract<Query<(&Mesh3d, &Tint, &GlobalTransform, &Aabb)>>,
    lights: Extract<Query<(&DirectionalLight, &GlobalTransform)>>,
) {
    let loaded = |(camera, graph): (_, &Graph)| Some((camera, pipelines.get(&graph.0)?.0.clone()));
    scene.pipelines = cameras.iter().filter_map(loaded).collect();
    let sun = |(light, transform): (&DirectionalLight, &GlobalTransform)| Sun {
        direction: transform.forward().to_array().map(f64::from),
        color: light.color.to_linear().to_f32_array_no_alpha(),
        illuminance: light.illuminance,
        casts_shadows: light.shadow_maps_enabled,
    };
    scene.suns = lights.iter().map(sun).collect();
    let corners = meshes.iter().flat_map(|(_, _, transform, aabb)| {
        let signs =
            (0..8_u8).map(|at| Vec3::from([0, 1, 2].map(|axis| f32::from(at >> axis & 1) * 2.0 - 1.0)));
        signs.map(|signs| {
            transform.transform_point(Vec3::from(aabb.center) + signs * Vec3::from(aabb.half_extents))
        })
    });
    let bounds = corners.fold(None, |bounds, corner| {
        let [min, max] = bounds.unwrap_or([corner; 2]);
        Some([min.min(corner), max.max(corner)])
    });
    scene.bounds = bounds.map(|corners: [Vec3; 2]| corners.map(|corner| corner.to_array().map(f64::from)));
    scene.index += 1;

    let mut sorted: Vec<_> = meshes.iter().collect();
    sorted.sort_by_key(|(mesh, ..)| mesh.id());
    let Scene { objects, batches, .. } = &mut *scene;
    objects.clear();
    batches.clear();
    for (at, (mesh, tint, transform, _)) in (0..).zip(sorted) {
        let world = transform.to_matrix();
        objects.values_mut().extend(world.to_cols_array_2d());
        objects.values_mut().extend(world.inverse().transpose().to_cols_array_2d());
        objects.push(tint.0.to_linear().to_f32_array());
        match batches.last_mut() {
            Some((last, instances)) if *last == mesh.id() => instances.end = at + 1,
            _ => batches.push((mesh.id(), at..at + 1)),
        }
    }
}

pub(crate) fn upload(mut scene: ResMut<Scene>, device: Res<RenderDevice>, queue: Res<RenderQueue>) {
    let room = scene.objects.len().next_power_of_two().max(1024);
    scene.objects.reserve(room, &device);
    scene.objects.write_buffer(&device, &queue);
}
