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

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, Vec3};

pub use crate::projection::Projection;

/// The point of view of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Camera {
    /// The position of the camera, in world metres.
    pub position: DVec3,
    /// The rotation from camera space (looks along −Z, +Y up) to world space; of unit length.
    pub rotation: DQuat,
    /// The projection.
    pub projection: Projection,
    /// Width over height of the picture.
    pub aspect: f64,
}

impl Camera {
    /// A camera at a position, with a rotation of unit length; `aspect` is width over height of the picture.
    pub fn new(position: impl Into<DVec3>, rotation: DQuat, projection: Projection, aspect: f64) -> Self {
        Self { position: position.into(), rotation, projection, aspect }
    }

    /// Sets the position, in world metres.
    #[must_use]
    pub fn position(self, position: impl Into<DVec3>) -> Self {
        Self { position: position.into(), ..self }
    }

    umbragraph_text::setters! {
        /// Sets the rotation, of unit length.
        rotation: DQuat,
        /// Sets the projection.
        projection: Projection,
    }

    /// A camera at a position that looks at another, upright, with a vertical field of view in radians, from 0.1 m to
    /// 1000 m. One that looks straight up has Z upwards in its picture, one that looks
    /// straight down has −Z.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], vertical_fov: f64, aspect: f64) -> Self {
        let position = DVec3::from(eye);
        let back = (position - DVec3::from(target)).try_normalize().unwrap_or(DVec3::Z);
        let right = DVec3::Y.cross(back).try_normalize().unwrap_or(DVec3::X);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        let projection = Projection::Perspective { vertical_fov, near: 0.1, far: 1000.0 };
        Self { position, rotation, projection, aspect }
    }

    /// The camera of an engine that has its matrices, column by column: view space (−Z forward, +Y up) to the world,
    /// and view to clip space with depth 0..1 or 1..0, of any projection. Scale in the first is left out.
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

    /// Moves the picture of this frame in clip space: 2 is its whole width or height.
    #[must_use]
    pub fn jittered(self, by: [f64; 2]) -> Self {
        let clip_from_view = self.clip(false);
        Self { projection: Projection::Matrix { clip_from_view, jitter: by.into() }, ..self }
    }

    /// World to view space.
    pub fn view(&self) -> DMat4 {
        DMat4::from_rotation_translation(self.rotation, self.position).inverse()
    }

    /// View to clip space with depth 0 at the near plane and 1 at the far plane; `reverse` swaps the two.
    pub fn clip(&self, reverse: bool) -> DMat4 {
        self.projection.clip(self.aspect, reverse)
    }

    /// The unit direction in which the camera looks.
    pub fn forward(&self) -> DVec3 {
        self.rotation * DVec3::NEG_Z
    }

    /// The four world positions at distance `depth` along the view axis that the picture's corners see:
    /// left bottom, right bottom, left top, right top.
    pub fn slice_corners(&self, depth: f64) -> [DVec3; 4] {
        let corners = self.projection.corners(self.aspect, depth);
        corners.map(|corner| self.position + self.rotation * corner.extend(-depth))
    }

    /// Why no pass could use this camera, or `None` if it is fine.
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

/// The kind of a light.
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

/// A light of a frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// The name by which passes and reports call it; of a word of the program nothing is allocated.
    pub name: Cow<'static, str>,
    /// The kind.
    pub kind: LightKind,
    /// The position, in world metres; meaningless for a directional light.
    pub position: DVec3,
    /// The unit direction in which its light travels; meaningless for a point light.
    pub direction: DVec3,
    /// Linear colour (Rec. 709 primaries).
    pub color: Vec3,
    /// Lux for a directional light, else candela.
    pub intensity: f32,
    /// The distance beyond which it has no effect, in metres; infinite where there is no such limit.
    pub range: f32,
    /// The words that are true of it, as host and passes agree on them.
    pub properties: Vec<Cow<'static, str>>,
    /// The angle under which a directional light is seen, in radians (0: a point at infinity).
    pub angular_diameter: f32,
    /// The radius of a point or spot light's source, in metres (0: a point).
    pub radius: f32,
    /// The host's own weight of its importance; 1 is neutral.
    pub priority: f32,
}

