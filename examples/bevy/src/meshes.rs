//! Bevy's meshes for the draw contract: vertices and indices in Bevy's slabs, objects in an array by instance. All
//! entities of one mesh are one draw.

use bevy::render::mesh::{RenderMesh, RenderMeshBufferInfo, allocator::MeshAllocator};
use bevy::render::render_asset::RenderAssets;
use umbragraph::data::ValueType;
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, HostResource, HostVertexBuffer};
use umbragraph::wgpu::{BindingResource, VertexFormat::Float32x2, VertexFormat::Float32x3};

use crate::extract::Scene;

/// The size of a vertex in bytes: position, normal and texture coordinates.
const STRIDE: u64 = 32;

/// The layout of vertices in Bevy's buffers, and of objects in the buffer of this plugin.
pub(crate) fn interface() -> HostInterface {
    let vertex = [("position", Float32x3, 0), ("normal", Float32x3, 12), ("texcoord", Float32x2, 24)];
    let matrices = [("world_from_object", ValueType::MAT4, 0), ("normal_from_object", ValueType::MAT4, 64)];
    let object = matrices.into_iter().chain([("color", ValueType::VEC4, 128)]);
    HostInterface::new()
        .vertices(HostVertexBuffer::new(STRIDE, vertex))
        .object(HostResource::array("objects", 144, object))
        .any_filter()
}

/// The meshes of a frame, as the draw source of its pipeline.
pub(crate) struct Meshes<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) allocator: &'a MeshAllocator,
    pub(crate) meshes: &'a RenderAssets<RenderMesh>,
}

impl DrawSource for Meshes<'_> {
    // The buffer is another when it has grown.
    fn generation(&self) -> u64 {
        self.scene.objects.capacity() as u64
    }

    fn object(&self, _: &str) -> Option<BindingResource<'_>> {
        self.scene.objects.binding()
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        let pass = pass.render_pass();
        for (id, instances) in &self.scene.batches {
            let mesh = self.meshes.get(*id).filter(|mesh| mesh.layout.0.layout().array_stride == STRIDE);
            let (Some(mesh), Some(vertices)) = (mesh, self.allocator.mesh_vertex_slice(id)) else { continue };
            pass.set_vertex_buffer(0, *vertices.buffer.slice(..));
            match (&mesh.buffer_info, self.allocator.mesh_index_slice(id)) {
                (RenderMeshBufferInfo::Indexed { count, index_format }, Some(indices)) => {
                    let (first, base) = (indices.range.start, vertices.range.start as i32);
                    pass.set_index_buffer(*indices.buffer.slice(..), *index_format);
                    pass.draw_indexed(first..first + count, base, instances.clone());
                }
                _ => pass.draw(vertices.range, instances.clone()),
            }
        }
    }
}
