//! Light from an equirectangular picture against closed forms and integrals in 64 bits.

use crate::common::gpu::{empty_frame, executor, import};
use crate::common::{With, check_with};
use serde_json::json;
use umbragraph::Frame;
use umbragraph::executor::read_back;
use umbragraph_test_support::gpu;

const LEVELS: usize = 6;

type Texels = Vec<[f32; 4]>;

/// Irradiance and the mip levels of reflections of a painted environment, as texels.
fn light(expression: &str) -> Option<(Texels, Vec<Texels>)> {
    let gpu = gpu::device()?;
    let paint = format!(
        "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
{{% include \"lib/environment_map.wgsl.jinja\" %}}
@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {{
    let at = environment_direction(covered.uv);
    return vec4<f32>({expression}, 1.0);
}}
"
    );
    let imported = |size: [u32; 2]| json!({ "texture": { "format": "rgba32float", "size": size, "lifetime": "imported" } });
    let mut resources = json!({
        "environment": { "texture": { "format": "rgba32float", "size": [1024, 512] } },
        "reflections": { "texture": { "format": "rgba16float", "size": [512, 256], "mips": LEVELS } },
        "irradiance": imported([9, 1]),
    });
    let mut passes = json!({
        "paint": { "fullscreen": { "shader": "paint.wgsl.jinja", "color": [{ "to": "&environment" }] } },
        "light": {
            "use": "parts/environment.json",
            "with": { "image": "&environment", "irradiance": "&irradiance", "reflections": "&reflections", "levels": LEVELS },
        },
    });
    for level in 0..LEVELS {
        resources[format!("level_{level}")] = imported([512 >> level, 256 >> level]);
        passes[format!("show_{level}")] = json!({ "fullscreen": {
            "shader": "resample.wgsl.jinja",
            "bind": {
                "source": { "texture": { "name": "&reflections", "mip": level } },
                
            },
            "color": [{ "to": format!("&level_{level}") }],
        } });
    }
    let text = json!({ "format": 1, "name": "lit", "resources": resources, "passes": passes }).to_string();
    let templates = [("paint.wgsl.jinja", paint.as_str())];
    let outcome = check_with("pipelines/lit.json", &text, &With { templates: &templates, ..With::default() });
    let plan = outcome.plan();
    let names: Vec<String> = std::iter::once("irradiance".to_owned())
        .chain((0..LEVELS).map(|level| format!("level_{level}")))
        .collect();
    let textures: Vec<_> = names.iter().map(|name| (name.as_str(), import(&gpu, plan, name))).collect();
    let mut executor = executor(&gpu, plan, None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let imports: Vec<_> = textures.iter().map(|(name, texture)| (*name, texture)).collect();
    executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(&imports)).expect("a record");
    gpu.queue.submit([encoder.finish()]);
    let mut read = textures.iter().map(|(_, texture)| {
        pollster::block_on(read_back(&gpu.device, &gpu.queue, texture)).expect("texels").values
    });
    let irradiance = read.next()?;
    Some((irradiance, read.collect()))
}

/// The direction of a texel of a mip level.
fn direction(index: usize, level: usize) -> [f64; 3] {
    let width = 512 >> level;
    let [x, y] = [index % width, index / width].map(|at| (at as f64 + 0.5) / width as f64);
    let (around, down) = ((x - 0.5) * std::f64::consts::TAU, y * std::f64::consts::TAU);
    [around.cos() * down.sin(), down.cos(), around.sin() * down.sin()]
}

/// Of a picture of first and second degree the harmonics are known: each is the picture's times π, 2π/3 or π/4.
#[test]
fn irradiance_of_an_environment_has_its_closed_form() {
    use std::f64::consts::PI;
    let Some((harmonics, _)) = light("vec3<f32>(2.0, 2.0 + 0.8 * at.y, 2.0 + 0.6 * at.x * at.z)") else {
        return;
    };
    let constant = 2.0 * PI / 0.282_094_79;
    let first = 0.8 * 2.0 * PI / 3.0 / 0.488_602_51;
    let second = 0.6 * PI / 4.0 / 1.092_548_43;
    for (index, texel) in harmonics.iter().enumerate() {
        let wanted = match index {
            0 => [constant; 3],
            1 => [0.0, first, 0.0],
            7 => [0.0, 0.0, second],
            _ => [0.0; 3],
        };
        for (value, wanted) in texel.iter().zip(wanted) {
            assert!(
                (f64::from(*value) - wanted).abs() < 0.01 * constant.min(wanted.abs().max(1.0)),
                "{index}: {texel:?}"
            );
        }
    }
}

/// The mean over a lobe keeps the direction of a linear picture, and shortens it by the mean cosine.
#[test]
fn reflections_of_an_environment_are_within_a_percent() {
    let Some((_, levels)) = light("vec3<f32>(2.0, 2.0 + at.y, 2.0 + at.x)") else { return };
    for (level, texels) in levels.into_iter().enumerate() {
        let roughness = level as f64 / (LEVELS - 1) as f64;
        let square = roughness.powi(4);
        let (mut sum, mut weights) = (0.0, 0.0);
        for step in 0..100_000 {
            let first = (f64::from(step) + 0.5) / 1e5;
            let height = 2.0 * (1.0 - first) / (1.0 + (square - 1.0) * first) - 1.0;
            sum += height.max(0.0) * height;
            weights += height.max(0.0);
        }
        let kept = if level == 0 { 1.0 } else { sum / weights };
        for (index, texel) in texels.iter().enumerate() {
            let [x, y, _] = direction(index, level);
            for (value, wanted) in texel.iter().zip([2.0, 2.0 + kept * y, 2.0 + kept * x]) {
                // Of the picture's mean.
                assert!(
                    (f64::from(*value) - wanted).abs() < 0.02,
                    "level {level}, texel {index}: {value} instead of {wanted}"
                );
            }
        }
    }
}

#[test]
fn environments_that_are_no_numbers_stay_finite() {
    let bad = "vec3<f32>(select(1.0, 1.0e30, at.x > 0.9) * 1.0e30, -5.0, select(1.0, bitcast<f32>(0x7fc00000u + u32(covered.uv.x)), at.y > 0.5))";
    let Some((harmonics, levels)) = light(bad) else { return };
    let all = levels.iter().flatten().chain(&harmonics).flatten();
    assert!(all.clone().all(|value| value.is_finite()));
    assert!(levels[1].iter().all(|texel| texel[1] == 0.0));
}
