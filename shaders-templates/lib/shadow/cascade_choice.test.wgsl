{# Three cascades that end at 10, 20 and 40 metres and begin to fade at 9, 18 and 36; the map of each lets another part of
   the light through. #}
struct Surface {
    distance: f32,
    // A cascade whose map does not show the surface.
    hole: u32,
}

fn cascade_reach(index: u32) -> vec2<f32> {
    return vec2<f32>(10.0, 9.0) * exp2(f32(index));
}

fn cascade_holds(index: u32, surface: Surface) -> bool {
    return index != surface.hole;
}

fn map_visibility(index: u32, surface: Surface, turn: vec2<f32>, hardness: u32) -> f32 {
    return 0.2 + 0.2 * f32(index);
}
{% if cascade_blend == "dither" %}

fn cascade_is_mixed(index: u32, hardness: u32) -> bool {
    return hardness == 1u;
}
{% endif %}

{% include "lib/shadow/cascade_choice.wgsl.jinja" %}

fn light(distance: f32, hole: u32, noise: f32, hardness: u32) -> f32 {
    let surface = Surface(distance, hole);
    return chosen_visibility(choose_cascade(0u, 3u, surface, noise, hardness), surface, vec2<f32>(), hardness);
}

@test
@case(0.0, 9u, 0u)
@case(9.99, 9u, 0u)
@case(10.0, 9u, 1u)
@case(39.9, 9u, 2u)
@case(40.0, 9u, 3u)
@case(5.0, 0u, 1u)
@case(15.0, 1u, 2u)
@case(30.0, 2u, 3u)
fn first_cascade_that_reaches_and_holds_is_chosen(distance: f32, hole: u32, wanted: u32) {
    expect_equal(select_cascade(0u, 3u, Surface(distance, hole)), wanted);
}

@test
@case(5.0, 0.2)
@case(12.0, 0.4)
@case(30.0, 0.6)
@case(50.0, 1.0)
fn one_map_decides_away_from_the_ends(distance: f32, wanted: f32) {
    expect_near(light(distance, 9u, 0.5, 0u), wanted, 1e-6);
    expect_near(light(distance, 9u, 0.5, 1u), wanted, 1e-6);
}

// A row: the distance, the hole, and the light for the blends none and mix, and dither with a noise of a quarter and three.
@test
@case(9.5, 9u, 0.2, 0.3, 0.4, 0.2)
@case(19.0, 9u, 0.4, 0.5, 0.6, 0.4)
@case(9.5, 1u, 0.2, 0.6, 0.2, 0.2)
@case(38.0, 9u, 0.6, 0.8, 0.8, 0.8)
fn ends_blend(distance: f32, hole: u32, none: f32, mixed: f32, low: f32, high: f32) {
{% if cascade_blend == "none" %}
    expect_near(light(distance, hole, 0.25, 0u), none, 1e-6, "an edge");
{% elif cascade_blend == "mix" %}
    expect_near(light(distance, hole, 0.25, 0u), mixed, 1e-6, "a mix with the next, or with light");
{% else %}
    expect_near(light(distance, hole, 0.25, 0u), low, 1e-6, "a noise below the fade takes the next");
    expect_near(light(distance, hole, 0.75, 0u), high, 1e-6, "a noise above it does not");
    expect_near(light(distance, hole, 0.75, 1u), select(mixed, none, hole == 1u), 1e-6, "what is cheap is mixed");
{% endif %}
}
