{% include "lib/histogram_bins.wgsl.jinja" %}

@test
@case(-12.0)
@case(-3.5)
@case(0.0)
@case(12.0)
fn bins_come_back_as_stops(stops: f32) {
    expect_near(stops_of(bin_of(exp2(stops))), stops, 1e-4, "the stops");
}

@test
@case(0.0, 0.0)
@case(-1.0, 0.0)
@case(1e9, 255.0)
fn bins_end_at_both_sides(luminance: f32, wanted: f32) {
    expect_near(bin_of(luminance), wanted, 1e-4);
}
