//! The node kind `camera`: the frame's camera as a view.
//!
//! Published, besides one view: [`shape`].
//!
//! Jitter: each frame is drawn a part of a pixel aside, by a point of the Halton sequence of the bases 2 and 3 (J.
//! Halton, 1960), so that the mean of frames has the samples of all of them. It is in every matrix to and from clip
//! space, and in the view, but not in `half_size`; cascades are fitted to the camera without it, and stay where they
//! are. The matrices of the frame before have the jitter of this one: what does not move is found at its own pixel
//! again, and what an effect has to know of jitter is nothing.
//!
//! The index identifies a frame: if it is recorded again, its previous frame stays the same. In the first frame, and
//! after one without a usable camera, the previous frame is the frame itself.
//!
//! Limits: a camera with unusable values (not finite, an empty depth range), or one whose matrices do not fit 32 bits,
//! is replaced by one whose matrices are all the identity, so that passes find finite values and a view to clear with.
//! Only the camera's motion is in the matrices, not that of what it sees.

use glam::{DMat4, DQuat, DVec2, DVec3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, DataShape, ValueType, View};
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::frame::{Camera as FrameCamera, Projection};
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

/// Publishes the frame's camera as a view, and its matrices and directions by name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false by default.
    pub reverse: Option<Expr>,
    /// The number of points of the Halton sequence that jitter the picture within a pixel, for effects that accumulate
    /// samples over frames. 0, the default, is no jitter.
    pub jitter: Option<Expr>,
}

/// The far distance that is published for a camera whose far plane is at infinity, in metres.
const NO_FAR_PLANE: f64 = 1e30;

/// The maximum number of jitter points; accumulating more frames makes no visible difference.
const MAX_JITTER: u32 = 1024;

/// The number of jitter points of a pass; 0 for no jitter. `None` follows a diagnostic.
fn points(setting: &Option<Expr>, pass: &mut impl Evaluate) -> Option<u32> {
    let jitter = pass.count_or(setting, "/jitter", 0)?;
    if jitter > MAX_JITTER {
        let message = format!("\"jitter\" ({jitter} points) is larger than the maximum ({MAX_JITTER})");
        let help = "8 or 16 points are usual";
        return pass.reject(codes::OUT_OF_BOUNDS, "/jitter", message, help);
    }
    Some(jitter)
}

impl Node for Camera {
    const NAME: &'static str = "camera";
    const SUMMARY: &'static str = "Publishes the frame's camera as a view.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let reverse = pass.boolean_or(&self.reverse, "/reverse", false)?;
        let jitter = pass.live(|pass| points(&self.jitter, pass))?;
        let output = pass.publish(&self.to, "/to", shape())?;
        pass.produce(Work::Cpu(CpuWork::new(
            RunCamera { setting: self.jitter.clone(), reverse, jitter },
            output,
            Vec::new(),
        )))
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", shape())]
    }
}

