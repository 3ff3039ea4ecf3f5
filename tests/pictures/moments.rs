//! Moments of depth against numbers of 64 bits: what is stored of a depth, and how it is blurred. Everything is
//! computed by the templates, on the device, and read back. How much light moments let through is in
//! `shaders-templates/lib/shadow/moments_bound.test.wgsl`.

use crate::common::gpu::{empty_frame, executor, import};
use crate::common::{With, check_with};
use umbragraph::Frame;
use umbragraph::executor::{Texels, read_back};
use umbragraph_test_support::gpu::{self, Gpu};

/// The texel formats with the moment modes that pipelines store in them, and their largest exponents.
const FORMATS: [(&str, &str, u32, f64); 5] = [
    ("rg32float", "rg32float", 0, 42.0),
    ("rgba32float", "rgba32float", 1, 42.0),
    ("packed_2x16float", "r32uint", 0, 5.54),
    ("rgba16float", "rgba16float", 1, 5.54),
    ("packed_4x16unorm", "rg32uint", 2, 1.0),
];

/// Writes moments of depths that run from -1 to 1 along each row.
const RAMP: &str = r#"{% include "lib/texels.wgsl.jinja" %}
{% include "lib/shadow/moments.wgsl.jinja" %}
struct Settings { exponent: f32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@group(1) @binding(1) var image: texture_storage_2d_array<{{ texel_storage }}, write>;
@compute @workgroup_size(64) fn ramp(@builtin(global_invocation_id) id: vec3<u32>) {
    let z = f32(id.x) / 512.0 - 1.0;
    textureStore(image, id.xy, 0, pack_texel(moments_of(z, settings.exponent)));
}
"#;

/// The four numbers of each texel.
const UNPACK: &str = r#"{% include "lib/texels.wgsl.jinja" %}
@group(1) @binding(1) var image: texture_2d_array<{{ texel_channel }}>;
@group(1) @binding(2) var plain: texture_storage_2d_array<rgba32float, write>;
@compute @workgroup_size(8, 8) fn unpack(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(plain)) || id.z >= textureNumLayers(plain) { return; }
    textureStore(plain, id.xy, id.z, unpack_texel(textureLoad(image, id.xy, id.z, 0)));
}
"#;

/// Numbers that differ from texel to texel.
const NOISE: &str = r#"{% include "lib/texels.wgsl.jinja" %}
@group(1) @binding(1) var image: texture_storage_2d_array<{{ texel_storage }}, write>;
@compute @workgroup_size(16, 16) fn paint(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(image)) || id.z >= textureNumLayers(image) { return; }
    let number = f32((id.x * 7919u + id.y * 104729u + id.z * 31u) % 1009u) / 1009.0;
    textureStore(image, id.xy, id.z, pack_texel(vec4<f32>(number, 1.0 - number, number * number, 0.5)));
}
"#;

