{% include "lib/spherical_harmonics.wgsl.jinja" %}

// The integral of a product of two harmonics over the sphere: exact up to the fifth degree (Gauss and Legendre in z).
fn product(first: u32, second: u32) -> f32 {
    var sum = 0.0;
    for (var at = 0; at < 24; at++) {
        let z = 0.77459667 * f32(at / 8 - 1);
        let weight = select(5.0, 8.0, at / 8 == 1) / 9.0 * 0.78539816;
        let angle = 0.78539816 * f32(at % 8);
        let direction = vec3<f32>(sqrt(1.0 - z * z) * vec2<f32>(cos(angle), sin(angle)), z);
        sum += weight * spherical_harmonic(first, direction) * spherical_harmonic(second, direction);
    }
    return sum;
}

@test
{% for first in range(9) %}
@case({{ first }}u)
{% endfor %}
fn harmonics_are_orthonormal(first: u32) {
    for (var second = 0u; second < 9u; second++) {
        expect_near(product(first, second), f32(first == second), 1e-5, "the product of two harmonics");
    }
}
