//! Fog against integrals in 64 bits: what arrives through it, and what it scatters of light from all sides.

use crate::common::gpu::Host;
use crate::common::{SMALL_MAPS, With, check_file, root};
use serde_json::json;
use umbragraph::frame::Camera;
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu;

const SIDE: u32 = 33;
const DISTANCE: f64 = 10.0;
const HEIGHT: f64 = 2.0;
const FOV: f64 = 0.8;

/// A wall of 2 km that reflects nothing and emits white light of a strength.
fn wall(strength: f64) -> Scene {
    let corners =
        [[-1000.0, -1000.0, 0.0_f32], [1000.0, -1000.0, 0.0], [-1000.0, 1000.0, 0.0], [1000.0, 1000.0, 0.0]];
    let binary: Vec<u8> = corners.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 5, "material": 0 }] }],
        "materials": [{
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 },
            "emissiveFactor": [strength, strength, strength], "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
        }],
        "extensionsUsed": ["KHR_materials_specular"],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
            "min": [-1000, -1000, 0], "max": [1000, 1000, 0],
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }], "buffers": [{ "byteLength": 48 }],
    });
    from_slice("wall.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

/// The linear red of the middle column, from the top, of the wall in fog.
fn column(
    strength: f64,
    (density, base, thickness): (f64, f64, f64),
    white: u32,
    half: &'static str,
) -> Option<Vec<f64>> {
    let gpu = gpu::device()?;
    let [density, base, thickness] = [density, base, thickness].map(|value| value.to_string());
    let color = format!("[{white}, {white}, {white}]");
    let fog = [
        ("fog_density", &density),
        ("fog_base", &base),
        ("fog_thickness", &thickness),
        ("fog_color", &color),
    ];
    let fog = fog.map(|(name, value)| (name, value.as_str()));
    let plain = [("tone_map", "\"none\""), ("ambient_sky", "[1, 1, 1]"), ("ambient_ground", "[1, 1, 1]")];
    let parameters: Vec<_> = SMALL_MAPS.iter().chain(&plain).chain(&fog).copied().collect();
    let features = [
        ("fog", "true"),
        ("half_resolution_fog", half),
        ("bloom", "false"),
        ("fxaa", "false"),
        ("sky_light", "false"),
    ];
    let with =
        With { parameters: &parameters, features: &features, size: Some([SIDE; 2]), ..With::default() };
    let outcome = check_file("pipelines/umbra.json", &with);
    let scene = wall(strength);
    let mut input = scene.frame_input(1.0, 0.0);
    input.camera = Camera::look_at([0.0, HEIGHT, DISTANCE], [0.0, HEIGHT, 0.0], FOV, 1.0);
    // The loader gives a scene without lights a sun.
    input.lights.clear();
    let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
    let pixels: Vec<[u8; 4]> = picture.rgba_pixels().collect();
    let linear = |byte: u8| {
        let value = f64::from(byte) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    Some((0..SIDE).map(|row| linear(pixels[(row * SIDE + SIDE / 2) as usize][0])).collect())
}

/// The light that arrives along the ray of a row, by quadrature.
fn arrives(row: usize, density: f64, base: f64, thickness: f64) -> f64 {
    let across = (1.0 - (row as f64 + 0.5) / f64::from(SIDE) * 2.0) * (FOV / 2.0).tan();
    let (length, rise) = (DISTANCE * 1.0_f64.hypot(across), DISTANCE * across);
    let steps = 10_000;
    let mean = (0..steps)
        .map(|step| {
            let height = HEIGHT + rise * (f64::from(step) + 0.5) / f64::from(steps);
            (-(height - base) / thickness).exp()
        })
        .sum::<f64>()
        / f64::from(steps);
    (-density * mean * length).exp()
}

const CASES: [(f64, f64, f64); 4] = [(0.05, 0.0, 1e6), (0.3, 0.0, 1.5), (0.1, 5.0, 4.0), (0.0, 0.0, 8.0)];

/// Each case at full and at half resolution.
fn cases() -> impl Iterator<Item = ((f64, f64, f64), &'static str)> {
    CASES.into_iter().flat_map(|case| [(case, "false"), (case, "true")])
}

#[test]
fn light_arrives_through_fog_as_its_integral_says() {
    for ((density, base, thickness), half) in cases() {
        let Some(column) = column(1.0, (density, base, thickness), 0, half) else { return };
        for (row, value) in column.into_iter().enumerate() {
            let wanted = arrives(row, density, base, thickness);
            assert!(
                (value - wanted).abs() < 0.01,
                "{value} instead of {wanted} in row {row} of {density}, {base}, {thickness}"
            );
        }
    }
}

/// In light of one luminance from all sides, 1 / π, white fog adds that of what it takes away.
#[test]
fn even_light_is_scattered_as_much_as_is_taken_away() {
    // What the wall itself reflects of it.
    let Some(clear) = column(0.0, (0.0, 0.0, 8.0), 1, "false") else { return };
    for ((density, base, thickness), half) in cases() {
        let Some(column) = column(0.0, (density, base, thickness), 1, half) else { return };
        for (row, value) in column.into_iter().enumerate() {
            let arrives = arrives(row, density, base, thickness);
            let wanted = clear[row] * arrives + (1.0 - arrives) / std::f64::consts::PI;
            assert!(
                (value - wanted).abs() < 0.005,
                "{value} instead of {wanted} in row {row} of {density}, {base}, {thickness}"
            );
        }
    }
}

/// On a scene with shadows in the fog, the two resolutions differ by less than a level in the mean.
#[test]
fn half_resolution_keeps_the_shadows_in_fog() {
    let Some(gpu) = gpu::device() else { return };
    let scene = crate::common::gpu::scene(&root().join("examples/scenes/courtyard.glb"));
    let [whole, half] = ["false", "true"].map(|half| {
        let features =
            [("fog", "true"), ("half_resolution_fog", half), ("whole_range", "true"), ("fxaa", "false")];
        let parameters: Vec<_> = SMALL_MAPS.iter().copied().chain([("fog_density", "0.05")]).collect();
        let with =
            With { parameters: &parameters, features: &features, size: Some([160, 90]), ..With::default() };
        let outcome = check_file("pipelines/umbra.json", &with);
        let mut host = Host::new(&gpu, &outcome, &scene);
        let input = scene.frame_input(16.0 / 9.0, 0.0);
        host.picture(&input).rgba_pixels().flatten().collect::<Vec<u8>>()
    });
    let sum: u32 = whole.iter().zip(&half).map(|(one, two)| u32::from(one.abs_diff(*two))).sum();
    let mean = f64::from(sum) / whole.len() as f64;
    println!("{mean} levels apart");
    assert!(mean < 1.0, "{mean} levels apart");
}
