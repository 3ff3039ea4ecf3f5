//! `--environment`: an equirectangular picture as the imported texture "environment" of a pipeline.
//!
//! The picture is brought to the texture's size on the CPU: each texel is the mean of those that it covers. What is not
//! a number becomes 0, and what 16 bits do not hold their greatest number. A pipeline with a toggle
//! "environment_changed" reads the texture in the first frame only.

mod radiance;

use std::path::Path;

pub(super) use self::radiance::Colors;
use crate::diagnostic::{Diagnostic, Place};
use crate::low_level::compose::{read_bytes, unreadable};
use crate::low_level::language::Lifetime;
use crate::{Plan, wgpu};
use exr::prelude::f16;

pub use super::codes::ENVIRONMENT;

/// The name of the imported texture.
pub const IMPORT: &str = "environment";
const TOGGLE: &str = "environment_changed";

/// The maximum size in bytes of a file.
const MAX_BYTES: u64 = 1 << 30;

/// The largest finite value of a 16-bit float.
const MAX: f32 = 65504.0;

/// An environment picture, and its state on the device. A clone shares no state with it.
#[derive(Clone)]
pub struct Environment {
    colors: Colors,
    /// The texture that contains the picture; `None` until it is written.
    written: Option<wgpu::Texture>,
    /// Set once a pass has read the texture.
    is_read: bool,
}

impl Environment {
    /// Loads the environment picture for a plan that imports one; `None` if neither a file is given nor the plan needs
    /// one.
    ///
    /// # Errors
    /// A file that cannot be read or is no .hdr or .exr. A file for a plan that imports no environment picture. A plan
    /// that needs such a picture, if no file is given.
    pub fn of(path: Option<&Path>, plan: &Plan) -> Result<Option<Self>, Diagnostic> {
        match path {
            None => missing(plan).map_or(Ok(None), Err),
            Some(path) => unread(path, plan).map_or_else(|| Self::read(path).map(Some), Err),
        }
    }

    /// Reads an environment picture.
    ///
    /// # Errors
    /// A file that cannot be read or is no .hdr or .exr.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        let name = path.display().to_string();
        let bytes = read_bytes(path, MAX_BYTES)
            .and_then(|bytes| bytes.ok_or_else(|| std::io::Error::other("it is larger than 1 GiB")))
            .map_err(|error| {
                unreadable(&name, &error).help("--environment names an equirectangular picture, .hdr or .exr")
            })?;
        let colors = decoded(&bytes).map_err(|error| {
            Diagnostic::in_file(ENVIRONMENT, name, "", format!("the picture cannot be read: {error}"))
                .help("--environment takes .hdr (Radiance) and .exr (OpenEXR)")
        })?;
        Ok(Self { colors, written: None, is_read: false })
    }

    /// The picture as a texture of `width` by `height` texels holds it: linear colors, rows from the top.
    pub fn texels(&self, width: usize, height: usize) -> Vec<[f32; 3]> {
        resized(&self.colors, width, height)
    }

    /// Writes the picture to the imported texture, unless the texture already contains it.
    pub fn bring<'a>(
        &mut self,
        queue: &wgpu::Queue,
        imports: impl IntoIterator<Item = (&'a str, &'a wgpu::Texture)>,
    ) {
        let texture = imports.into_iter().find(|(name, _)| *name == IMPORT).map(|(_, texture)| texture);
        let Some(texture) = texture.filter(|texture| self.written.as_ref() != Some(texture)) else { return };
        let (width, height) = (texture.width(), texture.height());
        let texels = resized(&self.colors, width as usize, height as usize);
        let bytes: Vec<u8> = texels
            .iter()
            .flat_map(|[red, green, blue]| [*red, *green, *blue, 1.0])
            .flat_map(|channel| f16::from_f32(channel).to_le_bytes())
            .collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * 8),
            rows_per_image: Some(height),
        };
        queue.write_texture(texture.as_image_copy(), &bytes, layout, texture.size());
        (self.written, self.is_read) = (Some(texture.clone()), false);
    }

    /// Returns the toggle `environment_changed` with the state "off from frame 0 on", once a frame has read the
    /// picture. `None` before, and if the plan has no such toggle.
    pub fn kept(&self, plan: &Plan) -> Option<(&'static str, (u32, bool))> {
        (self.is_read && plan.toggles.contains_key(TOGGLE)).then_some((TOGGLE, (0, false)))
    }

    /// Lets the next frame read the picture once more, for a plan that starts without the results of the one before.
    pub fn read_again(&mut self) {
        self.is_read = false;
    }

    /// Records that a frame was drawn.
    pub fn drawn(&mut self) {
        self.is_read = true;
    }
}

