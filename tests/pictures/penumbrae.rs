//! Penumbrae of `pipelines/awsm.json` against what geometry says, on each kind of light.
//!
//! A half plane hangs at some height over a plane, its edge straight below the light. Of a disc of light that moves out
//! behind an edge, the visible part goes from 0 to 1 over twice the penumbra's half width R, as the part of a disc
//! beside a chord: of a sun R is the height times the tangent of half its angle, of a lamp of radius r at a distance L
//! it is r · height / (L − height).

use crate::common::gpu::{Host, import};
use crate::common::{Outcome, With, check_file, check_with};
use glam::{DMat3, DQuat, DVec3};
use serde_json::json;
use umbragraph::executor::read_back;
use umbragraph::frame::{Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;

const AWSM: &str = "pipelines/awsm.json";
const SIZE: [u32; 2] = [480, 320];
/// The height of the lamps in metres.
const LAMP: f64 = 2.2;
const RADIUS: f64 = 0.2;
const ANGLE: f64 = 20.0;

/// Rectangles from one corner to the opposite one, each at a height.
fn rectangles(all: &[(f32, [f32; 4])]) -> Scene {
    let corners = |(y, [x0, z0, x1, z1]): &(f32, [f32; 4])| {
        [[*x0, *y, *z0], [*x0, *y, *z1], [*x1, *y, *z1], [*x1, *y, *z0]]
    };
    let positions: Vec<[f32; 3]> = all.iter().flat_map(corners).collect();
    let indices = (0..all.len() as u32).flat_map(|at| [0, 1, 2, 0, 2, 3].map(|corner| 4 * at + corner));
    let indices: Vec<u32> = indices.collect();
    let mut binary: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let places = binary.len();
    binary.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    let end = |pick: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|axis| positions.iter().map(|position| position[axis]).reduce(pick).unwrap_or(0.0))
    };
    let document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": binary.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": places },
            { "buffer": 0, "byteOffset": places, "byteLength": binary.len() - places },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3",
                "min": end(f32::min), "max": end(f32::max),
            },
            { "bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR" },
        ],
        "materials": [{ "doubleSided": true }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
    });
    from_slice("rectangles.glb", &container(&document.to_string(), &binary), &NoFiles).expect("a scene")
}

/// A half plane at a height over a plane.
fn edge(height: f64) -> Scene {
    rectangles(&[(0.0, [-3.0, -3.0, 3.0, 3.0]), (height as f32, [-3.0, -3.0, 0.0, 3.0])])
}

fn light(kind: LightKind) -> Light {
    Light::new("light", kind)
        .position(DVec3::new(0.0, LAMP, 0.0))
        .intensity(10.0)
        .range(20.0)
        .property("cast_shadow")
        .angular_diameter((ANGLE as f32).to_radians())
        .radius(RADIUS as f32)
}

/// Half the width of the penumbra of the edge.
fn analytic(kind: LightKind, height: f64) -> f64 {
    match kind {
        LightKind::Directional => height * (0.5 * ANGLE).to_radians().tan(),
        _ => RADIUS * height / (LAMP - height),
    }
}

/// A camera that sees the edge's shadow beside the half plane, farther away on the left.
fn frame(scene: &Scene, light: Light) -> FrameInput {
    let position = DVec3::new(2.2, 2.2, 1.5);
    let back = position.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
    let projection = Projection::Perspective { vertical_fov: 0.3, near: 0.1, far: 50.0 };
    let camera = Camera::new(position, rotation, projection, 1.5);
    scene.frame_input(1.5, 0.0).camera(camera).lights(vec![light])
}

/// Samples of the plane, one per pixel: x, the distance along the view axis, and the visibility.
fn seen(picture: &Picture, camera: &Camera) -> Vec<[f64; 3]> {
    let [width, height] = SIZE.map(f64::from);
    let half = (0.5 * 0.3_f64).tan();
    let place = |(at, pixel): (usize, [u8; 4])| {
        let (x, y) = ((at as u32 % SIZE[0]) as f64 + 0.5, (at as u32 / SIZE[0]) as f64 + 0.5);
        let ray = DVec3::new((2.0 * x / width - 1.0) * half * 1.5, (1.0 - 2.0 * y / height) * half, -1.0);
        let ray = camera.rotation * ray;
        let distance = -camera.position.y / ray.y;
        [camera.position.x + ray.x * distance, distance, f64::from(pixel[0]) / 255.0]
    };
    picture.rgba_pixels().enumerate().map(place).collect()
}

