//! Shadow descriptors: how a shader finds and measures one shadow map.
//!
//! Published in arrays, each element a descriptor; `count` says how many there are:
//!
//! | value | type | tile of an atlas, layer of an array | cube |
//! |---|---|---|---|
//! | `clip_from_world` | `mat4x4<f32>` | world to clip space | zero |
//! | `rectangle` | `vec4<f32>` | from its uv to the map's: scale x, y, offset x, y | position in the world; distance of the far planes |
//! | `reach` | `vec4<f32>` | where a cascade ends and where it begins to blend, along the view axis (else 0, 0); width of a texel (of a perspective at 1 m); 0 | a and b of the depth a + b / distance; width of a texel at 1 m; distance of the near planes |
//! | `place` | `vec4<u32>` | layer; texels on a side; 0, 0 | slot; texels on a side; 0, 0 |
//!
//! Lengths are metres.

use glam::{DMat4, DVec4, UVec2};
use umbragraph_pipeline::data::{Component, DataShape, HostData, ValueType};

/// One shadow map, as shaders see it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Descriptor {
    /// World to clip space; zero for a cube.
    pub clip_from_world: DMat4,
    /// See the module.
    pub rectangle: DVec4,
    /// See the module.
    pub reach: DVec4,
    /// The layer or slot, and the texels on a side.
    pub place: UVec2,
}

/// The names of the arrays with the types of their elements.
pub(crate) const VALUES: [(&str, ValueType); 4] = [
    ("clip_from_world", ValueType::MAT4),
    ("rectangle", ValueType::VEC4),
    ("reach", ValueType::VEC4),
    ("place", ValueType::vector(Component::U32, 4)),
];

/// What a pass that reads descriptors expects of host data.
pub(crate) fn expected() -> Vec<(&'static str, ValueType)> {
    let arrays = VALUES.iter().map(|(name, value_type)| (*name, value_type.array(0)));
    arrays.chain([("count", ValueType::U32)]).collect()
}

/// Adds the arrays of so many descriptors.
pub fn shape(shape: DataShape, capacity: u32) -> DataShape {
    VALUES.iter().fold(shape, |shape, (name, value_type)| shape.value(name, value_type.array(capacity)))
}

/// Publishes descriptors, and their number as `count`; those beyond the capacity are left out.
pub fn publish(data: &mut HostData, descriptors: &[Descriptor]) {
    let capacity = data.shape().find("place").map_or(0, |at| data.shape().values[at].1.count.unwrap_or(0));
    let some = &descriptors[..descriptors.len().min(capacity as usize)];
    data.set_matrices("clip_from_world", some.iter().map(|one| one.clip_from_world));
    data.set_vec4s("rectangle", some.iter().map(|one| one.rectangle.as_vec4()));
    data.set_vec4s("reach", some.iter().map(|one| one.reach.as_vec4()));
    data.set_words("place", some.iter().flat_map(|one| [one.place.x, one.place.y, 0, 0]));
    data.set_u32("count", some.len() as u32);
}

/// The number of descriptors that a data resource holds.
pub(crate) fn count(data: &HostData) -> u32 {
    data.words("count").and_then(|words| words.first().copied()).unwrap_or(0)
}
