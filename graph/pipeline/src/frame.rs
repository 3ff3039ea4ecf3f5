//! Input of a frame from the host: camera, lights, bounds, time.
//!
//! World space is right-handed, in metres. A camera or light looks along −Z of its own space, +Y is its up, as in
//! glTF. Positions and rotations are `f64`, because passes need whole texels a kilometre from the origin;
//! what reaches the GPU is `f32`. Clip depth is 0..1 (near 0, far 1; reversed where a pipeline says so), texture v
//! points down.
//!
//! An engine that has matrices gives those ([`Camera::from_matrices`]); what passes hand back has them as columns
//! (`view.clip_from_world.to_cols_array_2d()`), whatever version of glam the engine has.
//!
//! Nothing here is trusted: [`Camera::check`] and [`Light::check`] find the values (NaN, zero directions, an empty
//! depth range) that no pass could use.

use std::borrow::Cow;
use std::f32::consts::FRAC_PI_2;

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, Vec3};

pub use crate::projection::Projection;

/// The camera of a frame: position, rotation and projection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Camera {
    /// The position of the camera, in world metres.
    pub position: DVec3,
    /// The rotation from camera space (looks along −Z, +Y up) to world space; of unit length.
    pub rotation: DQuat,
    /// The projection from view space to clip space.
    pub projection: Projection,
    /// The width of the picture divided by its height.
    pub aspect: f64,
}

impl Camera {
    /// Creates a camera at a position in world metres, with a rotation of unit length; `aspect` is width over height of
    /// the picture.
    pub fn new(position: impl Into<DVec3>, rotation: DQuat, projection: Projection, aspect: f64) -> Self {
        Self { position: position.into(), rotation, projection, aspect }
    }

    /// Sets the position, in world metres.
    #[must_use]
    pub fn position(self, position: impl Into<DVec3>) -> Self {
        Self { position: position.into(), ..self }
    }

    umbragraph_text::setters! {
        /// Sets the rotation from camera space to world space, of unit length.
        rotation: DQuat,
        /// Sets the projection from view space to clip space.
        projection: Projection,
    }

