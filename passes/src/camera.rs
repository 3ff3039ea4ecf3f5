//! The node kind `camera`: the frame's camera as a view.
//!
//! Published, besides one view: [`shape`].
//!
//! Limits: a camera with unusable values (not finite, an empty depth range), or one whose matrices do not fit 32 bits,
//! is replaced by one whose matrices are all the identity, so that passes find finite values and a view to clear with.

use glam::{DMat4, DQuat, DVec3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, DataShape, ValueType, View};
use umbragraph_pipeline::frame::{Camera as FrameCamera, Projection};
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

/// Publishes the frame's camera as a view, and its matrices and directions by name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// The blackboard data to publish.
    pub to: String,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false without it.
    pub reverse: Option<Expr>,
}

impl Node for Camera {
    const NAME: &'static str = "camera";
    const SUMMARY: &'static str = "Publishes the frame's camera as a view.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let reverse = pass.boolean_or(&self.reverse, "/reverse", false)?;
        let output = pass.publish(&self.to, "/to", shape())?;
        pass.produce(Work::Cpu(CpuWork::new(RunCamera { reverse }, output, Vec::new())))
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", shape())]
    }
}

/// What a camera publishes, in metres unless said otherwise. The matrices are computed in `f64`.
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
        .value("far", ValueType::F32, "the distance of the far plane along the view axis")
        .value("aspect", ValueType::F32, "width over height")
        .value("time", ValueType::F32, "seconds since some start of the host's")
        .value("orthographic", ValueType::U32, "1 for an orthographic camera, else 0")
        .value("reverse", ValueType::U32, "1 where depth runs from 1 to 0, else 0")
        .value("frame_index", ValueType::U32, "counts frames, modulo 2³²")
        .value(
            "half_size",
            ValueType::VEC2,
            "half the visible width and height: at 1 m for a perspective, anywhere for an orthographic camera",
        )
        .views(1)
}

#[derive(Debug, PartialEq)]
struct RunCamera {
    reverse: bool,
}

impl CpuNode for RunCamera {
    type State = ();

    fn run(&self, (): &mut (), context: &CpuContext<'_>, data: &mut BlackboardData) {
        let lens = Lens::of(&context.frame.camera, self.reverse);
        let lens = lens.filter(Lens::is_finite).unwrap_or(Lens::identity());
        lens.publish(self.reverse, data);
        let time = context.frame.time as f32;
        data.set_f32("time", if time.is_finite() { time } else { 0.0 });
        // Whatever counts frames wraps around.
        data.set_u32("frame_index", context.frame.index as u32);
    }
}

/// A camera's matrices and numbers.
struct Lens {
    clip_from_view: DMat4,
    view_from_clip: DMat4,
    view_from_world: DMat4,
    world_from_view: DMat4,
    position: DVec3,
    rotation: DQuat,
    near: f64,
    far: f64,
    aspect: f64,
    half_height: f64,
    orthographic: bool,
}

impl Lens {
    fn of(camera: &FrameCamera, reverse: bool) -> Option<Self> {
        if camera.check().is_some() {
            return None;
        }
        let clip_from_view = camera.clip(reverse);
        let (near, far) = camera.projection.depth_range();
        let (half_height, orthographic) = match camera.projection {
            Projection::Perspective { vertical_fov, .. } => ((0.5 * vertical_fov).tan(), false),
            Projection::Orthographic { half_height, .. } => (half_height, true),
        };
        Some(Self {
            clip_from_view,
            view_from_clip: clip_from_view.inverse(),
            view_from_world: camera.view(),
            world_from_view: DMat4::from_rotation_translation(camera.rotation, camera.position),
            position: camera.position,
            rotation: camera.rotation,
            near,
            far,
            aspect: camera.aspect,
            half_height,
            orthographic,
        })
    }