/// The names and types of the data that a camera publishes, in metres unless stated otherwise. The matrices are
/// computed in `f64`.
pub fn shape() -> DataShape {
    let matrix = ValueType::MAT4;
    DataShape::new()
        .value("clip_from_world", matrix, "world to clip space, depth 0..1, or 1..0 reversed")
        .value("clip_from_view", matrix, "view space (looks along -z) to clip space")
        .value("view_from_world", matrix, "world to view space")
        .value("world_from_clip", matrix, "the inverse of `clip_from_world`")
        .value("view_from_clip", matrix, "the inverse of `clip_from_view`")
        .value("world_from_view", matrix, "the inverse of `view_from_world`")
        .value("position", ValueType::VEC3, "where the camera stands in the world")
        .value("forward", ValueType::VEC3, "the unit direction in which it looks, in the world")
        .value("right", ValueType::VEC3, "the unit direction to its right")
        .value("up", ValueType::VEC3, "the unit direction that is up in the picture")
        .value("near", ValueType::F32, "the distance of the near plane along the view axis")
        .value("far", ValueType::F32, "the distance of the far plane along the view axis; 1e30 where there is none")
        .value("aspect", ValueType::F32, "width over height")
        .value("time", ValueType::F32, "seconds since some start of the host's")
        .value("time_step", ValueType::F32, "seconds since the frame before; 0 in the first frame")
        .value("orthographic", ValueType::U32, "1 for an orthographic camera, else 0")
        .value("reverse", ValueType::U32, "1 where depth runs from 1 to 0, else 0")
        .value("frame_index", ValueType::U32, "counts frames, modulo 2³²")
        .value(
            "half_size",
            ValueType::VEC2,
            "half the visible width and height: at 1 m for a perspective, anywhere for an orthographic camera",
        )
        .value(
            "off_center",
            ValueType::VEC2,
            "the middle of what is seen, as `half_size`: 0 unless the projection is off-centre",
        )
        .value("jitter", ValueType::VEC2, "by how much the picture is moved in clip space; 0 unless the pass asks for `jitter`, or the host moves it")
        .value("previous_clip_from_world", matrix, "`clip_from_world` of the frame before, with this frame's jitter")
        .value("previous_view_from_world", matrix, "`view_from_world` of the frame before")
        .value("previous_clip_from_clip", matrix, "clip space to that of the frame before, for what does not move")
        .value("previous_position", ValueType::VEC3, "where the camera stood in the frame before")
        .views(1)
}

#[derive(Clone, Debug, PartialEq)]
struct RunCamera {
    setting: Option<Expr>,
    reverse: bool,
    /// The number of jitter points; 0 for no jitter.
    jitter: u32,
}

/// The camera and the time of the last frame with its frame index, and those of the frame before; no camera has jitter.
#[derive(Default)]
struct Frames {
    last: Option<(u64, (Lens, f64))>,
    before: Option<(Lens, f64)>,
}

impl Frames {
    /// Records the camera and the time of frame `index`, and returns those of the frame before. In the first frame it
    /// returns `now`.
    fn advance(&mut self, index: u64, now: (Lens, f64)) -> (Lens, f64) {
        if self.last.is_none_or(|(last, _)| last != index) {
            self.before = self.last.map(|(_, last)| last);
        }
        self.last = Some((index, now));
        self.before.unwrap_or(now)
    }
}

impl CpuNode for RunCamera {
    type State = Frames;

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        self.jitter = points(&self.setting, settings)?;
        Some(())
    }

    fn run(&self, frames: &mut Frames, context: &CpuContext<'_>, data: &mut BlackboardData) {
        let index = context.frame.index;
        let jitter = jitter(self.jitter, index, context.viewport) + context.frame.camera.projection.jitter();
        let aside = DMat4::from_translation(jitter.extend(0.0));
        let lens = Lens::of(&context.frame.camera, self.reverse);
        let moved = lens.map(|lens| (lens, lens.moved(&aside)));
        let time = Some(context.frame.time).filter(|time| (*time as f32).is_finite()).unwrap_or_default();
        let ((before, time_before), lens) = match moved.filter(|(_, lens)| lens.is_finite()) {
            Some((now, lens)) => (frames.advance(index, (now, time)), lens),
            None => {
                *frames = Frames::default();
                ((Lens::identity(), time), Lens::identity())
            }
        };
        lens.publish(self.reverse, data);
        let before_clip = aside * before.clip_from_view * before.view_from_world;
        data.set_matrix("previous_clip_from_world", &before_clip);
        data.set_matrix("previous_view_from_world", &before.view_from_world);
        // From view to view first: what cancels there is as large as the way from the origin.
        let before_from_view = before.view_from_world * lens.world_from_view;
        let from_clip = aside * before.clip_from_view * before_from_view * lens.view_from_clip;
        data.set_matrix("previous_clip_from_clip", &from_clip);
        data.set_vec3("previous_position", before.camera.position.as_vec3());
        data.set_f32s("jitter", [jitter.x as f32, jitter.y as f32]);
        data.set_f32("time", time as f32);
        let step = (time - time_before).clamp(f32::MIN.into(), f32::MAX.into());
        data.set_f32("time_step", step as f32);
        // Whatever counts frames wraps around.
        data.set_u32("frame_index", context.frame.index as u32);
    }
}

