//! Oracles for the whole fit: what has to hold of every cascade, on random cameras, lights and bounds.

mod coverage;
mod declaration;
mod robustness;
mod stability;

use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use umbragraph_pipeline::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
use umbragraph_test_support::property;

use super::configuration::Configuration;
use super::depth::NearPull;
use super::fit::FitShape;
use super::layout::Layout;
use super::snap::Snap;
use super::splits::{Blend, BlendOf, Splits};
use super::{Cascade, CascadeSet, MAX_CASCADES, light};

impl Configuration {
    /// Fits the cascades of one frame to the configured light, or to the light that [`light::choose`] prefers.
    fn fit(&self, frame: &FrameInput) -> CascadeSet {
        let light = light::choose(&frame.lights, self.light.as_deref());
        light.map(|(_, light)| self.fit_light(light, frame)).unwrap_or_default()
    }
}

/// A typical configuration: far distances in metres, maps of 2048 texels, a blend zone of 0.05, else default settings.
fn configuration(far: &[f64]) -> Configuration {
    let mut all = [0.0; MAX_CASCADES];
    all[..far.len()].copy_from_slice(far);
    Configuration {
        light: None,
        splits: Splits::Explicit { far: all, count: far.len() },
        blend: Blend { fraction: 0.05, of: BlendOf::Far },
        shape: FitShape::Sphere,
        snap: Snap::World,
        square: true,
        border: 2,
        up: DVec3::Y,
        near_pull: NearPull::Casters,
        far_extension: 0.0,
        clip_to_scene: false,
        reverse: false,
        cadence: 1,
        layout: Layout::layers(&[2048; MAX_CASCADES], None),
    }
}

fn sun(direction: DVec3) -> Light {
    Light::new("sun", LightKind::Directional)
        .direction(direction.normalize_or(DVec3::NEG_Y))
        .color(Vec3::new(1.0, 0.9, 0.8))
        .intensity(3.0)
        .property("cast_shadow")
        .angular_diameter(0.53_f32.to_radians())
}

fn frame(camera: Camera, direction: DVec3) -> FrameInput {
    let bounds = Bounds { min: DVec3::new(-60.0, -2.0, -60.0), max: DVec3::new(60.0, 40.0, 60.0) };
    FrameInput::new(camera).lights(vec![sun(direction)]).filter_bounds("casters", bounds).scene_bounds(bounds)
}

fn identity_camera() -> Camera {
    Camera::new(
        DVec3::ZERO,
        DQuat::IDENTITY,
        Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 5000.0 },
        16.0 / 9.0,
    )
}

/// The texel coordinates of a world point in the cascade's map, from the upper left (x, y), and its clip depth (z).
fn lookup(cascade: &Cascade, resolution: f64, point: DVec3) -> DVec3 {
    let clip = cascade.view.clip_from_world.transform_point3(point);
    DVec3::new((clip.x * 0.5 + 0.5) * resolution, (0.5 - clip.y * 0.5) * resolution, clip.z)
}

/// A world point in the view frustum at `depth` metres along the view axis; `x` and `y` run from −1 to 1 across the
/// picture.
fn frustum_point(camera: &Camera, depth: f64, x: f64, y: f64) -> DVec3 {
    let [left_bottom, right_bottom, left_top, _] = camera.slice_corners(depth);
    left_bottom + (right_bottom - left_bottom) * (x * 0.5 + 0.5) + (left_top - left_bottom) * (y * 0.5 + 0.5)
}

fn direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| DVec3::new(x, y, z))
        .prop_filter("has a direction", |vector| vector.length() > 0.1)
        .prop_map(DVec3::normalize)
}

fn rotation() -> impl Strategy<Value = DQuat> {
    (direction(), 0.0..std::f64::consts::TAU).prop_map(|(axis, angle)| DQuat::from_axis_angle(axis, angle))
}

fn position(metres: f64) -> impl Strategy<Value = DVec3> {
    (direction(), 0.0..metres).prop_map(|(direction, distance)| direction * distance)
}

fn projection() -> impl Strategy<Value = Projection> {
    prop_oneof![
        3 => (0.2..2.6, 0.01..1.0, 250.0..10_000.0)
            .prop_map(|(vertical_fov, near, far)| Projection::Perspective { vertical_fov, near, far }),
        1 => (0.5..80.0, -20.0..1.0, 250.0..10_000.0)
            .prop_map(|(half_height, near, far)| Projection::Orthographic { half_height, near, far }),
    ]
}

fn camera() -> impl Strategy<Value = Camera> {
    (position(1000.0), rotation(), projection(), 0.4..3.0).prop_map(
        |(position, rotation, projection, aspect)| Camera::new(position, rotation, projection, aspect),
    )
}

fn shape() -> impl Strategy<Value = FitShape> {
    prop_oneof![Just(FitShape::Tight), Just(FitShape::Aligned), Just(FitShape::Sphere)]
}

fn any_snap() -> impl Strategy<Value = Snap> {
    prop_oneof![Just(Snap::World), Just(Snap::Origin), Just(Snap::Projection), Just(Snap::None)]
}
