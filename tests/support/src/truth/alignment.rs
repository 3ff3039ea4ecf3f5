//! A hint when a picture disagrees with the truth because of how it was written, not of what was rendered.
//!
//! The common mistakes between a renderer's target and a file are undone one at a time; if one of them makes the
//! agreement better by a clear margin, its name is the hint. It never takes part in a verdict.

use super::scene::TruthScene;
use super::score::{Answer, BandScore, Mask};

/// The minimum gain of the intersection over union for which a hint is given.
const MARGIN: f64 = 0.005;

/// A possible mistake in writing a picture: flipped rows or columns, or inverted values.
struct Mistake {
    name: &'static str,
    flip_rows: bool,
    flip_columns: bool,
    invert: bool,
}

const MISTAKES: [Mistake; 4] = [
    Mistake { name: "upside down", flip_rows: true, flip_columns: false, invert: false },
    Mistake { name: "mirrored from left to right", flip_rows: false, flip_columns: true, invert: false },
    Mistake { name: "turned by half", flip_rows: true, flip_columns: true, invert: false },
    Mistake { name: "inverted", flip_rows: false, flip_columns: false, invert: true },
];

/// Returns the mistake whose correction improves the agreement most; `None` if no gain exceeds `MARGIN`.
pub(super) fn alignment_hint(scene: &TruthScene, mask: &Mask, reached: Option<f64>) -> Option<&'static str> {
    let mut best = (reached.unwrap_or(0.0) + MARGIN, None);
    for mistake in &MISTAKES {
        let agreement = agreement_without(mistake, scene, mask).intersection_over_union();
        match agreement {
            Some(value) if value > best.0 => best = (value, Some(mistake.name)),
            _ => {}
        }
    }
    best.1
}

fn agreement_without(mistake: &Mistake, scene: &TruthScene, mask: &Mask) -> BandScore {
    let (width, height) = (scene.width as usize, scene.height as usize);
    let mut score = BandScore::default();
    for pixel in (0..scene.hit.len()).filter(|&pixel| scene.evaluated[pixel] && mask.hit[pixel]) {
        let (x, y) = (pixel % width, pixel / width);
        let column = if mistake.flip_columns { width - 1 - x } else { x };
        let row = if mistake.flip_rows { height - 1 - y } else { y };
        let shadowed = mask.shadowed[row * width + column] != mistake.invert;
        score.count(Answer::new(!scene.lit[pixel], shadowed));
    }
    score
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::scene::half_shadowed;

    /// Returns the half-shadowed scene with an additional shadowed corner, so that each mistake gives a different
    /// picture.
    fn lopsided() -> TruthScene {
        let mut scene = half_shadowed();
        for pixel in [32, 33, 34, 40, 41, 48] {
            scene.lit[pixel] = false;
        }
        scene
    }

    fn hint_for(scene: &TruthScene, shadowed: Vec<bool>) -> Option<&'static str> {
        let mask = Mask { hit: vec![true; 64], shadowed };
        alignment_hint(scene, &mask, agreement_without(&UNCHANGED, scene, &mask).intersection_over_union())
    }

    const UNCHANGED: Mistake =
        Mistake { name: "unchanged", flip_rows: false, flip_columns: false, invert: false };

    #[test]
    fn each_mistake_is_recognised() {
        let scene = lopsided();
        for mistake in &MISTAKES {
            let shadowed = (0..64)
                .map(|pixel| {
                    let (x, y) = (pixel % 8, pixel / 8);
                    let column = if mistake.flip_columns { 7 - x } else { x };
                    let row = if mistake.flip_rows { 7 - y } else { y };
                    scene.lit[row * 8 + column] == mistake.invert
                })
                .collect();
            assert_eq!(hint_for(&scene, shadowed), Some(mistake.name));
        }
    }

    #[test]
    fn a_right_picture_has_no_hint() {
        let scene = lopsided();
        let shadowed = scene.lit.iter().map(|lit| !lit).collect();
        assert_eq!(hint_for(&scene, shadowed), None);
    }
}
