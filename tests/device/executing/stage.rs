//! Pipelines over squares and views, and what comes out of them.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostics, render};
use umbragraph::draw::DrawSource;
use umbragraph::executor::read_bytes;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::pipeline::Overrides;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::Gpu;

use crate::executing::squares::{DEPTH_TEMPLATE, GEOMETRY, Squares, TEMPLATE};
use crate::executing::state::Count;
use crate::executing::views::Views;

const FILL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return settings.color; }
"#;

const CLOCK: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Views { time: f32 }
@group(0) @binding(0) var<uniform> views: Views;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(views.time, 0.0, 0.0, 1.0); }
"#;

/// One layer of a depth array as grey.
const SHOW_DEPTH: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { layer: u32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@group(1) @binding(1) var maps: texture_depth_2d_array;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    let depth = textureLoad(maps, vec2<i32>(covered.position.xy), i32(settings.layer), 0);
    return vec4<f32>(depth, depth, depth, 1.0);
}
"#;

/// A texture, texel by texel.
const SHOW: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var picture: texture_2d<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return textureLoad(picture, vec2<i32>(covered.position.xy), 0);
}
"#;

/// The sum of two textures, texel by texel.
const ADD: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var one: texture_2d<f32>;
@group(1) @binding(1) var other: texture_2d<f32>;
@fragment fn add(covered: Covered) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(covered.position.xy);
    return vec4<f32>((textureLoad(one, texel, 0) + textureLoad(other, texel, 0)).rgb, 1.0);
}
"#;

/// The color that all three mips and both layers of a texture have, or nothing if they differ.
const SUM_OF_ALL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var pictures: texture_2d_array<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    let first = textureLoad(pictures, vec2<i32>(0, 0), 0, 0);
    var same = true;
    for (var mip = 0; mip < 3; mip += 1) {
        for (var layer = 0; layer < 2; layer += 1) {
            same = same && all(textureLoad(pictures, vec2<i32>(1, 1), layer, mip) == first);
        }
    }
    return select(vec4<f32>(0.0), first, same);
}
"#;

/// The numbers of layers and of mips that it sees, as 255ths of red and green.
const EXTENT: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var pictures: texture_2d_array<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    let extent = vec2<f32>(vec2<u32>(textureNumLayers(pictures), textureNumLevels(pictures)));
    return vec4<f32>(extent / 255.0, 0.0, 1.0);
}
"#;

/// Stencil as 255ths of red.
const SHOW_STENCIL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var marks: texture_2d<u32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(f32(textureLoad(marks, vec2<i32>(covered.position.xy), 0).r) / 255.0, 0.0, 0.0, 1.0);
}
"#;

/// Words of buffers as 255ths of red and green.
const WORDS: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var<storage, read> words: array<u32>;
@group(1) @binding(1) var<storage, read> zeros: array<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(f32(words[15]) / 255.0, zeros[15], 0.0, 1.0);
}
"#;

/// Says that three by two groups of workgroups are to run.
const COUNTS: &str = r#"@group(1) @binding(0) var<storage, read_write> words: array<u32>;
@compute @workgroup_size(1) fn say() { words[0] = 3u; words[1] = 2u; words[2] = 1u; }
"#;

/// Adds the number of words that it sees to a list, which begins with the length of the list.
const LENGTH: &str = r#"@group(1) @binding(0) var<storage, read> words: array<u32>;
@group(1) @binding(1) var<storage, read_write> lengths: array<u32>;
@compute @workgroup_size(1) fn tell() {
    lengths[0] += 1u;
    lengths[lengths[0]] = arrayLength(&words);
}
"#;

/// Makes the left half of an image green.
const HALF: &str = r#"@group(1) @binding(0) var image: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(4, 8) fn half(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(image, at.xy, vec4<f32>(0.0, 1.0, 0.0, 1.0));
}
"#;

/// The same in each layer.
const HALVES: &str = r#"@group(1) @binding(0) var image: texture_storage_2d_array<rgba8unorm, write>;
@compute @workgroup_size(4, 8) fn half(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(image, at.xy, at.z, vec4<f32>(0.0, 1.0, 0.0, 1.0));
}
"#;

/// Fills the left half, and leaves the right one.
const LEFT: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> {
    if covered.position.x >= 4.0 { discard; }
    return settings.color;
}
"#;

/// Fills the left half: the samples of the right one are masked.
const MASKED: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
struct Masked { @location(0) color: vec4<f32>, @builtin(sample_mask) mask: u32 }
@fragment fn fill(covered: Covered) -> Masked {
    return Masked(settings.color, select(0u, 1u, covered.position.x < 4.0));
}
"#;

/// Fills what the triangle of an expression for its corners covers.
const TRIANGLE: &str = r#"struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let uv = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return CORNER;
}
@fragment fn fill() -> @location(0) vec4<f32> { return settings.color; }
"#;

