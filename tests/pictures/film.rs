//! The effect `film` against its formulas in 64 bits, on painted pictures.

use crate::common::gpu::{empty_frame, executor, import};
use crate::common::{With, check_with};
use glam::DVec3;
use serde_json::{Value, json};
use umbragraph::Frame;
use umbragraph::executor::read_back;
use umbragraph_test_support::gpu;

const SIZE: [u32; 2] = [96, 64];

/// Changes nothing.
fn neutral() -> Value {
    json!({ "vignette": 0, "grain": 0 })
}

fn with(changes: &Value) -> Value {
    let mut settings = neutral();
    for (name, value) in changes.as_object().expect("an object") {
        settings[name] = value.clone();
    }
    settings
}

/// The picture that the effect makes of an expression of WGSL over `place`, after so many frames.
fn developed(
    expression: &str,
    settings: &Value,
    table: Option<&[[f32; 3]]>,
    frames: u64,
) -> Option<Vec<DVec3>> {
    let gpu = gpu::device()?;
    let paint = format!(
        "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {{
    let place = covered.position.xy / vec2<f32>({}.0, {}.0);
    return vec4<f32>({expression}, 1.0);
}}
",
        SIZE[0], SIZE[1]
    );
    let mut inputs = json!({ "image": "&picture", "result": "&target", "eye": "&eye" });
    for (name, value) in settings.as_object().expect("an object") {
        inputs[name] = value.clone();
    }
    if let Some(table) = table {
        inputs["has_color_table"] = true.into();
        inputs["color_table_side"] = (table.len() as f64).cbrt().round().into();
    }
    let text = json!({
        "format": 1, "name": "developed",
        "resources": {
            "picture": { "texture": { "format": "rgba32float", "size": "=viewport" } },
            "target": { "texture": { "format": "rgba32float", "size": "=viewport", "lifetime": "imported" } },
        },
        "passes": {
            "eye": { "camera": { "to": "&eye" } },
            "paint": { "fullscreen": { "shader": "paint.wgsl.jinja", "color": [{ "to": "&picture" }] } },
            "film": { "use": "effects/film.json", "with": inputs },
        },
    });
    let templates = [("paint.wgsl.jinja", paint.as_str())];
    let with = With { templates: &templates, size: Some(SIZE), ..With::default() };
    let outcome = check_with("pipelines/developed.json", &text.to_string(), &with);
    let plan = outcome.plan();
    let target = import(&gpu, plan, "target");
    let mut imports = vec![("target", &target)];
    let volume = table.map(|table| {
        let texture = import(&gpu, plan, "film.color_table");
        let size = texture.size();
        assert_eq!((size.width * size.height * size.depth_or_array_layers) as usize, table.len());
        let bytes: Vec<u8> = table
            .iter()
            .flat_map(|[red, green, blue]| [*red, *green, *blue, 1.0])
            .flat_map(|channel| half::f16::from_f32(channel).to_le_bytes())
            .collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * size.width),
            rows_per_image: Some(size.height),
        };
        gpu.queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
        texture
    });
    imports.extend(volume.as_ref().map(|texture| ("film.color_table", texture)));
    let mut executor = executor(&gpu, plan, None);
    for index in 0..=frames {
        let mut input = empty_frame();
        input.index = index;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &Frame::new(&input).imports(&imports)).expect("a record");
        gpu.queue.submit([encoder.finish()]);
    }
    let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &target)).expect("texels");
    Some(
        texels
            .values
            .iter()
            .map(|[red, green, blue, _]| DVec3::new(*red as f64, *green as f64, *blue as f64))
            .collect(),
    )
}

const COLORS: &str = "vec3<f32>(place, 0.3 + 0.5 * place.x * place.y)";

/// The same color on the CPU, by the index of a pixel.
fn color(index: usize) -> DVec3 {
    let (x, y) = (index % SIZE[0] as usize, index / SIZE[0] as usize);
    let (x, y) = ((x as f64 + 0.5) / f64::from(SIZE[0]), (y as f64 + 0.5) / f64::from(SIZE[1]));
    DVec3::new(x, y, 0.3 + 0.5 * x * y)
}