/// The part of a disc of radius 1 that is visible beside a chord at `t`.
fn beside_chord(t: f64) -> f64 {
    0.5 + (t * (1.0 - t * t).max(0.0).sqrt() + t.asin()) / std::f64::consts::PI
}

/// Half the width of a penumbra, from where 15 % and 85 % of the light are seen.
fn half_width(pixels: impl Iterator<Item = [f64; 3]>) -> f64 {
    const CELL: f64 = 0.004;
    let mut cells = vec![(0.0, 0_u32); 400];
    for [x, _, visibility] in pixels {
        if let Some((sum, count)) = cells.get_mut(((x + 0.8) / CELL).max(0.0) as usize) {
            *sum += visibility;
            *count += 1;
        }
    }
    let profile: Vec<[f64; 2]> = (cells.iter().enumerate())
        .filter(|(_, (_, count))| *count > 3)
        .map(|(at, (sum, count))| [(at as f64 + 0.5) * CELL - 0.8, sum / f64::from(*count)])
        .collect();
    let crossing = |level: f64| {
        let pair = profile.windows(2).find(|pair| pair[0][1] < level && pair[1][1] >= level);
        let [[x0, v0], [x1, v1]] = *pair.expect("a penumbra") else { panic!("two cells") };
        x0 + (x1 - x0) * (level - v0) / (v1 - v0)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if beside_chord(middle) < 0.85 { low = middle } else { high = middle }
    }
    (crossing(0.85) - crossing(0.15)) / (2.0 * low)
}

fn pcss(parameters: &[(&str, &str)]) -> Outcome {
    let mut all = vec![
        ("debug_view", "\"shadow_term\""),
        ("max_penumbra", "100"),
        ("max_search", "100"),
        ("search_taps", "32"),
        ("splits", "\"explicit\""),
        ("fit", "\"tight\""),
        ("far", "[6]"),
        ("blend", "0"),
        ("tile_max_side", "2048"),
        ("atlas_min_side", "2048"),
    ];
    all.retain(|(name, _)| parameters.iter().all(|(other, _)| other != name));
    all.extend_from_slice(parameters);
    let features = [("light_filter", "\"pcss\"")];
    check_file(AWSM, &With { parameters: &all, features: &features, size: Some(SIZE), ..With::default() })
}

/// Holds the widths at ten heights to what geometry says.
#[track_caller]
fn grow_with_the_height(kind: LightKind) {
    let Some(gpu) = gpu::device() else { return };
    let outcome = pcss(&[]);
    let mut before = 0.0;
    // From where a penumbra is some texels wide.
    for height in (0..10).map(|step| 0.3 + 0.08 * f64::from(step)) {
        let scene = edge(height);
        let input = frame(&scene, light(kind));
        let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
        let width = half_width(seen(&picture, &input.camera).into_iter());
        let expected = analytic(kind, height);
        println!("{height:.2} m: {width:.4} m, {:+.1} %", 100.0 * (width / expected - 1.0));
        assert!((width / expected - 1.0).abs() < 0.1, "at {height} m {width} instead of {expected}");
        assert!(width > before, "at {height} m {width} after {before}");
        before = width;
    }
}

#[test]
fn penumbrae_of_a_sun_are_as_wide_as_geometry_says() {
    grow_with_the_height(LightKind::Directional);
}

#[test]
fn penumbrae_of_a_spot_are_as_wide_as_geometry_says() {
    grow_with_the_height(LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 });
}

#[test]
fn penumbrae_of_a_point_light_are_as_wide_as_geometry_says() {
    grow_with_the_height(LightKind::Point);
}

#[test]
fn penumbrae_are_as_wide_on_both_sides_of_a_cascades_end() {
    let Some(gpu) = gpu::device() else { return };
    // The view axis meets the plane at 3.45 m.
    let outcome =
        pcss(&[("far", "[3.45, 8]"), ("blend", "0.02"), ("max_penumbra", "200"), ("max_search", "200")]);
    for height in [0.3, 0.6, 1.0] {
        let scene = edge(height);
        let input = frame(&scene, light(LightKind::Directional));
        let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
        let pixels = seen(&picture, &input.camera);
        let expected = analytic(LightKind::Directional, height);
        let near = half_width(pixels.iter().copied().filter(|[_, distance, _]| *distance < 3.38));
        let far = half_width(pixels.iter().copied().filter(|[_, distance, _]| *distance > 3.45));
        println!("{height} m: {near:.4} before the end, {far:.4} after it, {expected:.4} by geometry");
        for width in [near, far] {
            assert!((width / expected - 1.0).abs() < 0.1, "at {height} m {width} instead of {expected}");
        }
    }
}

