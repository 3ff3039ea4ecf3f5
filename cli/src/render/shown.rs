//! Pictures of any format of colors: as numbers, or as 8 bits a channel for a screen.
//!
//! A PNG holds colors of a screen. Formats with `-srgb` and of floats hold linear colors, which get the transfer
//! function of sRGB; other formats hold encoded colors and are written as they are. Colors of floats have no end: up to
//! 0.8 they stay as they are, and brighter ones come closer and closer to 1, with their hue, as in Khronos' PBR neutral
//! tone mapper. An EXR has the numbers themselves.

use umbragraph::diagnostic::Diagnostic;
use umbragraph::executor::{Texels, read_back, read_bytes};
use umbragraph::low_level::picture::{BRIGHT, is_of_floats, is_of_screen, picture_of, tone_mapping};
use umbragraph::low_level::sheet::{Content, Sheet, sheet};
use wgpu::TextureFormat;

use super::Drawing;

impl Drawing<'_> {
    /// Reads back the picture of the last frame with 8 bits per channel.
    ///
    /// # Errors
    /// A picture whose format has no 8-bit channels.
    pub(crate) fn picture(&self) -> Result<Vec<u8>, Diagnostic> {
        picture_of(self.executor.plan(), &self.captures)?;
        match self.target() {
            Some(texture) => {
                pollster::block_on(read_bytes(&self.graphics.device, &self.graphics.queue, texture))
            }
            None => Ok(Vec::new()),
        }
    }

    /// Reads back the frame as RGBA screen colors with 8 bits per channel. Formats other than `rgba8unorm` and
    /// `rgba8unorm-srgb` are converted; colors of float formats are tone mapped.
    pub(crate) fn shown(&self) -> Result<Vec<u8>, Diagnostic> {
        match self.target().map(wgpu::Texture::format).filter(|format| !is_of_screen(*format)) {
            Some(format) => Ok(bytes(&self.texels()?, format)),
            None => self.picture(),
        }
    }

    /// Reads back the picture of the last frame as numbers, without conversion.
    pub(super) fn numbers(&self) -> Result<Sheet, Diagnostic> {
        Ok(sheet(&self.texels()?, Content::default(), None))
    }

    fn texels(&self) -> Result<Texels, Diagnostic> {
        let empty = Texels { width: 0, height: 0, layers: 0, channels: 4, values: Vec::new() };
        self.target().map_or(Ok(empty), |texture| {
            pollster::block_on(read_back(&self.graphics.device, &self.graphics.queue, texture))
        })
    }

    fn target(&self) -> Option<&wgpu::Texture> {
        self.imports.iter().find(|(name, _)| *name == self.picture).map(|(_, texture)| texture)
    }

    /// Returns the note that 8-bit files have tone mapped colors, if the picture has a float format; otherwise `None`.
    pub(crate) fn note(&self) -> Option<Diagnostic> {
        let format = self.target()?.format();
        tone_mapping(&self.picture, format)
    }
}

/// Converts texels to RGBA with 8 bits per channel.
fn bytes(texels: &Texels, format: TextureFormat) -> Vec<u8> {
    let is_linear = format.is_srgb() || is_of_floats(format);
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let shown = |[red, green, blue, alpha]: [f32; 4]| {
        // One channel is a shade of grey.
        let [green, blue] = if texels.channels == 1 { [red; 2] } else { [green, blue] };
        let color = if is_of_floats(format) { tone_mapped([red, green, blue]) } else { [red, green, blue] };
        let [red, green, blue] = if is_linear { color.map(encoded) } else { color };
        [byte(red), byte(green), byte(blue), byte(alpha)]
    };
    texels.values.iter().flat_map(|texel| shown(*texel)).collect()
}

/// Scales a color so that its brightest channel is at most 1; the hue stays the same. Colors up to [`BRIGHT`] are
/// unchanged.
fn tone_mapped(color: [f32; 3]) -> [f32; 3] {
    // What is no number is black; infinities are white.
    let color = color.map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, f32::MAX) });
    let peak = color.iter().copied().fold(0.0, f32::max);
    if peak <= BRIGHT {
        return color;
    }
    let room = 1.0 - BRIGHT;
    let mapped = 1.0 - room * room / (peak - BRIGHT + room);
    color.map(|channel| channel / peak * mapped)
}

/// Encodes a linear value with the sRGB transfer function.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: [f32; 4], format: TextureFormat) -> Vec<u8> {
        let texels = Texels { width: 1, height: 1, layers: 1, channels: 4, values: vec![value] };
        bytes(&texels, format)
    }

    #[test]
    fn floats_are_encoded_and_never_brighter_than_white() {
        let format = TextureFormat::Rgba16Float;
        assert_eq!(shown([0.214, 0.0, 0.5, 1.0], format), [127, 0, 188, 255]);
        let bright = shown([4.0, 2.0, 0.0, 1.0], format);
        assert!(bright[0] > 250 && bright[1] < bright[0] && bright[2] == 0, "{bright:?}");
        assert_eq!(shown([f32::INFINITY, f32::NAN, -1.0, 1.0], format)[1..], [0, 0, 255]);
    }

    #[test]
    fn encoded_formats_are_written_as_they_are() {
        assert_eq!(shown([0.2, 0.4, 1.0, 1.0], TextureFormat::Bgra8Unorm), [51, 102, 255, 255]);
        assert_eq!(shown([0.214, 0.0, 1.0, 1.0], TextureFormat::Bgra8UnormSrgb), [127, 0, 255, 255]);
    }
}
