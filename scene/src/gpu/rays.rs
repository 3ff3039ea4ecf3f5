//! The scene's triangles in a storage buffer, for pipelines that trace rays.
//!
//! Nothing is packed and nothing uploaded until a plan imports the buffer [`BUFFER`]. Then each pose that moves something
//! places those draws anew on the CPU, fits the boxes, and writes the blocks of 4 KiB that have changed.

use std::sync::OnceLock;

use umbragraph_executor::wgpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::interface::RAYS as BUFFER;
use crate::pose::Pose;
use crate::scene::{Draw, Scene};
use crate::trace::PackedScene;

/// The storage buffer with the scene's triangles for ray tracing, created when a pipeline first imports it.
pub(super) struct Rays {
    device: wgpu::Device,
    scene: Scene,
    made: OnceLock<Result<Made, String>>,
}

struct Made {
    packed: PackedScene,
    buffer: wgpu::Buffer,
}

impl Rays {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene) -> Self {
        Self { device: device.clone(), scene: scene.clone(), made: OnceLock::new() }
    }

    /// The buffer for ray tracing, created for `pose` on first use. `None` if `name` is not [`BUFFER`]; an error
    /// message if the buffer would be too large for the device.
    pub(super) fn buffer(&self, name: &str, pose: &Pose) -> Option<Result<&wgpu::Buffer, String>> {
        if name != BUFFER {
            return None;
        }
        let made = self.made.get_or_init(|| Made::new(&self.device, &self.scene, pose));
        Some(made.as_ref().map(|made| &made.buffer).map_err(Clone::clone))
    }

    /// Updates the triangles of the draws for which `moved` returns `true`. Does nothing if the buffer has not been
    /// created.
    pub(super) fn follow(&mut self, queue: &wgpu::Queue, pose: &Pose, moved: impl Fn(Draw) -> bool) {
        if let Some(Ok(Made { packed, buffer })) = self.made.get_mut() {
            packed.follow(&self.scene, pose, moved);
            packed.changes(|offset, bytes| queue.write_buffer(buffer, offset, bytes));
        }
    }
}

impl Made {
    fn new(device: &wgpu::Device, scene: &Scene, pose: &Pose) -> Result<Self, String> {
        let limits = device.limits();
        let max = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let packed = PackedScene::new(scene, pose, max).map_err(|error| format!("{error} of the device"))?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let label = Some("scene rays");
        let buffer =
            device.create_buffer_init(&BufferInitDescriptor { label, contents: packed.bytes(), usage });
        Ok(Self { packed, buffer })
    }
}
