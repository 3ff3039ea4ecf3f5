//! Frustum tests of boxes.
//!
//! The corners of the box are transformed to clip space; the box is culled if all of them lie beyond the same side of
//! the view: left, right, below or above. That is conservative for any affine or perspective view, also for corners
//! behind it. The near and far planes do not cull: a shadow caster between the light and the near plane must be drawn
//! if depth is clamped, and clipping does the rest.

use glam::DMat4;
use umbragraph_pipeline::frame::Bounds;

/// Returns `false` if `bounds` is empty or lies entirely outside the left, right, bottom or top plane of the view
/// frustum. The near and far planes are not tested.
pub fn may_be_visible(bounds: &Bounds, clip_from_world: &DMat4) -> bool {
    if bounds.is_empty() {
        return false;
    }
    // A bit for each side, set while all corners so far lie beyond it.
    let beyond = bounds.corners().into_iter().fold(0b1111_u8, |beyond, corner| {
        let clip = *clip_from_world * corner.extend(1.0);
        let sides = [clip.x < -clip.w, clip.x > clip.w, clip.y < -clip.w, clip.y > clip.w];
        beyond
            & sides
                .into_iter()
                .enumerate()
                .fold(0, |bits, (side, is_beyond)| bits | u8::from(is_beyond) << side)
    });
    beyond == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use umbragraph_pipeline::frame::{Camera, Projection};

    fn view() -> DMat4 {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let camera = Camera::new(DVec3::ZERO, DQuat::IDENTITY, projection, 1.0);
        camera.clip(false) * camera.view()
    }

    fn cube(center: DVec3, half: f64) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    #[test]
    fn boxes_in_view_around_the_eye_and_across_a_side_are_kept() {
        let kept = [
            cube(DVec3::new(0.0, 0.0, -10.0), 1.0),
            cube(DVec3::ZERO, 5.0),
            cube(DVec3::new(6.0, 0.0, -10.0), 1.0),
            cube(DVec3::new(0.0, 0.0, 50.0), 80.0),
        ];
        assert!(kept.iter().all(|bounds| may_be_visible(bounds, &view())));
    }

    #[test]
    fn boxes_beside_behind_and_without_extent_are_left_out() {
        let left_out = [
            cube(DVec3::new(20.0, 0.0, -10.0), 1.0),
            cube(DVec3::new(-20.0, 0.0, -10.0), 1.0),
            cube(DVec3::new(0.0, -20.0, -10.0), 1.0),
            cube(DVec3::new(0.0, 20.0, -10.0), 1.0),
            cube(DVec3::new(0.0, 0.0, 10.0), 1.0),
            Bounds::EMPTY,
        ];
        assert!(left_out.iter().all(|bounds| !may_be_visible(bounds, &view())));
    }

    #[test]
    fn no_box_with_a_visible_point_is_ever_left_out() {
        let mut numbers = umbragraph_test_support::random::Random(7);
        let mut random = || numbers.unit() * 60.0 - 30.0;
        let mut seen = 0;
        for _ in 0..20_000 {
            let bounds = cube(DVec3::new(random(), random(), random()), random().abs());
            let inside = bounds.min.lerp(bounds.max, 0.3);
            let clip = view() * inside.extend(1.0);
            if clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w {
                seen += 1;
                assert!(may_be_visible(&bounds, &view()), "{bounds:?}");
            }
        }
        assert!(seen > 1000);
    }
}
