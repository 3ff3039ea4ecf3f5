//! The texels of a picture as a texture stores them.

use exr::prelude::f16;

use super::picture::Picture;
use crate::wgpu;
use crate::wgpu::TextureFormat as Format;

/// The formats that a picture fills, for messages.
pub(super) const FORMATS: &str = "r8unorm, rg8unorm, rgba8unorm, bgra8unorm (the last two also -srgb), r8uint, \
    rg8uint, rgba8uint, and r, rg or rgba with 16float or 32float";

/// The numbers of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Byte,
    Half,
    Float,
}

/// Returns the numbers of a format's channels; `None` for a format that no picture fills.
pub(super) fn numbers(format: Format) -> Option<Number> {
    match format {
        Format::R8Unorm
        | Format::R8Uint
        | Format::Rg8Unorm
        | Format::Rg8Uint
        | Format::Rgba8Unorm
        | Format::Rgba8UnormSrgb
        | Format::Rgba8Uint
        | Format::Bgra8Unorm
        | Format::Bgra8UnormSrgb => Some(Number::Byte),
        Format::R16Float | Format::Rg16Float | Format::Rgba16Float => Some(Number::Half),
        Format::R32Float | Format::Rg32Float | Format::Rgba32Float => Some(Number::Float),
        _ => None,
    }
}

/// The places of a texture's layers in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arrangement {
    /// Below one another; also a texture of one layer.
    Stacked,
    /// Side by side.
    Beside,
}

impl Arrangement {
    /// Returns the arrangement of a picture of the given size for a texture with `sides`: width, height and layers.
    /// `None` if the sizes do not fit.
    pub(super) fn of([width, height]: [u32; 2], sides: [u32; 3]) -> Option<Self> {
        let picture = [u64::from(width), u64::from(height)];
        let [width, height, layers] = sides.map(u64::from);
        if picture == [width, height * layers] {
            Some(Self::Stacked)
        } else {
            (picture == [width * layers, height]).then_some(Self::Beside)
        }
    }

    /// The index in the picture of each texel of the texture, in the order of the texture.
    fn indices(self, sides: [u32; 3]) -> impl Iterator<Item = usize> {
        let [width, height, layers] = sides.map(|side| side as usize);
        (0..layers * height * width).map(move |index| {
            let (row, x) = (index / width, index % width);
            match self {
                Self::Stacked => index,
                Self::Beside => (row % height * layers + row / height) * width + x,
            }
        })
    }
}

/// Returns the bytes of a texture of the given format and `sides` with the texels of a picture; `None` if the picture
/// does not fit.
fn bytes_of(picture: &Picture, format: Format, sides: [u32; 3]) -> Option<Vec<u8>> {
    let numbers = numbers(format)?;
    let is_bgra = matches!(format, Format::Bgra8Unorm | Format::Bgra8UnormSrgb);
    let order: &[usize] = if is_bgra { &[2, 1, 0, 3] } else { &[0, 1, 2, 3] };
    let order = &order[..usize::from(format.components()).min(4)];
    let mut bytes = Vec::new();
    for texel in Arrangement::of(picture.size(), sides)?.indices(sides) {
        for channel in order {
            match numbers {
                Number::Byte => bytes.push(picture.byte(texel, *channel)),
                Number::Half => {
                    bytes.extend(f16::from_f32(picture.float(texel, *channel)).to_le_bytes());
                }
                Number::Float => bytes.extend(picture.float(texel, *channel).to_le_bytes()),
            }
        }
    }
    Some(bytes)
}

/// Writes a picture to a texture. Returns `false`, and writes nothing, if their sizes do not fit.
pub(super) fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, picture: &Picture) -> bool {
    let size = texture.size();
    let sides = [size.width, size.height, size.depth_or_array_layers];
    let Some(bytes) = bytes_of(picture, texture.format(), sides) else { return false };
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: texture.format().block_copy_size(None).map(|bytes| bytes * size.width),
        rows_per_image: Some(size.height),
    };
    queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::texture::Image;

    /// A picture whose red is the number of the texel.
    fn numbered(width: u32, height: u32) -> Picture {
        let rgba = (0..(width * height) as u8).flat_map(|at| [at, 100, 200, 255]).collect();
        Picture::Bytes(Image { name: String::new(), width, height, rgba })
    }

    #[test]
    fn channels_follow_the_format() {
        let bytes = |format| bytes_of(&numbered(2, 1), format, [2, 1, 1]).expect("a picture");
        assert_eq!(bytes(Format::R8Unorm), [0, 1]);
        assert_eq!(bytes(Format::Rg8Uint), [0, 100, 1, 100]);
        assert_eq!(bytes(Format::Bgra8UnormSrgb), [200, 100, 0, 255, 200, 100, 1, 255]);
        assert_eq!(bytes(Format::R32Float), [0.0_f32, 1.0 / 255.0].map(f32::to_le_bytes).concat());
        assert_eq!(bytes(Format::Rgba16Float).len(), 16);
        assert!(bytes_of(&numbered(2, 1), Format::Depth32Float, [2, 1, 1]).is_none());
    }

    #[test]
    fn layers_stand_side_by_side_or_below_one_another() {
        let reds = |size: [u32; 2]| bytes_of(&numbered(size[0], size[1]), Format::R8Unorm, [2, 2, 2]);
        assert_eq!(reds([2, 4]), Some((0..8).collect()));
        assert_eq!(reds([4, 2]), Some(vec![0, 1, 4, 5, 2, 3, 6, 7]));
        assert_eq!(reds([8, 1]), None);
    }
}
