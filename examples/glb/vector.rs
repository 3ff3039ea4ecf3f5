//! Affine placements in `f64`, in metres.

use super::functions::sin_cos;

pub(crate) use glam::{DVec3 as Vec3, dvec3 as vec3};

/// An affine transform from the space of a shape or node to the space around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    /// The transformed X, Y and Z axes: the columns of the matrix.
    pub(crate) axes: [Vec3; 3],
    /// The transformed origin: the translation, in metres.
    pub(crate) origin: Vec3,
}

impl Placement {
    /// The identity transform.
    pub(crate) const IDENTITY: Self = Self { axes: Vec3::AXES, origin: Vec3::ZERO };

    /// A translation of the origin to a point.
    pub(crate) fn at(x: f64, y: f64, z: f64) -> Self {
        Self { origin: vec3(x, y, z), ..Self::IDENTITY }
    }

    /// A placement at `eye` with −Z towards `target` and +Y as near to up as possible, as for a camera or light.
    pub(crate) fn looking_at(eye: Vec3, target: Vec3) -> Self {
        let back = (eye - target).normalize_or(Vec3::Y);
        let right = Vec3::Y.cross(back).normalize_or(Vec3::Y);
        Self { axes: [right, back.cross(right), back], origin: eye }
    }

    /// A placement at `foot` with +Y towards `tip`.
    pub(crate) fn pointing(foot: Vec3, tip: Vec3) -> Self {
        let up = (tip - foot).normalize_or(Vec3::Y);
        let helper = if up.x.abs() < 0.9 { Vec3::X } else { Vec3::Z };
        let front = helper.cross(up).normalize_or(Vec3::Y);
        Self { axes: [up.cross(front), up, front], origin: foot }
    }

    /// Applies a rotation about the X axis, in degrees, before this placement.
    pub(crate) fn turned_x(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x, y * cos + z * sin, z * cos - y * sin], ..self }
    }

    /// Applies a rotation about the Y axis, in degrees, before this placement.
    pub(crate) fn turned_y(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x * cos - z * sin, y, z * cos + x * sin], ..self }
    }

    /// Applies a rotation about the Z axis, in degrees, before this placement.
    pub(crate) fn turned_z(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x * cos + y * sin, y * cos - x * sin, z], ..self }
    }

    /// Applies a scale along the axes before this placement.
    pub(crate) fn scaled(self, x: f64, y: f64, z: f64) -> Self {
        Self { axes: [self.axes[0] * x, self.axes[1] * y, self.axes[2] * z], ..self }
    }

    /// Transforms a point of the placed space to the space outside.
    pub(crate) fn point(&self, point: Vec3) -> Vec3 {
        self.origin + self.direction(point)
    }

    /// Transforms a direction of the placed space to the space outside.
    pub(crate) fn direction(&self, direction: Vec3) -> Vec3 {
        self.axes[0] * direction.x + self.axes[1] * direction.y + self.axes[2] * direction.z
    }

    /// Transforms a normal of the placed space to a unit normal outside, by cofactors, so that scales may differ by
    /// axis.
    pub(crate) fn normal(&self, normal: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        let cofactors = y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z;
        let sign = if self.is_mirrored() { -1.0 } else { 1.0 };
        cofactors.normalize_or(Vec3::Y) * sign
    }

    /// Returns `true` if the placement mirrors, which reverses the winding of triangles.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.axes[0].cross(self.axes[1]).dot(self.axes[2]) < 0.0
    }
}
