//! Vectors and affine placements in `f64`.

use super::functions::sin_cos;
use std::ops::{Add, Mul, Neg, Sub};

/// A point or direction, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vec3 {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

/// Shorthand for a vector.
pub(crate) const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    pub(crate) const ZERO: Self = vec3(0.0, 0.0, 0.0);

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Of unit length; +Y for a vector of length zero.
    pub(crate) fn normalized(self) -> Self {
        let length = self.length();
        if length > 0.0 { self * (1.0 / length) } else { vec3(0.0, 1.0, 0.0) }
    }

    pub(crate) fn lerp(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }

    pub(crate) fn array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        vec3(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// An affine transform: where a shape or node stands in the space around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    /// What the three axes become.
    pub(crate) axes: [Vec3; 3],
    /// What the origin becomes.
    pub(crate) origin: Vec3,
}

impl Placement {
    /// Changes nothing.
    pub(crate) const IDENTITY: Self =
        Self { axes: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)], origin: Vec3::ZERO };

    /// Moves the origin to a point.
    pub(crate) fn at(x: f64, y: f64, z: f64) -> Self {
        Self { origin: vec3(x, y, z), ..Self::IDENTITY }
    }

    /// At `eye`, with −Z towards `target` and +Y as near to up as possible: how a camera or light is placed.
    pub(crate) fn looking_at(eye: Vec3, target: Vec3) -> Self {
        let back = (eye - target).normalized();
        let right = vec3(0.0, 1.0, 0.0).cross(back).normalized();
        Self { axes: [right, back.cross(right), back], origin: eye }
    }

    /// With +Y from `foot` towards `tip`.
    pub(crate) fn pointing(foot: Vec3, tip: Vec3) -> Self {
        let up = (tip - foot).normalized();
        let helper = if up.x.abs() < 0.9 { vec3(1.0, 0.0, 0.0) } else { vec3(0.0, 0.0, 1.0) };
        let front = helper.cross(up).normalized();
        Self { axes: [up.cross(front), up, front], origin: foot }
    }

    /// First turned about its own X axis, by degrees.
    pub(crate) fn turned_x(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x, y * cos + z * sin, z * cos - y * sin], ..self }
    }

    /// First turned about its own Y axis, by degrees.
    pub(crate) fn turned_y(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x * cos - z * sin, y, z * cos + x * sin], ..self }
    }

    /// First turned about its own Z axis, by degrees.
    pub(crate) fn turned_z(self, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let [x, y, z] = self.axes;
        Self { axes: [x * cos + y * sin, y * cos - x * sin, z], ..self }
    }

    /// First scaled along its own axes.
    pub(crate) fn scaled(self, x: f64, y: f64, z: f64) -> Self {
        Self { axes: [self.axes[0] * x, self.axes[1] * y, self.axes[2] * z], ..self }
    }

    /// Where a point of the placed space lies outside.
    pub(crate) fn point(&self, point: Vec3) -> Vec3 {
        self.origin + self.direction(point)
    }

    /// Where a direction of the placed space points outside.
    pub(crate) fn direction(&self, direction: Vec3) -> Vec3 {
        self.axes[0] * direction.x + self.axes[1] * direction.y + self.axes[2] * direction.z
    }

    /// The unit normal outside of a surface whose normal inside is known (by cofactors, so that scaling may differ by
    /// axis).
    pub(crate) fn normal(&self, normal: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        let cofactors = y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z;
        let sign = if self.is_mirrored() { -1.0 } else { 1.0 };
        cofactors.normalized() * sign
    }

    /// Whether left becomes right.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.axes[0].cross(self.axes[1]).dot(self.axes[2]) < 0.0
    }
}