/// An image of zeros with a one in it, one of a constant, and one of halves that are tiles.
const IMAGES: &str = r#"{% include "lib/texels.wgsl.jinja" %}
struct Settings { constant: f32, radius: f32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@group(1) @binding(1) var image: texture_storage_2d_array<{{ texel_storage }}, write>;
@group(1) @binding(2) var tiles: texture_storage_2d_array<rgba32uint, write>;
@compute @workgroup_size(16, 16) fn paint(@builtin(global_invocation_id) id: vec3<u32>) {
    let left = id.x < 32u;
    let one = f32(all(id.xy == vec2<u32>(40u, 20u)));
    let half = select(settings.constant * 0.25, settings.constant, left);
    textureStore(image, id.xy, 0, pack_texel(vec4<f32>(one)));
    textureStore(image, id.xy, 1, pack_texel(vec4<f32>(settings.constant)));
    textureStore(image, id.xy, 2, pack_texel(vec4<f32>(half)));
    let first = select(32u, 0u, left);
    let tile = vec4<u32>(first, (first + 31u) | (47u << 16u), bitcast<u32>(settings.radius), 0u);
    textureStore(tiles, id.xy / 16u, 0, tile);
    textureStore(tiles, id.xy / 16u, 1, vec4<u32>(0u, 63u | (47u << 16u), tile.zw));
    textureStore(tiles, id.xy / 16u, 2, tile);
}
"#;

const OWN: [(&str, &str); 8] = [
    ("ramp.wgsl.jinja", RAMP),
    (
        "ramp.axes.json",
        r#"{ "inherits": ["lib/texels.wgsl.jinja", "lib/shadow/moments.wgsl.jinja"], "axes": {} }"#,
    ),
    ("unpack.wgsl.jinja", UNPACK),
    ("unpack.axes.json", r#"{ "inherits": ["lib/texels.wgsl.jinja"], "axes": {} }"#),
    ("noise.wgsl.jinja", NOISE),
    ("noise.axes.json", r#"{ "inherits": ["lib/texels.wgsl.jinja"], "axes": {} }"#),
    ("images.wgsl.jinja", IMAGES),
    ("images.axes.json", r#"{ "inherits": ["lib/texels.wgsl.jinja"], "axes": {} }"#),
];

/// The texels that a pipeline of these resources and passes leaves in the texture "plain".
#[track_caller]
fn run(gpu: &Gpu, size: [u32; 3], resources: &str, passes: &str) -> Texels {
    let [width, height, layers] = size;
    let texture = format!(r#""size": [{width}, {height}], "layers": {layers}"#);
    let text = format!(
        r#"{{ "format": 1, "name": "oracle", "resources": {{
            "plain": {{ "texture": {{ "format": "rgba32float", {texture}, "view_dimension": "2d-array" }} }},
            "seen": {{ "texture": {{ "format": "rgba32float", {texture}, "lifetime": "imported" }} }}{resources}
        }}, "passes": {{
            {passes},
            "look": {{ "copy": {{
                "from": {{ "name": "&plain", "layers": {layers} }}, "to": {{ "name": "&seen", "layers": {layers} }}
            }} }}
        }} }}"#
    );
    let outcome = check_with("oracle.json", &text, &With { templates: &OWN, ..With::default() });
    let seen = import(gpu, outcome.plan(), "seen");
    let mut executor = executor(gpu, outcome.plan(), None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(&[("seen", &seen)])).expect("a record");
    gpu.queue.submit([encoder.finish()]);
    pollster::block_on(read_back(&gpu.device, &gpu.queue, &seen)).expect("texels")
}

/// The moments of a depth, as far as a mode has them.
fn moments(mode: u32, z: f64, exponent: f64) -> [f64; 4] {
    let (warped, turned) = ((exponent * z).exp(), -(-exponent * z).exp());
    match mode {
        0 => [warped, warped * warped, 0.0, 0.0],
        1 => [warped, turned, warped * warped, turned * turned],
        _ => [z, z * z, z.powi(3), z.powi(4)],
    }
}

#[test]
fn stored_moments_are_right_over_the_whole_depth_range() {
    let Some(gpu) = gpu::device() else { return };
    for (texel, format, mode, exponent) in FORMATS {
        let image = format!(
            r#", "image": {{ "texture": {{ "format": "{format}", "size": [1025, 1], "view_dimension": "2d-array" }} }}"#
        );
        let passes = format!(
            r#""ramp": {{ "compute": {{ "shader": "ramp.wgsl.jinja", "dispatch_over": "&image",
                "axes": {{ "texel_format": "{texel}", "moment_mode": {mode} }},
                "bind": {{ "image": "&image", "settings": {{ "values": {{ "exponent": {exponent} }} }} }} }} }},
            "unpack": {{ "compute": {{ "shader": "unpack.wgsl.jinja", "dispatch_over": "&plain",
                "axes": {{ "texel_format": "{texel}" }}, "bind": {{ "image": "&image", "plain": "&plain" }} }} }}"#
        );
        let seen = run(&gpu, [1025, 1, 1], &image, &passes);
        let mut worst = 0.0_f64;
        for (at, stored) in seen.values.iter().enumerate() {
            let wanted = moments(mode, at as f64 / 512.0 - 1.0, exponent);
            let stored = stored.map(f64::from);
            let (stored, wanted) = if mode == 2 { (stored, polynomials(wanted)) } else { (stored, wanted) };
            for (stored, wanted) in stored.into_iter().zip(wanted).take(if mode == 0 { 2 } else { 4 }) {
                assert!(stored.is_finite());
                // Of 16 bits those that the smallest numbers still have.
                let error = match texel {
                    "packed_4x16unorm" => (stored - wanted).abs(),
                    "packed_2x16float" | "rgba16float" => (stored - wanted).abs() / (wanted.abs() + 6e-5),
                    _ => (stored - wanted).abs() / wanted.abs().max(1e-37),
                };
                worst = worst.max(error);
            }
        }
        println!("{texel}, mode {mode}: {worst:e}");
        let bound = if texel.contains("16") { 1e-3 } else { 3e-5 };
        assert!(worst < if mode == 2 { 1.0 / 65535.0 } else { bound }, "{texel}: {worst:e}");
    }
}

