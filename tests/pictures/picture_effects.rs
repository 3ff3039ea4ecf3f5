//! Bloom keeps the sum of light, and exposure follows the histogram: on painted pictures, whose results are known.

use crate::common::gpu::{empty_frame, executor, import};
use crate::common::{Outcome, With, check_with};
use serde_json::{Value, json};
use umbragraph::Frame;
use umbragraph::executor::read_back;
use umbragraph_test_support::gpu;

const SIZE: [u32; 2] = [96, 64];

/// A pipeline that paints a picture of an expression of WGSL over `place` and a live parameter, and uses an effect on
/// it.
fn painted(expression: &str, effect: &str, with: &Value) -> Outcome {
    let paint = format!(
        "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
struct Settings {{ @align(16) level: f32 }}
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {{
    let place = covered.position.xy;
    return vec4<f32>(vec3<f32>({expression}), 1.0);
}}
"
    );
    let mut inputs = json!({ "image": "&picture@paint", "result": "&picture" });
    for (name, value) in with.as_object().expect("an object") {
        inputs[name] = value.clone();
    }
    let text = json!({
        "format": 1, "name": "painted",
        "parameters": { "level": { "type": "f32", "default": 1, "unit": "1", "min": 0, "max": 1000 } },
        "resources": {
            "picture": { "texture": { "format": "rgba16float", "size": "=viewport", "lifetime": "imported" } },
            "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } },
        },
        "passes": {
            "eye": { "camera": { "to": "&eye" } },
            "paint": { "fullscreen": {
                "shader": "paint.wgsl.jinja", "bind": { "settings": { "values": { "level": "=level" } } },
                "color": [{ "to": "&picture" }],
            } },
            "effect": { "use": format!("effects/{effect}.json"), "with": inputs },
            "show": { "fullscreen": {
                "shader": "resample.wgsl.jinja", "bind": { "source": "&picture" }, "color": [{ "to": "&target" }],
            } },
        },
    });
    let templates = [("paint.wgsl.jinja", paint.as_str())];
    let with = With { templates: &templates, size: Some(SIZE), ..With::default() };
    check_with("pipelines/painted.json", &text.to_string(), &with)
}

/// The picture after frames with a time in seconds and a level each.
fn drawn(outcome: &Outcome, frames: &[(f64, f32)]) -> Option<Vec<f32>> {
    let gpu = gpu::device()?;
    let plan = outcome.plan();
    let [picture, target] = ["picture", "target"].map(|name| import(&gpu, plan, name));
    let mut executor = executor(&gpu, plan, None);
    let level = executor.parameter::<f32>("level").expect("a live parameter");
    for (time, value) in frames {
        executor.set(level, *value).expect("a value");
        let mut input = empty_frame();
        input.time = *time;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("picture", &picture), ("target", &target)];
        executor.record(&mut encoder, &Frame::new(&input).imports(&imports)).expect("a record");
        gpu.queue.submit([encoder.finish()]);
    }
    let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &picture)).expect("texels");
    Some(texels.values.iter().map(|texel| texel[0]).collect())
}

#[test]
fn bloom_keeps_the_sum_of_light() {
    let spot = "select(0.0, settings.level, all(abs(place - vec2<f32>(49.0, 31.0)) < vec2<f32>(3.0)))";
    let sums = [0.0, 0.5].map(|amount| {
        let outcome = painted(spot, "bloom", &json!({ "amount": amount, "levels": 3 }));
        Some(drawn(&outcome, &[(0.0, 100.0)])?.iter().map(|value| f64::from(*value)).sum::<f64>())
    });
    let [Some(sharp), Some(scattered)] = sums else { return };
    println!("{sharp} without, {scattered} with bloom");
    assert!((sharp - 3600.0).abs() < 1.0 && (scattered / sharp - 1.0).abs() < 0.01);
}

#[test]
fn bloom_leaves_an_even_picture_as_it_is() {
    let outcome = painted("settings.level", "bloom", &json!({ "amount": 1, "spread": 1 }));
    let Some(values) = drawn(&outcome, &[(0.0, 0.75)]) else { return };
    assert!(values.iter().all(|value| (value / 0.75 - 1.0).abs() < 0.01), "{:?}", &values[..4]);
}

#[test]
fn an_even_picture_is_exposed_to_grey() {
    let exposed = |stops: f32, level: f32| {
        let outcome = painted(
            "settings.level",
            "auto_exposure",
            &json!({ "eye": "&eye", "grey": 0.25, "max_stops": stops }),
        );
        drawn(&outcome, &[(0.0, level)]).map(|values| values[1000])
    };
    for (stops, level, wanted) in
        [(12.0, 0.02, 0.25), (12.0, 7.0, 0.25), (2.0, 0.02, 0.08), (2.0, 7.0, 1.75), (12.0, 0.0, 0.0)]
    {
        let Some(value) = exposed(stops, level) else { return };
        assert!((value - wanted).abs() <= 0.01 * wanted, "{level} becomes {value} instead of {wanted}");
    }
}

/// Two thirds of the picture at 0.5, the rest black or very bright: the mean is that of the two thirds.
#[test]
fn exposure_leaves_the_ends_of_the_histogram_out() {
    let three = "select(select(0.5, 1000.0, place.x > 94.0), 0.0, place.x < 32.0)";
    let outcome = painted(three, "auto_exposure", &json!({ "eye": "&eye", "grey": 0.25, "brightest": 0.05 }));
    let Some(values) = drawn(&outcome, &[(0.0, 1.0)]) else { return };
    let middle = values[32 * SIZE[0] as usize + 60];
    assert!((middle - 0.25).abs() < 0.0025, "0.5 becomes {middle}");
}

#[test]
fn exposure_follows_in_time_and_at_once_at_first() {
    let outcome = painted(
        "settings.level",
        "auto_exposure",
        &json!({ "eye": "&eye", "grey": 0.25, "speed": 1, "max_stops": 12 }),
    );
    for (seconds, kept) in [(0.0, 1.0), (1.0, (-1.0_f32).exp()), (-1.0, 0.0)] {
        let Some(values) = drawn(&outcome, &[(5.0, 0.02), (5.0 + seconds, 0.32)]) else { return };
        let wanted =
            0.32 * ((0.25_f32 / 0.32).log2() * (1.0 - kept) + (0.25_f32 / 0.02).log2() * kept).exp2();
        assert!(
            (values[0] / wanted - 1.0).abs() < 0.01,
            "{} instead of {wanted} after {seconds} s",
            values[0]
        );
    }
}
