{# Three quarters of a distribution at one depth and a quarter at another, 0.75 behind it: what its moments let through to
   depths from -1 to 1. #}
{% include "lib/shadow/moments_bound.wgsl.jinja" %}

const DEVIATION: f32 = 0.002;

fn stored(near: f32, exponent: f32) -> vec4<f32> {
    return mix(moments_of(near, exponent), moments_of(near + 0.75, exponent), 0.25);
}

fn lit(near: f32, exponent: f32, z: f32) -> f32 {
    return moments_bound(stored(near, exponent), z, exponent, DEVIATION, 1e-5);
}

// The light that the distribution really lets through.
fn truth(near: f32, z: f32) -> f32 {
    return select(select(0.0, 0.25, z <= near + 0.75), 1.0, z <= near);
}

// The inequality of Chebyshev, with the variance of two depths in closed form.
fn chebyshev(first: f32, second: f32, warped: f32, min_deviation: f32) -> f32 {
    let variance = max(0.1875 * (second - first) * (second - first), min_deviation * min_deviation);
    let beyond = max(warped - mix(first, second, 0.25), 0.0);
    return variance / (variance + beyond * beyond);
}

@test
{% for exponent in [5.0, 42.0] %}
{% for near in range(8) %}
@case({{ exponent }}, {{ near / 8 - 1 }})
{% endfor %}
{% endfor %}
fn bound_is_never_darker_than_the_truth(exponent: f32, near: f32) {
    for (var at = 0; at <= 256; at++) {
        let z = f32(at) / 128.0 - 1.0;
        let bound = lit(near, exponent, z);
        expect(bound >= 0.0 && bound <= 1.0, "the bound is a part of 1");
        expect_near(bound, max(bound, truth(near, z)), 1e-3, "the bound");
    }
}

@test
{% for exponent in [5.0, 42.0] %}
{% for near in range(8) %}
@case({{ exponent }}, {{ near / 8 - 1 }})
{% endfor %}
{% endfor %}
fn bound_is_the_inequality_of_its_moments(exponent: f32, near: f32) {
    let far = near + 0.75;
    for (var at = 0; at <= 256; at++) {
        let z = f32(at) / 128.0 - 1.0;
        let bound = lit(near, exponent, z);
        if moment_mode == MSM {
            // Two depths are all that four moments can tell: nothing else passes, but at the depths themselves.
            if abs(z - near) > 0.1 && abs(z - far) > 0.1 {
                expect_near(bound, truth(near, z), 0.02, "four moments tell two depths");
            }
        } else if moment_mode == VSM {
            expect_near(bound, chebyshev(near, far, z, DEVIATION), 2e-3, "two moments of depth");
        } else {
            let first = warp(near, exponent);
            let second = warp(far, exponent);
            let here = warp(z, exponent);
            let least = DEVIATION * exponent * abs(here);
            let front = chebyshev(first.x, second.x, here.x, least.x);
            let back = select(chebyshev(first.y, second.y, here.y, least.y), 1.0, moment_mode == EVSM2);
            expect_near(bound, min(front, back), 2e-3, "moments of warped depth");
        }
    }
}
