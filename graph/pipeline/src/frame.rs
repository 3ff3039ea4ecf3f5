//! What the host tells a frame: camera, lights, bounds, time.
//!
//! World space is right-handed, in metres. A camera or light looks along −Z of its own space, +Y is its up, as in
//! glTF. Positions and rotations are `f64`, because passes need whole texels a kilometre from the origin;
//! what reaches the GPU is `f32`. Clip depth is 0..1 (near 0, far 1; reversed where a pipeline says so), texture v
//! points down.
//!
//! Nothing here is trusted: [`Camera::check`] and [`Light::check`] find the values (NaN, zero directions, an empty
//! depth range) that no pass could use.

use std::borrow::Cow;

use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};

/// The projection of a camera, from view space to clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective projection.
    Perspective {
        /// The vertical field of view, in radians, above 0 and below π.
        vertical_fov: f64,
        /// The distance of the near plane, in metres, above 0.
        near: f64,
        /// The distance of the far plane, in metres, beyond the near plane.
        far: f64,
    },
    /// An orthographic projection.
    Orthographic {
        /// Half the visible height, in metres, above 0.
        half_height: f64,
        /// The distance of the near plane, in metres.
        near: f64,
        /// The distance of the far plane, in metres, beyond the near plane.
        far: f64,
    },
}

impl Projection {
    /// The distances of the near and the far plane, in metres.
    pub fn depth_range(self) -> (f64, f64) {
        match self {
            Projection::Perspective { near, far, .. } | Projection::Orthographic { near, far, .. } => {
                (near, far)
            }
        }
    }
}

/// The point of view of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// A camera at a position that looks at another, upright, with a vertical field of view in radians, from 0.1 m to
    /// 1000 m ([`Camera::between`] says others). One that looks straight up has Z upwards in its picture, one that looks
    /// straight down has −Z.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], vertical_fov: f64, aspect: f64) -> Self {
        let position = DVec3::from(eye);
        let back = (position - DVec3::from(target)).try_normalize().unwrap_or(DVec3::Z);
        let right = DVec3::Y.cross(back).try_normalize().unwrap_or(DVec3::X);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        let projection = Projection::Perspective { vertical_fov, near: 0.1, far: 1000.0 };
        Self { position, rotation, projection, aspect }
    }

    /// The same between two other planes, in metres.
    #[must_use]
    pub fn between(mut self, new_near: f64, new_far: f64) -> Self {
        match &mut self.projection {
            Projection::Perspective { near, far, .. } | Projection::Orthographic { near, far, .. } => {
                (*near, *far) = (new_near, new_far);
            }
        }
        self
    }

    /// World to view space.
    pub fn view(&self) -> DMat4 {
        DMat4::from_rotation_translation(self.rotation, self.position).inverse()
    }

    /// View to clip space with depth 0 at the near plane and 1 at the far plane; `reverse` swaps the two.
    pub fn clip(&self, reverse: bool) -> DMat4 {
        let (near, far) = self.projection.depth_range();
        let (near, far) = if reverse { (far, near) } else { (near, far) };
        match self.projection {
            Projection::Perspective { vertical_fov, .. } => {
                let height = 1.0 / (0.5 * vertical_fov).tan();
                let depth = far / (near - far);
                DMat4::from_cols_array(&[
                    height / self.aspect,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    height,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    depth,
                    -1.0,
                    0.0,
                    0.0,
                    depth * near,
                    0.0,
                ])
            }
            Projection::Orthographic { half_height, .. } => {
                let half_width = half_height * self.aspect;
                let depth = 1.0 / (near - far);
                DMat4::from_cols_array(&[
                    1.0 / half_width,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    1.0 / half_height,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    depth,
                    0.0,
                    0.0,
                    0.0,
                    depth * near,
                    1.0,
                ])
            }
        }
    }

    /// The unit direction in which the camera looks.
    pub fn forward(&self) -> DVec3 {
        self.rotation * DVec3::NEG_Z
    }

    /// The four world positions at distance `depth` along the view axis that the picture's corners see:
    /// left bottom, right bottom, left top, right top.
    pub fn slice_corners(&self, depth: f64) -> [DVec3; 4] {
        let half_height = match self.projection {
            Projection::Perspective { vertical_fov, .. } => depth * (0.5 * vertical_fov).tan(),
            Projection::Orthographic { half_height, .. } => half_height,
        };
        let half_width = half_height * self.aspect;
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
            .map(|(x, y)| self.position + self.rotation * DVec3::new(x * half_width, y * half_height, -depth))
    }

    /// Why no pass could use this camera, or `None` if it is fine.
    pub fn check(&self) -> Option<&'static str> {
        let (near, far) = self.projection.depth_range();
        if !(self.position.is_finite() && self.rotation.is_finite() && near.is_finite() && far.is_finite()) {
            return Some("it has a value that is not finite");
        }
        if !self.rotation.is_normalized() {
            return Some("its rotation is not of unit length");
        }
        if !(self.aspect.is_finite() && self.aspect > 0.0) {
            return Some("its aspect ratio is not above zero");
        }
        if near >= far {
            return Some("its far plane is not beyond its near plane");
        }
        match self.projection {
            Projection::Perspective { vertical_fov, .. }
                if !(vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI) =>
            {
                Some("its vertical field of view is not between 0 and π")
            }
            Projection::Perspective { near, .. } if near <= 0.0 => {
                Some("its near plane is not in front of it")
            }
            Projection::Orthographic { half_height, .. }
                if !(half_height.is_finite() && half_height > 0.0) =>
            {
                Some("its half height is not above zero")
            }
            _ => None,
        }
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
pub struct Light {
    /// The name by which passes and reports call it.
    pub name: String,
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
    /// A directional light that shines along a direction, with an intensity in lux. What passes ask of its
    /// [`properties`](Self::properties), the caller adds.
    pub fn directional(
        name: impl Into<String>,
        direction: [f64; 3],
        color: [f32; 3],
        intensity: f32,
    ) -> Self {
        Self {
            name: name.into(),
            kind: LightKind::Directional,
            position: DVec3::ZERO,
            direction: DVec3::from(direction).normalize_or(DVec3::NEG_Y),
            color: color.into(),
            intensity,
            range: f32::INFINITY,
            properties: Vec::new(),
            angular_diameter: 0.0,
            radius: 0.0,
            priority: 1.0,
        }
    }

    /// The same for a point light, with an intensity in candela.
    pub fn point(name: impl Into<String>, position: [f64; 3], color: [f32; 3], intensity: f32) -> Self {
        let position = position.into();
        let light = Self::directional(name, [0.0, -1.0, 0.0], color, intensity);
        Self { kind: LightKind::Point, position, ..light }
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

    /// The box around what a draw filter lets through, as far as the host tells.
    pub fn bounds_of(&self, filter: &str) -> &Bounds {
        let known = self.filter_bounds.iter().find(|(known, _)| known == filter);
        known.map_or(&self.scene_bounds, |(_, bounds)| bounds)
    }
}
