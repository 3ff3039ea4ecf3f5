//! The reflection of surfaces: the shading library on the device against numbers of 64 bits, and the laws that it
//! keeps.
//!
//! [`Oracle`] has the formulas of the papers: GGX, height-correlated shadowing, Fresnel by Schlick. Its directional
//! albedos are integrals, those of the library polynomials. Directions and materials are drawn at random, with a fixed
//! seed.

use crate::common::gpu::{empty_frame, executor, import};
use crate::common::{With, check_with};
use glam::DVec3;
use std::f64::consts::PI;
use umbragraph::Frame;
use umbragraph::executor::{Texels, read_back};
use umbragraph_test_support::gpu;

/// Draws materials and directions from the texel's place, and writes what is reflected.
const REFLECT: &str = r#"{% include "lib/brdf.wgsl.jinja" %}
@group(1) @binding(0) var plain: texture_storage_2d_array<rgba32float, write>;

// PCG (M. O'Neill, 2014), as a part of 1.
fn noise(seed: u32) -> f32 {
    let state = seed * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

fn direction(seed: u32) -> vec3<f32> {
    let z = noise(seed) * 0.98 + 0.015;
    let angle = noise(seed + 1u) * 6.2831853;
    return vec3<f32>(sqrt(1.0 - z * z) * vec2<f32>(cos(angle), sin(angle)), z);
}

@compute @workgroup_size(16, 8) fn reflect_all(@builtin(global_invocation_id) id: vec3<u32>) {
    let seed = (id.y * 128u + id.x) * 16u;
    let roughness = 0.05 + 0.95 * noise(seed);
    let metallic = floor(noise(seed + 1u) * 3.0) * 0.5;
    let f0 = 0.02 + 0.1 * noise(seed + 2u);
    let color = noise(seed + 3u);
    let view = direction(seed + 4u);
    let light = direction(seed + 6u);
    let normal = vec3<f32>(0.0, 0.0, 1.0);
    let reflection = Reflection(metallic, roughness, 1.0, vec3<f32>(f0), 1.0);
    let brdf = brdf_of(vec3<f32>(color), reflection, view.z);
    let lobe = lobe_part(brdf, normal, view, light).r;
    let base = brdf.diffuse_color.r * base_part(brdf, light.z) * light.z / 3.14159265;
    textureStore(plain, id.xy, 0, vec4<f32>(roughness, metallic, f0, color));
    textureStore(plain, id.xy, 1, vec4<f32>(view, lobe));
    textureStore(plain, id.xy, 2, vec4<f32>(light, base));
    let albedo = directional_albedo(brdf.n_dot_v, brdf.alpha, brdf.lost, brdf.grazing);
    textureStore(plain, id.xy, 3, vec4<f32>(albedo, brdf.base_albedo, brdf.base_coupling));
    // The same light the other way, under the other cosine.
    let back = brdf_of(vec3<f32>(color), reflection, light.z);
    let turned = back.diffuse_color.r * base_part(back, view.z) * light.z / 3.14159265;
    textureStore(plain, id.xy, 4, vec4<f32>(0.0, 0.0, 0.0, turned));
}
"#;

const TEMPLATES: [(&str, &str); 2] = [
    ("reflect.wgsl.jinja", REFLECT),
    ("reflect.axes.json", r#"{ "inherits": ["lib/brdf.wgsl.jinja"], "axes": {} }"#),
];

fn reflected() -> Option<Texels> {
    let gpu = gpu::device()?;
    let texture = r#""format": "rgba32float", "size": [128, 80], "layers": 5, "view_dimension": "2d-array""#;
    let text = format!(
        r#"{{ "format": 1, "name": "oracle", "resources": {{
            "plain": {{ "texture": {{ {texture} }} }},
            "seen": {{ "texture": {{ {texture}, "lifetime": "imported" }} }} }},
          "passes": {{
            "reflect": {{ "compute": {{
                "shader": "reflect.wgsl.jinja", "axes": {{ "pbr": true }}, "workgroups": [8, 10, 1], "bind": {{ "plain": "&plain" }} }} }},
            "show": {{ "copy": {{
                "from": {{ "name": "&plain", "layers": 5 }}, "to": {{ "name": "&seen", "layers": 5 }} }} }} }} }}"#
    );
    let outcome = check_with("oracle.json", &text, &With { templates: &TEMPLATES, ..With::default() });
    let plan = outcome.plan();
    let seen = import(&gpu, plan, "seen");
    let mut executor = executor(&gpu, plan, None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(&[("seen", &seen)])).expect("a record");
    gpu.queue.submit([encoder.finish()]);
    Some(pollster::block_on(read_back(&gpu.device, &gpu.queue, &seen)).expect("texels"))
}

