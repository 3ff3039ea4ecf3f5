//! `umbragraph score --of color` and `tune --of color` as a user meets them.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::{Value, json};
use umbragraph_test_support::command::rejected;
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::scratch::ScratchFolder;

const UMBRA: &str = "pipelines/umbra.json";
const FIGURE: &str = "examples/scenes/figure.glb";

/// The pipeline as it computes what is traced: no effects, one sample, no occlusion of ambient light.
const PLAIN: [&str; 8] = [
    "--feature",
    "ambient_occlusion=off",
    "--feature",
    "bloom=off",
    "--feature",
    "fxaa=off",
    "--ambient",
    "open",
];

fn command(name: &str, pipeline: &str, scene: &str, size: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args([name, pipeline, "--scene", scene, "--size", size, "--of", "color"]);
    command.current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."));
    command
}

fn score(scene: &str, arguments: &[&str]) -> Output {
    command("score", UMBRA, scene, "96x54").args(arguments).output().expect("the command")
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The mean errors over the picture and over its surfaces, and the noise of the traced picture.
fn errors(output: &Output) -> [f64; 3] {
    let json = json(output);
    println!("{}", json["together"]);
    ["mean_error", "surface_error", "noise"].map(|name| json["together"][name].as_f64().expect("a score"))
}

/// Writes a scene of spheres of 1 m in rows of `columns`, each with its material, before a camera and under a light.
fn spheres(path: &Path, materials: &[Value], columns: usize, light: f64) {
    let (rings, turns) = (32_u32, 64_u32);
    let (mut points, mut indices) = (Vec::new(), Vec::new());
    for ring in 0..=rings {
        for turn in 0..=turns {
            let (sine, cosine) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
            let (z, x) = (2.0 * PI * f64::from(turn) / f64::from(turns)).sin_cos();
            points.extend([sine * x, cosine, sine * z].map(|part| part as f32));
        }
    }
    for ring in 0..rings {
        for turn in 0..turns {
            let at = ring * (turns + 1) + turn;
            let below = at + turns + 1;
            indices.extend([at, at + 1, below, at + 1, below + 1, below]);
        }
    }
    let count = points.len() / 3;
    let mut binary: Vec<u8> = points.iter().flat_map(|part| part.to_le_bytes()).collect();
    let bytes = binary.len();
    binary.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    let mesh = |material: usize| json!({ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 0 }, "indices": 1, "material": material }] });
    let rows = materials.len().div_ceil(columns);
    let node = |at: usize| {
        let (x, y) = (at % columns, at / columns);
        let place = |at: usize, count: usize| (at as f64 - 0.5 * (count - 1) as f64) * 2.4;
        json!({ "mesh": at, "translation": [place(x, columns), -place(y, rows), 0] })
    };
    let mut nodes: Vec<Value> = (0..materials.len()).map(node).collect();
    let distance = 2.6 * (rows as f64).max(columns as f64 * 9.0 / 16.0) + 2.0;
    nodes.push(json!({ "camera": 0, "translation": [0, 0, distance] }));
    nodes.push(json!({
        "rotation": [-0.35, 0.25, 0.1, 0.897_217_922_246_3],
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    let extensions =
        ["KHR_lights_punctual", "KHR_materials_specular", "KHR_materials_ior", "KHR_materials_unlit"];
    let document = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": extensions,
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "directional", "intensity": light, "extras": { "angular_diameter_deg": 0.53 } }
        ] } },
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "zfar": 100 } }],
        "meshes": (0..materials.len()).map(mesh).collect::<Vec<_>>(),
        "materials": materials,
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1] },
            { "bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": bytes },
            { "buffer": 0, "byteOffset": bytes, "byteLength": binary.len() - bytes },
        ],
        "buffers": [{ "byteLength": binary.len() }],
    });
    std::fs::write(path, container(&document.to_string(), &binary)).expect("a scene");
}

