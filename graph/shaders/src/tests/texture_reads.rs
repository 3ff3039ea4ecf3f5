//! Counts of the texture reads of entry points.

use super::Fixture;
use crate::texture_reads;

const AXES: &str = r#"{ "axes": {
  "side": { "type": "integer", "min": 1, "max": 9, "default": 3, "as": "override" },
  "rounds": { "type": "integer", "min": 1, "max": 9, "default": 2 }
} }"#;

const MAIN: &str = "override side: u32 = 3;
@group(0) @binding(0) var map: texture_depth_2d;
@group(0) @binding(1) var compare: sampler_comparison;
@group(0) @binding(2) var<uniform> lights: u32;
fn taps(at: vec2<f32>) -> f32 {
    var sum = 0.0;
    for (var tap = 0u; tap < side * side; tap++) {
        sum += textureSampleCompareLevel(map, compare, at, 0.5);
    }
    return sum;
}
@fragment fn shade(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    var sum = 0.0;
    for (var light = 0u; light < lights; light++) {
        for (var round = 0; round < {{ rounds }}; round++) { sum += taps(at.xy); }
    }
    if sum > 1.0 { sum += textureLoad(map, vec2<i32>(), 0); } else { sum += taps(at.yx) + taps(at.xy); }
    return vec4<f32>(sum);
}
@fragment fn plain() -> @location(0) vec4<f32> { return vec4<f32>(); }
";

#[test]
fn constant_loops_multiply_reads_and_longer_branches_count() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", MAIN), ("main.axes.json", AXES)]);
    let usual = fixture.compile("main.wgsl.jinja", &[]);
    assert_eq!(texture_reads(&usual, "shade"), 2 * 9 + 2 * 9);
    assert_eq!(texture_reads(&usual, "plain"), 0);
    assert_eq!(texture_reads(&usual, "absent"), 0);
    let wide = fixture.compile("main.wgsl.jinja", &[("side", 5.into()), ("rounds", 4.into())]);
    assert_eq!(texture_reads(&wide, "shade"), 4 * 25 + 2 * 25);
}
