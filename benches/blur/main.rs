//! The Gaussian blur of `pipelines/parts/blur.json`, and the same with workgroup memory: a group of 128 texels along
//! the direction loads what its taps meet first (`shared.wgsl.jinja`). The library has the form that is faster.
//!
//! A texture of 1024 by 1024, along rows and then along columns, for formats of moments and radii: the time from
//! submission to its end, the minimum of several frames in turns. Lines `ratio blur/FORMAT/RADIUS VALUE` are the form
//! with workgroup memory divided by the other. Both are held to give the same texels within 1e-6 of their largest.
//!
//! `cargo bench --bench blur`

#[path = "../../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::gpu::{empty_frame, executor};
use common::{With, check_with};
use umbragraph::executor::read_back;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::{self, Gpu};

const SIDE: u32 = 1024;
const FORMATS: [(&str, &str); 4] = [
    ("rgba16float", "rgba16float"),
    ("rgba32float", "rgba32float"),
    ("rg32float", "rg32float"),
    ("packed_4x16unorm", "rg32uint"),
];

const SHARED: (&str, &str) = ("gaussian_blur.wgsl.jinja", include_str!("shared.wgsl.jinja"));

/// A template that fills a texture with a value that differs from texel to texel.
const PAINT: [(&str, &str); 2] = [
    (
        "paint.wgsl.jinja",
        r#"{% include "lib/texels.wgsl.jinja" %}
        @group(1) @binding(0) var image: texture_storage_2d_array<{{ texel_storage }}, write>;
        @compute @workgroup_size(16, 16) fn paint(@builtin(global_invocation_id) id: vec3<u32>) {
            let number = f32((id.x * 7919u + id.y * 104729u) % 1009u) / 1009.0;
            textureStore(image, id.xy, 0, pack_texel(vec4<f32>(number, 1.0 - number, number * number, 0.5)));
        }"#,
    ),
    ("paint.axes.json", r#"{ "inherits": ["lib/texels.wgsl.jinja"], "axes": {} }"#),
];

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("milliseconds on {} at {SIDE} by {SIDE}", gpu.name);
    println!("{:18} {:>6} {:>9} {:>9}", "format", "radius", "plain", "shared");
    for format in FORMATS {
        for radius in [2, 6, 20] {
            let mut forms = [false, true].map(|is_shared| Form::new(&gpu, format, radius, is_shared));
            let mut min = [f64::INFINITY; 2];
            for _ in 0..gpu.frames() {
                for (form, min) in forms.iter_mut().zip(&mut min) {
                    *min = min.min(form.frame(&gpu));
                }
            }
            let [plain, shared] = min;
            println!("{:18} {radius:6} {plain:9.3} {shared:9.3}", format.0);
            println!("ratio blur/{}/{radius} {:.2}", format.0, shared / plain);
            if format.0 == format.1 {
                same(&gpu, &forms.map(|form| form.result));
            }
        }
    }
}

/// One implementation of the blur, with its result texture.
struct Form {
    executor: Executor,
    result: wgpu::Texture,
}

impl Form {
    fn new(gpu: &Gpu, (texel, format): (&str, &str), radius: u32, is_shared: bool) -> Self {
        let texture =
            format!(r#""format": "{format}", "size": [{SIDE}, {SIDE}], "view_dimension": "2d-array""#);
        let text = format!(
            r#"{{ "format": 1, "name": "blurs", "resources": {{
                "image": {{ "texture": {{ {texture} }} }},
                "soft": {{ "texture": {{ {texture}, "lifetime": "imported" }} }}
            }}, "passes": {{
                "paint": {{ "compute": {{
                    "shader": "paint.wgsl.jinja", "axes": {{ "texel_format": "{texel}" }}, "dispatch_over": "&image", "bind": {{ "image": "&image" }} }} }},
                "soften": {{ "use": "pipelines/parts/blur.json", "with": {{
                    "image": "&image", "result": "&soft", "radius": {radius}, "texel_format": "{texel}" }} }}
            }} }}"#
        );
        let mut templates = PAINT.to_vec();
        templates.extend(is_shared.then_some(SHARED));
        let outcome = check_with("blurs.json", &text, &With { templates: &templates, ..With::default() });
        let result = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: outcome.plan().resources["soft"].format.expect("a texture"),
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self { executor: executor(gpu, outcome.plan(), None), result }
    }

    /// Renders a frame and returns the time from submission to completion, in milliseconds.
    fn frame(&mut self, gpu: &Gpu) -> f64 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = &[("soft", &self.result)];
        self.executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(imports)).expect("a record");
        let start = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        start.elapsed().as_secs_f64() * 1e3
    }
}

/// Asserts that two textures are equal within 1e-6, or within 1e-3 for 16-bit floats.
fn same(gpu: &Gpu, textures: &[wgpu::Texture; 2]) {
    let [plain, shared] = textures
        .each_ref()
        .map(|one| pollster::block_on(read_back(&gpu.device, &gpu.queue, one)).expect("texels"));
    let bound = if textures[0].format() == wgpu::TextureFormat::Rgba16Float { 1e-3 } else { 1e-6 };
    let pairs = plain.values.iter().flatten().zip(shared.values.iter().flatten());
    let worst = pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max);
    assert!(worst <= bound, "texels differ by {worst}");
}
