//! Vertices and indices of a scene in buffers.
//!
//! All primitives share one buffer for each stream. A static primitive is stored once, however often it is placed;
//! each draw that joints or morph targets move has a range of its own, which is written when the pose changes
//! ([`super::skinning`]). Those of skinned draws come first, so that a storage binding of them is no larger than they are;
//! then those of morphed ones, so that a buffer of previous positions ends there. All other vertices have the
//! positions of now as their previous ones.

use glam::{DMat3, DMat4};
use std::collections::BTreeMap;
use std::ops::Range;
use umbragraph_executor::wgpu;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::codes;
use crate::interface::{BLOCK_STRIDE, PREVIOUS, STREAMS};
use crate::mesh::VertexDetail;
use crate::scene::{Draw, Scene};

/// The vertex buffer slot of previous positions: the first slot after those that [`Geometry::bind`] sets.
const PREVIOUS_SLOT: u32 = STREAMS.len() as u32 + 1;

/// The ranges of a primitive in the vertex and index buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// The range of the primitive in the index buffer; index values are relative to `first_vertex`.
    pub(super) indices: Range<u32>,
    /// The index range of the same triangles with reversed winding, for mirrored draws.
    pub(super) mirrored: Range<u32>,
    /// The index of the primitive's first vertex in the vertex buffers.
    pub(super) first_vertex: i32,
}

/// The vertex and index buffers of a scene.
pub(super) struct Geometry {
    /// The vertex stream of positions. In all vertex streams, the vertices of skinned draws come first.
    pub(super) positions: wgpu::Buffer,
    pub(super) normals: wgpu::Buffer,
    /// The positions of skinned and morphed vertices in the previous pose.
    pub(super) previous: wgpu::Buffer,
    texcoords: wgpu::Buffer,
    /// The vertex stream of [`VertexDetail`]; it ends after the last vertex that has details.
    details: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// The buffer ranges by mesh index and primitive index. Each skinned or morphed draw has ranges of its own, whose
    /// key also contains the index of the draw.
    parts: BTreeMap<(usize, usize, Option<usize>), Part>,
    /// The number of vertices of all skinned draws, which come first in the buffers.
    pub(super) skinned_vertices: u32,
    /// The number of vertices of all skinned and morphed draws, which come first in the buffers.
    moved_vertices: u32,
}

/// The key of a draw in `Geometry::parts`: mesh index, primitive index, and for skinned or morphed draws the index
/// `number` of the draw.
fn key(scene: &Scene, number: usize, draw: Draw) -> (usize, usize, Option<usize>) {
    (draw.mesh, draw.primitive, scene.has_own_vertices(draw).then_some(number))
}

/// Checks that the buffers of a scene fit the limits of a device. Returns one diagnostic for each kind of data that is
/// too large for its buffer.
pub(super) fn check_limits(scene: &Scene, limits: &wgpu::Limits) -> Result<(), Diagnostics> {
    let (mut vertices, mut detailed, mut indices) = (0_u64, 0_u64, 0_u64);
    let mut known = std::collections::BTreeSet::new();
    for (number, draw) in scene.draws_of_all_details().enumerate() {
        if known.insert(key(scene, number, draw)) {
            let primitive = scene.primitive(draw);
            vertices += primitive.positions.len() as u64;
            if primitive.details.is_some() || scene.has_own_vertices(draw) {
                detailed += primitive.positions.len() as u64;
            }
            indices += scene.primitive(draw).indices.len() as u64 * 2;
        }
    }
    let mut diagnostics = Diagnostics::new();
    let blocks = scene.draws_of_all_details().len().max(scene.materials.len()) as u64;
    let needed = [
        ("vertices", vertices, vertices * 12, i32::MAX as u64),
        (
            "vertices with whole materials",
            detailed,
            detailed * size_of::<VertexDetail>() as u64,
            i32::MAX as u64,
        ),
        ("indices", indices, indices * 4, u64::from(u32::MAX)),
        (
            "objects and materials",
            blocks,
            blocks * u64::from(BLOCK_STRIDE),
            u64::from(u32::MAX / BLOCK_STRIDE),
        ),
    ];
    for (noun, count, bytes, max) in needed {
        if bytes > limits.max_buffer_size || count > max {
            let message = format!(
                "the {count} {noun} of the scene need {bytes} bytes, but a buffer of the device has at most {}",
                limits.max_buffer_size
            );
            let diagnostic = Diagnostic::in_file(codes::TOO_LARGE, &*scene.name, "", message);
            diagnostics.push(diagnostic.help("simplify the scene, or use a device with larger buffers"));
        }
    }
    if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
}