impl Light {
    /// A white light of a kind at the origin, which shines down, with an intensity of 1, without an extent or an end.
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
        /// Sets the linear color.
        color: Vec3,
    }

    umbragraph_text::setters! {
        /// Sets the intensity in lux (directional) or candela.
        intensity: f32,
        /// Sets the distance beyond which the light has no effect, in metres.
        range: f32,
    }

    /// Adds a property, a word that passes can ask for.
    #[must_use]
    pub fn property(mut self, property: impl Into<Cow<'static, str>>) -> Self {
        self.properties.push(property.into());
        self
    }

    umbragraph_text::setters! {
        /// Sets the angle under which a directional light is seen, in radians.
        angular_diameter: f32,
        /// Sets the radius of the source of a point light or spot, in metres.
        radius: f32,
        /// Sets the host's own weight of the light's importance.
        priority: f32,
    }

    /// A directional light that shines along a direction, with an intensity in lux. What passes ask of its
    /// [`properties`](Self::properties), the caller adds.
    pub fn directional(
        name: impl Into<Cow<'static, str>>,
        direction: [f64; 3],
        color: [f32; 3],
        intensity: f32,
    ) -> Self {
        let direction = DVec3::from(direction).normalize_or(DVec3::NEG_Y);
        Self::new(name, LightKind::Directional).direction(direction).color(color).intensity(intensity)
    }

    /// A point light at a position, with an intensity in candela.
    pub fn point(
        name: impl Into<Cow<'static, str>>,
        position: [f64; 3],
        color: [f32; 3],
        intensity: f32,
    ) -> Self {
        Self::new(name, LightKind::Point).position(position).color(color).intensity(intensity)
    }

    /// Whether a word is true of it.
    pub fn has(&self, property: &str) -> bool {
        self.properties.iter().any(|known| known == property)
    }

    /// Why no pass could use this light, or `None` if it is fine.
    pub fn check(&self) -> Option<&'static str> {
        if !(self.position.is_finite()
            && self.direction.is_finite()
            && self.color.is_finite()
            && self.intensity.is_finite())
        {
            return Some("it has a value that is not finite");
        }
        if !matches!(self.kind, LightKind::Point) && !self.direction.is_normalized() {
            return Some("its direction is not of unit length");
        }
        if self.range.is_nan() || self.range <= 0.0 {
            return Some("its range is not above zero");
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
    /// The box between two corners.
    pub fn between(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: min.into(), max: max.into() }
    }

    /// The box that holds nothing; growing it by a point gives that point.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Whether the box holds no point (or has a coordinate that is not finite).
    pub fn is_empty(&self) -> bool {
        !(self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all())
    }

    /// The smallest box that holds this one and the point.
    #[must_use]
    pub fn with(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|at| {
            DVec3::new(
                if at & 1 == 0 { self.min.x } else { self.max.x },
                if at & 2 == 0 { self.min.y } else { self.max.y },
                if at & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The box around this one after a transform.
    #[must_use]
    pub fn transformed(&self, transform: &DMat4) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        self.corners()
            .into_iter()
            .fold(Self::EMPTY, |bounds, corner| bounds.with(transform.transform_point3(corner)))
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the diagonal, in metres.
    pub fn radius(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() * 0.5 }
    }
}

/// Everything that the host says about one frame, apart from its draws and imported textures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameInput {
    /// The point of view.
    pub camera: Camera,
    /// The lights, in an order of the host's own; no pass lets the order decide anything but ties.
    pub lights: Vec<Light>,
    /// The box around everything that is drawn.
    pub scene_bounds: Bounds,
    /// The boxes around what draw filters let through, by their words; that of the scene stands for others.
    pub filter_bounds: Vec<(Cow<'static, str>, Bounds)>,
    /// Seconds since some start, for animation.
    pub time: f64,
    /// Counts frames; passes use it for what alternates.
    pub index: u64,
}

impl FrameInput {
    /// A frame without lights and bounds.
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
        /// Sets the camera.
        camera: Camera,
        /// Replaces the lights.
        lights: Vec<Light>,
        /// Sets the box around everything that is drawn.
        scene_bounds: Bounds,
    }

    /// Adds the box around what a draw filter lets through.
    #[must_use]
    pub fn filter_bounds(mut self, filter: impl Into<Cow<'static, str>>, bounds: Bounds) -> Self {
        self.filter_bounds.push((filter.into(), bounds));
        self
    }

    umbragraph_text::setters! {
        /// Sets the time in seconds.
        time: f64,
        /// Sets the number of the frame.
        index: u64,
    }

    /// The box around what a draw filter lets through, as far as the host tells.
    pub fn bounds_of(&self, filter: &str) -> &Bounds {
        let known = self.filter_bounds.iter().find(|(known, _)| known == filter);
        known.map_or(&self.scene_bounds, |(_, bounds)| bounds)
    }
}