/// The first four moments as they are stored: polynomials that run from 0 to 1.
fn polynomials([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let root = 3_f64.sqrt();
    [1.5 * a - 2.0 * c + 0.5, 4.0 * (b - d), root / 2.0 * a - root * 2.0 / 9.0 * c + 0.5, (b + d) / 2.0]
}

/// Blurs the images in a format; all three layers.
#[track_caller]
fn blurred(gpu: &Gpu, [texel, format]: [&str; 2], radius: f64, constant: f64, in_tiles: bool) -> Texels {
    let texture = |name: &str| {
        format!(
            r#", "{name}": {{ "texture": {{ "format": "{format}", "size": [64, 48], "layers": 3, "view_dimension": "2d-array" }} }}"#
        )
    };
    let resources = [
        &texture("image"),
        &texture("soft"),
        r#", "tiles": { "texture": { "format": "rgba32uint", "size": [4, 3], "layers": 3 } }"#,
    ]
    .map(str::to_owned)
    .concat();
    let (part, given) = if in_tiles {
        ("blur_tiles", r#""tiles": "&tiles""#.to_owned())
    } else {
        ("blur", format!(r#""radius": {radius}"#))
    };
    let passes = format!(
        r#""paint": {{ "compute": {{ "shader": "images.wgsl.jinja", "workgroups": [4, 3, 1], "axes": {{ "texel_format": "{texel}" }},
            "bind": {{ "image": "&image", "tiles": "&tiles", "settings": {{ "values": {{ "constant": {constant:?}, "radius": {radius} }} }} }} }} }},
        "soften": {{ "use": "pipelines/parts/{part}.json",
            "with": {{ "image": "&image", {given}, "result": "&soft", "texel_format": "{texel}" }} }},
        "unpack": {{ "compute": {{ "shader": "unpack.wgsl.jinja", "dispatch_over": "&plain", "axes": {{ "texel_format": "{texel}" }},
            "bind": {{ "image": "&soft", "plain": "&plain" }} }} }}"#
    );
    run(gpu, [64, 48, 3], &resources, &passes)
}

#[test]
fn weights_of_a_blur_are_a_gaussian_s_and_sum_to_one() {
    let Some(gpu) = gpu::device() else { return };
    // The radius of a tile may lie between two texels; the first image has a tile that ends eight texels left of the
    // one.
    for (radius, in_tiles) in [0.0, 1.0, 2.0, 6.0, 8.0, 16.0]
        .map(|r| (r, false))
        .into_iter()
        .chain([0.0, 0.4, 1.7, 6.0].map(|r| (r, true)))
    {
        let seen = blurred(&gpu, ["rgba32float", "rgba32float"], radius, 1.0, in_tiles);
        let sum: f64 = seen.values[..64 * 48].iter().map(|texel| f64::from(texel[0])).sum();
        assert!((sum - 1.0).abs() < 1e-6, "radius {radius}: weights sum to {sum}");
        let (deviation, reach) = (f64::max(radius, 0.03) / 2.5, radius.ceil());
        let weight = |offset: f64| (-0.5 * (offset / deviation).powi(2)).exp();
        let whole: f64 = (-reach as i64..=reach as i64).map(|offset| weight(offset as f64)).sum();
        for (at, texel) in seen.values[..64 * 48].iter().enumerate() {
            let offsets = [at as f64 % 64.0 - 40.0, (at / 64) as f64 - 20.0];
            let inside = offsets.iter().all(|offset| offset.abs() <= reach);
            let wanted =
                if inside { offsets.map(|offset| weight(offset) / whole).iter().product() } else { 0.0 };
            assert!((f64::from(texel[0]) - wanted).abs() < 1e-6, "radius {radius} at {offsets:?}: {texel:?}");
        }
    }
}