impl Geometry {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene) -> Self {
        let (mut positions, mut normals, mut texcoords) = (Vec::new(), Vec::new(), Vec::new());
        let mut details: Vec<VertexDetail> = Vec::new();
        let (mut indices, mut parts) = (Vec::<u32>::new(), BTreeMap::new());
        let (mut skinned_vertices, mut moved_vertices) = (0, 0);
        let mut draws: Vec<(usize, Draw)> = scene.draws_of_all_details().enumerate().collect();
        draws.sort_by_key(|(_, draw)| {
            let is_fixed = !scene.has_own_vertices(*draw);
            (draw.skin.is_none(), is_fixed, scene.primitive(*draw).details.is_none())
        });
        for (number, draw) in draws {
            parts.entry(key(scene, number, draw)).or_insert_with(|| {
                let primitive = scene.primitive(draw);
                let first_vertex = positions.len() as i32;
                normals.extend_from_slice(&primitive.normals);
                if let Some(own) = &primitive.details {
                    details.resize(positions.len(), VertexDetail::default());
                    // Tangents of vertices that move would have to move with them.
                    let is_fixed = !scene.has_own_vertices(draw);
                    let kept = |detail: &VertexDetail| VertexDetail {
                        tangent: if is_fixed { detail.tangent } else { [0.0; 4] },
                        ..*detail
                    };
                    details.extend(own.iter().map(kept));
                }
                positions.extend_from_slice(&primitive.positions);
                texcoords.extend_from_slice(&primitive.texcoords);
                let (start, count) = (indices.len() as u32, primitive.indices.len() as u32);
                indices.extend_from_slice(&primitive.indices);
                indices
                    .extend(primitive.indices.chunks_exact(3).flat_map(|face| [face[0], face[2], face[1]]));
                let (indices, mirrored) = (start..start + count, start + count..start + 2 * count);
                Part { indices, mirrored, first_vertex }
            });
            if draw.skin.is_some() {
                skinned_vertices = positions.len() as u32;
            }
            if scene.has_own_vertices(draw) {
                moved_vertices = positions.len() as u32;
            }
        }
        let buffer = |label: &str, contents: &[u8], usage: wgpu::BufferUsages| {
            // A buffer may not be empty, nor may a binding of it.
            let contents = if contents.is_empty() { &[0; 16] } else { contents };
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let vertices = wgpu::BufferUsages::VERTEX;
        let is_written = skinned_vertices > 0 && device.limits().max_storage_buffers_per_shader_stage > 0;
        let moved = if is_written { vertices | wgpu::BufferUsages::STORAGE } else { vertices };
        let moved =
            if moved_vertices > 0 || cfg!(test) { moved | wgpu::BufferUsages::COPY_SRC } else { moved };
        let label = |stream: usize| format!("scene {}", STREAMS[stream].0);
        Self {
            positions: buffer(&label(0), bytemuck::cast_slice(&positions), moved),
            normals: buffer(&label(1), bytemuck::cast_slice(&normals), moved),
            previous: buffer(
                "scene previous_position",
                bytemuck::cast_slice(&positions[..moved_vertices as usize]),
                vertices,
            ),
            texcoords: buffer(&label(2), bytemuck::cast_slice(&texcoords), vertices),
            details: buffer("scene details", bytemuck::cast_slice(&details), vertices),
            indices: buffer("scene indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            parts,
            skinned_vertices,
            moved_vertices,
        }
    }

    /// Copies the current positions of skinned and morphed vertices to the buffer of previous positions, in a command
    /// buffer that this function submits.
    pub(super) fn keep_positions(&self, device: &wgpu::Device, queue: &wgpu::Queue) {
        if self.moved_vertices > 0 {
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("scene previous positions") };
            let mut encoder = device.create_command_encoder(&descriptor);
            let bytes = u64::from(self.moved_vertices) * PREVIOUS.2;
            encoder.copy_buffer_to_buffer(&self.positions, 0, &self.previous, 0, bytes);
            queue.submit([encoder.finish()]);
        }
    }

    /// Returns `true` if the vertices of `part` are skinned or morphed, and so are in the buffer of previous positions.
    pub(super) fn has_previous(&self, part: &Part) -> bool {
        i64::from(part.first_vertex) < i64::from(self.moved_vertices)
    }

