//! The bytes that a texture takes on a device, as far as its description tells.

use crate::resources::resolved::TextureProperties;

/// The bytes of a texture: all mips, layers and samples.
pub(crate) fn texture_bytes(texture: &TextureProperties) -> u64 {
    let TextureProperties { format, size, volume, .. } = *texture;
    let (block_width, block_height) = format.block_dimensions();
    let depth_only = || format.block_copy_size(Some(wgpu_types::TextureAspect::DepthOnly));
    let block = u64::from(format.block_copy_size(None).or_else(depth_only).unwrap_or(4));
    (0..size.mips)
        .map(|mip| {
            let side = |length: u32, block: u32| u64::from((length >> mip).max(1).div_ceil(block));
            let layers = if volume { (size.layers >> mip).max(1) } else { size.layers };
            side(size.width, block_width) * side(size.height, block_height) * u64::from(layers) * block
        })
        .sum::<u64>()
        * u64::from(size.samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::texture_size::TextureSize;
    use wgpu_types::{TextureFormat, TextureUsages};

    #[test]
    fn a_texture_has_the_bytes_of_all_its_mips_layers_and_samples() {
        let bytes = |format, [width, height, layers, mips, samples]: [u32; 5], volume| {
            let size = TextureSize { width, height, layers, mips, samples };
            let usages = TextureUsages::empty();
            texture_bytes(&TextureProperties {
                format,
                size,
                volume,
                usages,
                view_format: None,
                only_array: false,
            })
        };
        let [layered, volume] =
            [false, true].map(|volume| bytes(TextureFormat::Rgba8Unorm, [8, 6, 4, 3, 1], volume));
        assert_eq!(layered, 4 * 4 * (8 * 6 + 4 * 3 + 2));
        assert_eq!(volume, 4 * (8 * 6 * 4 + 4 * 3 * 2 + 2));
        assert_eq!(bytes(TextureFormat::Bc1RgbaUnorm, [10, 4, 1, 2, 1], false), 8 * (3 + 2));
        assert_eq!(bytes(TextureFormat::Depth32Float, [8, 8, 1, 1, 4], false), 4 * 64 * 4);
    }
}