/// Returns `true` if a plan imports an environment picture.
pub fn is_read(plan: &Plan) -> bool {
    let resource = plan.resources.get(IMPORT).filter(|one| one.lifetime == Lifetime::Imported);
    resource.and_then(|one| one.format) == Some(wgpu::TextureFormat::Rgba16Float)
}

/// The error that a plan needs an environment picture, for a command line without one; `None` if it needs none.
fn missing(plan: &Plan) -> Option<Diagnostic> {
    let message = format!("the pipeline reads the picture \"{IMPORT}\", which is not given");
    let help = "add --environment FILE with a .hdr or .exr, or switch the feature \"environment\" off";
    (is_read(plan) && plan.toggles.contains_key(TOGGLE))
        .then(|| Diagnostic::error(ENVIRONMENT, Place::Nowhere, message).help(help))
}

/// The error that a plan imports no environment picture, for a command line with one; `None` if it imports one.
pub fn unread(path: &Path, plan: &Plan) -> Option<Diagnostic> {
    let message = format!("the pipeline reads no imported texture \"{IMPORT}\" of the format rgba16float");
    let help = "pipelines/umbra.json has one, with the feature \"environment\"";
    (!is_read(plan))
        .then(|| Diagnostic::in_file(ENVIRONMENT, path.display().to_string(), "", message).help(help))
}

/// The first bytes of an OpenEXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Returns `true` if the first bytes are those of an OpenEXR or Radiance file.
pub(super) fn is_known(bytes: &[u8]) -> bool {
    bytes.starts_with(&EXR) || bytes.starts_with(b"#?")
}

/// Decodes a picture as OpenEXR or Radiance, by its first bytes.
pub(super) fn decoded(bytes: &[u8]) -> Result<Colors, String> {
    if bytes.starts_with(&EXR) { open_exr(bytes) } else { radiance::decode(bytes) }
}

