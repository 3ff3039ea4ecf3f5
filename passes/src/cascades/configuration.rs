//! All settings of a cascade fit, and the fit of one frame.
//!
//! [`Configuration::fit_light`] is a pure function of the frame: no state is kept from frame to frame, so two hosts, or
//! two machines, that see the same frame fit the same cascades.
//!
//! All results are finite for any frame. A camera or light that [`umbragraph_pipeline::frame::Camera::check`] or
//! [`umbragraph_pipeline::frame::Light::check`] rejects, or numbers so large that a matrix does not fit 32 bits, give
//! fewer cascades. In the worst case there are none, and everything is lit.

use glam::{DMat3, DMat4, DVec3, DVec4};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::frame::{FrameInput, Light};

use super::depth::{self, NearPull};
use super::fit::{self, FitShape};
use super::layout::Layout;
use super::snap::{self, Snap, Texels};
use super::splits::{Blend, Slice, Splits};
use super::{MAX_CASCADES, light};
use crate::lights::missing::{self, NoBounds};
use crate::words::{CAST_SHADOW, filters::CASTERS};

/// All settings of a cascade fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// The light's name; `None` for the brightest directional light that casts shadows.
    pub light: Option<String>,
    /// The far distance of each cascade along the view axis.
    pub splits: Splits,
    /// The zone in which a cascade blends into the next.
    pub blend: Blend,
    /// The shape that encloses each slice of the view frustum: a box, or a sphere with a box around it.
    pub shape: FitShape,
    /// The grid to which the texels of each cascade are snapped.
    pub snap: Snap,
    /// Whether texels are as wide as they are high.
    pub square: bool,
    /// The border on each side of a cascade that its slice leaves free for filter taps, in texels.
    pub border: u32,
    /// The world direction that points up in the map.
    pub up: DVec3,
    /// The rule for the position of the near plane.
    pub near_pull: NearPull,
    /// The distance of the far plane from the slice, away from the light, in metres.
    pub far_extension: f64,
    /// Whether cascades are narrowed to the scene's bounds.
    pub clip_to_scene: bool,
    /// Whether depth runs from 1 (near) to 0 (far).
    pub reverse: bool,
    /// The maximum number of frames until a change of casters is drawn.
    pub cadence: u32,
    /// The region of the map and the resolution of each cascade.
    pub layout: Layout,
}

/// One fitted cascade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascade {
    /// The light view, with the layer and texels that it draws into.
    pub view: View,
    /// The matrix from world space to the map's uv (x, y) and clip depth (z).
    pub texture_from_world: DMat4,
    /// The range of distances along the view axis that the cascade covers.
    pub slice: Slice,
    /// The larger side of a texel, in metres.
    pub texel_size: f64,
    /// The distance between near and far plane, in metres.
    pub depth_range: f64,
}

/// The cascades of one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CascadeSet {
    cascades: [Option<Cascade>; MAX_CASCADES],
}

impl CascadeSet {
    /// The cascades, the nearest first.
    pub fn iter(&self) -> impl Iterator<Item = &Cascade> + Clone {
        self.cascades.iter().flatten()
    }

    /// The number of cascades.
    pub fn count(&self) -> usize {
        self.iter().count()
    }
}

impl Configuration {
    /// Fits the cascades of one frame to a light, which has to be usable ([`Light::check`]).
    pub fn fit_light(&self, light: &Light, frame: &FrameInput) -> CascadeSet {
        let mut set = CascadeSet::default();
        if frame.camera.check().is_some() || !light.has(CAST_SHADOW) {
            return set;
        }
        let mut rotation = light::from_world(light.direction, self.up);
        if self.shape == FitShape::Aligned {
            rotation = fit::aligned(&rotation, &frame.camera);
        }
        let (near, mut far) = frame.camera.projection.depth_range();
        if self.needs_far(far) {
            far = farthest(frame).max(2.0 * near);
        }
        for (at, slice) in self.splits.slices(self.blend, near, far).enumerate() {
            set.cascades[at] = self.cascade(at, slice, frame, &rotation);
            // Shaders count on cascades without gaps.
            if set.cascades[at].is_none() {
                break;
            }
        }
        set
    }

    /// Returns `true` if the far plane is at infinity and the cascades cover the camera's entire depth range. Then the
    /// scene's bounds limit them.
    fn needs_far(&self, far: f64) -> bool {
        far.is_infinite() && matches!(self.splits, Splits::Whole { .. })
    }

    /// The finding that the frame has no bounds although the fit needs them; `None` if nothing is missing.
    pub(crate) fn lacks_bounds(&self, frame: &FrameInput) -> Option<NoBounds> {
        let needed = matches!(self.near_pull, NearPull::Casters | NearPull::Scene);
        let (_, far) = frame.camera.projection.depth_range();
        let guessed = self.needs_far(far) && frame.scene_bounds.is_empty();
        let lacks = (needed && missing::has_no_bounds(frame)) || guessed;
        lacks.then(|| NoBounds { reach: guessed.then_some(FAR_WITHOUT_BOUNDS) })
    }

