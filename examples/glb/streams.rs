//! The binary side of a document: vertices, indices and key frames.
//!
//! All values of one kind lie in one buffer view, with an accessor for each primitive. Coordinates are rounded to a
//! grid, then equal vertices of a primitive are merged. Indices have 16 bits where they can.

use std::collections::BTreeMap;

use super::json::{Object, array, numbers, string};
use super::shape::Shape;

/// The grid to which coordinates are rounded, in metres: about an eighth of a millimetre, exact in binary.
const GRID: f64 = 1.0 / 8192.0;

const POSITIONS: usize = 0;
const NORMALS: usize = 1;
const TEXCOORDS: usize = 2;
const INDICES: usize = 3;
const JOINTS: usize = 4;
const OTHERS: usize = 5;

/// A buffer view: its bytes, its stride in bytes, and its target as a glTF constant.
pub(crate) type View<'a> = (&'a [u8], Option<usize>, Option<u32>);

/// The skinning of a vertex: two joint indices, and the weight of the second joint from 0 to 1.
pub(crate) type Weight = (u8, u8, f64);

/// The binary data under construction, and the JSON of the accessors that read it.
#[derive(Default)]
pub(crate) struct Streams {
    pub(crate) accessors: Vec<String>,
    /// The bytes of each buffer view: positions, normals, texture coordinates, indices, joints with weights, and all
    /// other data.
    streams: [Vec<u8>; 6],
}