/// The jitter of a frame in clip space: at most half a pixel to each side. `points` is the number of jitter points;
/// `width` and `height` are in pixels.
fn jitter(points: u32, index: u64, [width, height]: [u32; 2]) -> DVec2 {
    if points == 0 {
        return DVec2::ZERO;
    }
    // The first point is 0 in each base, in a corner of the pixel; the sequence begins behind it.
    let at = (index % u64::from(points)) as u32 + 1;
    let within = DVec2::new(radical_inverse(at, 2), radical_inverse(at, 3)) - 0.5;
    2.0 * within / DVec2::new(f64::from(width.max(1)), f64::from(height.max(1)))
}

/// The radical inverse of a number: its digits in `base` mirrored at the radix point, at least 0 and less than 1.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= f64::from(base);
        inverse += digit * f64::from(number % base);
        number /= base;
    }
    inverse
}

/// A camera and its matrices.
#[derive(Clone, Copy)]
struct Lens {
    camera: FrameCamera,
    clip_from_view: DMat4,
    view_from_clip: DMat4,
    view_from_world: DMat4,
    world_from_view: DMat4,
}

impl Lens {
    fn of(camera: &FrameCamera, reverse: bool) -> Option<Self> {
        if camera.check().is_some() {
            return None;
        }
        let clip_from_view = camera.clip(reverse);
        Some(Self {
            camera: *camera,
            clip_from_view,
            view_from_clip: clip_from_view.inverse(),
            view_from_world: camera.view(),
            world_from_view: DMat4::from_rotation_translation(camera.rotation, camera.position),
        })
    }

    fn identity() -> Self {
        let unit = Projection::Orthographic { half_height: 1.0, near: 0.0, far: 1.0 };
        Self {
            camera: FrameCamera::new(DVec3::ZERO, DQuat::IDENTITY, unit, 1.0),
            clip_from_view: DMat4::IDENTITY,
            view_from_clip: DMat4::IDENTITY,
            view_from_world: DMat4::IDENTITY,
            world_from_view: DMat4::IDENTITY,
        }
    }

    /// Moves the picture by `aside`, a translation in clip space.
    fn moved(self, aside: &DMat4) -> Self {
        let clip_from_view = *aside * self.clip_from_view;
        Self { clip_from_view, view_from_clip: clip_from_view.inverse(), ..self }
    }

    fn clip_from_world(&self) -> DMat4 {
        self.clip_from_view * self.view_from_world
    }

    fn world_from_clip(&self) -> DMat4 {
        self.world_from_view * self.view_from_clip
    }

    /// The distances of the near and the far plane along the view axis, in metres.
    fn planes(&self) -> [f64; 2] {
        let (near, far) = self.camera.projection.depth_range();
        [near, far.min(NO_FAR_PLANE)]
    }

    /// The centre of the visible rectangle and half its size: in metres, for a perspective camera at a distance of 1 m.
    fn picture(&self) -> [[f32; 2]; 2] {
        let (center, half_size) = self.camera.projection.picture(self.camera.aspect);
        [center, half_size].map(|size| size.as_vec2().to_array())
    }

    /// Returns `true` if all matrices, distances and sizes are finite when they are rounded to 32 bits.
    fn is_finite(&self) -> bool {
        let own = [self.clip_from_view, self.view_from_clip, self.view_from_world, self.world_from_view];
        let products = [self.clip_from_world(), self.world_from_clip()];
        own.iter().chain(&products).all(|matrix| matrix.as_mat4().is_finite())
            && self.planes().iter().chain(&[self.camera.aspect]).all(|number| (*number as f32).is_finite())
            && self.picture().iter().flatten().all(|number| number.is_finite())
    }

