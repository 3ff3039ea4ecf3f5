//! Depth of field against the closed form of a thin lens, on painted pictures and depths.

use crate::common::gpu::{executor, import};
use crate::common::{With, check_with};
use serde_json::{Value, json};
use umbragraph::Frame;
use umbragraph::executor::read_back;
use umbragraph::frame::{Camera, FrameInput, Projection};
use umbragraph_test_support::gpu;

const SIZE: [u32; 2] = [384, 256];
const FOV: f64 = 0.6;
const NEAR: f64 = 0.1;
const FAR: f64 = 1000.0;

/// The picture that the effect makes of an expression of WGSL over `place`, in pixels, and of a distance in metres.
/// Alpha is how much of a white picture is left.
fn blurred(color: &str, distance: &str, settings: &Value) -> Option<Vec<[f32; 4]>> {
    let gpu = gpu::device()?;
    let paint = |name: &str, expression: &str| {
        (
            name.to_owned(),
            format!(
                "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
@fragment
fn paint(covered: Covered) -> @location(0) vec4<f32> {{
    let place = covered.position.xy;
    return vec4<f32>({expression}, 1.0);
}}
"
            ),
        )
    };
    // Reversed, so that a depth in a texture of 32 bits keeps a distance of any length.
    let depth = format!("vec3<f32>(({NEAR} * {FAR} / ({distance}) - {NEAR}) / ({FAR} - {NEAR}))");
    let templates = [paint("color.wgsl.jinja", color), paint("depth.test.wgsl.jinja", &depth)];
    let templates: Vec<_> = templates.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let mut inputs = json!({
        "image": "&picture@color", "result": "&picture", "depth": "&depth", "eye": "&eye", "reverse_z": true,
    });
    for (name, value) in settings.as_object().expect("an object") {
        inputs[name] = value.clone();
    }
    let text = json!({
        "format": 1, "name": "blurred",
        "resources": {
            "picture": { "texture": { "format": "rgba16float", "size": "=viewport", "lifetime": "imported" } },
            "depth": { "texture": { "format": "r32float", "size": "=viewport" } },
        },
        "passes": {
            "eye": { "camera": { "to": "&eye", "reverse": true } },
            "color": { "fullscreen": { "shader": "color.wgsl.jinja", "color": [{ "to": "&picture" }] } },
            "distance": { "fullscreen": { "shader": "depth.test.wgsl.jinja", "color": [{ "to": "&depth" }] } },
            "lens": { "use": "effects/depth_of_field.json", "with": inputs },
        },
    });
    let with = With { templates: &templates, size: Some(SIZE), ..With::default() };
    let outcome = check_with("pipelines/blurred.json", &text.to_string(), &with);
    let plan = outcome.plan();
    let picture = import(&gpu, plan, "picture");
    let mut executor = executor(&gpu, plan, None);
    let lens = Projection::Perspective { vertical_fov: FOV, near: NEAR, far: FAR };
    let input = FrameInput::new(Camera::new(
        glam::DVec3::ZERO,
        Default::default(),
        lens,
        f64::from(SIZE[0]) / f64::from(SIZE[1]),
    ));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor.record(&mut encoder, &Frame::new(&input).imports(&[("picture", &picture)])).expect("a record");
    gpu.queue.submit([encoder.finish()]);
    let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &picture)).expect("texels");
    Some(texels.values)
}

/// The diameter in pixels of a point at a distance, by the equation of a thin lens: the sensor stands where the focus
/// is sharp.
fn diameter(distance: f64, focus: f64, f_number: f64, sensor_height: f64) -> f64 {
    let sensor_distance = sensor_height / 2.0 / (FOV / 2.0).tan();
    let focal_length = 1.0 / (1.0 / sensor_distance + 1.0 / focus);
    let image_distance = 1.0 / (1.0 / focal_length - 1.0 / distance);
    let on_sensor = focal_length / f_number * (image_distance - sensor_distance).abs() / image_distance;
    on_sensor / sensor_height * f64::from(SIZE[1])
}