#[test]
fn blurred_moments_are_as_soft_on_both_sides_of_a_cascades_end() {
    let Some(gpu) = gpu::device() else { return };
    let scene = edge(0.5);
    for (filter, precision, blur) in
        [("\"evsm4\"", "\"fp32\"", "40"), ("\"evsm2\"", "\"fp32\"", "16"), ("\"msm\"", "\"fp16\"", "24")]
    {
        let parameters = [
            ("debug_view", "\"shadow_term\""),
            ("splits", "\"explicit\""),
            ("fit", "\"tight\""),
            ("far", "[3.45, 8]"),
            ("blend", "0.02"),
            ("moment_cascades", "\"all\""),
            ("blur_radius", blur),
        ];
        let features = [("moment_filter", filter), ("moment_precision", precision)];
        let with = With { parameters: &parameters, features: &features, size: Some(SIZE), ..With::default() };
        let outcome = check_file(AWSM, &with);
        let input = frame(&scene, light(LightKind::Directional));
        let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
        let pixels = seen(&picture, &input.camera);
        let near = half_width(pixels.iter().copied().filter(|[_, distance, _]| *distance < 3.38));
        let far = half_width(pixels.iter().copied().filter(|[_, distance, _]| *distance > 3.45));
        println!("{filter}, {blur} texels: {near:.4} before the end, {far:.4} after it");
        assert!((near / far - 1.0).abs() < 0.1, "{filter}: {near} before the end, {far} after it");
    }
}

#[test]
fn lights_without_a_size_have_hard_shadows() {
    let Some(gpu) = gpu::device() else { return };
    let scene = edge(0.6);
    for kind in
        [LightKind::Directional, LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 }, LightKind::Point]
    {
        for size in [0.0, -1.0, f32::NAN] {
            let without = light(kind).angular_diameter(size).radius(size);
            let input = frame(&scene, without);
            let picture = Host::new(&gpu, &pcss(&[]), &scene).picture(&input);
            let grey = picture.rgba_pixels().filter(|pixel| !matches!(pixel[0], 0 | 255)).count();
            // A texel is filtered over two at most.
            assert!(grey < picture.rgba_pixels().count() / 50, "{kind:?} {size}: {grey} pixels are grey");
            let dark = picture.rgba_pixels().filter(|pixel| pixel[0] == 0).count();
            assert!(dark > 1000, "{kind:?} {size}: {dark} pixels are dark");
        }
    }
}

#[test]
fn whatever_size_a_light_has_visibility_is_a_number() {
    let Some(gpu) = gpu::device() else { return };
    // Numbers as they were before they became bytes, of which none says that it was none.
    let text = format!(
        r#"{{ "format": 1, "name": "seen", "extends": "{AWSM}",
             "resources": {{ "color": {{ "texture": {{ "lifetime": "imported" }} }} }} }}"#
    );
    let with = With {
        parameters: &[("debug_view", "\"shadow_term\""), ("max_penumbra", "100"), ("max_search", "100")],
        features: &[("light_filter", "\"pcss\"")],
        size: Some(SIZE),
        ..With::default()
    };
    let outcome = check_with("seen.json", &text, &with);
    let scene = edge(0.6);
    for kind in
        [LightKind::Directional, LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 }, LightKind::Point]
    {
        // Larger than the scene; and so that receivers stand within the light.
        for (size, height) in [(1e30, LAMP), (f32::INFINITY, LAMP), (3.0, 0.05), (0.5, 0.0)] {
            let position = DVec3::new(0.0, height, 0.0);
            let large = light(kind).angular_diameter(size).radius(size).position(position);
            let input = frame(&scene, large);
            let mut host = Host::new(&gpu, &outcome, &scene);
            host.imports.push(("color", import(&gpu, outcome.plan(), "color")));
            host.picture(&input);
            let seen = pollster::block_on(read_back(&gpu.device, &gpu.queue, &host.imports[0].1));
            let seen = seen.expect("numbers").values;
            assert!(seen.iter().all(|texel| (0.0..=1.0).contains(&texel[0])), "{kind:?} {size} at {height}");
        }
    }
}

