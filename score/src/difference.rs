//! Difference images: the places and kinds of errors against the truth.
//!
//! | colour | what |
//! |---|---|
//! | light grey, dark grey | lit, shadowed in both |
//! | red | light leaks; pale within a pixel of an edge |
//! | magenta | light leaks where something very near casts the shadow |
//! | blue | acne; pale within a pixel of an edge |
//! | orange to yellow, cyan | of a light with an extent: too light, too dark in the penumbra, the stronger the more |
//! | slate | does not count |

use crate::scores::{Answer, PENUMBRA, Rendered};
use crate::truth::{LightTruth, Truth};

/// Paints the errors of a shadow term against the truth. Returns four bytes for each pixel: red, green, blue and alpha.
pub fn picture(truth: &Truth<'_>, light: &LightTruth, rendered: Rendered<'_>) -> Vec<u8> {
    let colour = |at: usize| -> [u8; 3] {
        if truth.points()[at].is_none() || !light.evaluated[at] || !rendered.hits(at) {
            return [60, 60, 90];
        }
        let is_edge = light.edge[at] <= 1.0;
        let answer = Answer::new(light.lit[at], rendered.is_shadowed(at));
        if let Some(visible) = &light.visible {
            let part = f64::from(visible[at]);
            if PENUMBRA.contains(&part) || matches!(answer, Answer::ShadowedInBoth | Answer::LitInBoth) {
                return soft(rendered.part(at), part);
            }
        }
        match answer {
            Answer::ShadowedInBoth => [40; 3],
            Answer::LitInBoth => [225; 3],
            Answer::Leaking if is_edge => [255, 170, 170],
            Answer::Leaking if light.contact[at] => [255, 0, 255],
            Answer::Leaking => [255, 0, 0],
            Answer::Acne if is_edge => [170, 170, 255],
            Answer::Acne => [0, 0, 255],
        }
    };
    (0..truth.points().len())
        .flat_map(|at| {
            let [red, green, blue] = colour(at);
            [red, green, blue, 255]
        })
        .collect()
}

/// The color of a pixel lit by a light with an extent: the true visible part as grey, blended with a color for the
/// error.
fn soft(rendered: f64, part: f64) -> [u8; 3] {
    let grey = 40.0 + 185.0 * part;
    let error = rendered - part;
    let strength = (4.0 * error.abs()).min(1.0);
    let target = if error > 0.0 { [255.0, 60.0 + 160.0 * part, 0.0] } else { [0.0, 190.0, 255.0] };
    // Below a hundredth nothing is seen of it.
    let strength = if error.abs() < 0.01 { 0.0 } else { strength };
    target.map(|channel| (grey + (channel - grey) * strength) as u8)
}
