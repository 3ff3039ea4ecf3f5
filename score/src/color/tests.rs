//! The tracer against closed forms, on scenes written here.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use umbragraph_pipeline::frame::{Camera, Light, Projection};
use umbragraph_scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;

use super::lamp::Lamp;
use super::sky::{Radiance, Sky};
use super::surface::Surfaces;
use super::tracer::{Ambient, ColorTracer, PixelArea, Settings, Traced};
use crate::rays::Rays;

const SIDE: u32 = 24;

/// Positions, normals, texture coordinates and indices of a mesh.
#[derive(Default)]
struct Shape {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    indices: Vec<u32>,
}

/// A sphere of radius 1 about the origin.
fn sphere() -> Shape {
    let (rings, turns) = (64, 128);
    let mut shape = Shape::default();
    for ring in 0..=rings {
        for turn in 0..=turns {
            let (sine, cosine) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
            let (z, x) = (2.0 * PI * f64::from(turn) / f64::from(turns)).sin_cos();
            shape.normals.push(DVec3::new(sine * x, cosine, sine * z));
        }
    }
    shape.positions = shape.normals.clone();
    for ring in 0..rings {
        for turn in 0..turns {
            let at = ring * (turns + 1) + turn;
            let below = at + turns + 1;
            shape.indices.extend([at, at + 1, below, at + 1, below + 1, below]);
        }
    }
    shape
}

/// A square in the plane y = 0 that faces up.
fn ground(half: f64) -> Shape {
    let positions = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    Shape {
        positions: positions.map(|[x, z]| DVec3::new(x * half, 0.0, z * half)).to_vec(),
        normals: vec![DVec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// A scene of shapes, each with its material and the transform of its node.
fn scene(parts: &[(Shape, Value, Value)]) -> Scene {
    let (mut binary, mut views, mut accessors): (Vec<u8>, Vec<Value>, Vec<Value>) = Default::default();
    let mut add = |bytes: Vec<u8>, count: usize, kind: u32, of: &str, range: Option<[DVec3; 2]>| {
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        let mut accessor =
            json!({ "bufferView": views.len() - 1, "componentType": kind, "count": count, "type": of });
        if let Some([min, max]) = range {
            (accessor["min"], accessor["max"]) = (json!(min.to_array()), json!(max.to_array()));
        }
        accessors.push(accessor);
        binary.extend(bytes);
        accessors.len() - 1
    };
    let bytes = |list: &[DVec3]| {
        list.iter()
            .flat_map(|point| point.as_vec3().to_array())
            .flat_map(f32::to_le_bytes)
            .collect::<Vec<u8>>()
    };
    let mut meshes = Vec::new();
    for (at, (shape, ..)) in parts.iter().enumerate() {
        let count = shape.positions.len();
        let range = shape
            .positions
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], at| [min.min(*at), max.max(*at)]);
        let position = add(bytes(&shape.positions), count, 5126, "VEC3", Some(range));
        let normal = add(bytes(&shape.normals), count, 5126, "VEC3", None);
        let indices = shape.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let indices = add(indices, shape.indices.len(), 5125, "SCALAR", None);
        meshes.push(json!({ "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices, "material": at
        }] }));
    }
    let node = |(at, (_, _, node)): (usize, &(Shape, Value, Value))| {
        let mut node = node.clone();
        node["mesh"] = json!(at);
        node
    };
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_materials_specular", "KHR_materials_unlit", "KHR_materials_emissive_strength"],
        "scenes": [{ "nodes": (0..parts.len()).collect::<Vec<_>>() }],
        "nodes": parts.iter().enumerate().map(node).collect::<Vec<_>>(),
        "meshes": meshes,
        "materials": parts.iter().map(|(_, material, _)| material).collect::<Vec<_>>(),
        "accessors": accessors, "bufferViews": views, "buffers": [{ "byteLength": binary.len() }],
    });
    from_slice("test.glb", &container(&document.to_string(), &binary), &NoFiles).expect("a scene")
}