    fn identity() -> Self {
        Self {
            clip_from_view: DMat4::IDENTITY,
            view_from_clip: DMat4::IDENTITY,
            view_from_world: DMat4::IDENTITY,
            world_from_view: DMat4::IDENTITY,
            position: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            near: 0.0,
            far: 1.0,
            aspect: 1.0,
            half_height: 1.0,
            orthographic: true,
        }
    }

    fn clip_from_world(&self) -> DMat4 {
        self.clip_from_view * self.view_from_world
    }

    fn world_from_clip(&self) -> DMat4 {
        self.world_from_view * self.view_from_clip
    }

    fn half_size(&self) -> [f32; 2] {
        [(self.half_height * self.aspect) as f32, self.half_height as f32]
    }

    /// Whether everything is finite once it is rounded to 32 bits.
    fn is_finite(&self) -> bool {
        let own = [self.clip_from_view, self.view_from_clip, self.view_from_world, self.world_from_view];
        let products = [self.clip_from_world(), self.world_from_clip()];
        own.iter().chain(&products).all(|matrix| matrix.as_mat4().is_finite())
            && [self.near, self.far, self.aspect].iter().all(|number| (*number as f32).is_finite())
            && self.half_size().iter().all(|number| number.is_finite())
    }

    fn publish(&self, reverse: bool, data: &mut BlackboardData) {
        let direction = |axis: DVec3| -> Vec3 { (self.rotation * axis).as_vec3() };
        data.set_matrix("clip_from_world", &self.clip_from_world());
        data.set_matrix("clip_from_view", &self.clip_from_view);
        data.set_matrix("view_from_world", &self.view_from_world);
        data.set_matrix("world_from_clip", &self.world_from_clip());
        data.set_matrix("view_from_clip", &self.view_from_clip);
        data.set_matrix("world_from_view", &self.world_from_view);
        data.set_vec3("position", self.position.as_vec3());
        data.set_vec3("forward", direction(DVec3::NEG_Z));
        data.set_vec3("right", direction(DVec3::X));
        data.set_vec3("up", direction(DVec3::Y));
        data.set_f32("near", self.near as f32);
        data.set_f32("far", self.far as f32);
        data.set_f32("aspect", self.aspect as f32);
        data.set_f32s("half_size", self.half_size());
        data.set_u32("orthographic", u32::from(self.orthographic));
        data.set_u32("reverse", u32::from(reverse));
        data.push_view(View {
            clip_from_world: self.clip_from_world(),
            view_from_world: self.view_from_world,
            position: self.position,
            forward: self.rotation * DVec3::NEG_Z,
            reverse,
            layer: 0,
            viewport: None,
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec4, Mat4};
    use umbragraph_pipeline::frame::{Bounds, FrameInput};

    use super::*;

    fn run(camera: FrameCamera, reverse: bool) -> BlackboardData {
        let frame = FrameInput {
            camera,
            lights: Vec::new(),
            filter_bounds: Vec::new(),
            scene_bounds: Bounds::EMPTY,
            time: f64::NAN,
            index: u64::MAX,
        };
        let mut data = BlackboardData::new(shape());
        RunCamera { reverse }.run(&mut (), &CpuContext { frame: &frame, inputs: &[] }, &mut data);
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
        FrameCamera {
            position: DVec3::new(3.0, 2.0, -7.0),
            rotation: DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.3),
            projection,
            aspect: 1.6,
        }
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
            FrameCamera { position: DVec3::NAN, ..fine },
            FrameCamera { position: DVec3::splat(1e300), ..fine },
            FrameCamera { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..fine },
            FrameCamera { aspect: 0.0, ..fine },
            FrameCamera { aspect: f64::MIN_POSITIVE, ..fine },
            FrameCamera {
                projection: Projection::Perspective { vertical_fov: 1.0, near: 1.0, far: 1.0 },
                ..fine
            },
            FrameCamera {
                projection: Projection::Perspective { vertical_fov: 1.0, near: 1e-300, far: 1e300 },
                ..fine
            },
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
}