/// Fills, with a second color by which what is there is multiplied.
const TWO_SOURCES: &str = r#"enable dual_source_blending;
{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
struct Two { @location(0) @blend_src(0) color: vec4<f32>, @location(0) @blend_src(1) factor: vec4<f32> }
@fragment fn fill(covered: Covered) -> Two { return Two(settings.color, vec4<f32>(1.0, 0.5, 0.0, 0.25)); }
"#;

/// Adds a number to each word.
const BUMP: &str = r#"struct Settings { number: u32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@group(1) @binding(1) var<storage, read_write> words: array<u32>;
@compute @workgroup_size(1) fn bump() {
    for (var at = 0u; at < arrayLength(&words); at += 1u) { words[at] += settings.number; }
}
"#;

/// The last word as 255ths of red.
const WORD: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var<storage, read> words: array<u32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(f32(words[arrayLength(&words) - 1u]) / 255.0, 0.0, 0.0, 1.0);
}
"#;

/// A texture as large as the picture or half as large.
const ENLARGE: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(1) @binding(0) var picture: texture_2d<f32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(covered.uv * vec2<f32>(textureDimensions(picture)));
    return textureLoad(picture, texel, 0);
}
"#;

/// Counts its invocations.
const COUNT: &str = r#"struct Sum { value: atomic<u32> }
@group(1) @binding(0) var<storage, read_write> sum: Sum;
@compute @workgroup_size(4) fn count() { atomicAdd(&sum.value, 1u); }
"#;

/// Sums what its invocations say, in memory that a workgroup shares.
const SHARED: &str = r#"@group(1) @binding(0) var<storage, read_write> sums: array<u32>;
var<workgroup> shares: array<u32, 128>;
@compute @workgroup_size(16, 4, 2) fn sum(
    @builtin(local_invocation_index) own: u32, @builtin(workgroup_id) group: vec3<u32>
) {
    shares[own] = own;
    workgroupBarrier();
    if own == 0u { sums[group.x] = shares[1] + shares[127]; }
}
"#;

/// The edge of the picture, in texels.
pub(crate) const SIDE: u32 = 8;

/// A plan over the resources and passes of a text.
#[track_caller]
pub(crate) fn plan(resources: &str, passes: &str) -> Arc<Plan> {
    plan_of_size(resources, passes, SIDE)
}

/// A plan over the resources and passes of a text, for a picture of so many texels.
#[track_caller]
pub(crate) fn plan_of_size(resources: &str, passes: &str, side: u32) -> Arc<Plan> {
    let text = format!(
        r#"{{ "format": 1, "name": "test", {GEOMETRY}, "resources": {{ {resources} }}, "passes": {{ {passes} }} }}"#
    );
    plan_of_text(text, side)
}

/// A plan of a whole text.
#[track_caller]
pub(crate) fn plan_of_text(text: String, side: u32) -> Arc<Plan> {
    try_plan_of_text(text, side).unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

/// A plan of a whole text, or what is wrong with it.
pub(crate) fn try_plan_of_text(text: String, side: u32) -> Result<Arc<Plan>, String> {
    try_plan_with(text, side, wgpu::Features::empty())
}

/// The same for a device with optional features.
pub(crate) fn try_plan_with(text: String, side: u32, features: wgpu::Features) -> Result<Arc<Plan>, String> {
    // Squares that lie as many steps of depth farther away as the first word says.
    let sunk = DEPTH_TEMPLATE.replace("object.depth", "object.depth + f32(words[0]) / 85.0");
    let sunk = format!("{sunk}@group(1) @binding(0) var<storage, read> words: array<u32>;\n");
    // Squares in two colors.
    let paint = "@location(0) vec4<f32> { return object.color * material.tint; }";
    let twice = "Twice { let color = object.color * material.tint; return Twice(color, color); }";
    let twice = TEMPLATE.replace(paint, twice)
        + "struct Twice { @location(0) first: vec4<f32>, @location(1) second: vec4<f32> }\n";
    let own = [
        ("square.wgsl.jinja", TEMPLATE),
        ("square_depth.wgsl.jinja", DEPTH_TEMPLATE),
        ("square_twice.wgsl.jinja", &twice),
        ("sunk_depth.wgsl.jinja", &sunk),
        ("fill.wgsl.jinja", FILL),
        ("clock.wgsl.jinja", CLOCK),
        ("show_depth.wgsl.jinja", SHOW_DEPTH),
        ("show.wgsl.jinja", SHOW),
        ("add.wgsl.jinja", ADD),
        ("sum_of_all.wgsl.jinja", SUM_OF_ALL),
        ("extent.wgsl.jinja", EXTENT),
        ("show_stencil.wgsl.jinja", SHOW_STENCIL),
        ("words.wgsl.jinja", WORDS),
        ("counts.wgsl.jinja", COUNTS),
        ("count.wgsl.jinja", COUNT),
        ("half.wgsl.jinja", HALF),
        ("halves.wgsl.jinja", HALVES),
        ("left.wgsl.jinja", LEFT),
        ("masked.wgsl.jinja", MASKED),
        ("two_sources.wgsl.jinja", TWO_SOURCES),
        ("bump.wgsl.jinja", BUMP),
        ("word.wgsl.jinja", WORD),
        ("enlarge.wgsl.jinja", ENLARGE),
        ("length.wgsl.jinja", LENGTH),
        ("shared.wgsl.jinja", SHARED),
    ];
    let triangle = |corner: &str| TRIANGLE.replace("CORNER", corner);
    // A triangle that covers everything, one whose right half is beyond the far plane, and one over the left half.
    let triangles = [
        ("own_triangle.wgsl.jinja", triangle("vec4<f32>(uv * 4.0 - 1.5, 0.5, 1.0)")),
        ("clipped.wgsl.jinja", triangle("vec4<f32>(uv * 2.0 - 1.0, uv.x * 2.0, 1.0)")),
        ("left_triangles.wgsl.jinja", triangle("vec4<f32>(uv.x - 1.0, uv.y * 200.0 - 199.0, 0.0, 1.0)")),
    ];
    let own: Vec<_> =
        own.into_iter().chain(triangles.iter().map(|(name, text)| (*name, text.as_str()))).collect();
    let (mut sources, mut diagnostics, templates) = crate::common::templates(&own);
    let mut registry = umbragraph::registry();
    registry.register::<Views>().register::<Count>();
    let file = sources.add("test.json", text);
    let options = umbragraph::low_level::CheckOptions {
        registry: &registry,
        templates: &templates,
        profile: &TargetProfile::webgpu().with_features(features),
        overrides: &Overrides::default(),
        plan: &PlanOptions::new(side, side),
    };
    let checked = umbragraph::low_level::check(file, &options, &sources, &mut diagnostics);
    match checked.plan {
        Some(plan) if !diagnostics.has_errors() => Ok(plan),
        _ => Err(render::human_all(&diagnostics, &sources)),
    }
}

/// An imported texture that passes write.
pub(crate) fn target(layers: u32) -> String {
    format!(
        r#""target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "layers": {layers}, "lifetime": "imported" }} }}"#
    )
}

/// A pass that publishes up to so many views, and one that draws the squares in them.
pub(crate) fn draw(max: u32, to: &str) -> String {
    format!(
        r#""views": {{ "views": {{ "to": "&views", "max": {max} }} }},
           "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views", "shader": "square.wgsl.jinja",
               "color": [{to}] }} }}"#
    )
}

