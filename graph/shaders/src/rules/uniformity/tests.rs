//! Uniform and non-uniform code, one rule after the other; `tests/pictures/second_compiler.rs` compares the whole with
//! `tint`.

use super::found;

fn fragment(body: &str) -> String {
    format!(
        "struct Block {{ flag: u32, values: array<vec4<f32>, 4> }}
         @group(0) @binding(0) var<uniform> block: Block;
         @group(0) @binding(1) var image: texture_2d<f32>;
         @group(0) @binding(2) var plain: sampler;
         @group(0) @binding(3) var<storage, read> numbers: array<u32>;
         @group(0) @binding(4) var<storage, read_write> cells: array<u32>;
         override chosen: bool = true;
         fn shade(at: f32) -> f32 {{ return textureSample(image, plain, vec2<f32>(at)).x; }}
         fn fill(to: ptr<function, f32>, value: f32) {{ *to = value; }}
         fn early(at: f32) -> f32 {{ if at > 0.5 {{ return 1.0; }} return 0.0; }}
         @fragment fn main(@location(0) u: f32) -> @location(0) vec4<f32> {{
             var sum = 0.0;
             {body}
             return vec4<f32>(sum);
         }}"
    )
}

fn compute(body: &str) -> String {
    format!(
        "var<workgroup> together: u32;
         var<workgroup> several: array<u32, 4>;
         @compute @workgroup_size(64)
         fn main(@builtin(local_invocation_index) local: u32, @builtin(workgroup_id) group: vec3<u32>) {{ {body} }}"
    )
}

fn findings(text: &str) -> usize {
    found(&naga::front::wgsl::parse_str(text).expect("WGSL")).len()
}

#[test]
fn what_is_uniform_passes() {
    for body in [
        "sum = dpdx(u);",
        "if block.flag > 0u { sum = shade(u); }",
        "if numbers[2] > 0u && chosen { sum = dpdx(u); }",
        "if u > 0.5 { sum = 1.0; } sum += shade(u);",
        "if u > 0.5 { sum = textureSampleLevel(image, plain, vec2<f32>(u), 0.0).x; }",
        "if u > 0.5 { discard; } sum = dpdx(u);",
        "for (var i = 0u; i < block.flag; i++) { sum += shade(u); }",
        "for (var i = 0u; i < 4u; i++) { if u > 0.5 { sum += 1.0; } sum += dpdx(u); }",
        "switch block.flag { case 1u, 2u: { sum = dpdx(u); } default: {} }",
        "let x = early(u); sum = dpdx(x);",
        "var x = 0.0; fill(&x, block.values[0].x); if x > 0.5 { sum = dpdx(u); }",
        "switch 1u { default: { if u > 0.5 { break; } sum = 1.0; } } sum = dpdx(u);",
    ] {
        assert_eq!(findings(&fragment(body)), 0, "{body}");
    }
    for body in [
        "workgroupBarrier();",
        "if group.x > 2u { workgroupBarrier(); }",
        "if workgroupUniformLoad(&together) > 2u { workgroupBarrier(); }",
        "if local > 2u { several[local] = 1u; } workgroupBarrier();",
        "_ = workgroupUniformLoad(&several[group.x]);",
    ] {
        assert_eq!(findings(&compute(body)), 0, "{body}");
    }
}

#[test]
fn what_is_not_uniform_is_found() {
    for body in [
        "if u > 0.5 { sum = dpdx(u); }",
        "if u > 0.5 { sum = shade(u); }",
        "if cells[0] > 1u { sum = dpdx(u); }",
        "let yes = u > 0.5 && dpdx(u) > 0.1;",
        "if u > 0.5 { return vec4<f32>(); } sum = dpdx(u);",
        "loop { if u > sum { break; } sum += 1.0; sum += dpdx(u); }",
        "loop { sum += 1.0; if u > sum { continue; } sum += dpdx(u); if sum > 3.0 { break; } }",
        "loop { sum += 1.0; continuing { break if sum > u; } } if sum > 3.0 { sum = dpdx(u); }",
        "for (var i = 0.0; i < u; i += 1.0) { sum += shade(u); }",
        "switch u32(u) { case 1u: { sum = dpdx(u); } default: {} }",
        "switch 1u { default: { if u > 0.5 { break; } sum = dpdx(u); } }",
        "if early(u) > 0.5 { sum = dpdx(u); }",
        "var x = 0.0; fill(&x, u); if x > 0.5 { sum = dpdx(u); }",
        "var x = 0.0; let p = &x; *p = u; if x > 0.5 { sum = dpdx(u); }",
        "var x = vec2<f32>(); x.y = u; if x.x > 0.5 { sum = dpdx(u); }",
        "if dpdx(u) > 0.5 { sum = 1.0; } if fwidth(u) > 0.1 { sum = dpdy(u); }",
        "_ = select(0.0, dpdx(u), u > 0.5); if u > 0.5 { _ = dpdx(u); }",
    ] {
        assert_eq!(findings(&fragment(body)), 1, "{body}");
    }
    for body in [
        "if local > 2u { workgroupBarrier(); }",
        "if together > 2u { workgroupBarrier(); }",
        "_ = workgroupUniformLoad(&several[local % 4u]);",
        "if local > 2u { return; } storageBarrier();",
        "if local > 2u { _ = subgroupAdd(local); }",
        "_ = subgroupShuffleXor(local, local);",
    ] {
        assert_eq!(findings(&compute(body)), 1, "{body}");
    }
}

#[test]
fn severity_is_what_the_module_says() {
    let text = fragment("if u > 0.5 { sum = shade(u); }");
    let with = |first: &str| {
        let found = found(&naga::front::wgsl::parse_str(&format!("{first}{text}")).expect("WGSL"));
        found.iter().map(|one| one.warning).collect::<Vec<_>>()
    };
    assert_eq!(with(""), [false]);
    assert_eq!(with("diagnostic(off, derivative_uniformity);\n"), [] as [bool; 0]);
    assert_eq!(with("diagnostic(warning, derivative_uniformity);\n"), [true]);
    let within = text.replace("fn shade", "@diagnostic(off, derivative_uniformity) fn shade");
    assert_eq!(findings(&within), 0);
}