fn decode(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn encode(value: f64) -> f64 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

fn per_channel(color: DVec3, change: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(change(color.x), change(color.y), change(color.z))
}

#[track_caller]
fn assert_near(found: &[DVec3], tolerance: f64, wanted: impl Fn(usize) -> DVec3) {
    assert_eq!(found.len(), (SIZE[0] * SIZE[1]) as usize);
    for (index, value) in found.iter().enumerate() {
        let wanted = wanted(index);
        let off = (*value - wanted).abs().max_element();
        assert!(off <= tolerance, "pixel {index}: {value} instead of {wanted}");
    }
}

#[test]
fn neutral_film_changes_nothing() {
    let Some(found) = developed(COLORS, &neutral(), None, 0) else { return };
    assert_near(&found, 1e-6, color);
}

/// The corners keep 1 - `vignette` of their light, by cos⁴ of an angle whose tangent grows with the distance.
#[test]
fn corners_lose_light_by_the_cosine_law() {
    for vignette in [0.3_f64, 0.75] {
        let Some(found) = developed(COLORS, &with(&json!({ "vignette": vignette })), None, 0) else { return };
        let tangent = ((1.0 - vignette).powf(-0.5) - 1.0).sqrt();
        let diagonal = f64::from(SIZE[0]).hypot(f64::from(SIZE[1])) / 2.0;
        assert_near(&found, 1e-4, |index| {
            let (x, y) = (index % SIZE[0] as usize, index / SIZE[0] as usize);
            let (x, y) =
                (x as f64 + 0.5 - f64::from(SIZE[0]) / 2.0, y as f64 + 0.5 - f64::from(SIZE[1]) / 2.0);
            let kept = (tangent * x.hypot(y) / diagonal).atan().cos().powi(4);
            per_channel(color(index), |value| encode(decode(value) * kept))
        });
    }
}

#[test]
fn grades_follow_their_formulas() {
    let (lift, gamma, gain) =
        (DVec3::new(0.05, -0.02, 0.1), DVec3::new(1.2, 0.8, 1.0), DVec3::new(0.9, 1.1, 1.3));
    let grade = json!({
        "lift": lift.to_array(), "gamma": gamma.to_array(), "gain": gain.to_array(), "contrast": 1.2, "saturation": 0.6,
    });
    let Some(found) = developed(COLORS, &with(&grade), None, 0) else { return };
    let grey = encode(0.18);
    assert_near(&found, 1e-4, |index| {
        let color = color(index);
        let raised = (gain * (color + lift * (1.0 - color))).max(DVec3::ZERO);
        let bent = DVec3::new(raised.x.powf(1.0 / gamma.x), raised.y.powf(1.0 / gamma.y), raised.z);
        let spread = (bent - grey) * 1.2 + grey;
        let luma = spread.dot(DVec3::new(0.2126, 0.7152, 0.0722));
        (DVec3::splat(luma) * 0.4 + spread * 0.6).clamp(DVec3::ZERO, DVec3::ONE)
    });
}

/// A color table of a side, red first.
fn table(side: usize, color: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    let part = |index: usize| index as f32 / (side.max(2) - 1) as f32;
    (0..side * side * side)
        .map(|index| color([part(index % side), part(index / side % side), part(index / side / side)]))
        .collect()
}

#[test]
fn color_tables_are_read_between_their_texels() {
    for side in [2, 17] {
        let turned = table(side, |[red, green, blue]| [1.0 - green, blue, red]);
        let Some(found) = developed(COLORS, &neutral(), Some(&turned), 0) else { return };
        // Filters of 8 bits between texels of 16.
        assert_near(&found, 0.003, |index| {
            let color = color(index);
            DVec3::new(1.0 - color.y, color.z, color.x)
        });
    }
    let Some(half) = developed(
        COLORS,
        &with(&json!({ "color_table_amount": 0.5 })),
        Some(&table(2, |color| color.map(|value| 1.0 - value))),
        0,
    ) else {
        return;
    };
    assert_near(&half, 0.003, |_| DVec3::splat(0.5));
}

#[test]
fn grain_has_its_deviation_and_changes_by_frame() {
    for size in [1.0, 2.5] {
        let settings = with(&json!({ "grain": 0.05, "grain_size": size }));
        let grey = "vec3<f32>(0.5)";
        let [first, second] = [0, 1].map(|frames| developed(grey, &settings, None, frames));
        let (Some(first), Some(second)) = (first, second) else { return };
        assert_eq!(Some(&first), developed(grey, &settings, None, 0).as_ref(), "one frame has one grain");
        let count = first.len() as f64;
        let mean = first.iter().map(|one| one.x).sum::<f64>() / count;
        let deviation = (first.iter().map(|one| (one.x - mean).powi(2)).sum::<f64>() / count).sqrt();
        println!("size {size}: mean {mean}, deviation {deviation}");
        assert!((mean - 0.5).abs() < 0.003 && (deviation - 0.05).abs() < 0.003);
        // Two frames have nothing in common.
        let common =
            first.iter().zip(&second).map(|(one, two)| (one.x - 0.5) * (two.x - 0.5)).sum::<f64>() / count;
        assert!(common.abs() < 0.1 * 0.05 * 0.05, "{common}");
    }
    let settings = with(&json!({ "grain": 1 }));
    for (expression, wanted) in [("vec3<f32>(0.0)", 0.0), ("vec3<f32>(1.0)", 1.0)] {
        let Some(found) = developed(expression, &settings, None, 0) else { return };
        assert_near(&found, 1e-6, |_| DVec3::splat(wanted));
    }
}

#[test]
fn film_of_bad_values_stays_finite() {
    let bad = "vec3<f32>(select(1.0, 1.0e30, place.x > 0.5) * 1.0e30, -5.0, select(0.5, bitcast<f32>(0x7fc00000u + u32(place.x)), place.y > 0.5))";
    let worst = json!({ "grain": 0, "vignette": 0.99, "lift": [-1, -1, -1], "gamma": [0.01, 0.01, 10], "gain": [10, 0, 1], "contrast": 4 });
    let of_one = [[0.25, 0.5, 0.75]];
    for table in [None, Some(&of_one[..])] {
        let Some(found) = developed(bad, &worst, table, 0) else { return };
        assert!(
            found.iter().all(|value| value.is_finite()),
            "{:?}",
            found.iter().find(|value| !value.is_finite())
        );
        if table.is_some() {
            assert_near(&found, 1e-3, |_| DVec3::new(0.25, 0.5, 0.75));
        }
    }
}
