{% include "lib/reflection.wgsl.jinja" %}
{% include "lib/surface_textures.wgsl.jinja" %}

@test
@case(vec3(0.0, 0.0, 1.0), vec2(0.0, 0.0))
@case(vec3(0.0, 0.0, -1.0), vec2(1.0, 1.0))
@case(vec3(1.0, 0.0, 0.0), vec2(1.0, 0.0))
@case(vec3(0.0, -1.0, 0.0), vec2(0.0, -1.0))
@case(vec3(0.6, -0.8, 0.0), vec2(0.42857143, -0.5714286))
@case(vec3(-0.48, 0.6, -0.64), vec2(-0.6511628, 0.72093023))
fn axes_and_edges_unfold_to_their_places(unit: vec3<f32>, wanted: vec2<f32>) {
    expect_near(octahedral(unit), wanted, 1e-6, "the place on the square");
    expect_near(from_octahedral(wanted), unit, 1e-6, "the direction of that place");
}

// The direction of a point of a spiral of 1000 over the sphere.
fn spiral(at: u32) -> vec3<f32> {
    let z = 1.0 - (f32(at) + 0.5) * 0.002;
    let angle = f32(at) * 2.3999632;
    return vec3<f32>(sqrt(1.0 - z * z) * vec2<f32>(cos(angle), sin(angle)), z);
}

@test
fn every_direction_comes_back() {
    for (var at = 0u; at < 1000u; at++) {
        let unit = spiral(at);
        let folded = octahedral(unit);
        expect(all(abs(folded) <= vec2<f32>(1.0)), "the map is within the square");
        expect_near(from_octahedral(folded), unit, 2e-6, "the direction that was folded");
    }
}

@test
fn sixteen_bits_keep_directions_to_a_ten_thousandth() {
    for (var at = 0u; at < 1000u; at++) {
        let stored = stored_directions(spiral(at), spiral(999u - at));
        expect(all(abs(stored) <= vec4<i32>(32767)), "whole numbers of 16 bits");
        expect_near(direction_of(stored.xy), spiral(at), 1e-4, "the first direction");
        expect_near(direction_of(stored.zw), spiral(999u - at), 1e-4, "the second direction");
    }
}

@test
@case(0.0, 0.0)
@case(0.0, 1.0)
@case(1.0, 0.0)
@case(1.0, 0.4)
@case(1.0, 1.0)
fn eight_bits_of_alpha_keep_receivers_and_occlusion(receives: f32, occlusion: f32) {
    let alpha = round(255.0 * stored_alpha(receives, occlusion)) / 255.0;
    expect_equal(receives_of(alpha), receives, "whether shadows fall");
{% if pbr %}
    let stored = stored_reflection(Reflection(0.5, 0.25, 1.0, vec3<f32>(0.04, 0.01, 0.0), 0.75));
    let read = reflection_of(stored, alpha);
    expect_near(read.occlusion, occlusion, 0.005, "the occlusion");
    expect_near(vec2<f32>(read.metallic, read.roughness), vec2<f32>(0.5, 0.25), 1e-6, "metallic and roughness");
    expect_near(read.f0, vec3<f32>(0.04), 1e-6, "the greatest reflectance at normal incidence");
    expect_near(read.f90, 0.75, 1e-6, "the reflectance at grazing incidence");
{% endif %}
}