/// Writes a Radiance picture: bright above, striped around, with a soft sun.
fn surroundings(path: &Path) {
    let (width, height) = (128_u32, 64_u32);
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for at in 0..width * height {
        let (u, v) = (f64::from(at % width) / f64::from(width), f64::from(at / width) / f64::from(height));
        let height = 0.5 + 0.5 * (PI * v).cos();
        let sun = 8.0 * (-60.0 * ((u - 0.3).powi(2) + 0.25 * (v - 0.3).powi(2))).exp();
        let stripe = if (u * 8.0) as u32 % 2 == 1 { 0.75 } else { 0.15 };
        let color =
            [0.3 + 0.5 * height, 0.35 + 0.6 * height, 0.4 + 0.9 * height].map(|part| part + stripe + sun);
        let exponent = color.into_iter().fold(0.0, f64::max).log2().floor() + 1.0;
        bytes.extend(color.map(|part| (part * 256.0 / exponent.exp2()) as u8));
        bytes.push((exponent + 128.0) as u8);
    }
    std::fs::write(path, bytes).expect("a picture");
}

fn material(color: [f64; 3], metallic: f64, roughness: f64) -> Value {
    let [red, green, blue] = color;
    json!({ "pbrMetallicRoughness": {
        "baseColorFactor": [red, green, blue, 1], "metallicFactor": metallic, "roughnessFactor": roughness
    } })
}

#[test]
fn a_picture_agrees_with_paths_and_its_sheet_shows_both() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("a_picture_agrees_with_paths");
    let sheet = folder.join("sheet.png");
    let arguments = ["--samples", "64", "--format", "json", "--out", sheet.to_str().unwrap()];
    let [mean, surfaces, noise] = errors(&score(FIGURE, &[&PLAIN[..], &arguments].concat()));
    // Three quarters of it are the lobe that `umbra` leaves out of rough dielectrics, and walls that face the horizon.
    assert!(mean < 0.02 && surfaces < 0.02 && noise < 0.01, "{mean} {surfaces} {noise}");
    let sheet = Picture::load(&sheet).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (3 * 96, 54), "rendered, traced, FLIP");
}

#[test]
fn the_texture_before_effects_is_scored_without_them() {
    if gpu::device().is_none() {
        return;
    }
    let common =
        ["--ambient", "open", "--format", "json", "--feature", "ambient_occlusion=off", "--samples", "16"];
    let output = score(FIGURE, &[&common[..], &["--set", "bloom_amount=0.9"]].concat());
    let with_effects = errors(&output)[0];
    let notes = String::from_utf8_lossy(&output.stderr);
    assert!(notes.contains("bloom, fxaa"), "{notes}");
    let output =
        score(FIGURE, &[&common[..], &["--set", "bloom_amount=0.9", "--resource", "color@sky"]].concat());
    let before = errors(&output)[0];
    assert!(before < 0.02 && before + 0.01 < with_effects, "{before} {with_effects}");
    rejected(&score(FIGURE, &["--resource", "depth"]), 1, &["UG0812", "depth"]);
}

#[test]
fn a_seed_repeats_and_limits_decide() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("a_seed_repeats_and_limits_decide");
    let said = |seed: &str| score(FIGURE, &["--samples", "4", "--seed", seed, "--format", "json"]).stdout;
    assert_eq!(said("5"), said("5"));
    assert_ne!(said("5"), said("6"));
    let limits = folder.join("limits.json");
    std::fs::write(&limits, r#"{ "max_flip": 0.0001 }"#).unwrap();
    let limited = || score(FIGURE, &["--samples", "4", "--limits", limits.to_str().unwrap()]);
    rejected(&limited(), 1, &["UG0813", "max_flip is 0.0001"]);
    std::fs::write(&limits, r#"{ "min_iou": 0.5 }"#).unwrap();
    rejected(&limited(), 1, &["UG0813", "min_iou", "max_surface_error"]);
}

#[test]
fn options_that_do_not_fit_are_told() {
    let shadows = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["score", UMBRA, "--scene", FIGURE]).args(arguments);
        command
            .current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."))
            .output()
            .expect("the command")
    };
    rejected(&shadows(&["--samples", "4"]), 1, &["UG0812", "--samples", "--of color"]);
    rejected(&score(FIGURE, &["--ambient", "open", "--bounces", "1"]), 1, &["UG0812", "--bounces 1"]);
}

