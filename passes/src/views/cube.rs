//! The six views of a point light.
//!
//! | face | +X | −X | +Y | −Y | +Z | −Z |
//! |---|---|---|---|---|---|---|
//! | u before the division by the major axis | −z | z | x | x | x | −x |
//! | v, downwards | −y | −y | z | −z | −y | −y |
//!
//! These are WebGPU's, so that a cube texture's own lookup finds what was drawn. Seen from inside, a face is then a
//! *mirror image* (+Y up on the face +X puts +Z to the left of the picture), which no rotation gives. So each view is a
//! rotation as any other, and its projection swaps left and right: **front faces come out clockwise**, and whoever
//! culls has to cull the other side for these views.
//!
//! A direction belongs to the face of its largest component; of equal ones to X before Y before Z. Neighbouring faces
//! meet at 90°, so that there is neither a gap nor an overlap; a view can be made wider by some texels, for faces in
//! an array or an atlas whose filters cannot step over to the next face ([`CubeViews::of`]).

use glam::{DMat3, DMat4, DVec3};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::frame::{Light, LightKind};

use super::{NEAR, is_place, projection, range};

/// A face of a cube. Its number is the index of its layer in a cube texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Face {
    /// Towards +X.
    PositiveX,
    /// Towards −X.
    NegativeX,
    /// Towards +Y.
    PositiveY,
    /// Towards −Y.
    NegativeY,
    /// Towards +Z.
    PositiveZ,
    /// Towards −Z.
    NegativeZ,
}

/// The direction at the centre of each face, and the directions in which u and v grow.
const DIRECTIONS: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::X, DVec3::NEG_Y],
    [DVec3::NEG_Z, DVec3::NEG_X, DVec3::NEG_Y],
];

impl Face {
    /// All faces in the order of their layers.
    pub const ALL: [Self; 6] = [
        Self::PositiveX,
        Self::NegativeX,
        Self::PositiveY,
        Self::NegativeY,
        Self::PositiveZ,
        Self::NegativeZ,
    ];

    /// The direction at the centre of the face.
    pub fn forward(self) -> DVec3 {
        DIRECTIONS[self as usize][0]
    }

    /// The directions in which u and v of the face grow.
    pub fn axes(self) -> (DVec3, DVec3) {
        let [_, u, v] = DIRECTIONS[self as usize];
        (u, v)
    }

    /// The rotation from world to view space, right-handed and looking along −Z.
    pub fn rotation(self) -> DMat3 {
        let (u, v) = self.axes();
        DMat3::from_cols(-u, -v, -self.forward()).transpose()
    }
}

/// The six views of a point light, one for each face of a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeViews {
    /// The position of the light, in world metres.
    pub position: DVec3,
    /// The distance of the near planes, in metres.
    pub near: f64,
    /// The distance of the far planes along each view's axis, in metres: the light's range.
    pub far: f64,
    /// The tangent of half the angle of each view: 1 for 90°.
    pub half_width: f64,
    /// Whether depth runs from 1 (near) to 0 (far).
    pub reverse: bool,
}

impl CubeViews {
    /// The views of a point light; `None` for another kind of light, or an unusable position. `border` is the fraction
    /// of each picture's width, 0 to 0.4, that lies outside the face on each side.
    pub fn new(light: &Light, border: f64, reverse: bool) -> Option<Self> {
        let LightKind::Point = light.kind else { return None };
        Self::of(light.position, range::of(light), border, reverse)
    }

    /// The views from a position, with a range in metres; `None` for an unusable position. `border` is the fraction of
    /// each picture's width, 0 to 0.4, that lies outside the face on each side (border texels / all texels).
    pub fn of(position: DVec3, range: f64, border: f64, reverse: bool) -> Option<Self> {
        if !is_place(position) {
            return None;
        }
        let border = if border > 0.0 { border.min(0.4) } else { 0.0 };
        let far = range::clamped(range);
        Some(Self { position, near: NEAR, far, half_width: 1.0 / (1.0 - 2.0 * border), reverse })
    }

    /// The matrix from world to view space of a face: a rotation and a translation.
    pub fn view_from_world(&self, face: Face) -> DMat4 {
        DMat4::from_mat3(face.rotation()) * DMat4::from_translation(-self.position)
    }

    /// The matrix from world to clip space of a face, which mirrors left and right.
    pub fn clip_from_world(&self, face: Face) -> DMat4 {
        let scale = 1.0 / self.half_width;
        projection(-scale, scale, self.near, self.far, self.reverse) * self.view_from_world(face)
    }