    /// Binds the buffer of previous positions, or the current positions in its place if `has_previous` is `false`.
    pub(super) fn bind_previous(&self, has_previous: bool, pass: &mut wgpu::RenderPass<'static>) {
        let stream = if has_previous { &self.previous } else { &self.positions };
        pass.set_vertex_buffer(PREVIOUS_SLOT, stream.slice(..));
    }

    /// The ranges of a draw in the buffers; `number` is the index of the draw in [`Scene::draws_of_all_details`].
    /// `None` if the buffers do not contain the draw.
    pub(super) fn part(&self, scene: &Scene, number: usize, draw: Draw) -> Option<&Part> {
        self.parts.get(&key(scene, number, draw))
    }

    /// Binds all vertex streams, except previous positions, and the index buffer.
    pub(super) fn bind(&self, pass: &mut wgpu::RenderPass<'static>) {
        for (slot, stream) in (0..).zip([&self.positions, &self.normals, &self.texcoords, &self.details]) {
            pass.set_vertex_buffer(slot, stream.slice(..));
        }
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
    }
}

/// The matrix that transforms normals: the cofactor matrix of `transform`, scaled to the range of `f32`. Unlike the
/// inverse transpose, the cofactor matrix exists for every transform, even a singular one.
pub(super) fn normal_matrix(transform: &DMat4) -> DMat3 {
    let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(glam::DVec4::truncate);
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let max = cofactors.to_cols_array().into_iter().fold(0.0_f64, |max, value| max.max(value.abs()));
    let sign = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
    if max > 0.0 && max.is_finite() { cofactors * (sign / max) } else { DMat3::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn normals_stay_perpendicular_under_uneven_scale_and_mirror() {
        let tangent = DVec3::new(1.0, -1.0, 0.0);
        for scale in [DVec3::new(4.0, 1.0, 1.0), DVec3::new(-4.0, 1.0, 2.0), DVec3::splat(1e-6)] {
            let transform = DMat4::from_rotation_y(0.4) * DMat4::from_scale(scale);
            let normal = normal_matrix(&transform) * DVec3::new(1.0, 1.0, 0.0);
            assert!(normal.dot(transform.transform_vector3(tangent)).abs() < 1e-9, "{scale}");
            assert!(normal.dot(transform.transform_vector3(DVec3::new(1.0, 1.0, 0.0))) > 0.0, "{scale}");
        }
    }

    #[test]
    fn a_transform_that_flattens_leaves_a_normal_that_is_finite() {
        let flat = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(normal_matrix(&flat) * DVec3::Y, DVec3::Y);
        assert_eq!(normal_matrix(&DMat4::ZERO), DMat3::IDENTITY);
    }

    /// A scene with `nodes` nodes that all draw the same triangle.
    fn scene(nodes: usize) -> Scene {
        let shown: Vec<_> = (0..nodes).collect();
        let nodes = vec![r#"{ "mesh": 0 }"#; nodes].join(", ");
        let rest = r#"
            "asset": { "version": "2.0" },
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
        }"#;
        let text = format!(r#"{{ "scenes": [{{ "nodes": {shown:?} }}], "nodes": [{nodes}], {rest}"#);
        crate::from_slice("many.gltf", text.as_bytes(), &crate::NoFiles).expect("a scene")
    }

    #[test]
    fn a_scene_that_no_buffer_of_a_device_holds_says_what_it_needs() {
        assert!(check_limits(&scene(300), &wgpu::Limits::default()).is_ok());
        let scene = scene(2);
        let told = |max_buffer_size: u64| -> Vec<String> {
            let limits = wgpu::Limits { max_buffer_size, ..wgpu::Limits::default() };
            let diagnostics = check_limits(&scene, &limits).err().unwrap_or_default();
            diagnostics.iter().map(|one| one.message.clone()).collect()
        };
        // Of each object 256 bytes, of each vertex 12, of each index 4, for both ways round.
        for (size, count) in [(512, 0), (511, 1), (36, 1), (35, 2), (24, 2), (23, 3)] {
            assert_eq!(told(size).len(), count, "{size}: {:?}", told(size));
        }
        let said = |what: &str| format!("the {what} bytes, but a buffer of the device has at most 23");
        assert_eq!(
            told(23),
            [
                said("3 vertices of the scene need 36"),
                said("6 indices of the scene need 24"),
                said("2 objects and materials of the scene need 512"),
            ]
        );
    }
}
