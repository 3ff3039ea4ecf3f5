//! A scene on the device, drawn through the engine's draw contract.
//!
//! [`SceneResources`] uploads a scene once: one buffer for each vertex stream and one for indices, one uniform block
//! for each material and each draw, textures with mip levels. Each frame, [`SceneResources::update`] writes what a pose
//! changes, and the executor asks for the draws of each view, which are culled against it.
//!
//! Draws are sorted once by properties, material and mesh, so that a view changes as little state as possible;
//! transparent draws are sorted for each view, farthest first. A node that mirrors its mesh uses a second index range
//! with reversed winding, so that front faces stay front faces.
//!
//! Each draw of a skinned mesh has its own vertices, which are transformed when the pose changes; every pass draws them
//! like any other mesh. The device transforms them, or the CPU if the device cannot ([`SceneResources::update`]).
//!
//! Pipelines that trace rays import the buffer [`RAYS`](crate::interface::RAYS): the triangles, and boxes around them
//! ([`crate::trace`]). It is made when a plan first asks for it.

mod draws;
mod geometry;
mod materials;
mod objects;
mod rays;
mod skinning;

use std::sync::Mutex;

use umbragraph_executor::wgpu;
use umbragraph_executor::{DrawPass, DrawSource};
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::draw::HostInterface;

use crate::interface::{GEOMETRY, interface};
use crate::pose::Pose;
use crate::scene::Scene;
use draws::Item;
use geometry::Geometry;
use materials::Materials;
use objects::Objects;
use rays::Rays;
use skinning::Skinning;

/// The vertex, uniform and texture resources of a scene on one device, as a source of draws for the executor.
pub struct SceneResources {
    interface: HostInterface,
    geometry: Geometry,
    materials: Materials,
    objects: Objects,
    skinning: Skinning,
    items: Vec<Item>,
    /// The pose in the buffers, and the number of updates in which a draw has moved.
    pose: (Pose, u64),
    /// A reused list for sorting the draws of a view: sort key (view depth in metres) and index in `items`.
    sorted: Mutex<Vec<(f64, u32)>>,
    rays: Rays,
}

impl std::fmt::Debug for SceneResources {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SceneResources").field("draws", &self.items.len()).finish_non_exhaustive()
    }
}

impl SceneResources {
    /// Uploads the geometry, materials and textures of a scene to a device, in a pose.
    ///
    /// # Errors
    /// Diagnostics if the scene needs larger buffers than the device supports.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        pose: &Pose,
    ) -> Result<Self, Diagnostics> {
        geometry::check_limits(scene, &device.limits())?;
        let geometry = Geometry::new(device, scene);
        let materials = Materials::new(device, queue, scene);
        let objects = Objects::new(device, scene);
        let skinning = Skinning::new(device, scene, &geometry);
        let items = draws::sorted_items(scene, &geometry);
        let sorted = Mutex::new(Vec::with_capacity(items.len()));
        let interface = interface(scene);
        let pose_held = (pose.clone(), 0);
        let rays = Rays::new(device, scene);
        let mut resources =
            Self { interface, geometry, materials, objects, skinning, items, pose: pose_held, sorted, rays };
        for item in &mut resources.items {
            item.place(scene, pose);
        }
        resources.objects.write_all(queue, scene, pose);
        resources.skinning.write(queue, &resources.geometry, scene, pose);
        resources.geometry.keep_positions(device, queue);
        Ok(resources)
    }

    /// Uploads a new pose: the transforms of draws that can move, and skinned or morphed vertices. `scene` must be the
    /// uploaded scene. Call this once in each frame, also if the pose has not changed: motion vectors are relative to
    /// the pose of the last call.
    ///
    /// Command buffers submitted later draw the new pose, even if they were recorded before this call. Compute
    /// dispatches, in a command buffer that this method submits, compute the skinned vertices. The CPU computes all
    /// morphed vertices. It also computes the skinned ones if the device's limits for compute are too low, such as
    /// fewer than four storage buffers in a stage.
    pub fn update(&mut self, queue: &wgpu::Queue, scene: &Scene, pose: &Pose) {
        let (held, moves) = &mut self.pose;
        self.objects.write_motion(queue, scene, held);
        *moves += u64::from(scene.draws_of_all_details().any(|draw| scene.moves(draw, held, pose)));
        self.rays.follow(queue, pose, |draw| scene.moves(draw, held, pose));
        held.clone_from(pose);
        for item in self.items.iter_mut().filter(|item| item.draw.dynamic) {
            item.place(scene, pose);
        }
        self.objects.write_dynamic(queue, scene, pose);
        self.skinning.write(queue, &self.geometry, scene, pose);
    }
}

impl DrawSource for SceneResources {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        (geometry == GEOMETRY).then_some(&self.interface)
    }

    fn revision(&self, filter: &str) -> Option<u64> {
        Some(if filter == "static_casters" { 0 } else { self.pose.1 })
    }

    fn material_count(&self) -> u32 {
        self.materials.count()
    }

    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.materials.binding(material, binding)
    }

    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.objects.binding(binding)
    }

    fn buffer(&self, name: &str) -> Option<Result<&wgpu::Buffer, String>> {
        self.rays.buffer(name, &self.pose.0)
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        if pass.geometry() == GEOMETRY {
            draws::record(&self.items, &self.geometry, &self.sorted, pass);
        }
    }
}
