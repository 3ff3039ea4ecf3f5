//! The view of a spot light: a square perspective along its cone.
//!
//! The picture holds the cone and, where it is asked for, some texels around it, so that filter taps at the cone's edge
//! find something. Its upper side is the world's Y axis, or Z for a light that shines along Y.
//!
//! Limits: the cone's half angle is clamped to [`MIN_ANGLE`]..[`MAX_ANGLE`] (margin included): a cone of 0° is
//! seen with the smallest, and of one that opens to 180° the outermost part lies outside the picture; what lies
//! outside casts no shadow. [`SpotView::clamped`] tells. No direction counts as −Z.

use glam::{DMat3, DMat4, DVec3};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::frame::{Light, LightKind};

use super::{NEAR, is_place, projection, range};
use crate::cascades::light::from_world;

/// The smallest half angle of a view, in radians: half a degree.
pub const MIN_ANGLE: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// The largest half angle of a view, in radians: 80°.
pub const MAX_ANGLE: f64 = 80.0 * std::f64::consts::PI / 180.0;

/// The view of a spot light: a square perspective along its cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotView {
    /// The matrix from world to clip space.
    pub clip_from_world: DMat4,
    /// The matrix from world to view space: a rotation and a translation.
    pub view_from_world: DMat4,
    /// The position of the light, in world metres.
    pub position: DVec3,
    /// The unit direction of the cone's axis, in world space.
    pub forward: DVec3,
    /// The half angle of the view, in radians.
    pub half_angle: f64,
    /// The distance of the near plane, in metres.
    pub near: f64,
    /// The distance of the far plane, in metres.
    pub far: f64,
    /// Whether depth runs from 1 (near) to 0 (far).
    pub reverse: bool,
    /// Whether the half angle was clamped, so that it differs from the cone's half angle with its border.
    pub clamped: bool,
}

impl SpotView {
    /// The view of a spot light; `None` for another kind of light, or an unusable position. `border` is the fraction of
    /// the picture's width, 0 to 0.4, that stays free on each side of the cone (border texels / texels of the tile).
    pub fn new(light: &Light, border: f64, reverse: bool) -> Option<Self> {
        let LightKind::Spot { outer_angle, .. } = light.kind else { return None };
        let cone = [f64::from(outer_angle), range::of(light)];
        Self::of(light.position, light.direction, cone, border, reverse)
    }

    /// The view along a cone with a half angle in radians and a range in metres; `None` for an unusable position.
    /// `border` is the fraction of the picture's width that stays free on each side, 0 to 0.4.
    pub fn of(
        position: DVec3,
        direction: DVec3,
        [half_angle, range]: [f64; 2],
        border: f64,
        reverse: bool,
    ) -> Option<Self> {
        if !is_place(position) {
            return None;
        }
        let border = if border > 0.0 { border.min(0.4) } else { 0.0 };
        let cone = if half_angle > 0.0 { half_angle.min(MAX_ANGLE) } else { 0.0 };
        let with_border = (cone.tan() / (1.0 - 2.0 * border)).atan();
        let angle = with_border.clamp(MIN_ANGLE, MAX_ANGLE);
        let far = range::clamped(range);
        let forward = range::direction(direction);
        let rotation: DMat3 = from_world(forward, DVec3::Y);
        let view_from_world = DMat4::from_mat3(rotation) * DMat4::from_translation(-position);
        let scale = 1.0 / angle.tan();
        Some(Self {
            clip_from_world: projection(scale, scale, NEAR, far, reverse) * view_from_world,
            view_from_world,
            position,
            forward,
            half_angle: angle,
            near: NEAR,
            far,
            reverse,
            clamped: angle != with_border || cone != half_angle,
        })
    }

    /// Half the width of the picture at a distance of 1 m, in metres. A texel of a tile of `size` texels is `2 ·
    /// half_width / size` wide per metre of distance.
    pub fn half_width(&self) -> f64 {
        self.half_angle.tan()
    }

    /// The view for draws into a layer of a shadow map. `viewport` is x, y, width and height in texels; `None` is the
    /// entire layer.
    pub fn view(&self, layer: u32, viewport: Option<[u32; 4]>) -> View {
        View::new(self.clip_from_world, self.view_from_world, self.position, self.forward)
            .reverse(self.reverse)
            .layer(layer)
            .viewport(viewport)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use umbragraph_test_support::property;

    use super::*;
    use crate::views::depth;

    fn any() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => -50.0..50.0f64, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(f64::NEG_INFINITY),
            1 => Just(0.0), 1 => Just(1e300), 1 => Just(1e-310), 1 => Just(1e9), 1 => Just(std::f64::consts::PI),
            1 => Just(std::f64::consts::FRAC_PI_2),
        ]
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn whatever_a_light_says_its_view_is_finite_and_can_be_inverted(
            position in proptest::array::uniform3(any()), direction in proptest::array::uniform3(any()),
            angle in any(), range in any(), border in any(), reverse: bool,
        ) {
            let view = SpotView::of(position.into(), direction.into(), [angle, range], border, reverse);
            let usable = position.iter().all(|value| value.abs() <= 1e9);
            prop_assert_eq!(view.is_some(), usable);
            if let Some(view) = view {
                prop_assert!(view.clip_from_world.as_mat4().is_finite());
                prop_assert!(view.clip_from_world.inverse().is_finite());
                prop_assert!((view.forward.length() - 1.0).abs() < 1e-9 && view.near < view.far);
                prop_assert!((view.view_from_world.determinant() - 1.0).abs() < 1e-9);
            }
        }

        #[test]
        fn points_of_the_cone_are_in_the_picture_at_the_analytic_depth(
            turn in 0.0..7.0f64, part in 0.0..1.0f64, along in 0.06..20.0f64, angle in 0.02..1.3f64,
            direction in proptest::array::uniform3(-1.0..1.0f64), reverse: bool,
        ) {
            let direction = DVec3::from(direction).normalize_or(DVec3::X);
            let position = DVec3::new(3.0, -2.0, 500.0);
            let view = SpotView::of(position, direction, [angle, 20.0], 4.0 / 256.0, reverse).unwrap();
            prop_assert!(!view.clamped);
            let (side, up) = direction.any_orthonormal_pair();
            let off = along * angle.tan() * part;
            let point = position + direction * along + (side * turn.cos() + up * turn.sin()) * off;
            let clip = view.clip_from_world * point.extend(1.0);
            let edge = 1.0 - 2.0 * 4.0 / 256.0 + 1e-6;
            prop_assert!((clip.w - along).abs() < 1e-9);
            prop_assert!(clip.x.hypot(clip.y) / clip.w <= edge);
            prop_assert!((clip.z / clip.w - depth(along, view.near, view.far, reverse)).abs() < 1e-9);
        }
    }

    #[test]
    fn cones_of_no_and_of_all_width_are_clamped_and_say_so() {
        let of = |angle: f64| SpotView::of(DVec3::ZERO, DVec3::NEG_Y, [angle, 5.0], 0.0, false).unwrap();
        assert_eq!((of(0.0).half_angle, of(0.0).clamped), (MIN_ANGLE, true));
        assert_eq!(of(std::f64::consts::FRAC_PI_2).half_angle, MAX_ANGLE);
        assert!(of(std::f64::consts::PI).clamped && of(f64::NAN).clamped && !of(0.7).clamped);
        assert!((of(0.7).half_angle - 0.7).abs() < 1e-12);
        assert_eq!(of(0.7).view(2, Some([1, 2, 3, 4])).viewport, Some([1, 2, 3, 4]));
    }
}
