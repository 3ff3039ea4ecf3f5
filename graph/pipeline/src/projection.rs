//! The projection of a camera: by its angles and planes, or as the matrix that an engine has.
//!
//! A matrix may be off-centre or sheared, with a far plane at infinity, and with depth from 0 to 1 or from 1 to 0,
//! which is found by comparing two depths. With rows X, Y, Z, W over view space (x, y, z = −d, 1), the plane of depth
//! t lies at d = (t·W₄ − Z₄) / (t·W₃ − Z₃); depth the other way around is W − Z in place of Z. The
//! corners of the picture at a distance solve X = ±W, Y = ±W for x and y.
//!
//! Limits: W is −z (perspective) or 1 (parallel), up to a factor; where the near plane is oblique, its distance is
//! that on the view axis.

use glam::{DMat2, DMat4, DVec2, DVec4};

/// The projection of a camera, from view space to clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective projection.
    Perspective {
        /// The vertical field of view, in radians, above 0 and below π.
        vertical_fov: f64,
        /// The distance of the near plane, in metres, above 0.
        near: f64,
        /// The distance of the far plane, in metres, beyond the near plane; infinite for a projection without a far
        /// plane.
        far: f64,
    },
    /// An orthographic projection.
    Orthographic {
        /// Half the visible height, in metres, above 0.
        half_height: f64,
        /// The distance of the near plane from the camera, in metres; may be negative.
        near: f64,
        /// The distance of the far plane, in metres, beyond the near plane.
        far: f64,
    },
    /// Any other projection, as a matrix.
    Matrix {
        /// The transform from view space to clip space, with depth 0..1 or 1..0 and without jitter. Pipelines that use
        /// the opposite depth direction convert the matrix.
        clip_from_view: DMat4,
        /// The offset of this frame's picture in clip space (2 is its full width or height), for effects that
        /// accumulate samples over frames.
        jitter: DVec2,
    },
}

impl Projection {
    /// The distances of the near and the far plane, in metres; the far plane may be infinite.
    pub fn depth_range(self) -> (f64, f64) {
        match self {
            Projection::Perspective { near, far, .. } | Projection::Orthographic { near, far, .. } => {
                (near, far)
            }
            Projection::Matrix { clip_from_view, .. } => {
                let [near, far] = [0.0, 1.0].map(|depth| distance_of(&clip_from_view, depth));
                if is_reverse(&clip_from_view) { (far, near) } else { (near, far) }
            }
        }
    }

    /// Returns `true` for an orthographic projection, in which distant things are as large as near ones.
    pub fn is_orthographic(self) -> bool {
        match self {
            Projection::Perspective { .. } => false,
            Projection::Orthographic { .. } => true,
            Projection::Matrix { clip_from_view, .. } => clip_from_view.z_axis.w == 0.0,
        }
    }

    /// The offset of this frame's picture in clip space that the host sets (2 is the picture's full width or height);
    /// zero if there is none.
    pub fn jitter(self) -> DVec2 {
        match self {
            Projection::Matrix { jitter, .. } => jitter,
            Projection::Perspective { .. } | Projection::Orthographic { .. } => DVec2::ZERO,
        }
    }

