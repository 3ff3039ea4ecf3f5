//! The picture of a file: bytes of a PNG or JPEG, or floats of an OpenEXR or Radiance file or of a color table.

use std::path::Path;

use super::super::environment::{self, Colors};
use super::IMPORT_FILE;
use super::cube;
use super::texels::{Number, numbers};
use crate::diagnostic::Diagnostic;
use crate::low_level::compose::{read_bytes, unreadable};
use crate::scene::image_from_slice;
use crate::scene::texture::Image;
use crate::wgpu;

/// The maximum size of a file in bytes, 1 GiB.
const MAX_BYTES: u64 = 1 << 30;

const HELP: &str =
    "--import NAME=FILE takes a PNG or JPEG, .exr (OpenEXR), .hdr (Radiance) or .cube (color table)";

/// A decoded picture.
#[derive(Clone)]
pub(super) enum Picture {
    /// Four bytes for each texel.
    Bytes(Image),
    /// Four floats for each texel.
    Floats(Colors),
}

impl Picture {
    /// Reads a picture.
    ///
    /// # Errors
    /// A file that cannot be read, or that is no picture.
    pub(super) fn read(path: &Path) -> Result<Self, Diagnostic> {
        let name = path.display().to_string();
        let bytes = read_bytes(path, MAX_BYTES)
            .and_then(|bytes| bytes.ok_or_else(|| std::io::Error::other("it is larger than 1 GiB")))
            .map_err(|error| unreadable(&name, &error).help(HELP))?;
        Self::decode(&name, &bytes).map_err(|error| {
            let message = format!("the picture cannot be read: {error}");
            Diagnostic::in_file(IMPORT_FILE, name.clone(), "", message).help(HELP)
        })
    }

    /// Decodes a picture by its first bytes.
    fn decode(name: &str, bytes: &[u8]) -> Result<Self, String> {
        if environment::is_known(bytes) {
            return environment::decoded(bytes).map(Self::Floats);
        }
        if cube::is_cube(bytes) {
            return cube::decode(bytes).map(Self::Floats);
        }
        image_from_slice(name, bytes).map(Self::Bytes)
    }

    /// The width and height in texels.
    pub(super) fn size(&self) -> [u32; 2] {
        match self {
            Self::Bytes(image) => [image.width, image.height],
            Self::Floats(colors) => [colors.width as u32, colors.height as u32],
        }
    }

    /// Returns `true` if a texture of the format can hold the picture without loss of range.
    pub(super) fn suits(&self, format: wgpu::TextureFormat) -> bool {
        let is_float = numbers(format).is_some_and(|numbers| numbers != Number::Byte);
        matches!(self, Self::Bytes(_)) || is_float
    }

    /// The number of a channel of a texel, from 0 to 1 for a picture of bytes.
    pub(super) fn float(&self, texel: usize, channel: usize) -> f32 {
        match self {
            Self::Bytes(_) => f32::from(self.byte(texel, channel)) / 255.0,
            Self::Floats(colors) => colors.texels[texel][channel],
        }
    }

    /// The byte of a channel of a texel; 0 for a picture of floats.
    pub(super) fn byte(&self, texel: usize, channel: usize) -> u8 {
        match self {
            Self::Bytes(image) => image.rgba[4 * texel + channel],
            Self::Floats(_) => 0,
        }
    }
}
