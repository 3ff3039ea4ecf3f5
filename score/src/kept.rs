//! Traced visibility as bytes, and what it follows from: for whoever keeps it from run to run.
//!
//! Four bytes a pixel, exact: three bits for lit, evaluated and contact; the square of the distance to an edge, which
//! is a whole number up to 25; and the visible part in 256ths, which is what samples make it.

use umbragraph_pipeline::frame::Light;

use crate::rays::Rays;
use crate::triangles::Surface;
use crate::truth::{LightTruth, Truth};

const LIT: u8 = 1;
const EVALUATED: u8 = 2;
const CONTACT: u8 = 4;
const HAS_EXTENT: u8 = 8;

impl LightTruth {
    /// The traced visibility as four bytes for each pixel, without loss.
    pub fn to_bytes(&self) -> Vec<u8> {
        let pixel = |at: usize| {
            let bits = [
                (self.lit[at], LIT),
                (self.evaluated[at], EVALUATED),
                (self.contact[at], CONTACT),
                (self.visible.is_some(), HAS_EXTENT),
            ];
            let bits = bits.iter().filter(|(is_set, _)| *is_set).fold(0, |all, (_, bit)| all | bit);
            let edge = (self.edge[at] * self.edge[at]).round() as u8;
            let visible = self.visible.as_ref().map_or(0, |visible| (visible[at] * 256.0).round() as u16);
            let [low, high] = visible.to_le_bytes();
            [bits, edge, low, high]
        };
        (0..self.lit.len()).flat_map(pixel).collect()
    }

    /// Restores the visibility from the bytes of `to_bytes`; `None` if there are not exactly four bytes for each of
    /// `pixels` pixels.
    pub fn from_bytes(bytes: &[u8], pixels: usize) -> Option<Self> {
        let (all, rest) = bytes.as_chunks::<4>();
        if all.len() != pixels || !rest.is_empty() {
            return None;
        }
        let bits = |bit: u8| all.iter().map(|pixel| pixel[0] & bit != 0).collect::<Vec<bool>>();
        let has_extent = all.first().is_some_and(|pixel| pixel[0] & HAS_EXTENT != 0);
        let visible = |pixel: &[u8; 4]| f32::from(u16::from_le_bytes([pixel[2], pixel[3]])) / 256.0;
        Some(Self {
            lit: bits(LIT),
            visible: has_extent.then(|| all.iter().map(visible).collect()),
            evaluated: bits(EVALUATED),
            edge: all.iter().map(|pixel| f32::from(pixel[1]).sqrt()).collect(),
            contact: bits(CONTACT),
        })
    }
}

impl Truth<'_> {
    /// Passes all inputs of the traced visibility of `light` to `each` as bytes, such as to hash them: triangles,
    /// surfaces, camera, image size and light.
    pub fn describe(&self, light: &Light, each: &mut dyn FnMut(&[u8])) {
        self.rays.describe(each);
        each(format!("{:?} {:?} {light:?}", self.camera, self.size).as_bytes());
    }
}

impl Rays<'_> {
    fn describe(&self, each: &mut dyn FnMut(&[u8])) {
        for triangle in &self.triangles {
            each(&triangle.draw.to_le_bytes());
            for part in triangle.corners.iter().flat_map(glam::DVec3::to_array) {
                each(&part.to_bits().to_le_bytes());
            }
        }
        for surface in &self.surfaces {
            each(format!("{surface:?}").as_bytes());
            self.describe_mask(surface, each);
        }
    }

    fn describe_mask(&self, surface: &Surface, each: &mut dyn FnMut(&[u8])) {
        let Some(mask) = &surface.mask else { return };
        let (texture, texcoords, indices) = mask.parts(self.scene);
        let texels = texture.map(|image| &image.rgba[..]);
        each(texels.unwrap_or_default());
        texcoords.iter().flatten().for_each(|part| each(&part.to_bits().to_le_bytes()));
        indices.iter().for_each(|index| each(&index.to_le_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_comes_back_from_its_bytes() {
        let edge = [0.0, 1.0, 2_f32.sqrt(), 13_f32.sqrt(), 5.0];
        for visible in [None, Some(vec![0.0, 1.0 / 16.0, 255.0 / 256.0, 1.0, 0.5])] {
            let truth = LightTruth {
                lit: vec![true, false, true, false, true],
                visible,
                evaluated: vec![true, true, false, false, true],
                edge: edge.to_vec(),
                contact: vec![false, true, false, true, false],
            };
            let bytes = truth.to_bytes();
            let back = LightTruth::from_bytes(&bytes, 5).unwrap();
            assert_eq!((&back.lit, &back.evaluated), (&truth.lit, &truth.evaluated));
            assert_eq!((&back.contact, &back.edge), (&truth.contact, &truth.edge));
            assert_eq!(back.visible, truth.visible);
            assert!(LightTruth::from_bytes(&bytes, 4).is_none());
            assert!(LightTruth::from_bytes(&bytes[1..], 5).is_none());
        }
    }
}