    fn publish(&self, reverse: bool, data: &mut BlackboardData) {
        let Self { camera, .. } = self;
        let direction = |axis: DVec3| -> Vec3 { (camera.rotation * axis).as_vec3() };
        data.set_matrix("clip_from_world", &self.clip_from_world());
        data.set_matrix("clip_from_view", &self.clip_from_view);
        data.set_matrix("view_from_world", &self.view_from_world);
        data.set_matrix("world_from_clip", &self.world_from_clip());
        data.set_matrix("view_from_clip", &self.view_from_clip);
        data.set_matrix("world_from_view", &self.world_from_view);
        data.set_vec3("position", camera.position.as_vec3());
        data.set_vec3("forward", direction(DVec3::NEG_Z));
        data.set_vec3("right", direction(DVec3::X));
        data.set_vec3("up", direction(DVec3::Y));
        let [near, far] = self.planes();
        data.set_f32("near", near as f32);
        data.set_f32("far", far as f32);
        data.set_f32("aspect", camera.aspect as f32);
        let [center, half_size] = self.picture();
        data.set_f32s("half_size", half_size);
        data.set_f32s("off_center", center);
        data.set_u32("orthographic", u32::from(camera.projection.is_orthographic()));
        data.set_u32("reverse", u32::from(reverse));
        let forward = camera.rotation * DVec3::NEG_Z;
        let view = View::new(self.clip_from_world(), self.view_from_world, camera.position, forward);
        data.push_view(view.reverse(reverse));
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec4, Mat4};
    use umbragraph_pipeline::frame::FrameInput;

    use super::*;

    fn run(camera: FrameCamera, reverse: bool) -> BlackboardData {
        frames(&RunCamera { setting: None, reverse, jitter: 0 }, &mut Frames::default(), camera, u64::MAX)
    }

    fn frames(node: &RunCamera, state: &mut Frames, camera: FrameCamera, index: u64) -> BlackboardData {
        let frame = FrameInput::new(camera).time(f64::NAN).index(index);
        let mut data = BlackboardData::new(shape());
        node.run(state, &CpuContext { frame: &frame, viewport: [640, 400], inputs: &[] }, &mut data);
        assert_eq!(data.rejected(), None);
        data
    }

    fn floats(data: &BlackboardData, name: &str) -> Vec<f32> {
        data.words(name).unwrap().iter().map(|word| f32::from_bits(*word)).collect()
    }

    fn matrix(data: &BlackboardData, name: &str) -> DMat4 {
        Mat4::from_cols_slice(&floats(data, name)).as_dmat4()
    }