    /// Creates an upright camera at `eye` that looks at `target`. `vertical_fov` is in radians; the planes are at 0.1 m
    /// and 1000 m. The top of the picture is +Z if the camera looks straight up, and −Z if it looks straight down.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], vertical_fov: f64, aspect: f64) -> Self {
        let position = DVec3::from(eye);
        let back = (position - DVec3::from(target)).try_normalize().unwrap_or(DVec3::Z);
        let right = DVec3::Y.cross(back).try_normalize().unwrap_or(DVec3::X);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        let projection = Projection::Perspective { vertical_fov, near: 0.1, far: 1000.0 };
        Self { position, rotation, projection, aspect }
    }

    /// Creates a camera from an engine's matrices, given as columns. `world_from_view` maps view space (−Z forward, +Y
    /// up) to the world; its scale is ignored. `clip_from_view` is any projection with depth 0..1 or 1..0.
    pub fn from_matrices<T: Into<f64> + Copy>(
        world_from_view: [[T; 4]; 4],
        clip_from_view: [[T; 4]; 4],
    ) -> Self {
        let matrix =
            |columns: [[T; 4]; 4]| DMat4::from_cols_array_2d(&columns.map(|column| column.map(Into::into)));
        let (world, clip_from_view) = (matrix(world_from_view), matrix(clip_from_view));
        let axis = |axis: glam::DVec4| axis.truncate().normalize_or_zero();
        let rotation = DMat3::from_cols(axis(world.x_axis), axis(world.y_axis), axis(world.z_axis));
        let (_, half) = Projection::Matrix { clip_from_view, jitter: DVec2::ZERO }.picture(1.0);
        Self {
            position: world.w_axis.truncate(),
            rotation: DQuat::from_mat3(&rotation).normalize(),
            projection: Projection::Matrix { clip_from_view, jitter: DVec2::ZERO },
            aspect: half.x / half.y,
        }
    }

    /// Sets the offset of this frame's picture in clip space, for effects that accumulate samples over frames. The
    /// picture is 2 wide and high in clip space.
    #[must_use]
    pub fn jittered(self, by: [f64; 2]) -> Self {
        let clip_from_view = self.clip(false);
        Self { projection: Projection::Matrix { clip_from_view, jitter: by.into() }, ..self }
    }

    /// The transform from world space to view space.
    pub fn view(&self) -> DMat4 {
        DMat4::from_rotation_translation(self.rotation, self.position).inverse()
    }

    /// The transform from view to clip space, with depth 0 at the near plane and 1 at the far plane; `reverse` swaps
    /// the two depths.
    pub fn clip(&self, reverse: bool) -> DMat4 {
        self.projection.clip(self.aspect, reverse)
    }

    /// The unit direction in which the camera looks.
    pub fn forward(&self) -> DVec3 {
        self.rotation * DVec3::NEG_Z
    }

    /// The world positions of the picture's four corners at `depth` metres along the view axis: left bottom, right
    /// bottom, left top, right top.
    pub fn slice_corners(&self, depth: f64) -> [DVec3; 4] {
        let corners = self.projection.corners(self.aspect, depth);
        corners.map(|corner| self.position + self.rotation * corner.extend(-depth))
    }

    /// Returns the reason for which the camera is invalid, or `None` if it is valid.
    pub fn check(&self) -> Option<&'static str> {
        if !(self.position.is_finite() && self.rotation.is_finite()) {
            return Some("it has a value that is not finite");
        }
        if !self.rotation.is_normalized() {
            return Some("its rotation is not of unit length");
        }
        if !(self.aspect.is_finite() && self.aspect > 0.0) {
            return Some("its aspect ratio is not above zero");
        }
        self.projection.check()
    }
}

/// The kind of a light, which also determines the unit of its intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light. Intensity in lux.
    Directional,
    /// Light in all directions from a point. Intensity in candela.
    Point,
    /// Light in a cone. Intensity in candela.
    Spot {
        /// The angle from the axis to where the light begins to fall off, in radians.
        inner_angle: f32,
        /// The angle from the axis to where the light ends, in radians.
        outer_angle: f32,
    },
}

/// A light source in one frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// The name of the light, by which passes and reports refer to it. A static string needs no allocation.
    pub name: Cow<'static, str>,
    /// The kind of the light: directional, point or spot.
    pub kind: LightKind,
    /// The position, in world metres; meaningless for a directional light.
    pub position: DVec3,
    /// The unit direction in which the light shines; meaningless for a point light.
    pub direction: DVec3,
    /// Linear colour (Rec. 709 primaries).
    pub color: Vec3,
    /// The intensity: lux for a directional light, candela for others.
    pub intensity: f32,
    /// The distance beyond which the light has no effect, in metres; infinite for no limit.
    pub range: f32,
    /// The properties of the light: words agreed between host and passes, by which passes choose lights.
    pub properties: Vec<Cow<'static, str>>,
    /// The angular diameter of a directional light's source as seen from the scene, in radians (0: a point at
    /// infinity). A value that is negative or not a number counts as 0.
    pub angular_diameter: f32,
    /// The radius of a point or spot light's source, in metres (0: a point). A value that is negative or not a number
    /// counts as 0.
    pub radius: f32,
    /// The importance that the host gives the light where passes must choose among lights; 1 is neutral.
    pub priority: f32,
}

impl Light {
    /// Creates a white light at the origin, with direction −Y, intensity 1, a source without size and an infinite
    /// range.
    pub fn new(name: impl Into<Cow<'static, str>>, kind: LightKind) -> Self {
        Self {
            name: name.into(),
            kind,
            position: DVec3::ZERO,
            direction: DVec3::NEG_Y,
            color: Vec3::ONE,
            intensity: 1.0,
            range: f32::INFINITY,
            properties: Vec::new(),
            angular_diameter: 0.0,
            radius: 0.0,
            priority: 1.0,
        }
    }

