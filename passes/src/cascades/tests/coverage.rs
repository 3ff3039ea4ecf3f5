//! Coverage: the map contains every point that it must contain.

use super::*;

proptest! {
    #![proptest_config(property::config(1000))]

    #[test]
    fn every_point_of_a_slice_lies_inside_its_cascade(
        camera in camera(), light in direction(), shape in shape(), snap in any_snap(), square: bool,
        border in 0u32..4, reverse: bool,
        points in prop::collection::vec((0.0..=1.0, -1.0..=1.0, -1.0..=1.0), 16),
    ) {
        let settings = Configuration { shape, snap, square, border, reverse, ..configuration(&[8.0, 40.0, 200.0]) };
        let set = settings.fit(&frame(camera, light));
        prop_assert_eq!(set.count(), 3);
        let (near, _) = camera.projection.depth_range();
        let mut begin = near;
        for cascade in set.iter() {
            prop_assert_eq!(cascade.slice.begin, begin);
            for (part, x, y) in &points {
                let depth = begin + (cascade.slice.far - begin) * part;
                let at = lookup(cascade, 2048.0, frustum_point(&camera, depth, *x, *y));
                let (low, high) = (f64::from(border) - 1e-6, 2048.0 - f64::from(border) + 1e-6);
                prop_assert!(at.x >= low && at.x <= high && at.y >= low && at.y <= high, "{at}");
                prop_assert!(at.z > 0.0 && at.z < 1.0, "{at}");
            }
            // The next cascade covers the zone in which this one blends into it.
            begin = cascade.slice.blend_start.max(near);
        }
    }

    #[test]
    fn casters_outside_the_slice_are_inside_the_depth_range(
        camera in camera(), light in direction(), shape in shape(),
        corner in position(300.0), size in (0.0..300.0, 0.0..300.0, 0.0..300.0),
        points in prop::collection::vec((0.0..=1.0, 0.0..=1.0, 0.0..=1.0), 64),
    ) {
        let min = camera.position + corner;
        let size = DVec3::from(size);
        let mut frame = frame(camera, light);
        frame.filter_bounds = vec![("casters".into(), Bounds { min, max: min + size })];
        let set = Configuration { shape, ..configuration(&[8.0, 40.0, 200.0]) }.fit(&frame);
        for cascade in set.iter() {
            for part in &points {
                let at = lookup(cascade, 2048.0, min + size * DVec3::from(*part));
                let above = at.x >= 0.0 && at.x <= 2048.0 && at.y >= 0.0 && at.y <= 2048.0;
                // What lies beyond the far plane is behind everything that is looked up.
                prop_assert!(!above || at.z > 0.0, "{at}");
            }
        }
    }

    #[test]
    fn forward_and_reverse_depth_are_mirror_images(
        camera in camera(), light in direction(), point in position(100.0),
    ) {
        let forward = configuration(&[8.0, 40.0, 200.0]);
        let reverse = Configuration { reverse: true, ..forward.clone() };
        let frame = frame(camera, light);
        let point = camera.position + point;
        for (forward, reverse) in forward.fit(&frame).iter().zip(reverse.fit(&frame).iter()) {
            let (f, r) = (lookup(forward, 2048.0, point), lookup(reverse, 2048.0, point));
            prop_assert!((f.z + r.z - 1.0).abs() < 1e-9, "{f} {r}");
            prop_assert_eq!((f.x, f.y), (r.x, r.y));
            prop_assert!(reverse.view.reverse && !forward.view.reverse);
        }
    }

    #[test]
    fn a_cascade_narrowed_to_the_scene_covers_slice_and_scene(
        camera in camera(), light in direction(), shape in shape(),
        corner in position(100.0), size in (1.0..100.0, 1.0..100.0, 1.0..100.0),
        points in prop::collection::vec((0.0..=1.0, -1.0..=1.0, -1.0..=1.0), 64),
    ) {
        let mut frame = frame(camera, light);
        let min = camera.position + camera.forward() * 60.0 + corner * 0.3;
        frame.scene_bounds = Bounds { min, max: min + DVec3::from(size) };
        let wide = Configuration { shape, ..configuration(&[8.0, 40.0, 200.0]) };
        let narrow = Configuration { clip_to_scene: true, ..wide.clone() };
        for (wide, cascade) in wide.fit(&frame).iter().zip(narrow.fit(&frame).iter()) {
            prop_assert!(cascade.texel_size <= wide.texel_size);
            for (part, x, y) in &points {
                let slice = &cascade.slice;
                let point = frustum_point(&camera, slice.begin + (slice.end - slice.begin) * part, *x, *y);
                let bounds = &frame.scene_bounds;
                if point.cmpge(bounds.min).all() && point.cmple(bounds.max).all() {
                    let at = lookup(cascade, 2048.0, point);
                    prop_assert!(at.min_element() > 0.0 && at.truncate().max_element() < 2048.0 && at.z < 1.0, "{at}");
                }
            }
        }
    }
}

#[test]
fn a_small_scene_gives_the_far_cascades_fine_texels() {
    let far = [32.0, 128.0, 512.0, 2048.0];
    let frame = frame(identity_camera(), DVec3::new(0.3, -1.0, 0.2));
    let sizes = |clip_to_scene| {
        let set = Configuration { clip_to_scene, ..configuration(&far) }.fit(&frame);
        set.iter().map(|cascade| cascade.texel_size).collect::<Vec<_>>()
    };
    assert!(sizes(false)[3] > 1.0 && sizes(true)[3] < 0.1, "{:?} {:?}", sizes(false), sizes(true));
}

