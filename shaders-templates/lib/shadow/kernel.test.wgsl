{% include "lib/shadow/kernel.wgsl.jinja" %}
{% set counts = {"hard": 1, "squares9": 9, "poisson9": 9, "poisson16": 16, "poisson64": 64} %}
{% set nearest = {"grid_pcf": "1.999 / f32(grid_pcf_side)", "poisson9": 0.66, "poisson16": 0.43, "poisson64": 0.19} %}

@test
fn number_of_taps_is_that_of_the_filter() {
{% if shadow_filter in counts %}
    expect_equal(filter_taps(), {{ counts[shadow_filter] }});
{% elif shadow_filter == "grid_pcf" %}
    expect_equal(filter_taps(), grid_pcf_side * grid_pcf_side);
{% else %}
    expect_equal(filter_taps(), vogel_taps);
{% endif %}
}

@test
fn taps_lie_on_the_disc_or_the_square() {
    var sum = vec2<f32>();
    for (var at = 0u; at < filter_taps(); at++) {
        let tap = filter_tap(at);
        sum += tap;
{% if shadow_filter == "grid_pcf" %}
        expect(all(abs(tap) < vec2<f32>(1.0)), "the tap is within the square");
{% else %}
        expect(length(tap) < 1.00001, "the tap is within the disc");
{% endif %}
    }
{% if shadow_filter in ["hard", "grid_pcf", "squares9"] %}
    expect_near(sum, vec2<f32>(), 1e-4, "the taps are symmetric");
{% endif %}
}
{% if shadow_filter in nearest %}

@test
fn no_two_taps_are_nearer_than_the_table_says() {
    for (var first = 0u; first < filter_taps(); first++) {
        for (var second = first + 1u; second < filter_taps(); second++) {
            let between = distance(filter_tap(first), filter_tap(second));
            expect(between > {{ nearest[shadow_filter] }}, "more than {{ nearest[shadow_filter] }} apart");
        }
    }
}
{% endif %}
{% if shadow_filter in ["vogel", "pcss"] %}

@test
fn each_tap_of_the_spiral_has_the_same_area() {
    for (var at = 0u; at < filter_taps(); at++) {
        let tap = filter_tap(at);
        expect_near(dot(tap, tap) * f32(filter_taps()), f32(at) + 0.5, 1e-3, "the square of the radius");
    }
}
{% endif %}

@test
@case(0.0)
@case(0.3)
@case(0.99)
fn a_turned_tap_keeps_its_length(noise: f32) {
    let turn = filter_turn(noise);
    expect_near(length(turn), 1.0, 1e-6, "a cosine and a sine");
    expect_near(length(rotated(vec2<f32>(0.6, -0.3), turn)), length(vec2<f32>(0.6, -0.3)), 1e-6);
{% if shadow_filter in ["hard", "grid_pcf"] %}
    expect_equal(rotated(vec2<f32>(0.6, -0.3), turn), vec2<f32>(0.6, -0.3), "grids are not turned");
{% else %}
    let angle = select(0.0, 6.2831853 * noise, rotate_taps);
    expect_near(rotated(vec2<f32>(1.0, 0.0), turn), vec2<f32>(cos(angle), sin(angle)), 1e-6, "the turn");
{% endif %}
}