    umbragraph_text::setters! { into
        /// Sets the position, in world metres.
        position: DVec3,
        /// Sets the direction in which the light shines, of unit length.
        direction: DVec3,
        /// Sets the linear color (Rec. 709 primaries).
        color: Vec3,
    }

    umbragraph_text::setters! {
        /// Sets the intensity: in lux for a directional light, in candela for others.
        intensity: f32,
        /// Sets the distance beyond which the light has no effect, in metres.
        range: f32,
    }

    /// Adds a property: a word by which passes choose lights.
    #[must_use]
    pub fn property(mut self, property: impl Into<Cow<'static, str>>) -> Self {
        self.properties.push(property.into());
        self
    }

    umbragraph_text::setters! {
        /// Sets the angular diameter of a directional light's source as seen from the scene, in radians.
        angular_diameter: f32,
        /// Sets the radius of the source of a point light or spot, in metres.
        radius: f32,
        /// Sets the importance that the host gives the light; 1 is neutral.
        priority: f32,
    }

    /// Creates a directional light that shines along `direction`, with `intensity` in lux. The caller adds the
    /// [`properties`](Self::properties) by which passes choose lights.
    pub fn directional(
        name: impl Into<Cow<'static, str>>,
        direction: [f64; 3],
        color: [f32; 3],
        intensity: f32,
    ) -> Self {
        let direction = DVec3::from(direction).normalize_or(DVec3::NEG_Y);
        Self::new(name, LightKind::Directional).direction(direction).color(color).intensity(intensity)
    }

    /// Creates a point light at `position` (world metres), with `intensity` in candela.
    pub fn point(
        name: impl Into<Cow<'static, str>>,
        position: [f64; 3],
        color: [f32; 3],
        intensity: f32,
    ) -> Self {
        Self::new(name, LightKind::Point).position(position).color(color).intensity(intensity)
    }

    /// Returns `true` if the light has this property, a word by which passes choose lights.
    pub fn has(&self, property: &str) -> bool {
        self.properties.iter().any(|known| known == property)
    }

    /// Returns the reason for which the light is invalid, or `None` if it is valid.
    pub fn check(&self) -> Option<&'static str> {
        if !(self.position.is_finite()
            && self.direction.is_finite()
            && self.color.is_finite()
            && self.intensity.is_finite())
        {
            return Some("it has a value that is not finite");
        }
        if self.priority.is_nan() {
            return Some("its priority is not a number");
        }
        if !matches!(self.kind, LightKind::Point) && !self.direction.is_normalized() {
            return Some("its direction is not of unit length");
        }
        if self.range.is_nan() || self.range <= 0.0 {
            return Some("its range is not above zero");
        }
        if let LightKind::Spot { inner_angle, outer_angle } = self.kind {
            // π/2 as decimal text is often rounded up.
            let is_cone = 0.0 <= inner_angle && inner_angle <= outer_angle && outer_angle <= FRAC_PI_2 + 1e-4;
            if !is_cone {
                return Some(
                    "its inner angle is negative or above the outer one, or the outer one above π/2",
                );
            }
        }
        None
    }
}

