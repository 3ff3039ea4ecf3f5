//! Pictures to files: PNG, EXR, APNG and GIF, by the extension. The formats of captured buffers are checked here, too.
//!
//! A file is there whole or not at all: it is written under another name and renamed when it is finished.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufWriter, Cursor, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage as _,
};
use smallvec::SmallVec;
use umbragraph::diagnostic::{Diagnostic, Place, codes, list_of};
use umbragraph::low_level::sheet::Sheet;

use crate::replace::{Unfinished, create, replace, unwritable};

/// The format of a file with a picture, or with the contents of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Png,
    Exr,
    Apng,
    Gif,
    Json,
    Csv,
}

impl Format {
    /// Returns the format that the extension of a path names; `None` if the extension is unknown.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(Self::Png),
            "exr" => Some(Self::Exr),
            "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            "json" => Some(Self::Json),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// Checks that a file's format can be written and that its folder exists. Returns the format.
///
/// # Errors
/// A diagnostic that names the option.
pub(crate) fn check(option: &str, path: &Path, formats: &[(&str, Format)]) -> Result<Format, Diagnostic> {
    let place = |message: String| Diagnostic::error(codes::PICTURE, Place::Nowhere, message);
    let names: Vec<&str> = formats.iter().map(|(name, _)| *name).collect();
    // A device, such as /dev/null, has no extension.
    if std::fs::metadata(path).is_ok_and(|known| !known.is_file() && !known.is_dir()) {
        return Ok(Format::Png);
    }
    let format =
        Format::of(path).filter(|format| formats.iter().any(|(_, one)| one == format)).ok_or_else(|| {
            place(format!(
                "{option}: the extension of \"{}\" names no format that can be written here",
                path.display()
            ))
            .help(format!("write a file that ends in {}", list_of(names)))
        })?;
    check_folder(path)?;
    Ok(format)
}

/// Checks that the folder of an output file exists, before work is done for the file.
///
/// # Errors
/// The folder does not exist.
pub(crate) fn check_folder(path: &Path) -> Result<(), Diagnostic> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        Some(folder) => {
            let diagnostic =
                unwritable(path, &format_args!("the folder \"{}\" does not exist", folder.display()));
            Err(diagnostic.help("make the folder first"))
        }
        None => Ok(()),
    }
}

/// The compression effort for PNG files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Compression {
    pub(crate) fast: bool,
}

fn png_encoder<'a, W: Write>(
    to: W,
    [width, height]: [u32; 2],
    compression: Compression,
) -> png::Encoder<'a, W> {
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let Compression { fast } = compression;
    encoder.set_compression(if fast { png::Compression::Fastest } else { png::Compression::Balanced });
    encoder
}

/// Writes 8-bit RGBA pixels to a PNG file.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write_png(
    path: &Path,
    [width, height]: [u32; 2],
    rgba: &[u8],
    compression: Compression,
) -> Result<(), Diagnostic> {
    let bytes = png_bytes([width, height], rgba, compression).map_err(|error| unwritable(path, &error))?;
    replace(path, &bytes)
}

/// Encodes 8-bit RGBA pixels as a PNG file in memory.
pub(super) fn png_bytes(
    size: [u32; 2],
    rgba: &[u8],
    compression: Compression,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut writer = png_encoder(&mut bytes, size, compression).write_header()?;
    writer.write_image_data(rgba)?;
    writer.finish()?;
    Ok(bytes)
}

/// Writes the unconverted numbers as an EXR of 32-bit floats. One channel is named `Y`, or `Z` for depth; several are
/// R, G, B and A.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write_exr(path: &Path, sheet: &Sheet, is_depth: bool) -> Result<(), Diagnostic> {
    let failed = |error: &dyn Display| unwritable(path, error);
    let names: &[&str] = match (sheet.channels, is_depth) {
        (1, true) => &["Z"],
        (1, false) => &["Y"],
        (channels, _) => &["R", "G", "B", "A"][..channels.min(4)],
    };
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = names
        .iter()
        .enumerate()
        .map(|(at, name)| {
            AnyChannel::new(*name, FlatSamples::F32(sheet.values.iter().map(|value| value[at]).collect()))
        })
        .collect();
    let size = (sheet.width as usize, sheet.height as usize);
    let layer =
        Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| failed(&error))?;
    replace(path, &bytes)
}

/// A writer of frames, into one animated file or into one file for each frame.
pub(super) enum Animation {
    /// A file for each frame; the frame's number replaces the `#`s in the path.
    Numbered {
        path: PathBuf,
        size: [u32; 2],
        compression: Compression,
    },
    Apng {
        file: Unfinished,
        writer: png::Writer<BufWriter<File>>,
    },
    Gif {
        file: Unfinished,
        encoder: Box<gif::Encoder<BufWriter<File>>>,
        size: [u16; 2],
        delay: u16,
    },
}