#[test]
fn a_blurred_constant_stays_constant_to_the_last_texel() {
    let Some(gpu) = gpu::device() else { return };
    for (texel, format, constant, bound) in [
        ("r32float", "r32float", 0.7_f64, 1e-6_f64),
        ("rg32float", "rg32float", 0.7, 1e-6),
        // The square of the largest warped depth, and the smallest.
        ("rgba32float", "rgba32float", 3.0e36, 1e-6),
        ("rgba32float", "rgba32float", 4.0e-37, 1e-6),
        // Drivers may round 16 bits down, each time that they write them.
        ("rgba16float", "rgba16float", 64860.0, 2e-3),
        ("packed_2x16float", "r32uint", 64860.0, 2e-3),
        ("packed_4x16unorm", "rg32uint", 1.0, 1.0 / 32768.0),
        ("rgba8unorm", "rgba8unorm", 1.0, 1e-6),
    ] {
        for radius in [0.0, 64.0] {
            for in_tiles in [false, true] {
                let seen = blurred(&gpu, [texel, format], radius, constant, in_tiles);
                // The third image is constant in each of its tiles.
                let layers = if in_tiles { 3 } else { 2 };
                for (at, value) in seen.values[64 * 48..64 * 48 * layers].iter().enumerate() {
                    let is_less = at >= 64 * 48 && at % 64 >= 32;
                    let wanted = if is_less { constant * 0.25 } else { constant };
                    let error = (f64::from(value[0]) - wanted).abs() / wanted;
                    let bound = if is_less {
                        bound.max(1e-2 * f64::from(u8::from(texel == "rgba8unorm")))
                    } else {
                        bound
                    };
                    assert!(error <= bound, "{texel}, radius {radius}, texel {at}: {value:?} of {wanted}");
                }
            }
        }
    }
}

#[test]
fn each_mip_level_is_the_mean_of_the_level_above_it() {
    let Some(gpu) = gpu::device() else { return };
    // The sides of the first level, one of which is odd from the second level on, and one a single texel at last.
    for (size, formats) in [([50_u32, 37_u32], 0..5), ([64, 2], 0..1)] {
        for (texel, format, bound) in [
            ("rgba32float", "rgba32float", 1e-6),
            ("rg32float", "rg32float", 1e-6),
            ("rgba16float", "rgba16float", 2e-3),
            ("packed_2x16float", "r32uint", 2e-3),
            ("packed_4x16unorm", "rg32uint", 4.0 / 65535.0),
        ][formats]
            .iter()
            .copied()
        {
            let level = |level: u32| {
                let [width, height] = size.map(|side| (side >> level).max(1));
                let image = format!(
                    r#", "image": {{ "texture": {{ "format": "{format}", "size": {size:?}, "layers": 2, "mips": 5, "view_dimension": "2d-array" }} }}"#
                );
                let passes = format!(
                    r#""paint": {{ "compute": {{ "shader": "noise.wgsl.jinja", "dispatch_over": "&image", "axes": {{ "texel_format": "{texel}" }},
                        "bind": {{ "image": {{ "texture": {{ "name": "&image", "mip": 0 }} }} }} }} }},
                    "mips": {{ "use": "pipelines/parts/mips.json",
                        "with": {{ "image": "&image", "levels": 5, "texel_format": "{texel}" }} }},
                    "unpack": {{ "compute": {{ "shader": "unpack.wgsl.jinja", "dispatch_over": "&plain", "axes": {{ "texel_format": "{texel}" }},
                        "bind": {{ "image": {{ "texture": {{ "name": "&image", "mip": {level} }} }}, "plain": "&plain" }} }} }}"#
                );
                (width, height, run(&gpu, [width, height, 2], &image, &passes).values)
            };
            let mut above = level(0);
            assert!(above.2.iter().any(|value| value[0] > 0.9) && above.2.iter().any(|value| value[0] < 0.1));
            for index in 1..5 {
                let (width, height, values) = level(index);
                for (at, value) in values.iter().enumerate() {
                    let (x, y) = (at as u32 % width, at as u32 / width % height);
                    let layer = at as u32 / (width * height);
                    let of_four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| {
                        let (x, y) = ((2 * x + right).min(above.0 - 1), (2 * y + down).min(above.1 - 1));
                        above.2[((layer * above.1 + y) * above.0 + x) as usize]
                    });
                    for (channel, value) in value.iter().enumerate() {
                        let wanted = of_four.iter().map(|one| f64::from(one[channel])).sum::<f64>() / 4.0;
                        let error = (f64::from(*value) - wanted).abs();
                        assert!(
                            error <= bound,
                            "{texel} {size:?}, level {index}, {x} {y}: {value} of {wanted}"
                        );
                    }
                }
                above = (width, height, values);
            }
        }
    }
}