/// A bright point of 4 pixels becomes a disc: its diameter follows from the mean square of distances, an eighth of the
/// square of the diameter, less that of the point and of the filters at half resolution.
#[test]
fn bright_points_become_discs_of_the_lens_equation() {
    let point = "select(vec3<f32>(0.0), vec3<f32>(1000.0), all(abs(place - vec2<f32>(192.0, 128.0)) < vec2<f32>(1.0)))";
    let mut wrong = false;
    for (distance, focus, f_number, sensor) in [
        (20.0, 1.0, 1.0, 24.0),
        (0.5, 1.0, 1.4, 24.0),
        (8.0, 2.0, 0.5, 24.0),
        (0.5, 0.7, 0.45, 12.0),
        (3.0, 1.5, 0.7, 36.0),
    ] {
        let lens = json!({ "focus_distance": focus, "f_number": f_number, "sensor_height": sensor, "max_blur": 0.1 });
        let Some(picture) = blurred(point, &format!("{distance:?}"), &lens) else { return };
        let (mut sum, mut squares) = (0.0, 0.0);
        for (index, [red, ..]) in picture.iter().enumerate() {
            let (x, y) = (index % SIZE[0] as usize, index / SIZE[0] as usize);
            let (x, y) = (x as f64 + 0.5 - 192.0, y as f64 + 0.5 - 128.0);
            sum += f64::from(*red);
            squares += f64::from(*red) * (x * x + y * y);
        }
        // Mean squares in pixels: of the point, of the tent over 3 by 3 texels of two pixels, of reading between these, of
        // points at whole texels, and of an edge that is a texel wide.
        let filters = 0.5 + 4.0 + 1.0 + 4.0 / 6.0 + 4.0 * 5.0 / 24.0;
        let found = (8.0 * (squares / sum - filters)).sqrt();
        let wanted = diameter(distance, focus, f_number, sensor / 1000.0);
        println!(
            "{distance} m with the focus at {focus}: {found:.2} pixels, by its form {wanted:.2}; light {:.3}",
            sum / 4000.0
        );
        wrong |= (found / wanted - 1.0).abs() > 0.05 || (sum / 4000.0 - 1.0).abs() > 0.06;
        assert!(wanted > 6.0 && wanted < 25.0, "{wanted} is none of the test's sizes");
    }
    assert!(!wrong, "a diameter or a sum is more than 5 % off");
}

const BOARD: &str = "vec3<f32>(select(0.0, 1.0, (i32(place.x / 5.0) + i32(place.y / 5.0)) % 2 == 0))";

#[test]
fn what_is_in_focus_stays_bit_for_bit() {
    let lens = json!({ "focus_distance": 3, "f_number": 1.4 });
    let Some(sharp) = blurred(BOARD, "3.0", &lens) else { return };
    for (index, [red, ..]) in sharp.iter().enumerate() {
        let (x, y) = (index % SIZE[0] as usize, index / SIZE[0] as usize);
        assert_eq!(*red, f32::from(u8::from((x / 5 + y / 5) % 2 == 0)), "pixel {x}, {y}");
    }
}

/// A sharp white half before a black blurred one, and the other way around: nothing white is seen over the black.
#[test]
fn sharp_foreground_does_not_bleed_into_blur() {
    let lens = json!({ "focus_distance": 1, "f_number": 0.7, "max_blur": 0.1 });
    let (color, distance) =
        ("vec3<f32>(select(0.0, 1.0, place.x < 191.0))", "select(50.0, 1.0, place.x < 191.0)");
    let Some(picture) = blurred(color, distance, &lens) else { return };
    for (index, [red, ..]) in picture.iter().enumerate() {
        let x = index % SIZE[0] as usize;
        let wanted = f32::from(u8::from(x < 191));
        assert!((*red - wanted).abs() < 0.002, "{red} in column {x}");
    }
}

/// Before the focus an edge spreads over both sides: half the light at the edge, none and all a radius beside it.
#[test]
fn edges_before_the_focus_spread_over_both_sides() {
    let lens = json!({ "focus_distance": 20, "f_number": 0.8, "max_blur": 0.1 });
    let (color, distance) =
        ("vec3<f32>(select(0.0, 1.0, place.x < 192.0))", "select(20.0, 1.0, place.x < 192.0)");
    let Some(picture) = blurred(color, distance, &lens) else { return };
    let radius = diameter(1.0, 20.0, 0.8, 0.024) / 2.0;
    let column =
        |x: usize| (100..150).map(|y| f64::from(picture[y * SIZE[0] as usize + x][0])).sum::<f64>() / 50.0;
    println!("radius {radius:.1}; {:?}", (170..214).step_by(4).map(column).collect::<Vec<_>>());
    assert!(radius > 8.0 && radius < 12.0, "{radius}");
    // The part of a disc on one side of a line at a part of its radius.
    let part = |offset: f64| {
        let at = (offset / radius).clamp(-1.0, 1.0);
        (at.acos() - at * (1.0 - at * at).sqrt()) / std::f64::consts::PI
    };
    for x in (176..208).step_by(2) {
        let wanted = part(x as f64 + 0.5 - 192.0);
        assert!((column(x) - wanted).abs() < 0.12, "{} instead of {wanted} in column {x}", column(x));
    }
}

#[test]
fn bad_lenses_and_pictures_stay_finite() {
    let bad = "vec3<f32>(select(1.0, 1.0e30, place.x > 100.0) * 1.0e30, -5.0, 0.5)";
    for lens in [
        json!({ "focus_distance": 0, "f_number": 0 }),
        json!({ "focus_distance": 0, "f_number": 0, "sensor_height": 1000, "max_blur": 0.1 }),
        json!({ "focus_distance": 100_000, "f_number": 0, "lens_taps": 4 }),
    ] {
        for distance in ["1000.0", "0.1 + place.x"] {
            let Some(picture) = blurred(bad, distance, &lens) else { return };
            let is_bad = |index: &usize| picture[*index][1..].iter().any(|value| !value.is_finite());
            assert_eq!((0..picture.len()).find(is_bad), None, "{lens}");
        }
    }
}