/// The formulas for one roughness.
struct Oracle {
    alpha: f64,
}

impl Oracle {
    fn new(roughness: f64) -> Self {
        Self { alpha: roughness * roughness }
    }

    /// Distribution times shadowing over 4 cosines, without Fresnel; directions about +Z.
    fn lobe(&self, view: DVec3, light: DVec3) -> f64 {
        let square = self.alpha * self.alpha;
        let halfway = (view + light).normalize();
        let distribution = square / (PI * (halfway.z * halfway.z * (square - 1.0) + 1.0).powi(2));
        let lambda = |cosine: f64| ((1.0 + square * (1.0 / (cosine * cosine) - 1.0)).sqrt() - 1.0) / 2.0;
        distribution / (1.0 + lambda(view.z) + lambda(light.z)) / (4.0 * view.z * light.z)
    }

    /// The directional albedo of the lobe as factors of the reflectances at normal and at grazing incidence: an
    /// integral over visible normals, which `steps` squared samples of equal weight stand for (E. Heitz, 2018).
    fn albedo(&self, cosine: f64, steps: u32) -> [f64; 2] {
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let stretched = DVec3::new(self.alpha * view.x, 0.0, view.z).normalize();
        let square = self.alpha * self.alpha;
        let lambda = |cosine: f64| ((1.0 + square * (1.0 / (cosine * cosine) - 1.0)).sqrt() - 1.0) / 2.0;
        let (mut normal, mut grazing) = (0.0, 0.0);
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let part = |at: u32| (f64::from(at) + 0.5) / f64::from(steps);
            let angle = 2.0 * PI * part(i);
            let z = (1.0 - part(j)) * (1.0 + stretched.z) - stretched.z;
            let across = (1.0 - z * z).max(0.0).sqrt();
            let cap = DVec3::new(across * angle.cos(), across * angle.sin(), z) + stretched;
            let halfway = DVec3::new(self.alpha * cap.x, self.alpha * cap.y, cap.z.max(0.0)).normalize();
            let toward = halfway.dot(view).clamp(0.0, 1.0);
            let light = halfway * (2.0 * toward) - view;
            if light.z > 0.0 {
                let weight = (1.0 + lambda(view.z)) / (1.0 + lambda(view.z) + lambda(light.z));
                let edge = (1.0 - toward).powi(5);
                normal += weight * (1.0 - edge);
                grazing += weight * edge;
            }
        }
        [normal, grazing].map(|sum| sum / f64::from(steps * steps))
    }

    /// The mean of the albedo over all cosines.
    fn mean_albedo(&self, steps: u32) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for at in 0..16 {
            let square = (f64::from(at) + 0.5) / 16.0;
            let [normal, grazing] = self.albedo(square.sqrt(), steps);
            sum = [sum[0] + normal / 16.0, sum[1] + grazing / 16.0];
        }
        sum
    }
}

