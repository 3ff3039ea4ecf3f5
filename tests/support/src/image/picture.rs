//! 8-bit pictures and their PNG files.
//!
//! Grey, grey with alpha, RGB and RGBA are read and written as they are; palettes and fewer than 8 bits are
//! expanded. Pictures of 16 bits are rejected: cutting them to 8 would let two different pictures compare equal.
//! Colour-space chunks are neither read nor written; values are compared as they are stored.

use std::error::Error;
use std::fmt;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

/// The channels of a pixel, one byte each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// One byte: grey.
    Grey,
    /// Two bytes: grey and alpha.
    GreyAlpha,
    /// Three bytes: red, green, blue.
    Rgb,
    /// Four bytes: red, green, blue, alpha.
    Rgba,
}

impl Channels {
    /// The number of bytes in a pixel.
    pub fn count(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    /// Returns `true` if the last byte of a pixel is its alpha.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::GreyAlpha | Self::Rgba)
    }

    fn to_png(self) -> png::ColorType {
        match self {
            Self::Grey => png::ColorType::Grayscale,
            Self::GreyAlpha => png::ColorType::GrayscaleAlpha,
            Self::Rgb => png::ColorType::Rgb,
            Self::Rgba => png::ColorType::Rgba,
        }
    }

    fn from_png(color: png::ColorType) -> Option<Self> {
        match color {
            png::ColorType::Grayscale => Some(Self::Grey),
            png::ColorType::GrayscaleAlpha => Some(Self::GreyAlpha),
            png::ColorType::Rgb => Some(Self::Rgb),
            png::ColorType::Rgba => Some(Self::Rgba),
            png::ColorType::Indexed => None,
        }
    }
}

/// An 8-bit picture; row 0 is at the top, and rows have no padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    channels: Channels,
    bytes: Vec<u8>,
}

impl Picture {
    /// Creates a picture from its bytes.
    pub fn new(width: u32, height: u32, channels: Channels, bytes: Vec<u8>) -> Result<Self, PictureError> {
        let expected = byte_count(width, height, channels);
        if expected != Some(bytes.len()) {
            return Err(PictureError::ByteCount { width, height, channels, actual: bytes.len() });
        }
        Ok(Self { width, height, channels, bytes })
    }

    /// Creates a picture with the same value in each pixel.
    ///
    /// # Panics
    /// If the number of bytes in `pixel` differs from that of `channels`.
    pub fn filled(width: u32, height: u32, channels: Channels, pixel: &[u8]) -> Self {
        assert_eq!(pixel.len(), channels.count(), "a pixel of {channels:?} has another number of bytes");
        let pixels = width as usize * height as usize;
        Self { width, height, channels, bytes: pixel.repeat(pixels) }
    }

    /// Reads a PNG file.
    pub fn load(path: &Path) -> Result<Self, PictureError> {
        let file = File::open(path).map_err(|error| PictureError::Open { path: path.to_owned(), error })?;
        let decode = |error| PictureError::Decode { path: path.to_owned(), error };
        let mut decoder = png::Decoder::new(BufReader::new(file));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(decode)?;
        let size = reader.output_buffer_size().ok_or_else(|| decode(png::DecodingError::LimitsExceeded))?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes).map_err(decode)?;
        bytes.truncate(info.buffer_size());
        match (Channels::from_png(info.color_type), info.bit_depth) {
            (Some(channels), png::BitDepth::Eight) => Self::new(info.width, info.height, channels, bytes),
            _ => Err(PictureError::Layout {
                path: path.to_owned(),
                layout: format!("{:?}, {:?} bits", info.color_type, info.bit_depth),
            }),
        }
    }

    /// Writes a PNG file, and creates missing parent folders.
    pub fn save(&self, path: &Path) -> Result<(), PictureError> {
        let open = |error| PictureError::Create { path: path.to_owned(), error };
        let encode = |error| PictureError::Encode { path: path.to_owned(), error };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(open)?;
        }
        let file = BufWriter::new(File::create(path).map_err(open)?);
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(self.channels.to_png());
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(encode)?;
        writer.write_image_data(&self.bytes).map_err(encode)?;
        writer.finish().map_err(encode)
    }

    /// Returns the number of pixels in which some channel differs from the other picture by more than `by` levels.
    pub fn differing(&self, other: &Self, by: u8) -> usize {
        let differs = |(a, b): &([u8; 4], [u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > by);
        self.rgba_pixels().zip(other.rgba_pixels()).filter(differs).count()
    }

    /// The number of pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The channels of a pixel.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// The bytes of all pixels, row 0 first.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes of one pixel, mutable; `None` outside of the picture.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> Option<&mut [u8]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let count = self.channels.count();
        let start = (y as usize * self.width as usize + x as usize) * count;
        self.bytes.get_mut(start..start + count)
    }

    /// The pixels as red, green, blue and alpha, row 0 first. Grey is copied to all three colors; a missing alpha is
    /// 255.
    pub fn rgba_pixels(&self) -> impl Iterator<Item = [u8; 4]> + '_ {
        self.bytes.chunks_exact(self.channels.count()).map(|pixel| match *pixel {
            [grey] => [grey, grey, grey, 255],
            [grey, alpha] => [grey, grey, grey, alpha],
            [red, green, blue] => [red, green, blue, 255],
            [red, green, blue, alpha] => [red, green, blue, alpha],
            _ => [0; 4],
        })
    }
}