    /// The transform from view to clip space, with depth 0 at the near plane and 1 at the far plane; `reverse` swaps
    /// the two depths. `aspect` is width over height.
    pub fn clip(self, aspect: f64, reverse: bool) -> DMat4 {
        let (near, far) = match self {
            Projection::Matrix { clip_from_view, .. } if is_reverse(&clip_from_view) == reverse => {
                return clip_from_view;
            }
            Projection::Matrix { clip_from_view, .. } => {
                let rows = clip_from_view.transpose();
                return DMat4 { z_axis: rows.w_axis - rows.z_axis, ..rows }.transpose();
            }
            _ => self.depth_range(),
        };
        let (first, last) = if reverse { (far, near) } else { (near, far) };
        let diagonal = |x: f64, y: f64, depth: f64| DMat4::from_diagonal(DVec4::new(x, y, depth, 0.0));
        match self {
            Projection::Perspective { vertical_fov, .. } => {
                let height = 1.0 / (0.5 * vertical_fov).tan();
                let (depth, offset) = match (far.is_infinite(), reverse) {
                    (false, _) => (last / (first - last), last / (first - last) * first),
                    (true, false) => (-1.0, -near),
                    (true, true) => (0.0, near),
                };
                let mut clip = diagonal(height / aspect, height, depth);
                (clip.z_axis.w, clip.w_axis.z) = (-1.0, offset);
                clip
            }
            Projection::Orthographic { half_height, .. } => {
                let depth = 1.0 / (first - last);
                let mut clip = diagonal(1.0 / (half_height * aspect), 1.0 / half_height, depth);
                clip.w_axis = DVec4::new(0.0, 0.0, depth * first, 1.0);
                clip
            }
            Projection::Matrix { clip_from_view, .. } => clip_from_view,
        }
    }

    /// The corners of the picture in view space, in metres, at `distance` metres along the view axis: left bottom,
    /// right bottom, left top, right top.
    pub fn corners(self, aspect: f64, distance: f64) -> [DVec2; 4] {
        let signs = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let half_height = match self {
            Projection::Perspective { vertical_fov, .. } => distance * (0.5 * vertical_fov).tan(),
            Projection::Orthographic { half_height, .. } => half_height,
            Projection::Matrix { clip_from_view, .. } => {
                let on_axis = clip_from_view * DVec4::new(0.0, 0.0, -distance, 1.0);
                let across = DMat2::from_cols(
                    clip_from_view.x_axis.truncate().truncate(),
                    clip_from_view.y_axis.truncate().truncate(),
                );
                let back = across.inverse();
                return signs
                    .map(|(x, y)| back * (DVec2::new(x, y) * on_axis.w - on_axis.truncate().truncate()));
            }
        };
        let half_width = half_height * aspect;
        signs.map(|(x, y)| DVec2::new(x * half_width, y * half_height))
    }

    /// The centre of the visible rectangle and half its size, in metres. A perspective camera's rectangle lies at a
    /// distance of 1 m; an orthographic camera's rectangle is the same at every distance.
    pub fn picture(self, aspect: f64) -> (DVec2, DVec2) {
        match self {
            Projection::Matrix { .. } => {
                let corners = self.corners(aspect, 1.0);
                let low = corners.into_iter().reduce(DVec2::min).unwrap_or_default();
                let high = corners.into_iter().reduce(DVec2::max).unwrap_or_default();
                ((low + high) * 0.5, (high - low) * 0.5)
            }
            Projection::Perspective { vertical_fov, .. } => {
                let half = (0.5 * vertical_fov).tan();
                (DVec2::ZERO, DVec2::new(half * aspect, half))
            }
            Projection::Orthographic { half_height, .. } => {
                (DVec2::ZERO, DVec2::new(half_height * aspect, half_height))
            }
        }
    }

    /// Returns the reason for which the projection is invalid, or `None` if it is valid.
    pub(super) fn check(self) -> Option<&'static str> {
        if let Projection::Matrix { clip_from_view, jitter } = self {
            let DVec4 { x, y, z, w } = clip_from_view.transpose().w_axis;
            if !clip_from_view.is_finite() || !jitter.is_finite() {
                return Some("its projection has a value that is not finite");
            }
            if (x, y) != (0.0, 0.0) || !((z < 0.0 && w == 0.0) || (z == 0.0 && w > 0.0)) {
                return Some("its projection is neither perspective nor parallel along the view axis");
            }
            if clip_from_view.determinant() == 0.0 {
                return Some("its projection cannot be turned around");
            }
        }
        let (near, far) = self.depth_range();
        if !near.is_finite() || far.is_nan() || (far.is_infinite() && self.is_orthographic()) {
            return Some("it has a value that is not finite");
        }
        if near >= far {
            return Some("its far plane is not beyond its near plane");
        }
        match self {
            Projection::Perspective { vertical_fov, .. }
                if !(vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI) =>
            {
                Some("its vertical field of view is not between 0 and π")
            }
            Projection::Orthographic { half_height, .. }
                if !(half_height.is_finite() && half_height > 0.0) =>
            {
                Some("its half height is not above zero")
            }
            _ if near <= 0.0 && !self.is_orthographic() => Some("its near plane is not in front of it"),
            _ => None,
        }
    }
}