#[test]
fn without_a_far_plane_the_range_ends_with_the_scene() {
    let settings = Configuration { splits: Splits::Whole { count: 2 }, ..configuration(&[1.0]) };
    let endless = Projection::Perspective { vertical_fov: 1.0, near: 0.3, far: f64::INFINITY };
    let camera = identity_camera().projection(endless).position(DVec3::new(0.0, 0.0, 5.0));
    let behind = Bounds { min: DVec3::splat(6.0), max: DVec3::splat(9.0) };
    let around = frame(camera, DVec3::NEG_Y).scene_bounds;
    for (bounds, end) in [(around, 65.0), (behind, 0.6), (Bounds::EMPTY, 1000.0)] {
        let set = settings.fit(&frame(camera, DVec3::new(0.2, -0.9, 0.1)).scene_bounds(bounds));
        let slices: Vec<_> = set.iter().map(|cascade| (cascade.slice.begin, cascade.slice.end)).collect();
        assert_eq!(slices, [(0.3, end); 2]);
    }
    let ends = |settings: &Configuration, camera| {
        let set = settings.fit(&frame(camera, DVec3::new(0.2, -0.9, 0.1)));
        set.iter().map(|cascade| cascade.slice.end).collect::<Vec<_>>()
    };
    assert_eq!(ends(&settings, identity_camera()), [5000.0; 2], "a far plane is the end");
    assert_eq!(ends(&configuration(&[10.0, 90.0]), camera), [10.0, 90.0], "what is listed is the end");
}

#[test]
fn an_off_centre_slice_lies_inside_its_cascade() {
    let whole = identity_camera();
    // The left half of a picture: twice as wide, and moved by half.
    let mut clip = whole.clip(false).as_mat4().to_cols_array_2d();
    clip.iter_mut().for_each(|column| column[0] = 2.0 * column[0] + column[3]);
    let world = whole.view().inverse().as_mat4().to_cols_array_2d();
    let camera = Camera::from_matrices(world, clip);
    for shape in [FitShape::Tight, FitShape::Sphere] {
        let settings = Configuration { shape, ..configuration(&[8.0, 40.0]) };
        let set = settings.fit(&frame(camera, DVec3::new(0.3, -0.8, 0.2)));
        assert_eq!(set.count(), 2);
        for cascade in set.iter() {
            for corner in camera.slice_corners(cascade.slice.end) {
                let at = lookup(cascade, 2048.0, corner);
                assert!(at.min_element() > 0.0 && at.truncate().max_element() < 2048.0, "{shape:?} {at}");
            }
        }
    }
}

#[test]
fn depth_can_cover_the_scene_whatever_the_camera_sees() {
    let settings = Configuration { near_pull: NearPull::Scene, ..configuration(&[8.0, 40.0]) };
    let mut frame = frame(identity_camera(), DVec3::NEG_Y);
    // The scene stands between -2 m and 40 m.
    frame.filter_bounds[0].1.max.y = 70.0;
    for height in [0.0, 30.0] {
        frame.camera.position.y = height;
        let set = settings.fit(&frame);
        assert_eq!(set.count(), 2);
        for cascade in set.iter() {
            let [top, bottom] = [70.0, -2.0].map(|y| lookup(cascade, 2048.0, DVec3::new(0.0, y, 0.0)).z);
            assert!(top > 0.0 && bottom < 1.0, "{top} {bottom}");
            let steps = (cascade.depth_range - 72.0) / cascade.texel_size;
            assert!((1.99..=4.01).contains(&steps), "{steps} texels more than the scene is high");
        }
    }
}

#[test]
fn the_view_agrees_with_its_matrices() {
    for reverse in [false, true] {
        let settings = Configuration { reverse, ..configuration(&[10.0, 50.0]) };
        let set = settings.fit(&frame(identity_camera(), DVec3::new(0.5, -0.6, 0.1)));
        for cascade in set.iter() {
            let view = &cascade.view;
            assert!(view.view_from_world.transform_point3(view.position).length() < 1e-9);
            let near = lookup(cascade, 2048.0, view.position);
            let far = lookup(cascade, 2048.0, view.position + view.forward * cascade.depth_range);
            let (first, last) = if reverse { (1.0, 0.0) } else { (0.0, 1.0) };
            assert!((near - DVec3::new(1024.0, 1024.0, first)).length() < 1e-6, "{near}");
            assert!((far.z - last).abs() < 1e-9, "{far}");
        }
    }
}

#[test]
fn the_map_is_found_through_scale_and_offset_and_directly_alike() {
    let origins = [glam::UVec2::ZERO, glam::UVec2::new(1024, 0), glam::UVec2::new(0, 1024)];
    let settings = Configuration {
        layout: Layout::tiles(&[1024; 3], &origins, None),
        ..configuration(&[8.0, 40.0, 200.0])
    };
    let camera = identity_camera();
    for (at, cascade) in settings.fit(&frame(camera, DVec3::new(0.5, -0.6, 0.1))).iter().enumerate() {
        let point = frustum_point(&camera, cascade.slice.end * 0.97, 0.3, -0.2);
        let uv = lookup(cascade, 1.0, point);
        let scale_offset = settings.layout.scale_offset(at);
        let direct = cascade.texture_from_world.transform_point3(point);
        assert!((uv.x * scale_offset.x + scale_offset.z - direct.x).abs() < 1e-12);
        assert!((uv.y * scale_offset.y + scale_offset.w - direct.y).abs() < 1e-12);
        assert!((uv.z - direct.z).abs() < 1e-12);
        assert_eq!(cascade.view.viewport, Some([origins[at].x, origins[at].y, 1024, 1024]));
        assert_eq!(cascade.view.layer, 0);
    }
}