    /// The view of a face for draws into a layer of a shadow map. `viewport` is x, y, width and height in texels;
    /// `None` is the entire layer.
    pub fn view(&self, face: Face, layer: u32, viewport: Option<[u32; 4]>) -> View {
        View::new(self.clip_from_world(face), self.view_from_world(face), self.position, face.forward())
            .reverse(self.reverse)
            .layer(layer)
            .viewport(viewport)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, UVec2};
    use proptest::prelude::*;
    use umbragraph_test_support::property;

    use super::*;
    use crate::views::depth;

    /// The cube face in a direction, the place on the face (0..1, v down), and the length of the direction along the
    /// face's axis, which determines the stored depth. `None` for a direction that is zero or not finite.
    fn lookup(direction: DVec3) -> Option<(Face, DVec2, f64)> {
        let size = direction.abs();
        let major = size.max_element();
        if !(direction.is_finite() && major > 0.0) {
            return None;
        }
        let (axis, negative) = if size.x == major {
            (0, direction.x < 0.0)
        } else if size.y == major {
            (1, direction.y < 0.0)
        } else {
            (2, direction.z < 0.0)
        };
        let face = Face::ALL[2 * axis + usize::from(negative)];
        let (u, v) = face.axes();
        let across = DVec2::new((direction / major).dot(u), (direction / major).dot(v));
        Some((face, 0.5 * across + 0.5, major))
    }

    /// The cube face in a direction, and the texel on the face, for faces with `size` texels on a side.
    fn texel(direction: DVec3, size: u32) -> Option<(Face, UVec2)> {
        let (face, place, _) = lookup(direction)?;
        let size = size.max(1);
        let texel = (place * f64::from(size)).floor().as_uvec2();
        Some((face, texel.min(UVec2::splat(size - 1))))
    }

    /// The direction towards a place on a face (0..1 with v down); its largest component is 1.
    fn direction(face: Face, place: DVec2) -> DVec3 {
        let (u, v) = face.axes();
        let across = place * 2.0 - 1.0;
        face.forward() + u * across.x + v * across.y
    }

    /// The texel that a point covers when a face's matrix projects it, and its depth; `None` if the point is outside
    /// the view.
    fn rasterised(views: &CubeViews, face: Face, point: DVec3, size: u32) -> Option<(UVec2, f64)> {
        let clip = views.clip_from_world(face) * point.extend(1.0);
        if clip.w <= 0.0 || clip.x.abs() > clip.w || clip.y.abs() > clip.w {
            return None;
        }
        let place = DVec2::new(clip.x / clip.w, -clip.y / clip.w) * 0.5 + 0.5;
        let texel = (place * f64::from(size)).floor().as_uvec2().min(UVec2::splat(size - 1));
        Some((texel, clip.z / clip.w))
    }