    fn tilted(projection: Projection) -> FrameCamera {
        FrameCamera::new(
            DVec3::new(3.0, 2.0, -7.0),
            DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.3),
            projection,
            1.6,
        )
    }

    const PERSPECTIVE: Projection = Projection::Perspective { vertical_fov: 1.0, near: 0.5, far: 200.0 };
    const ORTHOGRAPHIC: Projection = Projection::Orthographic { half_height: 9.0, near: -5.0, far: 80.0 };

    #[test]
    fn the_inverse_leads_from_clip_space_back_to_the_world() {
        for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
            for reverse in [false, true] {
                let data = run(tilted(projection), reverse);
                for point in [DVec3::new(0.0, 0.0, 0.0), DVec3::new(-10.0, 1.0, -30.0)] {
                    let clip = matrix(&data, "clip_from_world") * point.extend(1.0);
                    let back = matrix(&data, "world_from_clip") * clip;
                    assert!(
                        (back.truncate() / back.w - point).length() < 1e-2,
                        "{projection:?} {reverse} {point}"
                    );
                }
            }
        }
    }

    #[test]
    fn depth_runs_from_near_to_far_and_back_in_reverse() {
        for (projection, near, far) in [(PERSPECTIVE, 0.5, 200.0), (ORTHOGRAPHIC, -5.0, 80.0)] {
            for reverse in [false, true] {
                let data = run(tilted(projection), reverse);
                let depth = |distance: f64| {
                    let clip: DVec4 = matrix(&data, "clip_from_view") * DVec4::new(0.0, 0.0, -distance, 1.0);
                    clip.z / clip.w
                };
                let (first, last) = if reverse { (1.0, 0.0) } else { (0.0, 1.0) };
                assert!(
                    (depth(near) - first).abs() < 1e-5 && (depth(far) - last).abs() < 1e-5,
                    "{projection:?} {reverse}"
                );
                assert_eq!(data.words("reverse"), Some([u32::from(reverse)].as_slice()));
            }
        }
    }

    #[test]
    fn an_unusable_camera_is_the_identity_and_finite() {
        let fine = tilted(PERSPECTIVE);
        let broken = [
            fine.position(DVec3::NAN),
            fine.position(DVec3::splat(1e300)),
            fine.rotation(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
            FrameCamera::new(fine.position, fine.rotation, fine.projection, 0.0),
            FrameCamera::new(fine.position, fine.rotation, fine.projection, f64::MIN_POSITIVE),
            fine.projection(Projection::Perspective { vertical_fov: 1.0, near: 1.0, far: 1.0 }),
            fine.projection(Projection::Perspective { vertical_fov: 1.0, near: 1e-300, far: 1e300 }),
        ];
        for camera in broken {
            let data = run(camera, true);
            assert_eq!(matrix(&data, "clip_from_world"), DMat4::IDENTITY, "{camera:?}");
            assert_eq!(data.views().len(), 1);
            assert!(data.views()[0].clip_from_world.is_finite());
            assert!(shape().values.iter().map(|value| &value.name).all(|name| {
                floats(&data, name).iter().all(|value| value.is_finite() || name == "frame_index")
            }));
        }
    }

    #[test]
    fn the_view_is_the_camera() {
        let camera = tilted(PERSPECTIVE);
        let data = run(camera, false);
        let [view] = data.views() else { panic!("one view") };
        assert_eq!((view.position, view.forward), (camera.position, camera.forward()));
        assert!((view.view_from_world.transform_point3(camera.position)).length() < 1e-12);
        assert!((floats(&data, "half_size")[0] / floats(&data, "half_size")[1] - 1.6).abs() < 1e-6);
    }

    #[test]
    fn the_frame_before_is_the_last_of_another_index() {
        let node = RunCamera { setting: None, reverse: false, jitter: 0 };
        let mut state = Frames::default();
        let camera = |x: f64| tilted(PERSPECTIVE).position(DVec3::new(x, 0.0, 0.0));
        let before = |data: &BlackboardData| floats(data, "previous_position")[0];
        assert_eq!(before(&frames(&node, &mut state, camera(1.0), 7)), 1.0);
        assert_eq!(before(&frames(&node, &mut state, camera(2.0), 8)), 1.0);
        assert_eq!(before(&frames(&node, &mut state, camera(3.0), 8)), 1.0, "recorded again");
        assert_eq!(before(&frames(&node, &mut state, camera(4.0), 9)), 3.0);
        frames(&node, &mut state, camera(f64::NAN), 10);
        assert_eq!(before(&frames(&node, &mut state, camera(5.0), 11)), 5.0);
    }

    #[test]
    fn the_time_step_is_that_between_two_frames() {
        let mut state = Frames::default();
        let lens = Lens::identity();
        let mut step = |index, time| time - state.advance(index, (lens, time)).1;
        assert_eq!(
            [(3, 10.0), (4, 10.5), (4, 10.5), (5, 12.0)].map(|(at, time)| step(at, time)),
            [0.0, 0.5, 0.5, 1.5]
        );
    }

    #[test]
    fn a_point_is_found_where_it_was_in_the_frame_before() {
        let node = RunCamera { setting: None, reverse: true, jitter: 8 };
        let mut state = Frames::default();
        // Far from the origin, where 32 bits have no centimetres.
        let at = DVec3::new(4e6, 0.0, -4e6);
        let first = tilted(PERSPECTIVE).position(at);
        let second = first
            .position(at + DVec3::new(0.3, 0.1, 0.0))
            .rotation(first.rotation * DQuat::from_rotation_y(0.02));
        frames(&node, &mut state, first, 0);
        let data = frames(&node, &mut state, second, 1);
        let jitter = floats(&data, "jitter");
        let aside = DMat4::from_translation(DVec3::new(jitter[0].into(), jitter[1].into(), 0.0));
        let point = second.position + second.rotation * DVec3::new(1.0, -0.5, -6.0);
        let clip = aside * second.clip(true) * second.view() * point.extend(1.0);
        let expected = aside * first.clip(true) * first.view() * point.extend(1.0);
        let found = matrix(&data, "previous_clip_from_clip") * clip;
        let difference = found.truncate() / found.w - expected.truncate() / expected.w;
        assert!(difference.length() < 1e-5, "{difference}");
        let still = matrix(&frames(&node, &mut state, second, 2), "previous_clip_from_clip");
        assert!(still.abs_diff_eq(DMat4::IDENTITY, 1e-6), "nothing moves but the jitter: {still}");
    }

    #[test]
    fn matrices_of_the_frame_before_have_the_jitter_of_this_one() {
        let node = RunCamera { setting: None, reverse: false, jitter: 8 };
        let mut state = Frames::default();
        let first = tilted(PERSPECTIVE);
        frames(&node, &mut state, first, 0);
        let second = first.position(first.position + 1.0).rotation(DQuat::from_rotation_y(0.1));
        let data = frames(&node, &mut state, second, 1);
        let jitter = floats(&data, "jitter");
        let aside = DMat4::from_translation(DVec3::new(jitter[0].into(), jitter[1].into(), 0.0));
        let clip = aside * first.clip(false) * first.view();
        for (name, wanted) in [("previous_clip_from_world", clip), ("previous_view_from_world", first.view())]
        {
            let found = matrix(&data, name);
            assert!(found.abs_diff_eq(wanted, 1e-5), "{name}: {found} {wanted}");
        }
    }

    #[test]
    fn a_picture_that_the_host_moves_is_published_as_moved() {
        let data = run(tilted(PERSPECTIVE).jittered([0.25, -0.125]), false);
        assert_eq!(floats(&data, "jitter"), [0.25, -0.125]);
    }

    #[test]
    fn jitter_stays_in_a_pixel_and_moves_view_and_matrices_alike() {
        let node = RunCamera { setting: None, reverse: false, jitter: 8 };
        let mut state = Frames::default();
        let camera = tilted(PERSPECTIVE);
        let mut seen = Vec::new();
        for index in 0..16 {
            let data = frames(&node, &mut state, camera, index);
            let jitter = floats(&data, "jitter");
            let pixels = [jitter[0] * 320.0, jitter[1] * 200.0];
            assert!(pixels.iter().all(|offset| offset.abs() <= 0.5), "{pixels:?}");
            let point = (camera.position + camera.forward() * 9.0).extend(1.0);
            let clip = matrix(&data, "clip_from_world") * point;
            assert!((clip.x / clip.w - f64::from(jitter[0])).abs() < 1e-5);
            let [view] = data.views() else { panic!("one view") };
            let drawn = view.clip_from_world * point;
            assert!((drawn.y / drawn.w - f64::from(jitter[1])).abs() < 1e-6);
            seen.push(pixels.map(|offset| (offset * 1000.0).round() as i32));
        }
        assert_eq!(seen[..8], seen[8..]);
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 8);
    }
}
