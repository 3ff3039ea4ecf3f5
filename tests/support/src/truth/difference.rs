//! A picture of where a rendered shadow mask and the truth disagree, for looking at.

use super::error::TruthError;
use super::scene::TruthScene;
use super::score::{Answer, Mask};
use crate::image::{Channels, Picture};

const NOT_EVALUATED: [u8; 3] = [60, 60, 90];

/// Returns a picture of the differences. Light and dark grey mark agreement, red light leaks, blue acne; pixels near a
/// shadow edge are pale, unevaluated ones slate.
pub fn difference_picture(scene: &TruthScene, picture: &Picture) -> Result<Picture, TruthError> {
    let mask = Mask::new(scene, picture)?;
    let mut bytes = Vec::with_capacity(scene.hit.len() * 3);
    for pixel in 0..scene.hit.len() {
        let inside = scene.band[pixel] >= 2;
        let colour = if scene.evaluated[pixel] && mask.hit[pixel] {
            match (Answer::new(!scene.lit[pixel], mask.shadowed[pixel]), inside) {
                (Answer::ShadowedInBoth, _) => [40, 40, 40],
                (Answer::LitInBoth, _) => [225, 225, 225],
                (Answer::Leaking, true) => [255, 0, 0],
                (Answer::Leaking, false) => [255, 170, 170],
                (Answer::Acne, true) => [0, 0, 255],
                (Answer::Acne, false) => [170, 170, 255],
            }
        } else {
            NOT_EVALUATED
        };
        bytes.extend_from_slice(&colour);
    }
    Ok(Picture::new(scene.width, scene.height, Channels::Rgb, bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::scene::half_shadowed;

    #[test]
    fn leak_and_acne_have_their_colours() {
        let mut scene = half_shadowed();
        scene.evaluated[63] = false;
        let mut rendered = Picture::filled(8, 8, Channels::Grey, &[255]);
        rendered.pixel_mut(0, 7).unwrap()[0] = 0;
        rendered.pixel_mut(1, 4).unwrap()[0] = 0;
        let mut difference = difference_picture(&scene, &rendered).unwrap();
        for (x, y, colour) in [
            (0, 0, [255, 0, 0]),
            (0, 3, [255, 170, 170]),
            (0, 7, [0, 0, 255]),
            (1, 4, [170, 170, 255]),
            (2, 7, [225, 225, 225]),
            (7, 7, NOT_EVALUATED),
        ] {
            assert_eq!(difference.pixel_mut(x, y).unwrap(), colour, "column {x}, row {y}");
        }
    }
}