#[test]
fn spheres_over_metalness_and_roughness_agree_with_paths() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("spheres_over_metalness_and_roughness");
    let path = folder.join("spheres.glb");
    let grid = [0.0, 0.5, 1.0].iter().flat_map(|metallic| {
        [0.1, 0.3, 0.5, 0.75, 1.0].map(|roughness| material([0.9, 0.6, 0.3], *metallic, roughness))
    });
    spheres(&path, &grid.collect::<Vec<_>>(), 5, 2.0);
    let sky = folder.join("sky.hdr");
    surroundings(&sky);
    let mut command = command("score", UMBRA, path.to_str().unwrap(), "128x72");
    let arguments = ["--samples", "128", "--format", "json", "--set", "exposure=0.2", "--environment"];
    let output = command.args(PLAIN).args(arguments).arg(&sky).output().expect("the command");
    let [mean, surfaces, noise] = errors(&output);
    assert!(mean < 0.01 && surfaces < 0.015 && noise < 0.01, "{mean} {surfaces} {noise}");
}

#[test]
fn extensions_agree_with_paths() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("extensions_agree_with_paths");
    let with = |roughness: f64, extensions: Value| {
        let mut material = material([0.4, 0.5, 0.7], 0.0, roughness);
        material["extensions"] = extensions;
        material
    };
    let sky = folder.join("sky.hdr");
    surroundings(&sky);
    for (name, extensions) in [
        ("ior", json!({ "KHR_materials_ior": { "ior": 2.2 } })),
        (
            "specular",
            json!({ "KHR_materials_specular": { "specularFactor": 0.4, "specularColorFactor": [1, 0.5, 0.2] } }),
        ),
        ("unlit", json!({ "KHR_materials_unlit": {} })),
    ] {
        let path = folder.join(format!("{name}.glb"));
        spheres(&path, &[0.2, 0.5, 0.9].map(|roughness| with(roughness, extensions.clone())), 3, 2.0);
        let arguments = [
            "--samples",
            "128",
            "--format",
            "json",
            "--set",
            "exposure=0.2",
            "--environment",
            sky.to_str().unwrap(),
        ];
        let [mean, surfaces, noise] =
            errors(&score(path.to_str().unwrap(), &[&PLAIN[..], &arguments].concat()));
        println!("{name}: {mean} {surfaces} {noise}");
        assert!(mean < 0.005 && surfaces < 0.01, "{name}: {mean} {surfaces} {noise}");
    }
}

#[test]
fn tune_brings_a_picture_closer_to_paths() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("tune_brings_a_picture_closer");
    let out = folder.join("tuned.json");
    let arguments = [
        "--over",
        "occlusion_strength",
        "--set",
        "occlusion_strength=4",
        "--budget",
        "8",
        "--samples",
        "16",
        "--bounces",
        "1",
        "--resource",
        "color@sky",
        "--format",
        "json",
        "--out",
    ];
    let mut command = command("tune", UMBRA, FIGURE, "96x54");
    let found = json(&command.args(arguments).arg(&out).output().expect("the command"));
    let [before, after] = ["before", "after"].map(|name| found[name]["score"].as_f64().unwrap());
    assert_eq!(found["score"], "mean error");
    assert!(after < before, "{before} {after}");
    assert!(std::fs::read_to_string(&out).unwrap().contains("\"occlusion_strength\""));
}
