//! Static points keep their place in their texel as the camera moves.

use std::f64::consts::FRAC_PI_4;

use glam::DVec4;

use super::*;

/// The difference of a shift, in texels, from a whole number of texels: the larger one of x and y.
fn fraction(shift: DVec3) -> f64 {
    (shift - shift.round()).truncate().abs().max_element()
}

proptest! {
    #![proptest_config(property::config(1000))]

    #[test]
    fn camera_translation_moves_static_points_by_whole_texels(
        camera in camera(), light in direction(), shape in shape(), clip_to_scene: bool,
        snap in prop_oneof![Just(Snap::World), Just(Snap::Origin)],
        step in (position(3.0), 0.001..1.0).prop_map(|(step, scale)| step * scale), point in position(50.0),
    ) {
        let settings = Configuration { shape, snap, clip_to_scene, ..configuration(&[8.0, 40.0, 200.0]) };
        let before = settings.fit(&frame(camera, light));
        let after = settings.fit(&frame(camera.position(camera.position + step), light));
        prop_assert_eq!(before.count(), after.count());
        let point = camera.position + point;
        for (before, after) in before.iter().zip(after.iter()).filter(|(before, _)| before.texel_size >= 0.005) {
            prop_assert_eq!(before.texel_size.to_bits(), after.texel_size.to_bits());
            let shift = lookup(after, 2048.0, point) - lookup(before, 2048.0, point);
            prop_assert!(fraction(shift) < 0.01, "{}", fraction(shift));
        }
    }

    #[test]
    fn rounding_matrices_to_32_bits_moves_under_0_01_texels(
        camera in camera(), light in direction(), shape in shape(),
    ) {
        let set = Configuration { shape, ..configuration(&[8.0, 40.0, 200.0]) }.fit(&frame(camera, light));
        for cascade in set.iter() {
            let width = 2048.0 * cascade.texel_size;
            let exact = cascade.view.clip_from_world.w_axis.truncate();
            let rounded = cascade.view.clip_from_world.as_mat4().as_dmat4().w_axis.truncate();
            let shift = (exact - rounded).truncate().abs().max_element() * 1024.0;
            prop_assert!(shift < 0.01 || cascade.view.position.length() > 100.0 * width, "{shift}");
        }
    }

    #[test]
    fn camera_rotation_leaves_the_texels_of_a_sphere_fit(
        camera in camera(), light in direction(), rotation in rotation(), point in position(50.0),
    ) {
        let settings = configuration(&[8.0, 40.0, 200.0]);
        let before = settings.fit(&frame(camera, light));
        let after = settings.fit(&frame(camera.rotation(rotation), light));
        let point = camera.position + point;
        for (before, after) in before.iter().zip(after.iter()).filter(|(before, _)| before.texel_size >= 0.005) {
            prop_assert_eq!(before.texel_size.to_bits(), after.texel_size.to_bits());
            let shift = lookup(after, 2048.0, point) - lookup(before, 2048.0, point);
            prop_assert!(fraction(shift) < 0.01, "{}", fraction(shift));
        }
    }
}

#[test]
fn a_light_view_centred_on_the_slice_lets_static_points_crawl() {
    let settings = Configuration { snap: Snap::Projection, ..configuration(&[32.0, 128.0]) };
    let moved = identity_camera().position(DVec3::new(0.003, 0.0, 0.0));
    let light = DVec3::new(0.3, -1.0, 0.2);
    let (before, after) =
        (settings.fit(&frame(identity_camera(), light)), settings.fit(&frame(moved, light)));
    for (before, after) in before.iter().zip(after.iter()) {
        let shift = lookup(after, 2048.0, DVec3::ZERO) - lookup(before, 2048.0, DVec3::ZERO);
        assert!(fraction(shift) > 0.01, "{shift}");
    }
}

#[test]
fn a_tight_fit_has_finer_texels_than_a_sphere() {
    let frame = frame(identity_camera(), DVec3::new(0.0, -1.0, 0.0));
    let texel = |shape| {
        let set = Configuration { shape, ..configuration(&[20.0]) }.fit(&frame);
        set.iter().map(|cascade| cascade.texel_size).sum::<f64>()
    };
    assert!(texel(FitShape::Tight) < 0.95 * texel(FitShape::Sphere));
}

#[test]
fn an_aligned_fit_is_finer_than_a_tight_one_and_turns_in_steps() {
    let projection = Projection::Perspective { vertical_fov: 0.5, near: 0.1, far: 100.0 };
    let looking = |turn: f64| Camera::new(DVec3::ZERO, DQuat::from_rotation_y(turn), projection, 1.0);
    let light = DVec3::new(0.0, -1.0, 0.0);
    let sets = |turn: f64, shape| {
        Configuration { shape, square: false, ..configuration(&[20.0]) }.fit(&frame(looking(turn), light))
    };
    // Half of a right angle beside both axes of the light.
    let area = |shape| {
        let side = |row: DVec4| 2.0 / row.truncate().length();
        let set = sets(FRAC_PI_4, shape);
        let matrices = set.iter().map(|cascade| cascade.view.clip_from_world);
        matrices.map(|matrix| side(matrix.row(0)) * side(matrix.row(1))).sum::<f64>()
    };
    let [aligned, tight] = [FitShape::Aligned, FitShape::Tight].map(area);
    assert!(aligned < 0.8 * tight, "{aligned} {tight}");
    let axis = |turn: f64| {
        let set = sets(turn, FitShape::Aligned);
        set.iter().next().expect("a cascade").view.clip_from_world.row(0).truncate().normalize()
    };
    // Within a step of 15 degrees the axes stay, beyond it they do not.
    assert!(axis(0.30).abs_diff_eq(axis(0.35), 1e-12));
    assert!(axis(0.30).dot(axis(0.60)) < 0.99);
}

#[test]
fn a_movement_within_a_texel_keeps_matrices_bit_identical() {
    let settings = configuration(&[500.0]);
    let light = DVec3::new(0.3, -1.0, 0.2);
    let matrices: std::collections::BTreeSet<_> = (0..100)
        .map(|step| {
            let camera = identity_camera().position(DVec3::new(0.001 * f64::from(step), 0.0, 0.0));
            let set = settings.fit(&frame(camera, light));
            set.iter()
                .flat_map(|cascade| cascade.view.clip_from_world.to_cols_array().map(f64::to_bits))
                .collect::<Vec<_>>()
        })
        .collect();
    // 10 cm with texels of half a metre: each of three axes steps once at most.
    assert!(matrices.len() <= 4, "{}", matrices.len());
}