/// A pass that fills a texture with one color.
pub(crate) fn fill(name: &str, to: &str, color: &str) -> String {
    format!(
        r#""{name}": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja",
            "bind": {{ "settings": {{ "values": {{ "color": {color} }} }} }}, "color": [{to}] }} }}"#
    )
}

/// An executor for a plan.
#[track_caller]
pub(crate) fn executor(gpu: &Gpu, plan: &Arc<Plan>, squares: Option<&Squares>) -> Executor {
    let source = squares.map(|squares| squares as &dyn DrawSource);
    let made = Executor::new(&gpu.device, &gpu.queue, plan.clone(), source);
    made.unwrap_or_else(|diagnostics| panic!("{diagnostics:#?}"))
}

/// Codes and messages of diagnostics.
pub(crate) fn said(diagnostics: &Diagnostics) -> Vec<(&'static str, String)> {
    diagnostics.iter().map(|diagnostic| (diagnostic.code.id, diagnostic.message.clone())).collect()
}

/// Records a frame and submits it, holding wgpu to silence about everything that was recorded.
#[track_caller]
pub(crate) fn play(
    gpu: &Gpu,
    executor: &mut Executor,
    squares: Option<&Squares>,
    target: &wgpu::Texture,
    input: &FrameInput,
) -> Result<(), umbragraph::Error> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let draws = squares.map(|squares| squares as &dyn DrawSource);
    let imports = [("target", target)];
    let mut frame = Frame::new(input).imports(&imports);
    frame.draws = draws;
    let result = executor.record(&mut encoder, &frame);
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    if let Some(error) = pollster::block_on(scope.pop()) {
        panic!("what was recorded is not valid: {error}");
    }
    result
}

/// The same, for a frame that is fine.
#[track_caller]
pub(crate) fn show(
    gpu: &Gpu,
    executor: &mut Executor,
    squares: Option<&Squares>,
    target: &wgpu::Texture,
    input: &FrameInput,
) {
    if let Err(diagnostics) = play(gpu, executor, squares, target, input) {
        panic!("{diagnostics:#?}");
    }
}

/// The texels of a layer of an rgba8 texture, row by row.
pub(crate) fn texels(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Vec<[u8; 4]> {
    let bytes = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, texture)).expect("bytes");
    let size = (texture.width() * texture.height()) as usize;
    bytes.as_chunks::<4>().0[layer as usize * size..][..size].to_vec()
}

/// The color of a layer that has only one.
#[track_caller]
pub(crate) fn color(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> [u8; 4] {
    let texels = texels(gpu, texture, layer);
    assert!(texels.iter().all(|texel| *texel == texels[0]), "{texels:?}");
    texels[0]
}

/// The color at a texel of layer 0.
pub(crate) fn at(gpu: &Gpu, texture: &wgpu::Texture, x: u32, y: u32) -> [u8; 4] {
    texels(gpu, texture, 0)[(y * texture.width() + x) as usize]
}
