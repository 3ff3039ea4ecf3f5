//! The views that casters are drawn from for lights with a position.
//!
//! [`spot`] is one view along a cone, [`cube`] six around a point, [`range`] how far they look. Right-handed world in
//! metres, clip depth 0 at the near plane and 1 at the far plane (the other way round where `reverse`), texture v down.
//! Both store the same depth: with d the distance along the view's axis, `near` [`NEAR`] and `far` the light's range,
//! `far / (far − near) · (1 − near / d)`, or in reverse `near / (far − near) · (far / d − 1)`; see
//! [`depth_coefficients`].
//!
//! Everything is computed in `f64`, and all results are finite in 32 bits for any light. Lights with an unusable
//! position ([`MAX_COORDINATE`]) have no views.

pub mod cube;
pub mod range;
pub mod spot;

use glam::{DMat4, DVec2, DVec3, DVec4};

/// The distance of the near plane of a light's views, in metres.
pub const NEAR: f64 = 0.05;

/// The largest absolute coordinate of a light's position for which there are views, in metres.
pub const MAX_COORDINATE: f64 = 1e9;

/// The coefficients a and b of the depth of a perspective view: a point at a distance along the view's axis has the
/// depth a + b / distance.
pub fn depth_coefficients(near: f64, far: f64, reverse: bool) -> DVec2 {
    let (near, far) = if reverse { (far, near) } else { (near, far) };
    DVec2::new(far, -near * far) / (far - near)
}

/// The perspective projection from view to clip space. `x_scale` and `y_scale` are the cotangents of the half angles.
fn projection(x_scale: f64, y_scale: f64, near: f64, far: f64, reverse: bool) -> DMat4 {
    let (near, far) = if reverse { (far, near) } else { (near, far) };
    let slope = far / (near - far);
    DMat4::from_cols(
        DVec4::new(x_scale, 0.0, 0.0, 0.0),
        DVec4::new(0.0, y_scale, 0.0, 0.0),
        DVec4::new(0.0, 0.0, slope, -1.0),
        DVec4::new(0.0, 0.0, slope * near, 0.0),
    )
}

/// Returns `true` if a light's position is finite and within [`MAX_COORDINATE`].
fn is_place(position: DVec3) -> bool {
    position.is_finite() && position.abs().max_element() <= MAX_COORDINATE
}

/// The depth that is stored for a point at a distance along the view's axis.
#[cfg(test)]
fn depth(distance: f64, near: f64, far: f64, reverse: bool) -> f64 {
    let DVec2 { x: a, y: b } = depth_coefficients(near, far, reverse);
    a + b / distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_runs_from_plane_to_plane() {
        for reverse in [false, true] {
            let (first, last) = if reverse { (1.0, 0.0) } else { (0.0, 1.0) };
            assert!((depth(NEAR, NEAR, 20.0, reverse) - first).abs() < 1e-12);
            assert!((depth(20.0, NEAR, 20.0, reverse) - last).abs() < 1e-12);
        }
    }
}
