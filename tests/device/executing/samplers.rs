//! Samplers: filters, addresses, and levels of detail.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::common::{With, check_with, gpu as common_gpu};
use crate::executing::stage::{color, show};
use crate::executing::views::frame;

/// Red at the left, green at the top, and as much blue as is said.
const QUARTERS: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { blue: f32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(step(covered.uv, vec2<f32>(0.5)), settings.blue, 1.0);
}
"#;

/// A shader that samples at a place of a level, or at a slant.
const SEEN: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { place: vec3<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@group(1) @binding(1) var quarters: texture_2d<f32>;
@group(1) @binding(2) var quarters_sampler: sampler;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    if settings.place.z < 0.0 {
        return textureSampleGrad(quarters, quarters_sampler, settings.place.xy, vec2<f32>(0.25, 0.0), vec2<f32>(0.0));
    }
    return textureSampleLevel(quarters, quarters_sampler, settings.place.xy, settings.place.z);
}
"#;

#[test]
fn each_setting_of_a_sampler_is_the_one_that_is_written() {
    let Some(gpu) = gpu::device() else { return };
    let cases = [
        // Texels are mixed or not, whether a texture is seen enlarged or made smaller, and so are levels.
        (r#""filter": "linear""#, "[0.5, 0.25, 0]", [128, 255, 0]),
        (r#""filter": "nearest""#, "[0.49, 0.25, 0]", [255, 255, 0]),
        (r#""filter": "linear""#, "[0.25, 0.5, 1]", [255, 128, 102]),
        (r#""filter": "nearest""#, "[0.25, 0.49, 1]", [255, 255, 102]),
        (r#""filter": "linear""#, "[0.25, 0.25, 0.5]", [255, 255, 51]),
        (r#""filter": "nearest""#, "[0.25, 0.25, 0.4]", [255, 255, 0]),
        // Beyond the right edge and the lower one.
        ("", "[1.25, 0.25, 0]", [0, 255, 0]),
        (r#""address": "repeat""#, "[1.25, 0.75, 0]", [255, 0, 0]),
        (r#""address": "mirror-repeat""#, "[1.75, 0.75, 0]", [255, 0, 0]),
        ("", "[0.25, 1.25, 0]", [255, 0, 0]),
        (r#""address": "repeat""#, "[0.75, 1.25, 0]", [0, 255, 0]),
        (r#""address": "mirror-repeat""#, "[0.75, 1.75, 0]", [0, 255, 0]),
        // Levels that are there, and those that are left out.
        ("", "[0.25, 0.25, 2]", [255, 255, 204]),
        (r#""lod_min_clamp": 1"#, "[0.25, 0.25, 0]", [255, 255, 102]),
        (r#""lod_min_clamp": 0.5"#, "[0.25, 0.25, 0]", [255, 255, 51]),
        (r#""lod_max_clamp": 1"#, "[0.25, 0.25, 2]", [255, 255, 102]),
        // At a slant the coarsest level, or several samples of the finest.
        ("", "[0.25, 0.25, -1]", [255, 255, 204]),
        (r#""max_anisotropy": 16"#, "[0.25, 0.25, -1]", [255, 255, 0]),
    ];
    let flags = gpu.adapter.get_downlevel_capabilities().flags;
    for (sampler, place, wanted) in cases {
        if sampler.contains("anisotropy") && !flags.contains(wgpu::DownlevelFlags::ANISOTROPIC_FILTERING) {
            continue;
        }
        let level = |mip: u32, blue: f64| {
            format!(
                r#""level_{mip}": {{ "fullscreen": {{ "shader": "quarters.wgsl.jinja",
                    "bind": {{ "settings": {{ "values": {{ "blue": {blue} }} }} }},
                    "color": [{{ "to": "&quarters", "mip": {mip} }}] }} }}"#
            )
        };
        let text = format!(
            r#"{{ "format": 1, "name": "samplers", "resources": {{
                "quarters": {{ "texture": {{ "format": "rgba8unorm", "size": [16, 16], "mips": 3 }} }},
                "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
              "passes": {{ {}, {}, {},
                "show": {{ "fullscreen": {{ "shader": "seen.wgsl.jinja", "bind": {{
                    "settings": {{ "values": {{ "place": {place} }} }}, "quarters": "&quarters",
                    "quarters_sampler": {{ "sampler": {{ {sampler} }} }} }},
                  "color": [{{ "to": "&target" }}] }} }} }} }}"#,
            level(0, 0.0),
            level(1, 0.4),
            level(2, 0.8)
        );
        let templates = [("quarters.wgsl.jinja", QUARTERS), ("seen.wgsl.jinja", SEEN)];
        let with = With { templates: &templates, size: Some([2, 2]), ..With::default() };
        let outcome = check_with("samplers.json", &text, &with);
        let mut executor = common_gpu::executor(&gpu, outcome.plan(), None);
        let target = import(&gpu, outcome.plan(), "target");
        show(&gpu, &mut executor, None, &target, &frame(&[]));
        let [red, green, blue, _] = color(&gpu, &target, 0);
        let is_near = |(found, wanted): (u8, u8)| found.abs_diff(wanted) <= 2;
        let seen = [red, green, blue];
        assert!(seen.into_iter().zip(wanted).all(is_near), "{sampler} at {place}: {seen:?}, not {wanted:?}");
    }
}