/// The distance along the view axis, in metres, at which the projection yields this depth; infinite if no distance
/// does.
fn distance_of(clip_from_view: &DMat4, depth: f64) -> f64 {
    let rows = clip_from_view.transpose();
    let along = depth * rows.w_axis - rows.z_axis;
    if along.z == 0.0 { f64::INFINITY } else { along.w / along.z }
}

/// Returns `true` if the projection's depth falls with distance (reversed depth).
fn is_reverse(clip_from_view: &DMat4) -> bool {
    let depth = |distance: f64| {
        let clip = clip_from_view * DVec4::new(0.0, 0.0, -distance, 1.0);
        clip.z / clip.w
    };
    depth(2.0) < depth(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASPECT: f64 = 1.6;

    fn matrix(clip_from_view: DMat4) -> Projection {
        Projection::Matrix { clip_from_view, jitter: DVec2::ZERO }
    }

    #[test]
    fn a_matrix_says_what_angles_and_planes_say() {
        for known in [
            Projection::Perspective { vertical_fov: 1.0, near: 0.5, far: 200.0 },
            Projection::Perspective { vertical_fov: 1.0, near: 0.5, far: f64::INFINITY },
            Projection::Orthographic { half_height: 9.0, near: -5.0, far: 80.0 },
        ] {
            for reverse in [false, true] {
                let found = matrix(known.clip(ASPECT, reverse));
                assert_eq!(found.check(), None, "{found:?}");
                assert_eq!(found.is_orthographic(), known.is_orthographic());
                let ((near, far), (known_near, known_far)) = (found.depth_range(), known.depth_range());
                assert!((near - known_near).abs() < 1e-9, "{near} {known_near}");
                assert!(far == known_far || (far - known_far).abs() < 1e-6, "{far} {known_far}");
                for (found, known) in found.corners(ASPECT, 3.0).into_iter().zip(known.corners(ASPECT, 3.0)) {
                    assert!(found.abs_diff_eq(known, 1e-9), "{found} {known}");
                }
                for other in [false, true] {
                    let (found, known) = (found.clip(ASPECT, other), known.clip(ASPECT, other));
                    assert!(found.abs_diff_eq(known, 1e-9), "{found} {known}");
                }
            }
        }
    }

    #[test]
    fn corners_of_a_sheared_matrix_match_those_of_the_picture() {
        let mut clip = Projection::Perspective { vertical_fov: 0.9, near: 0.1, far: 50.0 }.clip(ASPECT, true);
        (clip.z_axis.x, clip.z_axis.y, clip.y_axis.x) = (0.3, -0.2, 0.15);
        let corners = matrix(clip).corners(ASPECT, 7.0);
        for (corner, wanted) in corners.into_iter().zip([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
        {
            let at = clip * DVec4::new(corner.x, corner.y, -7.0, 1.0);
            assert!((at.truncate().truncate() / at.w).abs_diff_eq(DVec2::from(wanted), 1e-12), "{at}");
        }
        let (center, _) = matrix(clip).picture(ASPECT);
        assert!(center.length() > 0.1, "{center}");
    }

    #[test]
    fn what_no_pass_could_use_is_said() {
        for broken in [DMat4::NAN, DMat4::ZERO, DMat4::from_scale(glam::DVec3::new(1.0, 0.0, 1.0))] {
            assert!(matrix(broken).check().is_some(), "{broken}");
        }
        let behind = Projection::Perspective { vertical_fov: 1.0, near: 0.5, far: 9.0 }.clip(1.0, false);
        assert!(matrix(behind * DMat4::from_scale(glam::DVec3::new(1.0, 1.0, -1.0))).check().is_some());
    }
}
