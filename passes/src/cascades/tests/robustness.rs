//! Whatever the host says, everything is finite, and nothing panics.

use glam::{DMat4, Mat4};
use umbragraph_pipeline::data::BlackboardData;

use super::*;
use crate::cascades::CascadeSet;
use crate::cascades::light::choose;

fn assert_finite(set: &CascadeSet) {
    for cascade in set.iter() {
        let view = &cascade.view;
        for matrix in [view.clip_from_world, view.view_from_world, cascade.texture_from_world] {
            assert!(matrix.as_mat4().is_finite(), "{cascade:?}");
        }
        assert!(view.position.is_finite() && view.forward.is_finite(), "{cascade:?}");
        assert!(cascade.texel_size > 0.0 && cascade.depth_range > 0.0, "{cascade:?}");
    }
}

fn odd_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => -1000.0..1000.0,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 1e30, 1e-30, 5e-324,
        ]),
    ]
}

fn odd_vector() -> impl Strategy<Value = DVec3> {
    (odd_number(), odd_number(), odd_number()).prop_map(DVec3::from)
}

fn odd_camera() -> impl Strategy<Value = Camera> {
    let numbers = (odd_number(), odd_number(), odd_number(), odd_number());
    (odd_vector(), rotation(), numbers, any::<bool>()).prop_map(
        |(position, rotation, (a, near, far, aspect), perspective)| {
            let projection = if perspective {
                Projection::Perspective { vertical_fov: a.abs() % 4.0, near: near.abs(), far: far.abs() }
            } else {
                Projection::Orthographic { half_height: a.abs(), near, far }
            };
            Camera::new(position, rotation, projection, aspect.abs())
        },
    )
}

proptest! {
    #![proptest_config(property::config(4000))]

    #[test]
    fn any_frame_gives_finite_cascades(
        camera in odd_camera(), light in odd_vector(), unit: bool,
        low in odd_vector(), high in odd_vector(), scene_low in odd_vector(), scene_high in odd_vector(),
        shape in shape(), snap in any_snap(), clip_to_scene: bool, formula: bool, fraction in 0.0..=1.0,
    ) {
        let mut settings = Configuration {
            shape, snap, clip_to_scene, blend: Blend { fraction, of: BlendOf::Range }, ..configuration(&[32.0, 128.0, 512.0, 2048.0])
        };
        if formula {
            settings.splits = Splits::Formula { lambda: fraction, near: None, far: 200.0, count: 8 };
        }
        let mut frame = frame(camera, DVec3::NEG_Y);
        frame.lights[0].direction = if unit { light.normalize_or(DVec3::X) } else { light };
        frame.filter_bounds = vec![("casters".into(), Bounds { min: low, max: high })];
        frame.scene_bounds = Bounds { min: scene_low, max: scene_high };
        assert_finite(&settings.fit(&frame));
    }
}

#[test]
fn the_identity_camera_gives_finite_other_matrices() {
    let set = configuration(&[32.0, 128.0, 512.0, 2048.0]).fit(&frame(identity_camera(), DVec3::NEG_Y));
    assert_eq!(set.count(), 4);
    assert_finite(&set);
    for cascade in set.iter() {
        assert_ne!(cascade.view.clip_from_world, DMat4::IDENTITY);
    }
}

#[test]
fn wide_splits_blend_over_a_metre_and_more() {
    for of in [BlendOf::Far, BlendOf::Range] {
        let settings = Configuration {
            blend: Blend { fraction: 0.05, of },
            ..configuration(&[32.0, 128.0, 512.0, 2048.0])
        };
        let set = settings.fit(&frame(identity_camera(), DVec3::NEG_Y));
        assert_eq!(set.count(), 4);
        assert!(set.iter().all(|cascade| cascade.slice.far - cascade.slice.blend_start >= 1.0), "{of:?}");
    }
}

#[test]
fn an_unusable_camera_or_light_leaves_no_cascades() {
    let settings = configuration(&[10.0]);
    let fine = frame(identity_camera(), DVec3::NEG_Y);
    assert_eq!(settings.fit(&fine).count(), 1);
    let mut camera = fine.clone();
    camera.camera.position.x = f64::NAN;
    let light = |frame: &FrameInput| choose(&frame.lights, None).map(|(at, _)| at);
    assert_eq!((settings.fit(&camera).count(), light(&camera)), (0, Some(0)));
    let projection = |vertical_fov, near, far| Projection::Perspective { vertical_fov, near, far };
    for camera in [
        fine.camera.rotation(DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0)),
        fine.camera.projection(projection(4.0, 0.1, 100.0)),
        fine.camera.projection(projection(1.0, -0.1, 100.0)),
    ] {
        assert_eq!(settings.fit(&fine.clone().camera(camera)).count(), 0, "{camera:?}");
    }
    let mut shadowless = fine.clone();
    shadowless.lights[0].properties.clear();
    assert_eq!((settings.fit(&shadowless).count(), light(&shadowless)), (0, Some(0)));
    let mut broken = fine.clone();
    broken.lights[0].direction = DVec3::ZERO;
    assert_eq!((settings.fit(&broken).count(), light(&broken)), (0, None));
    assert_eq!(Configuration { light: Some("moon".into()), ..settings }.fit(&fine).count(), 0);
}

#[test]
fn one_object_with_broken_bounds_changes_no_cascade() {
    let settings = configuration(&[10.0, 100.0]);
    let mut frame = frame(identity_camera(), DVec3::NEG_Y);
    let sizes =
        |frame: &FrameInput| settings.fit(frame).iter().map(|cascade| cascade.texel_size).collect::<Vec<_>>();
    let fine = sizes(&frame);
    for size in [1e20, 1e300, f64::MAX] {
        frame.filter_bounds =
            vec![("casters".into(), Bounds { min: DVec3::splat(-size), max: DVec3::splat(size) })];
        assert_eq!(sizes(&frame), fine, "{size}");
    }
}

#[test]
fn cascades_beyond_the_far_plane_of_the_camera_are_not_drawn() {
    let mut camera = identity_camera();
    camera.projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
    assert_eq!(configuration(&[32.0, 128.0, 512.0]).fit(&frame(camera, DVec3::NEG_Y)).count(), 2);
}

#[test]
fn a_frame_with_large_numbers_is_published_within_32_bits() {
    let mut frame = frame(identity_camera(), DVec3::NEG_Y);
    frame.lights[0].intensity = f32::MAX;
    frame.lights[0].color = Vec3::splat(1e30);
    frame.lights[0].angular_diameter = f32::NAN;
    let data = super::declaration::run(r#"{ "far": [10, 20], "resolution": 512 }"#, &frame);
    let floats = |name: &str| -> Vec<f32> {
        data.words(name).unwrap_or_default().iter().map(|word| f32::from_bits(*word)).collect()
    };
    let published: &BlackboardData = &data;
    for name in published.shape().values.iter().map(|value| &value.name) {
        assert!(floats(name).iter().all(|value| value.is_finite()), "{name}");
    }
    assert!(Mat4::from_cols_slice(&floats("clip_from_world")[..16]).is_finite());
}