impl Streams {
    /// The buffer views, one for each stream. A view may not be empty, so an unused stream has four zero bytes.
    pub(crate) fn views(&self) -> impl Iterator<Item = View<'_>> {
        const VERTICES: Option<u32> = Some(34_962);
        let layout = [
            (Some(12), VERTICES),
            (Some(12), VERTICES),
            (Some(8), VERTICES),
            (None, Some(34_963)),
            (Some(4), VERTICES),
            (None, None),
        ];
        self.streams.iter().zip(layout).map(|(stream, (stride, target))| {
            if stream.is_empty() { (&[0; 4][..], None, None) } else { (&stream[..], stride, target) }
        })
    }

    /// Adds a primitive and returns its JSON.
    pub(crate) fn primitive(
        &mut self,
        material: usize,
        textured: bool,
        shape: &Shape,
        weights: Option<&[Weight]>,
    ) -> String {
        let mut known = BTreeMap::new();
        let mut remap = Vec::with_capacity(shape.vertices.len());
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut unique: Vec<usize> = Vec::new();
        for (at, vertex) in shape.vertices.iter().enumerate() {
            let grid = |value: f64, step: f64| (value / step).round() as i64;
            let position = vertex.position.to_array().map(|value| grid(value, GRID));
            let normal = vertex.normal.to_array().map(|value| grid(value, 1.0 / 16_384.0));
            let texcoord =
                if textured { vertex.texcoord.map(|value| grid(value, 1.0 / 4096.0)) } else { [0; 2] };
            let joints = weights.map(|weights| {
                let (first, second, weight) = weights[at];
                (first, second, grid(weight, 1.0 / 255.0))
            });
            let index = *known.entry((position, normal, texcoord, joints)).or_insert_with(|| {
                unique.push(at);
                let floats = |stream: &mut Vec<u8>, values: &[i64], step: f64| {
                    stream.extend(
                        values.iter().flat_map(|value| ((*value as f64 * step) as f32).to_le_bytes()),
                    );
                };
                floats(&mut self.streams[POSITIONS], &position, GRID);
                floats(&mut self.streams[NORMALS], &normal, 1.0 / 16_384.0);
                if textured {
                    floats(&mut self.streams[TEXCOORDS], &texcoord, 1.0 / 4096.0);
                }
                for (axis, value) in position.into_iter().enumerate() {
                    low[axis] = low[axis].min(value as f64 * GRID);
                    high[axis] = high[axis].max(value as f64 * GRID);
                }
                unique.len() - 1
            });
            remap.push(index);
        }
        let count = unique.len();
        let indices: Vec<usize> =
            shape.triangles.iter().flat_map(|triangle| triangle.map(|index| remap[index as usize])).collect();
        let bounded = |accessor: Object| accessor.with("min", exact(&low)).with("max", exact(&high));
        let mut attributes = Object::default()
            .with("POSITION", self.accessor(POSITIONS, count * 12, count, 5126, "VEC3", bounded))
            .with("NORMAL", self.accessor(NORMALS, count * 12, count, 5126, "VEC3", plain));
        if textured {
            let texcoords = self.accessor(TEXCOORDS, count * 8, count, 5126, "VEC2", plain);
            attributes = attributes.with("TEXCOORD_0", texcoords);
        }
        if let Some(weights) = weights {
            let chosen: Vec<(u8, u8, u8)> = unique
                .iter()
                .map(|at| (weights[*at].0, weights[*at].1, (weights[*at].2 * 255.0).round() as u8))
                .collect();
            self.streams[JOINTS].extend(chosen.iter().flat_map(|(first, second, _)| [*first, *second, 0, 0]));
            let joints = self.accessor(JOINTS, count * 4, count, 5121, "VEC4", plain);
            self.streams[JOINTS]
                .extend(chosen.iter().flat_map(|(_, _, weight)| [255 - weight, *weight, 0, 0]));
            let normalized = |accessor: Object| accessor.with("normalized", true);
            let weights = self.accessor(JOINTS, count * 4, count, 5121, "VEC4", normalized);
            attributes = attributes.with("JOINTS_0", joints).with("WEIGHTS_0", weights);
        }
        let (width, kind) = if count <= 65_535 { (2, 5123) } else { (4, 5125) };
        let stream = &mut self.streams[INDICES];
        stream.resize(stream.len().next_multiple_of(4), 0);
        for index in &indices {
            stream.extend(&(*index as u32).to_le_bytes()[..width]);
        }
        let indices = self.accessor(INDICES, indices.len() * width, indices.len(), kind, "SCALAR", plain);
        Object::default()
            .with("attributes", attributes.json())
            .with("indices", indices)
            .with("material", material)
            .json()
    }

    /// Adds an accessor for the last `bytes` bytes of a stream and returns its index. `more` adds members to its JSON.
    fn accessor(
        &mut self,
        stream: usize,
        bytes: usize,
        count: usize,
        component: u32,
        kind: &str,
        more: impl Fn(Object) -> Object,
    ) -> usize {
        let accessor = Object::default()
            .with("bufferView", stream)
            .with("byteOffset", self.streams[stream].len() - bytes)
            .with("componentType", component)
            .with("count", count)
            .with("type", string(kind));
        self.accessors.push(more(accessor).json());
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats that are not vertices (key times, values, matrices) and returns its index. Key times
    /// get a minimum and a maximum.
    pub(crate) fn floats(&mut self, values: &[f64], parts: usize, kind: &str) -> usize {
        let stream = &mut self.streams[OTHERS];
        stream.extend(values.iter().flat_map(|value| (((value * 1e6).round() / 1e6) as f32).to_le_bytes()));
        let bounded = |accessor: Object| match (kind, values.first(), values.last()) {
            ("SCALAR", Some(first), Some(last)) => {
                accessor.with("min", numbers(&[*first])).with("max", numbers(&[*last]))
            }
            _ => accessor,
        };
        self.accessor(OTHERS, values.len() * 4, values.len() / parts, 5126, kind, bounded)
    }
}

/// A JSON array of numbers without rounding, for values that are exact in binary.
fn exact(values: &[f64]) -> String {
    array(values.iter().map(|value| format!("{}", value + 0.0)))
}

/// Returns an accessor unchanged, for accessors without further members.
fn plain(accessor: Object) -> Object {
    accessor
}