/// An axis-aligned box in world metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner of the minimum coordinates.
    pub min: DVec3,
    /// The corner of the maximum coordinates.
    pub max: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    /// Creates a box from the corners with the minimum and the maximum coordinates.
    pub fn between(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: min.into(), max: max.into() }
    }

    /// The empty box. Extended by a point, it becomes the box that contains only this point.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Returns `true` if the box contains no point, or has a coordinate that is not finite.
    pub fn is_empty(&self) -> bool {
        !(self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all())
    }

    /// Returns the smallest box that contains this box and the point.
    #[must_use]
    pub fn with(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Returns the smallest box that contains this box and `other`.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The eight corners; bits 0, 1 and 2 of the index select the maximum of x, y and z.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|at| {
            DVec3::new(
                if at & 1 == 0 { self.min.x } else { self.max.x },
                if at & 2 == 0 { self.min.y } else { self.max.y },
                if at & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// Returns the axis-aligned box around the transformed corners of this box.
    #[must_use]
    pub fn transformed(&self, transform: &DMat4) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        self.corners()
            .into_iter()
            .fold(Self::EMPTY, |bounds, corner| bounds.with(transform.transform_point3(corner)))
    }

    /// The centre of the box, in world metres.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the diagonal of the box, in metres; 0 for an empty box.
    pub fn radius(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() * 0.5 }
    }
}

/// The host's input for one frame, apart from its draws and imported textures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameInput {
    /// The camera of the frame.
    pub camera: Camera,
    /// The lights in any order; passes use the order only to break ties.
    pub lights: Vec<Light>,
    /// The box, in world metres, around everything that is drawn.
    pub scene_bounds: Bounds,
    /// The boxes around the meshes that pass each draw filter, by filter name, in world metres. Filters without an
    /// entry use `scene_bounds`.
    pub filter_bounds: Vec<(Cow<'static, str>, Bounds)>,
    /// The time in seconds since an arbitrary start, for animation.
    pub time: f64,
    /// The number of the frame; passes use it for values that alternate between frames.
    pub index: u64,
}

impl FrameInput {
    /// Creates the input of a frame at time 0, without lights and bounds.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            lights: Vec::new(),
            scene_bounds: Bounds::EMPTY,
            filter_bounds: Vec::new(),
            time: 0.0,
            index: 0,
        }
    }

    umbragraph_text::setters! {
        /// Sets the camera of the frame.
        camera: Camera,
        /// Replaces the lights of the frame.
        lights: Vec<Light>,
        /// Sets the box, in world metres, around everything that is drawn.
        scene_bounds: Bounds,
    }

    /// Adds the box, in world metres, around the meshes that pass a draw filter.
    #[must_use]
    pub fn filter_bounds(mut self, filter: impl Into<Cow<'static, str>>, bounds: Bounds) -> Self {
        self.filter_bounds.push((filter.into(), bounds));
        self
    }

    umbragraph_text::setters! {
        /// Sets the time in seconds since an arbitrary start.
        time: f64,
        /// Sets the number of the frame, which passes use for values that alternate between frames.
        index: u64,
    }

    /// The box, in world metres, around the meshes that pass a draw filter; `scene_bounds` if the host gave none for
    /// the filter.
    pub fn bounds_of(&self, filter: &str) -> &Bounds {
        let known = self.filter_bounds.iter().find(|(known, _)| known == filter);
        known.map_or(&self.scene_bounds, |(_, bounds)| bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_with_an_impossible_cone_or_priority_is_invalid() {
        let spot = |inner_angle, outer_angle| Light::new("s", LightKind::Spot { inner_angle, outer_angle });
        let lamp = || Light::point("lamp", [0.0; 3], [1.0; 3], 1.0);
        // A source of no possible size counts as a point.
        let others = [lamp().radius(-1.0), lamp().priority(-1.0), lamp().priority(f32::INFINITY)];
        for fine in [spot(0.0, 0.4), spot(0.4, 0.4), spot(0.1, FRAC_PI_2)].into_iter().chain(others) {
            assert_eq!(fine.check(), None, "{fine:?}");
        }
        for (light, reason) in [
            (spot(0.5, 0.4), "angle"),
            (spot(-0.1, 0.4), "angle"),
            (spot(0.1, 1.6), "angle"),
            (spot(f32::NAN, 0.4), "angle"),
            (lamp().priority(f32::NAN), "priority"),
        ] {
            let said = light.check();
            assert!(said.is_some_and(|said| said.contains(reason)), "{light:?}: {said:?}");
        }
    }
}