#[test]
fn the_device_reflects_as_the_formulas_say() {
    let Some(texels) = reflected() else { return };
    let count = 128 * 80;
    let layer = |layer: usize, at: usize| texels.values[layer * count + at].map(|part| part as f64);
    let (mut lobes, mut bases) = (0.0_f64, 0.0_f64);
    for at in 0..count {
        let [roughness, metallic, f0, color] = layer(0, at);
        let [x, y, z, lobe] = layer(1, at);
        let view = DVec3::new(x, y, z).normalize();
        let [x, y, z, base] = layer(2, at);
        let light = DVec3::new(x, y, z).normalize();
        let oracle = Oracle::new(roughness);
        let steps = if at % 16 == 0 { 48 } else { 20 };
        let [normal, grazing] = oracle.albedo(view.z, steps);
        let reflectance = f0 + (color - f0) * metallic;
        let edge = (1.0 - view.dot((view + light).normalize())).powi(5);
        let fresnel = reflectance + (1.0 - reflectance) * edge;
        let compensation = 1.0 + reflectance * (1.0 / (normal + grazing) - 1.0);
        let wanted = oracle.lobe(view, light) * fresnel * compensation * light.z;
        assert!(lobe.is_finite() && base.is_finite());
        // The polynomials come in by the compensation; digits are lost where a highlight is narrow.
        lobes = lobes.max((lobe - wanted).abs() / (wanted + 1e-3));
        if at % 16 == 0 {
            let left = |[normal, grazing]: [f64; 2]| 1.0 - f0 * normal - grazing;
            let coupling =
                left([normal, grazing]) * left(oracle.albedo(light.z, steps)) / left(oracle.mean_albedo(24));
            let wanted = color * (1.0 - metallic) * coupling * light.z / PI;
            bases = bases.max((base - wanted).abs() / (wanted + 1e-2));
        }
    }
    assert!(lobes < 0.02, "the lobe is off by {lobes}");
    assert!(bases < 0.03, "the base is off by {bases}");
}

#[test]
fn white_surfaces_stay_white_in_white_light() {
    let Some(texels) = reflected() else { return };
    let count = 128 * 80;
    let layer = |layer: usize, at: usize| texels.values[layer * count + at].map(|part| part as f64);
    let (mut mirrors, mut dielectrics) = (0.0_f64, 0.0_f64);
    for at in (0..count).step_by(40) {
        let [roughness, _, f0, _] = layer(0, at);
        let cosine = layer(1, at)[2];
        let [normal, grazing, left, coupling] = layer(3, at);
        let oracle = Oracle::new(roughness);
        let (exact, mean) = (oracle.albedo(cosine, 64), oracle.mean_albedo(24));
        // A mirror that reflects all: what the lobe reflects once, times the library's factor for what is passed on.
        let factor = 1.0 / (normal + grazing);
        mirrors = mirrors.max(((exact[0] + exact[1]) * factor - 1.0).abs());
        // A white dielectric: its lobe, and its base under light from all sides.
        let lobe = (f0 * exact[0] + exact[1]) * (1.0 + f0 * (factor - 1.0));
        let metallic = layer(0, at)[1];
        if metallic == 0.0 {
            let base = coupling * (1.0 - f0 * mean[0] - mean[1]);
            assert!((base - left).abs() < 0.01, "{base} of {left}, roughness {roughness}");
            dielectrics = dielectrics.max((lobe + base - 1.0).abs());
        }
    }
    assert!(mirrors < 0.01, "a mirror is off by {mirrors}");
    assert!(dielectrics < 0.012, "a dielectric is off by {dielectrics}");
}

#[test]
fn light_may_run_either_way() {
    let Some(texels) = reflected() else { return };
    let count = 128 * 80;
    let layer = |layer: usize, at: usize| texels.values[layer * count + at].map(|part| part as f64);
    for at in 0..count {
        let [_, metallic, _, color] = layer(0, at);
        let [.., base] = layer(2, at);
        let [.., turned] = layer(4, at);
        let size = color * (1.0 - metallic) + 1e-3;
        assert!((base - turned).abs() < 0.002 * size, "{base} and {turned}");
    }
}
