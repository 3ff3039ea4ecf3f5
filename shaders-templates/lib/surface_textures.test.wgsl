{% include "lib/reflection.wgsl.jinja" %}
{% include "lib/surface_textures.wgsl.jinja" %}

@test
@case(vec3(0.0, 0.0, 1.0))
@case(vec3(0.0, 0.0, -1.0))
@case(vec3(0.6, -0.8, 0.0))
@case(vec3(-0.48, 0.6, -0.64))
fn octahedral_maps_come_back(unit: vec3<f32>) {
    let folded = octahedral(unit);
    expect(all(abs(folded) <= vec2<f32>(1.0)), "the map stays in the square");
    expect_near(from_octahedral(folded), unit, 1e-6, "the direction comes back");
}