impl Animation {
    /// Begins to write frames of one size. `rate` is the number of frames per second.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn begin(
        path: &Path,
        format: Format,
        size: [u32; 2],
        frames: u32,
        rate: f64,
        compression: Compression,
    ) -> Result<Self, Diagnostic> {
        let failed = |error: &dyn Display| unwritable(path, error);
        match format {
            Format::Apng => {
                let (file, writer) = create(path)?;
                let mut encoder = png_encoder(BufWriter::new(writer), size, compression);
                encoder.set_animated(frames, 0).map_err(|error| failed(&error))?;
                let milliseconds = (1000.0 / rate).round().clamp(1.0, 65535.0) as u16;
                encoder.set_frame_delay(milliseconds, 1000).map_err(|error| failed(&error))?;
                let writer = encoder.write_header().map_err(|error| failed(&error))?;
                Ok(Self::Apng { file, writer })
            }
            Format::Gif => {
                let [Ok(width), Ok(height)] = size.map(u16::try_from) else {
                    return Err(failed(&"a GIF has at most 65535 pixels on a side"));
                };
                let (file, writer) = create(path)?;
                let mut encoder = gif::Encoder::new(BufWriter::new(writer), width, height, &[])
                    .map_err(|error| failed(&error))?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(|error| failed(&error))?;
                // A GIF counts in hundredths of a second.
                let delay = (100.0 / rate).round().clamp(1.0, 65535.0) as u16;
                Ok(Self::Gif { file, encoder: Box::new(encoder), size: [width, height], delay })
            }
            Format::Png | Format::Exr | Format::Json | Format::Csv => {
                Ok(Self::Numbered { path: path.to_owned(), size, compression })
            }
        }
    }

    /// Adds a frame of 8-bit RGBA pixels. `at` is the number of the frame, from 0.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn frame(&mut self, at: u32, rgba: &mut [u8]) -> Result<(), Diagnostic> {
        match self {
            Self::Numbered { path, size, compression } => {
                write_png(&numbered(path, at), *size, rgba, *compression)
            }
            Self::Apng { file, writer } => {
                writer.write_image_data(rgba).map_err(|error| unwritable(file.path(), &error))
            }
            Self::Gif { file, encoder, size: [width, height], delay } => {
                let mut frame = gif::Frame::from_rgba_speed(*width, *height, rgba, 10);
                frame.delay = *delay;
                encoder.write_frame(&frame).map_err(|error| unwritable(file.path(), &error))
            }
        }
    }

    /// Completes and closes the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn finish(self) -> Result<(), Diagnostic> {
        match self {
            Self::Numbered { .. } => Ok(()),
            Self::Apng { file, writer } => {
                writer.finish().map_err(|error| unwritable(file.path(), &error))?;
                file.finish()
            }
            Self::Gif { file, encoder, .. } => {
                let mut writer = encoder.into_inner().map_err(|error| unwritable(file.path(), &error))?;
                writer.flush().map_err(|error| unwritable(file.path(), &error))?;
                file.finish()
            }
        }
    }
}

/// Returns the path of a frame's file: the frame's number replaces the last run of `#` in the name.
pub(super) fn numbered(path: &Path, at: u32) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let Some(end) = name.rfind('#').map(|last| last + 1) else { return path.to_owned() };
    let digits = name[..end].chars().rev().take_while(|one| *one == '#').count();
    path.with_file_name(format!("{}{at:0digits$}{}", &name[..end - digits], &name[end..]))
}

/// Returns `true` if the file name contains a `#` for the frame's number.
pub(super) fn is_numbered(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
}

#[cfg(test)]
mod tests {
    use umbragraph_test_support::scratch::ScratchFolder;

    use super::*;

    #[test]
    fn the_last_run_of_number_signs_is_the_number() {
        assert_eq!(numbered(Path::new("a#/b-####.png"), 7), Path::new("a#/b-0007.png"));
        assert_eq!(numbered(Path::new("#.png"), 1234), Path::new("1234.png"));
        assert!(is_numbered(Path::new("x/##.png")) && !is_numbered(Path::new("##/x.png")));
    }

    #[test]
    fn an_animation_that_is_given_up_leaves_nothing() {
        let folder = ScratchFolder::new("render-unfinished");
        for (name, format) in [("x.gif", Format::Gif), ("x.apng", Format::Apng)] {
            let path = folder.join(name);
            let compression = Compression { fast: true };
            let mut animation = Animation::begin(&path, format, [2, 2], 2, 10.0, compression).unwrap();
            animation.frame(0, &mut [128; 16]).unwrap();
            drop(animation);
            assert_eq!(std::fs::read_dir(folder.join("")).unwrap().count(), 0, "{name}");
            let mut animation = Animation::begin(&path, format, [2, 2], 2, 10.0, compression).unwrap();
            for at in 0..2 {
                animation.frame(at, &mut [128; 16]).unwrap();
            }
            animation.finish().unwrap();
            assert!(path.is_file(), "{name}");
            std::fs::remove_file(&path).unwrap();
        }
    }
}
