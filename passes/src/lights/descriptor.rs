//! Shadow descriptors: how a shader finds and measures one shadow map.
//!
//! Published as an array `map` of structs, which a shader declares with the members below; `count` says how many there
//! are. Each has 128 bytes, a cache line. Lengths are metres, texels those of the whole texture. The members are in
//! [`VALUES`].
//!
//! A descriptor of zeros shadows nothing.

use glam::{DMat4, DVec2, DVec4, UVec2};
use umbragraph_pipeline::data::{BlackboardData, Component, DataShape, ValueType};
use umbragraph_pipeline::frame::{Light, LightKind};

/// One shadow map, as shaders read it; [`VALUES`] lists the meaning of each component.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Descriptor {
    /// The rows x, y and z of the matrix from world to light space.
    pub axes: [DVec4; 3],
    /// The scale (x, y) and the offset (z, w) from light space to texels.
    pub texels: DVec4,
    /// The texels that belong to the map: upper left corner (x, y) and lower right corner (z, w).
    pub bounds: DVec4,
    /// The coefficients of depth (x, y), the width of a texel in metres (z), and the size of the light (w).
    pub depth: DVec4,
    /// For a cascade, the distances along the view axis at which it ends and begins to blend. Otherwise the distances
    /// of the far and the near plane. In metres.
    pub reach: DVec2,
    /// The index of the layer (of a cube, its first), and the side of the map in texels.
    pub place: UVec2,
}

/// The maximum angular diameter of a directional light, in radians; greater ones are reduced to it.
pub const MAX_ANGLE: f64 = std::f64::consts::FRAC_PI_2;

/// The name, type and meaning of each member of a descriptor in published data. Meanings differ between a layer of an
/// array (orthographic), and a tile of an atlas or a cube (perspective).
pub const VALUES: [(&str, ValueType, &str); 8] = [
    (
        "map.axis_x",
        ValueType::VEC4,
        "row from the world to the light's x axis, the same for all cascades of a light; of a cube the world's axes, seen from where it stands",
    ),
    ("map.axis_y", ValueType::VEC4, "the same of y"),
    ("map.axis_z", ValueType::VEC4, "the same of z, towards the light"),
    (
        "map.texels",
        ValueType::VEC4,
        "to texels, scale of x and y, offset: of the axes for a layer, over the distance along the axis for a tile, across its faces for a cube",
    ),
    ("map.bounds", ValueType::VEC4, "the texels that belong to it: upper left corner, lower right corner"),
    (
        "map.depth",
        ValueType::VEC4,
        "of a layer: a, b of the depth a + b · z, width of a texel, tangent of half the angle under which the light is seen; else: a, b of the depth a + b / distance, width of a texel at 1 m, radius of the light",
    ),
    (
        "map.reach",
        ValueType::VEC2,
        "of a layer: where the cascade ends and where it begins to blend, along the view axis; else: distance of the far and the near plane",
    ),
    ("map.place", ValueType::vector(Component::U32, 2), "layer, of a cube the first; texels on a side"),
];

/// The first three rows of a matrix.
pub(crate) fn rows(matrix: &DMat4) -> [DVec4; 3] {
    [matrix.row(0), matrix.row(1), matrix.row(2)]
}

/// The upper left (x, y) and lower right (z, w) corner of a square with a side of `side` texels.
pub(crate) fn square(x: u32, y: u32, side: u32) -> DVec4 {
    DVec4::new(f64::from(x), f64::from(y), f64::from(x + side), f64::from(y + side))
}

/// The size of a light as descriptors store it: the tangent of half the angular diameter for a directional light, else
/// the radius in metres. `without` (radians or metres) is the size of lights without one; NaN and negative sizes count
/// as none. Angles are limited to [`MAX_ANGLE`], radii to `range` metres.
pub(crate) fn light_size(light: &Light, without: f64, range: f64) -> f64 {
    let given = match light.kind {
        LightKind::Directional => light.angular_diameter,
        LightKind::Point | LightKind::Spot { .. } => light.radius,
    };
    let size = if given > 0.0 { f64::from(given) } else { without.max(0.0) };
    match light.kind {
        LightKind::Directional => (0.5 * size.min(MAX_ANGLE)).tan(),
        LightKind::Point | LightKind::Spot { .. } => size.min(range),
    }
}

/// The names and types of the values that blackboard data with shadow descriptors has.
pub(crate) fn expected() -> Vec<(&'static str, ValueType)> {
    let arrays = VALUES.iter().map(|(name, value_type, _)| (*name, value_type.array(0)));
    arrays.chain([("count", ValueType::U32)]).collect()
}

/// The shape of blackboard data with up to `capacity` shadow descriptors.
pub fn shape(capacity: u32) -> DataShape {
    add(DataShape::new().value("count", ValueType::U32, "the descriptors of this frame"), capacity)
}

/// Adds the members of `capacity` descriptors to the shape of blackboard data.
pub(crate) fn add(shape: DataShape, capacity: u32) -> DataShape {
    VALUES
        .iter()
        .fold(shape, |shape, (name, value_type, what)| shape.value(name, value_type.array(capacity), what))
}

/// Publishes descriptors, and their number as `count`; descriptors beyond the capacity are left out.
pub fn publish(data: &mut BlackboardData, descriptors: &[Descriptor]) {
    let some = &descriptors[..descriptors.len().min(capacity(data) as usize)];
    for (at, name) in ["map.axis_x", "map.axis_y", "map.axis_z"].into_iter().enumerate() {
        data.set_vec4s(name, some.iter().map(|one| one.axes[at].as_vec4()));
    }
    data.set_vec4s("map.texels", some.iter().map(|one| one.texels.as_vec4()));
    data.set_vec4s("map.bounds", some.iter().map(|one| one.bounds.as_vec4()));
    data.set_vec4s("map.depth", some.iter().map(|one| one.depth.as_vec4()));
    data.set_f32s("map.reach", some.iter().flat_map(|one| one.reach.as_vec2().to_array()));
    data.set_words("map.place", some.iter().flat_map(|one| one.place.to_array()));
    data.set_u32("count", some.len() as u32);
}

/// The maximum number of descriptors that the data can hold.
pub(crate) fn capacity(data: &BlackboardData) -> u32 {
    data.shape().find("map.place").map_or(0, |at| data.shape().values[at].value_type.count.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_sizes_count_as_missing_and_huge_ones_are_bounded() {
        let size = |kind, given: f32, without| {
            let light = Light::new("", kind).range(10.0).angular_diameter(given).radius(given);
            light_size(&light, without, 10.0)
        };
        for kind in [LightKind::Point, LightKind::Spot { inner_angle: 0.1, outer_angle: 0.2 }] {
            assert_eq!(size(kind, 0.25, 0.1), 0.25);
            for none in [0.0, -1.0, f32::NAN] {
                assert_eq!([size(kind, none, 0.0), size(kind, none, 0.5)], [0.0, 0.5]);
            }
            assert_eq!([size(kind, 1e30, 0.0), size(kind, f32::INFINITY, 0.0)], [10.0; 2]);
        }
        let sun = |given| size(LightKind::Directional, given, 0.0);
        assert!((sun(0.5) - 0.25f64.tan()).abs() < 1e-12);
        for none in [0.0, -3.0, f32::NAN] {
            assert_eq!(sun(none), 0.0);
        }
        assert!((sun(3.0) - 1.0).abs() < 1e-12 && (sun(f32::INFINITY) - 1.0).abs() < 1e-12);
    }
}