/// A material without a lobe: reflection is albedo over pi.
fn lambert(albedo: f64) -> Value {
    json!({
        "pbrMetallicRoughness": { "baseColorFactor": [albedo, albedo, albedo, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
    })
}

/// A camera that looks at a point.
fn camera(from: DVec3, at: DVec3) -> Camera {
    let forward = (at - from).normalize();
    let right = forward.cross(if forward.y.abs() > 0.9 { DVec3::NEG_Z } else { DVec3::Y }).normalize();
    let rotation = glam::DMat3::from_cols(right, right.cross(forward), -forward);
    let projection = Projection::Perspective { vertical_fov: 0.8, near: 0.01, far: 100.0 };
    Camera::new(from, DQuat::from_mat3(&rotation), projection, 1.0)
}

fn settings(samples: u32, bounces: u32) -> Settings {
    Settings { samples, bounces, seed: 1, ambient: Ambient::Occluded, area: PixelArea::Middle }
}

fn flat(radiance: f64) -> Sky {
    let light = Radiance::Halves { above: DVec3::splat(radiance), below: DVec3::splat(radiance) };
    Sky::new(light.clone(), light)
}

fn traced(scene: &Scene, camera: &Camera, sky: &Sky, lights: &[Light], settings: Settings) -> Traced {
    let pose = scene.rest_pose();
    let rays = Rays::new(scene, &pose);
    let lamps = lights.iter().map(|light| Lamp::new(light, true).expect("a usable light")).collect();
    let tracer = ColorTracer::new(&rays, Surfaces::new(scene, &pose), sky, lamps, settings);
    tracer.picture(camera, [SIDE; 2], &|| {})
}

/// The unit direction of the ray through the middle of a pixel.
fn direction(camera: &Camera, pixel: usize) -> DVec3 {
    crate::truth::camera_ray(camera, [SIDE; 2], pixel, glam::DVec2::splat(0.5)).1.normalize()
}

#[test]
fn a_lambert_sphere_is_as_bright_as_its_cosine() {
    let scene = scene(&[(sphere(), lambert(0.7), json!({}))]);
    let camera = camera(DVec3::new(0.0, 0.5, 3.5), DVec3::ZERO);
    let to_light = DVec3::new(0.5, 0.7, 0.6).normalize();
    let light = Light::directional("sun", (-to_light).to_array(), [1.0; 3], 3.0);
    let picture = traced(&scene, &camera, &flat(0.0), &[light], settings(1, 0));
    let mut seen = 0;
    for pixel in 0..(SIDE * SIDE) as usize {
        let toward = direction(&camera, pixel);
        let middle = -camera.position.dot(toward);
        let square = middle * middle - camera.position.length_squared() + 1.0;
        if square < 0.02 {
            continue;
        }
        let normal = camera.position + toward * (middle - square.sqrt());
        let cosine = normal.dot(to_light);
        let expected = 0.7 / PI * 3.0 * cosine.max(0.0);
        // Facets shade one another where light grazes them.
        if !(-0.1..=0.1).contains(&cosine) {
            let found = picture.radiance[pixel].x;
            assert!((found - expected).abs() < 0.01, "{pixel}: {found} {expected}");
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn a_white_sphere_vanishes_in_white_light() {
    let camera = camera(DVec3::new(0.0, 0.0, 3.5), DVec3::ZERO);
    for (metallic, roughness) in [(0, 0.05), (0, 0.6), (1, 0.05), (1, 0.4), (1, 1.0)] {
        let material =
            json!({ "pbrMetallicRoughness": { "metallicFactor": metallic, "roughnessFactor": roughness } });
        let scene = scene(&[(sphere(), material, json!({}))]);
        let open = Settings { ambient: Ambient::Open, ..settings(256, 0) };
        let picture = traced(&scene, &camera, &flat(1.0), &[], open);
        let worst = picture.radiance.iter().map(|radiance| (radiance.x - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 0.02, "metallic {metallic}, roughness {roughness}: {worst}");
        let mean =
            picture.radiance.iter().map(|radiance| radiance.x - 1.0).sum::<f64>() / f64::from(SIDE * SIDE);
        assert!(mean.abs() < 0.005, "metallic {metallic}, roughness {roughness}: {mean}");
    }
}

#[test]
fn a_point_light_falls_off_with_the_square() {
    let scene = scene(&[(ground(40.0), lambert(0.5), json!({}))]);
    let camera = camera(DVec3::new(0.0, 9.0, 0.01), DVec3::ZERO);
    let place = DVec3::new(1.0, 2.0, -0.5);
    for radius in [0.0, 0.3] {
        let light = Light::point("lamp", place.to_array(), [1.0; 3], 40.0).radius(radius);
        let picture = traced(&scene, &camera, &flat(0.0), &[light], settings(64, 0));
        for pixel in 0..(SIDE * SIDE) as usize {
            let toward = direction(&camera, pixel);
            let offset = place - (camera.position - toward * (camera.position.y / toward.y));
            let expected = 0.5 / PI * 40.0 * offset.y / offset.length().powi(3);
            let found = picture.radiance[pixel].x;
            let tolerance = if radius > 0.0 { 0.03 } else { 1e-6 };
            assert!((found - expected).abs() < tolerance * expected, "{pixel}: {found} {expected}");
        }
    }
}

#[test]
fn bounces_in_a_closed_room_add_up_to_a_series() {
    let mut material = lambert(0.5);
    material["emissiveFactor"] = json!([0.4, 0.4, 0.4]);
    material["doubleSided"] = json!(true);
    let scene = scene(&[(sphere(), material, json!({}))]);
    let camera = camera(DVec3::new(0.2, 0.1, 0.0), DVec3::new(0.0, 0.2, 1.0));
    for (bounces, expected) in [(0, 0.4), (1, 0.6), (3, 0.75)] {
        let picture = traced(&scene, &camera, &flat(9.0), &[], settings(64, bounces));
        // Now and then a direction above the bent normal lies behind the facet, and is lost.
        let worst = picture.radiance.iter().map(|radiance| (radiance.x - expected).abs()).fold(0.0, f64::max);
        let mean = picture.radiance.iter().map(|radiance| radiance.x).sum::<f64>() / f64::from(SIDE * SIDE);
        assert!(worst < 0.03 && (mean - expected).abs() < 0.003, "{bounces} bounces: {worst} {mean}");
    }
}

#[test]
fn a_gradient_lights_the_ground_as_its_integral_says() {
    let scene = scene(&[(ground(40.0), lambert(0.8), json!({}))]);
    let camera = camera(DVec3::new(0.0, 9.0, 0.01), DVec3::ZERO);
    let (horizon, zenith) = (DVec3::new(0.75, 0.72, 0.66), DVec3::new(0.16, 0.32, 0.62));
    let light = Radiance::Gradient { horizon, zenith, below: DVec3::splat(5.0) };
    let sky = Sky::new(light.clone(), light);
    for ambient in [Ambient::Open, Ambient::Occluded] {
        let picture = traced(&scene, &camera, &sky, &[], Settings { ambient, ..settings(256, 0) });
        // The integral of 2 · h · h^0.6 over heights h from 0 to 1 is 2 / 2.6.
        let part = 2.0 / 2.6;
        let expected = 0.8 * (horizon * (1.0 - part) + zenith * part);
        for radiance in &picture.radiance {
            assert!((*radiance - expected).length() < 0.01, "{radiance} {expected}");
        }
    }
}

#[test]
fn blended_surfaces_cover_what_is_behind_by_their_alpha() {
    let unlit = |color: [f64; 4]| {
        json!({
            "pbrMetallicRoughness": { "baseColorFactor": color },
            "alphaMode": "BLEND", "extensions": { "KHR_materials_unlit": {} },
        })
    };
    let at = |height: f64| json!({ "translation": [0, height, 0] });
    let scene = scene(&[
        (ground(40.0), unlit([1.0, 0.0, 0.0, 0.25]), at(1.0)),
        (ground(40.0), unlit([0.0, 1.0, 0.0, 0.5]), at(2.0)),
    ]);
    let from_above = camera(DVec3::new(0.0, 9.0, 0.01), DVec3::ZERO);
    let picture = traced(&scene, &from_above, &flat(2.0), &[], settings(1, 0));
    let expected = DVec3::new(0.5 * 0.25, 0.5, 0.0) + 0.375 * 2.0;
    assert!((picture.radiance[300] - expected).length() < 1e-9, "{}", picture.radiance[300]);
    // Their backs are not seen.
    let from_below = camera(DVec3::new(0.0, -9.0, 0.01), DVec3::ZERO);
    assert_eq!(traced(&scene, &from_below, &flat(2.0), &[], settings(1, 0)).radiance[300], DVec3::splat(2.0));
}

#[test]
fn mirrored_nodes_show_their_fronts() {
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.25, 0.25, 1] },
        "extensions": { "KHR_materials_unlit": {} },
    });
    let scene = scene(&[(sphere(), material, json!({ "scale": [-1, 1, 1] }))]);
    let camera = camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO);
    let middle = (SIDE * SIDE / 2 + SIDE / 2) as usize;
    assert!(
        (traced(&scene, &camera, &flat(0.0), &[], settings(1, 0)).radiance[middle].x - 0.25).abs() < 1e-6
    );
    let rays_scene = Rays::new(&scene, &scene.rest_pose());
    let seen = rays_scene.seen(camera.position, DVec3::NEG_Z, [0.0, 10.0]).expect("a surface");
    assert!((seen.distance - 2.0).abs() < 0.01, "the near side: {}", seen.distance);
}

#[test]
fn a_seed_gives_one_picture_and_more_samples_less_noise() {
    let scene = scene(&[
        (ground(40.0), lambert(0.8), json!({})),
        (sphere(), lambert(0.3), json!({ "translation": [0, 1, 0] })),
    ]);
    let camera = camera(DVec3::new(0.0, 5.0, 6.0), DVec3::Y);
    let sky = flat(1.0);
    let picture = |seed: u64, samples: u32| {
        traced(&scene, &camera, &sky, &[], Settings { seed, ..settings(samples, 1) })
    };
    assert_eq!(picture(3, 8), picture(3, 8));
    assert_ne!(picture(3, 8).radiance, picture(4, 8).radiance);
    let noise = |samples: u32| picture(3, samples).noise.iter().map(|noise| noise.x.abs()).sum::<f64>();
    assert!(noise(64) < 0.5 * noise(8), "{} {}", noise(64), noise(8));
}