    #[test]
    fn the_faces_are_those_of_the_table() {
        // Written out once more, as the shaders have it: u and v before the division by the major axis.
        let table: [fn(DVec3) -> (f64, f64); 6] = [
            |d| (-d.z, -d.y),
            |d| (d.z, -d.y),
            |d| (d.x, d.z),
            |d| (d.x, -d.z),
            |d| (d.x, -d.y),
            |d| (-d.x, -d.y),
        ];
        for (face, table) in Face::ALL.into_iter().zip(table) {
            let direction = face.forward() + DVec3::new(0.3, 0.2, -0.1) * (DVec3::ONE - face.forward().abs());
            let (found, place, major) = lookup(direction).unwrap();
            let (u, v) = table(direction);
            assert_eq!((found, major), (face, 1.0));
            assert!((place - DVec2::new(u, v) * 0.5 - 0.5).length() < 1e-12, "{face:?}");
            assert!((face.rotation().determinant() - 1.0).abs() < 1e-12, "{face:?} is no rotation");
            assert_eq!(face.rotation() * face.forward(), DVec3::NEG_Z);
        }
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn a_direction_leads_to_the_texel_that_rasterising_hits(
            direction in proptest::array::uniform3(-1.0..1.0f64), length in 0.1..9.0f64,
            size in prop::sample::select(vec![1u32, 2, 7, 16, 512, 1024]), reverse: bool,
        ) {
            let direction = DVec3::from(direction).normalize_or(DVec3::X) * length;
            let position = DVec3::new(100.0, -3.0, 7.0);
            let views = CubeViews::of(position, 12.0, 0.0, reverse).unwrap();
            let (face, texel) = texel(direction, size).unwrap();
            let (_, place, along) = lookup(direction).unwrap();
            // Where rounding decides between neighbours nothing is claimed.
            let inside = (place * f64::from(size)).fract();
            prop_assume!(inside.min_element() > 1e-6 && inside.max_element() < 1.0 - 1e-6);
            let hits: Vec<_> = Face::ALL
                .into_iter()
                .filter_map(|face| Some((face, rasterised(&views, face, position + direction, size)?)))
                .collect();
            prop_assert_eq!(hits.len(), 1);
            prop_assert_eq!((hits[0].0, hits[0].1.0), (face, texel));
            prop_assert!((hits[0].1.1 - depth(along, views.near, views.far, reverse)).abs() < 1e-9);
        }

        #[test]
        fn the_analytic_depth_is_that_of_the_matrix(
            along in 0.05..30.0f64, x in -1.0..1.0f64, y in -1.0..1.0f64, range in 0.2..40.0f64,
        ) {
            for face in Face::ALL {
                for reverse in [false, true] {
                    let views = CubeViews::of(DVec3::ZERO, range, 0.0, reverse).unwrap();
                    let (u, v) = face.axes();
                    let point = (face.forward() + u * x + v * y) * along;
                    let clip = views.clip_from_world(face) * point.extend(1.0);
                    let matrix = clip.z / clip.w;
                    let near = 0.05;
                    let forward = range / (range - near) * (1.0 - near / along);
                    let analytic = if reverse { near / (range - near) * (range / along - 1.0) } else { forward };
                    prop_assert!((matrix - analytic).abs() < 1e-9, "{} {}", matrix, analytic);
                    prop_assert!((depth(along, near, range, reverse) - analytic).abs() < 1e-9);
                    // 32 bits, as on a GPU.
                    let single = views.clip_from_world(face).as_mat4() * point.as_vec3().extend(1.0);
                    prop_assert!((f64::from(single.z / single.w) - analytic).abs() < 1e-5);
                }
            }
        }

        #[test]
        fn places_and_directions_are_inverse(
            u in 0.001..0.999f64, v in 0.001..0.999f64, face in 0usize..6,
        ) {
            let (found, place, major) = lookup(direction(Face::ALL[face], DVec2::new(u, v)) * 3.0).unwrap();
            prop_assert_eq!(found, Face::ALL[face]);
            prop_assert!((place - DVec2::new(u, v)).length() < 1e-12 && (major - 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn edges_and_corners_lead_to_exactly_one_face() {
        let face = |x, y, z| lookup(DVec3::new(x, y, z)).map(|(face, ..)| face);
        assert_eq!(face(1.0, 1.0, 1.0), Some(Face::PositiveX));
        assert_eq!(face(0.0, -2.0, 2.0), Some(Face::NegativeY));
        assert_eq!([face(0.0, 0.0, 0.0), face(f64::NAN, 1.0, 0.0), face(f64::INFINITY, 1.0, 0.0)], [None; 3]);
        assert_eq!(texel(DVec3::ONE, 8), Some((Face::PositiveX, UVec2::ZERO)));
        assert_eq!(texel(DVec3::new(1.0, -1.0, -1.0), 8), Some((Face::PositiveX, UVec2::splat(7))));
        assert_eq!(texel(DVec3::splat(1e-320), 0), Some((Face::PositiveX, UVec2::ZERO)));
    }

    #[test]
    fn front_faces_come_out_mirrored() {
        for face in Face::ALL {
            let clip = CubeViews::of(DVec3::ZERO, 9.0, 0.0, false).unwrap().clip_from_world(face);
            let linear = DMat3::from_cols(
                clip.x_axis.truncate().with_z(-clip.x_axis.w),
                clip.y_axis.truncate().with_z(-clip.y_axis.w),
                clip.z_axis.truncate().with_z(-clip.z_axis.w),
            );
            assert!(linear.determinant() < 0.0, "{face:?}");
        }
    }

    #[test]
    fn a_border_widens_the_views_by_its_texels() {
        // 4 of 64 texels on each side: the face itself is 56 texels wide.
        let views = CubeViews::of(DVec3::ZERO, 9.0, 4.0 / 64.0, false).unwrap();
        let edge = views.clip_from_world(Face::PositiveZ) * DVec3::new(2.0, 0.0, 2.0).extend(1.0);
        assert!((edge.x / edge.w - 56.0 / 64.0).abs() < 1e-12);
    }

    #[test]
    fn whatever_a_light_says_its_views_are_finite() {
        for range in [f64::NAN, 0.0, -3.0, 1e-300, 1e300, f64::INFINITY] {
            for border in [f64::NAN, -1.0, 0.0, 0.5, 1e9] {
                for position in [DVec3::ZERO, DVec3::splat(1e9), DVec3::splat(-1e9)] {
                    let views = CubeViews::of(position, range, border, true).unwrap();
                    for face in Face::ALL {
                        let clip = views.view(face, 0, None).clip_from_world;
                        assert!(clip.as_mat4().is_finite() && clip.inverse().is_finite(), "{range} {border}");
                    }
                }
            }
        }
        for position in [DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e10)] {
            assert_eq!(CubeViews::of(position, 1.0, 0.0, false), None);
        }
    }
}
