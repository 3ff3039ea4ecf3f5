//! Textures sampled as their samplers say: filters, mip levels and what lies beyond the edges.
//!
//! The mip level follows from the longer side of a pixel in texels, as in the Vulkan specification (section
//! "Scale Factor, LOD and Image Level(s) Selection"), without anisotropic filtering.

use std::collections::HashMap;

use glam::{DVec2, DVec4};
use umbragraph_pipeline::wgpu_types::{FilterMode, MipmapFilterMode};
use umbragraph_scene::material::Map;
use umbragraph_scene::texture::Sampler;
use umbragraph_scene::{Scene, mipmap};

use crate::triangles::wrapped;

/// Changes of texture coordinates from a pixel to its neighbours, to the right and down.
pub type Changes = [DVec2; 2];

struct Level {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

/// The images of a scene with their mip levels, as the maps of its materials use them.
pub struct Textures<'s> {
    scene: &'s Scene,
    /// By image, and whether its colors are sRGB-encoded.
    levels: HashMap<(usize, bool), Vec<Level>>,
    /// The linear value of each sRGB byte.
    linear: [f64; 256],
}

impl<'s> Textures<'s> {
    /// Prepares the images of all materials of a scene.
    pub fn new(scene: &'s Scene) -> Self {
        let mut textures = Self { scene, levels: HashMap::new(), linear: std::array::from_fn(linear) };
        for material in &scene.materials {
            for (map, is_srgb) in [
                (material.base_color_map, true),
                (material.metallic_roughness_map, false),
                (material.normal_map, false),
                (material.occlusion_map, false),
                (material.emissive_map, true),
            ] {
                map.iter().for_each(|map| textures.prepare(*map, is_srgb));
            }
        }
        textures
    }

    fn prepare(&mut self, map: Map, is_srgb: bool) {
        let Some(texture) = self.scene.textures.get(map.texture) else { return };
        let Some(image) = self.scene.images.get(texture.image) else { return };
        self.levels.entry((texture.image, is_srgb)).or_insert_with(|| {
            let base = Level { width: image.width, height: image.height, rgba: image.rgba.clone() };
            let smaller = mipmap::levels(image, is_srgb);
            let smaller = smaller.into_iter().map(|(width, height, rgba)| Level { width, height, rgba });
            std::iter::once(base).chain(smaller).collect()
        });
    }

    /// The texel of a map at texture coordinates: linear colors and alpha, 0 to 1. White for an image that is missing.
    pub fn sample(&self, map: Map, is_srgb: bool, at: DVec2, changes: Option<Changes>) -> DVec4 {
        let texture = self.scene.textures.get(map.texture);
        let levels = texture.and_then(|texture| self.levels.get(&(texture.image, is_srgb)));
        let (Some(texture), Some(levels)) = (texture, levels) else { return DVec4::ONE };
        let (sampler, size) =
            (texture.sampler, DVec2::new(f64::from(levels[0].width), f64::from(levels[0].height)));
        let texels = changes.map_or(0.0, |changes| {
            changes.iter().map(|change| (*change * size).length()).fold(0.0, f64::max)
        });
        let level = if texels > 0.0 { texels.log2() } else { f64::NEG_INFINITY };
        let filter = if level > 0.0 { sampler.minify } else { sampler.magnify };
        let last = (levels.len() - 1) as f64;
        let one = |level: f64| self.filtered(&levels[level as usize], sampler, filter, is_srgb, at);
        match sampler.mipmap {
            None => one(0.0),
            Some(MipmapFilterMode::Nearest) => one((level + 0.5).ceil().clamp(1.0, last + 1.0) - 1.0),
            Some(MipmapFilterMode::Linear) => {
                let level = level.clamp(0.0, last);
                let (below, part) = (level.floor(), level.fract());
                if part == 0.0 { one(below) } else { one(below).lerp(one(below + 1.0), part) }
            }
        }
    }

    fn filtered(
        &self,
        level: &Level,
        sampler: Sampler,
        filter: FilterMode,
        is_srgb: bool,
        at: DVec2,
    ) -> DVec4 {
        let size = DVec2::new(f64::from(level.width), f64::from(level.height));
        let texel = |x: f64, y: f64| {
            let x = wrapped(x, level.width, sampler.wrap_u) as usize;
            let y = wrapped(y, level.height, sampler.wrap_v) as usize;
            let first = 4 * (y * level.width as usize + x);
            let rgba: [u8; 4] =
                level.rgba.get(first..first + 4).and_then(|rgba| rgba.try_into().ok()).unwrap_or([255; 4]);
            let [red, green, blue, alpha] = rgba.map(|byte| f64::from(byte) / 255.0);
            if is_srgb {
                let [red, green, blue, _] = rgba.map(|byte| self.linear[usize::from(byte)]);
                return DVec4::new(red, green, blue, alpha);
            }
            DVec4::new(red, green, blue, alpha)
        };
        match filter {
            FilterMode::Nearest => {
                let at = (at * size).floor();
                texel(at.x, at.y)
            }
            FilterMode::Linear => {
                let at = at * size - 0.5;
                let (low, part) = (at.floor(), at - at.floor());
                let row = |y: f64| texel(low.x, y).lerp(texel(low.x + 1.0, y), part.x);
                row(low.y).lerp(row(low.y + 1.0), part.y)
            }
        }
    }
}

/// The linear value of an sRGB byte (IEC 61966-2-1).
fn linear(byte: usize) -> f64 {
    let encoded = byte as f64 / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