    /// Fits the cascade with index `at` to a slice; `light` is the rotation from world to light space. Returns `None`
    /// if a result is not finite in 32 bits.
    fn cascade(&self, at: usize, slice: Slice, frame: &FrameInput, light: &DMat3) -> Option<Cascade> {
        let FrameInput { camera, scene_bounds, .. } = frame;
        let mut extent = fit::extent(camera, &slice, light, self.shape);
        if self.clip_to_scene {
            extent = fit::within_scene(extent, scene_bounds, light);
        }
        let resolution = self.layout.tiles.get(at)?.resolution;
        let rectangle = snap::rectangle(
            &extent,
            Texels { resolution, border: self.border, square: self.square },
            self.snap,
        );
        let slice_depths = match self.near_pull {
            NearPull::Scene => scene_depths(frame, light),
            NearPull::Casters | NearPull::Metres(_) => None,
        };
        let (near, far) = depth::planes(
            slice_depths.unwrap_or((extent.near, extent.min.z)),
            &rectangle,
            frame.bounds_of(CASTERS),
            light,
            (self.near_pull, self.far_extension),
        );
        let center = rectangle.min + 0.5 * rectangle.size;
        let clip_from_light =
            orthographic(center.extend(near), rectangle.size.extend(near - far), self.reverse);
        let light_from_world = DMat4::from_mat3(*light);
        let eye = center.extend(near);
        let view = View::new(
            clip_from_light * light_from_world,
            DMat4::from_translation(-eye) * light_from_world,
            light.transpose() * eye,
            light.transpose() * DVec3::NEG_Z,
        )
        .reverse(self.reverse)
        .layer(self.layout.tiles[at].layer)
        .viewport(self.layout.viewport(at));
        let cascade = Cascade {
            view,
            texture_from_world: texture_from_clip(self.layout.scale_offset(at)) * view.clip_from_world,
            slice,
            texel_size: rectangle.texel.max_element(),
            depth_range: near - far,
        };
        cascade.is_finite().then_some(cascade)
    }
}

impl Cascade {
    /// Returns `true` if all values are finite after rounding to 32 bits.
    fn is_finite(&self) -> bool {
        let View { clip_from_world, view_from_world, position, forward, .. } = self.view;
        let matrices = [clip_from_world, view_from_world, self.texture_from_world];
        matrices.iter().all(|matrix| matrix.as_mat4().is_finite())
            && position.as_vec3().is_finite()
            && forward.is_finite()
            && (self.texel_size as f32).is_finite()
            && (self.depth_range as f32).is_finite()
    }
}

/// The distance along the view axis at which shadows end, in metres, for a camera without a far plane in a scene
/// without bounds.
const FAR_WITHOUT_BOUNDS: f64 = 1000.0;

/// The distance of the farthest point of the scene along the view axis, in metres; [`FAR_WITHOUT_BOUNDS`] without
/// bounds.
fn farthest(frame: &FrameInput) -> f64 {
    let FrameInput { camera, scene_bounds, .. } = frame;
    if scene_bounds.is_empty() {
        return FAR_WITHOUT_BOUNDS;
    }
    let along = |corner: DVec3| (corner - camera.position).dot(camera.forward());
    scene_bounds.corners().map(along).into_iter().fold(0.0, f64::max)
}

/// The largest and the smallest light-space z of scene and casters, in metres; `None` without bounds.
fn scene_depths(frame: &FrameInput, light: &DMat3) -> Option<(f64, f64)> {
    let bounds = frame.scene_bounds.union(*frame.bounds_of(CASTERS));
    let bounds = fit::in_light_space(&bounds, light);
    (!bounds.is_empty()).then_some((bounds.max.z, bounds.min.z))
}

/// The orthographic projection from light to clip space. `near_center` is the centre of the near plane; `size` has
/// width, height and depth in metres.
fn orthographic(near_center: DVec3, size: DVec3, reverse: bool) -> DMat4 {
    let (depth, offset) = if reverse { (1.0 / size.z, 1.0) } else { (-1.0 / size.z, 0.0) };
    let scale = DVec3::new(2.0 / size.x, 2.0 / size.y, depth);
    let translation = DVec3::new(0.0, 0.0, offset) - near_center * scale;
    DMat4::from_cols(
        DVec4::new(scale.x, 0.0, 0.0, 0.0),
        DVec4::new(0.0, scale.y, 0.0, 0.0),
        DVec4::new(0.0, 0.0, scale.z, 0.0),
        translation.extend(1.0),
    )
}

/// The matrix from clip space to the uv of the map (v points down); depth stays unchanged. `scale_offset` is the
/// transform from the cascade's uv to the map's.
fn texture_from_clip(scale_offset: DVec4) -> DMat4 {
    let DVec4 { x: width, y: height, z: left, w: top } = scale_offset;
    DMat4::from_cols(
        DVec4::new(0.5 * width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -0.5 * height, 0.0, 0.0),
        DVec4::Z,
        DVec4::new(left + 0.5 * width, top + 0.5 * height, 0.0, 1.0),
    )
}