/// Decodes the first layer of an OpenEXR file that has red, green and blue. Alpha is 1 where the file has none.
fn open_exr(bytes: &[u8]) -> Result<Colors, String> {
    use exr::prelude::*;
    // Memory is taken for the size that the header states.
    let header = exr::meta::MetaData::read_from_buffered(std::io::Cursor::new(bytes), false);
    let header = header.map_err(|error| error.to_string())?;
    let sizes = header.headers.iter().map(|header| header.layer_size);
    if let Some(Vec2(width, height)) = sizes.into_iter().find(|Vec2(x, y)| *x.max(y) > radiance::MAX_SIDE) {
        return Err(format!("its size is {width} × {height}, at most {} each", radiance::MAX_SIDE));
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size: Vec2<usize>, _: &RgbaChannels| (size.width(), vec![[0.0_f32; 4]; size.area()]),
            |(width, texels): &mut (usize, Vec<[f32; 4]>),
             at: Vec2<usize>,
             (red, green, blue, alpha): (f32, f32, f32, f32)| {
                texels[at.y() * *width + at.x()] = [red, green, blue, alpha];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let size = image.layer_data.size;
    Ok(Colors { width: size.width(), height: size.height(), texels: image.layer_data.channel_data.pixels.1 })
}

/// Resizes a picture. Each texel is the mean of the source texels that it covers, or, in an enlarged picture, the
/// source texel that contains it. NaN counts as 0, and channels are clamped to the range from 0 to 65504.
fn resized(colors: &Colors, width: usize, height: usize) -> Vec<[f32; 3]> {
    let span = |index: usize, count: usize, whole: usize| {
        let first = index * whole / count;
        first..((index + 1) * whole / count).max(first + 1)
    };
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        let rows = span(y, height, colors.height);
        for x in 0..width {
            let columns = span(x, width, colors.width);
            let mut sum = [0.0_f32; 3];
            for texel in rows.clone().flat_map(|row| &colors.texels[row * colors.width..][columns.clone()]) {
                // Without alpha.
                for (sum, channel) in sum.iter_mut().zip(texel) {
                    *sum += if channel.is_nan() { 0.0 } else { channel.clamp(0.0, MAX) };
                }
            }
            let count = (rows.len() * columns.len()) as f32;
            texels.push(sum.map(|channel| channel / count));
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use umbragraph_test_support::property;
    use umbragraph_test_support::random::Random;

    use super::*;

    #[test]
    fn resized_pictures_keep_their_mean_and_are_numbers() {
        let texels = vec![
            [1.0, f32::NAN, f32::INFINITY, 1.0],
            [3.0, 2.0, -1.0, 1.0],
            [5.0, 0.0, 0.0, 1.0],
            [7.0, 0.0, 0.0, 1.0],
        ];
        let colors = Colors { width: 4, height: 1, texels };
        assert_eq!(resized(&colors, 2, 1), [[2.0, 1.0, MAX / 2.0], [6.0, 0.0, 0.0]]);
        let larger = resized(&colors, 8, 2);
        assert_eq!((larger.len(), larger[1][0], larger[15][0]), (16, 1.0, 7.0));
    }

    /// Returns the bytes of an OpenEXR picture with a gradient.
    fn gradient(width: usize, height: usize) -> Vec<u8> {
        use exr::prelude::*;
        let image = Image::from_channels(
            (width, height),
            SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, 0.5_f32, 4.0_f32)),
        );
        let mut file = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut file).expect("a file");
        file.into_inner()
    }

    #[test]
    fn pictures_with_bytes_changed_are_numbers_or_errors() {
        let run = [2, 2, 0, 9, 137, 128, 137, 64, 9, 0, 1, 2, 3, 4, 5, 6, 7, 8, 137, 136];
        let radiance = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 9\n".as_slice(), &run].concat();
        let seeds = [gradient(9, 5), gradient(1, 1), radiance];
        let mut random = Random(property::seed());
        let (mut read, cases) = (0, 200 * property::times() as usize);
        for _ in 0..cases {
            let mut bytes = random.one_of(&seeds);
            for _ in 0..random.below(4) {
                let at = random.below(bytes.len());
                match random.below(4) {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes.insert(at, random.next() as u8),
                    2 => drop(bytes.remove(at)),
                    _ => bytes[at] = random.one_of(&[0, 1, 0x7f, 0x80, 0xff, random.clone().next() as u8]),
                }
                if bytes.is_empty() {
                    break;
                }
            }
            let Ok(colors) = decoded(&bytes) else { continue };
            read += 1;
            let texels = resized(&colors, 4, 2);
            assert!(
                texels.iter().flatten().all(|channel| channel.is_finite() && *channel >= 0.0),
                "{texels:?}"
            );
        }
        assert!(read * 10 > cases, "{read} of {cases} are pictures");
    }

    #[test]
    fn open_exr_pictures_are_read_and_broken_ones_are_not() {
        let bytes = gradient(2, 1);
        assert_eq!(open_exr(&bytes).expect("a picture").texels, [[0.0, 0.5, 4.0, 1.0], [1.0, 0.5, 4.0, 1.0]]);
        assert!(open_exr(&bytes[..bytes.len() / 2]).is_err());
        // A header of a few bytes that states terabytes.
        let mut huge = bytes;
        for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            let at = huge.windows(window.len()).position(|part| part == window).expect("a window");
            let ends = at + window.len() + 4 + 8;
            huge[ends..ends + 8].copy_from_slice(&[0xff, 0xff, 0xff, 0x1f, 0xff, 0xff, 0xff, 0x1f]);
        }
        let Err(error) = open_exr(&huge) else { panic!("it is too large") };
        assert!(error.contains("536870912") && error.contains("16384"), "{error}");
    }
}