fn byte_count(width: u32, height: u32, channels: Channels) -> Option<usize> {
    (width as usize).checked_mul(height as usize)?.checked_mul(channels.count())
}

/// The reason why a picture could not be created, read or written.
#[derive(Debug)]
pub enum PictureError {
    /// The number of bytes does not match the size and channels.
    ByteCount {
        /// The number of pixels in a row.
        width: u32,
        /// The number of rows.
        height: u32,
        /// The channels of a pixel.
        channels: Channels,
        /// The number of bytes given.
        actual: usize,
    },
    /// The file cannot be opened.
    Open {
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// The file is not a PNG, or a broken one.
    Decode {
        /// The path of the file.
        path: PathBuf,
        /// The error of the decoder.
        error: png::DecodingError,
    },
    /// The file has more than 8 bits in a channel.
    Layout {
        /// The path of the file.
        path: PathBuf,
        /// The color type and bit depth of the file.
        layout: String,
    },
    /// The file or a parent folder cannot be created.
    Create {
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// The file cannot be written.
    Encode {
        /// The path of the file.
        path: PathBuf,
        /// The error of the encoder.
        error: png::EncodingError,
    },
}

impl PictureError {
    /// Returns `true` if the error is that the file does not exist.
    pub fn is_missing_file(&self) -> bool {
        matches!(self, Self::Open { error, .. } if error.kind() == std::io::ErrorKind::NotFound)
    }
}

impl fmt::Display for PictureError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ByteCount { width, height, channels, actual } => {
                write!(formatter, "{actual} bytes do not make a {width}x{height} picture of {channels:?}")
            }
            Self::Open { path, error } => write!(formatter, "cannot open {}: {error}", path.display()),
            Self::Decode { path, error } => {
                write!(formatter, "{} is not a readable PNG: {error}", path.display())
            }
            Self::Layout { path, layout } => {
                write!(formatter, "{} holds {layout}; an 8-bit picture is wanted", path.display())
            }
            Self::Create { path, error } => write!(formatter, "cannot create {}: {error}", path.display()),
            Self::Encode { path, error } => write!(formatter, "cannot write {}: {error}", path.display()),
        }
    }
}

impl Error for PictureError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::ByteCount { .. } | Self::Layout { .. } => None,
            Self::Open { error, .. } | Self::Create { error, .. } => Some(error),
            Self::Decode { error, .. } => Some(error),
            Self::Encode { error, .. } => Some(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::ScratchFolder;

    #[test]
    fn each_layout_survives_a_file() {
        let folder = ScratchFolder::new("each_layout_survives_a_file");
        for channels in [Channels::Grey, Channels::GreyAlpha, Channels::Rgb, Channels::Rgba] {
            let count = 5 * 3 * channels.count();
            let bytes = (0..count).map(|index| (index * 41 % 256) as u8).collect();
            let picture = Picture::new(5, 3, channels, bytes).unwrap();
            let path = folder.join(format!("{channels:?}.png"));
            picture.save(&path).unwrap();
            assert_eq!(Picture::load(&path).unwrap(), picture);
        }
    }

    #[test]
    fn a_picture_needs_exactly_its_bytes() {
        assert!(Picture::new(2, 2, Channels::Rgb, vec![0; 12]).is_ok());
        for wrong in [0, 11, 13] {
            let error = Picture::new(2, 2, Channels::Rgb, vec![0; wrong]).unwrap_err();
            assert!(error.to_string().contains("2x2"), "{error}");
        }
    }

    #[test]
    fn a_missing_file_and_a_broken_file_are_told_apart() {
        let folder = ScratchFolder::new("a_missing_file_and_a_broken_file_are_told_apart");
        let missing = Picture::load(&folder.join("missing.png")).unwrap_err();
        assert!(missing.is_missing_file());
        let path = folder.join("broken.png");
        std::fs::write(&path, b"not a picture").unwrap();
        let broken = Picture::load(&path).unwrap_err();
        assert!(!broken.is_missing_file());
        assert!(broken.to_string().contains("broken.png"), "{broken}");
    }

    #[test]
    fn sixteen_bits_are_rejected() {
        let folder = ScratchFolder::new("sixteen_bits_are_rejected");
        let path = folder.join("deep.png");
        let mut encoder = png::Encoder::new(File::create(&path).unwrap(), 1, 1);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_image_data(&[1, 2]).unwrap();
        let error = Picture::load(&path).unwrap_err();
        assert!(error.to_string().contains("8-bit picture is wanted"), "{error}");
    }

    #[test]
    fn pixels_outside_the_picture_do_not_exist() {
        let mut picture = Picture::filled(2, 3, Channels::Grey, &[7]);
        assert!(picture.pixel_mut(1, 2).is_some());
        assert!(picture.pixel_mut(2, 0).is_none());
        assert!(picture.pixel_mut(0, 3).is_none());
    }
}