#[test]
fn each_light_says_how_hard_its_shadows_are() {
    let Some(gpu) = gpu::device() else { return };
    let scene = edge(0.6);
    let with = [("filter_radius", "0.1"), ("hard_below", "2")];
    let outcome = pcss(&with);
    for kind in
        [LightKind::Directional, LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 }, LightKind::Point]
    {
        // The pixels that are neither lit nor dark.
        let grey = |word: &'static str, priority: f32, size: f32| {
            let mut light = light(kind).priority(priority).angular_diameter(size).radius(size);
            light.properties.push(word.into());
            let input = frame(&scene, light);
            let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
            let dark = picture.rgba_pixels().filter(|pixel| pixel[0] == 0).count();
            assert!(dark > 1000, "{kind:?} {word}: {dark} pixels are dark");
            picture.rgba_pixels().filter(|pixel| !matches!(pixel[0], 0 | 255)).count()
        };
        let own = grey("", 3.0, 0.3);
        let (hard, soft, sizeless) =
            (grey("hard_shadow", 1.0, 0.3), grey("soft_shadow", 1.0, 0.3), grey("soft_shadow", 1.0, 0.0));
        println!("{kind:?}: grey {own}, hard {hard}, soft {soft}, soft without a size {sizeless}");
        assert_eq!(grey("pcss_shadow", 1.0, 0.3), own, "{kind:?}");
        assert_eq!(grey("", 1.0, 0.3), hard, "{kind:?}: those of little priority are hard");
        assert!(3 * hard < soft && soft == sizeless && soft != own, "{kind:?}");
    }
}

/// The distances that a debug view shows as colors, beside the edge's shadow; from blue over green to red.
fn shown(picture: &Picture, camera: &Camera, longest: f64) -> Vec<f64> {
    let places = seen(picture, camera);
    let part = |[r, g, b, _]: [u8; 4]| {
        let [r, g, b] = [r, g, b].map(|channel| f64::from(channel) / 255.0);
        let is_grey = r == g && g == b;
        let ramp = if b > 0.0 && g < 1.0 {
            g
        } else if b > 0.0 {
            2.0 - b
        } else if g >= 1.0 {
            1.0 + r
        } else {
            3.0 - g
        };
        (!is_grey).then_some(ramp / 3.0)
    };
    let near = places.iter().zip(picture.rgba_pixels()).filter(|([x, ..], _)| x.abs() < 0.1);
    near.filter_map(|(_, pixel)| part(pixel)).map(|part| longest * 2_f64.powf(10.0 * (part - 1.0))).collect()
}

#[test]
fn debug_views_show_penumbra_width_and_caster_distance() {
    let Some(gpu) = gpu::device() else { return };
    let height = 0.6;
    let scene = edge(height);
    let kinds =
        [LightKind::Directional, LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 }, LightKind::Point];
    // Without a width it is that of the penumbra.
    for (view, filter, wanted) in [
        ("\"penumbra\"", "\"pcss\"", None),
        ("\"penumbra\"", "\"poisson16\"", Some(0.07)),
        ("\"blockers\"", "\"hard\"", Some(height)),
    ] {
        let parameters = [
            ("debug_view", view),
            ("debug_distance", "2"),
            ("max_penumbra", "100"),
            ("max_search", "100"),
            ("filter_radius", "0.07"),
            ("min_radius", "1"),
            ("max_radius", "60"),
            ("search_taps", "32"),
            ("splits", "\"explicit\""),
            ("fit", "\"tight\""),
            ("far", "[6]"),
            ("tile_max_side", "2048"),
            ("atlas_min_side", "2048"),
        ];
        let features = [("light_filter", filter)];
        let with = With { parameters: &parameters, features: &features, size: Some(SIZE), ..With::default() };
        let outcome = check_file(AWSM, &with);
        for kind in kinds {
            let input = frame(&scene, light(kind));
            let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
            let mut all = shown(&picture, &input.camera, 2.0);
            all.sort_by(f64::total_cmp);
            let median = *all.get(all.len() / 2).expect("a shadow");
            let wanted = wanted.unwrap_or_else(|| analytic(kind, height));
            println!("{kind:?} {view} {filter}: {median:.4} of {wanted:.4}, {} pixels", all.len());
            assert!((median / wanted - 1.0).abs() < 0.1, "{kind:?} {view} {filter}: {median} of {wanted}");
        }
    }
}
