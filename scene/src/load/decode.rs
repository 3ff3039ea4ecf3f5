//! PNG and JPEG files as 8-bit RGBA.
//!
//! The first bytes identify the format. The header's size is checked before any texel is decoded. 16-bit channels keep
//! their upper byte, palettes are looked up, and grey becomes three equal channels; embedded color profiles are
//! ignored, as glTF demands.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use thiserror::Error;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::jpeg::without_metadata;

/// The error for an image that cannot be decoded.
#[derive(Debug, Error)]
pub(super) enum DecodeError {
    #[error("its first bytes are those of neither PNG nor JPEG")]
    Format,
    #[error(transparent)]
    Png(#[from] png::DecodingError),
    #[error(transparent)]
    Jpeg(#[from] zune_jpeg::errors::DecodeErrors),
    #[error("a JPEG of {0} channels is neither grey nor RGB, YCbCr or CMYK")]
    Channels(u8),
    /// The JPEG decoder panicked.
    #[error("the JPEG decoder failed")]
    Panic,
}

/// An encoded PNG or JPEG image whose header has been read.
pub(super) enum Encoded<'a> {
    Png(Box<png::Reader<Cursor<&'a [u8]>>>),
    Jpeg(Box<zune_jpeg::JpegDecoder<ZCursor<Vec<u8>>>>),
}

impl<'a> Encoded<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, DecodeError> {
        if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            let mut decoder = png::Decoder::new(Cursor::new(bytes));
            decoder.set_transformations(png::Transformations::normalize_to_color8());
            decoder.set_ignore_text_chunk(true);
            decoder.set_ignore_iccp_chunk(true);
            return Ok(Self::Png(Box::new(decoder.read_info()?)));
        }
        if bytes.starts_with(b"\xff\xd8\xff") {
            let options = DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX);
            let options = options.set_strict_mode(false);
            let bytes = ZCursor::new(without_metadata(bytes));
            let mut decoder = zune_jpeg::JpegDecoder::new_with_options(bytes, options);
            guarded(|| decoder.decode_headers())?;
            let colors = match (decoder.info().unwrap_or_default().components, decoder.input_colorspace()) {
                (1, Some(ColorSpace::Luma)) => ColorSpace::Luma,
                (3 | 4, _) => ColorSpace::RGB,
                (channels, _) => return Err(DecodeError::Channels(channels)),
            };
            decoder.set_options(options.jpeg_set_out_colorspace(colors));
            return Ok(Self::Jpeg(Box::new(decoder)));
        }
        Err(DecodeError::Format)
    }

    /// The width and height of the image, in texels.
    pub(super) fn size(&self) -> (u32, u32) {
        match self {
            Self::Png(reader) => reader.info().size(),
            Self::Jpeg(decoder) => {
                let info = decoder.info().unwrap_or_default();
                (info.width.into(), info.height.into())
            }
        }
    }

    /// Decodes the texels. Each texel has four bytes (RGBA); rows are stored from top to bottom.
    pub(super) fn rgba(self) -> Result<Vec<u8>, DecodeError> {
        let (texels, channels) = match self {
            Self::Png(mut reader) => {
                let mut texels = vec![0; reader.output_buffer_size().unwrap_or_default()];
                let info = reader.next_frame(&mut texels)?;
                texels.truncate(info.buffer_size());
                (texels, info.color_type.samples())
            }
            Self::Jpeg(mut decoder) => {
                let texels = guarded(|| decoder.decode())?;
                (texels, decoder.output_colorspace().map_or(3, |colors| colors.num_components()))
            }
        };
        Ok(match channels {
            1 => texels.iter().flat_map(|grey| [*grey, *grey, *grey, 255]).collect(),
            2 => texels.chunks_exact(2).flat_map(|one| [one[0], one[0], one[0], one[1]]).collect(),
            3 => texels.chunks_exact(3).flat_map(|one| [one[0], one[1], one[2], 255]).collect(),
            _ => texels,
        })
    }
}

/// Runs `decode`, which may panic on corrupt files, and converts a panic to [`DecodeError::Panic`].
fn guarded<T>(decode: impl FnOnce() -> Result<T, zune_jpeg::errors::DecodeErrors>) -> Result<T, DecodeError> {
    Ok(catch_unwind(AssertUnwindSafe(decode)).map_err(|_| DecodeError::Panic)??)
}
