//! The value of `--capture`: a resource, a part of it and a file.

use std::path::PathBuf;

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Place, codes, list_of};
use umbragraph::low_level::sheet::Content;

use super::buffer::BufferCapture;
use super::{Contents, base};
use crate::render::files::{self, Format};

/// The value of one `--capture`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CaptureArgument {
    pub(super) reference: String,
    pub(super) mip: u32,
    layer: Option<u32>,
    /// The face of a cube map, from 0 (+X) to 5 (−Z); `None` if no face is given.
    face: Option<u32>,
    pub(super) file: PathBuf,
}

/// The formats of the files that a texture, and a buffer, can be written to.
const OF_TEXTURES: [(&str, Format); 2] = [(".png", Format::Png), (".exr", Format::Exr)];
const OF_BUFFERS: [(&str, Format); 2] = [(".json", Format::Json), (".csv", Format::Csv)];

const FACES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

impl CaptureArgument {
    /// Parses `RESOURCE[@PASS][:MIP[,LAYER][,FACE]]=FILE`, the value of `--capture`.
    ///
    /// # Errors
    /// A message that describes the invalid part.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (what, file) = text.split_once('=').ok_or_else(|| {
            format!("a capture is RESOURCE[@PASS][:MIP,LAYER,FACE]=FILE, such as {text}=capture.png")
        })?;
        if file.is_empty() {
            return Err("the file is missing behind \"=\"".to_owned());
        }
        let (reference, part) = what.split_once(':').unwrap_or((what, ""));
        let mut capture =
            Self { reference: reference.to_owned(), mip: 0, layer: None, face: None, file: file.into() };
        let mut numbers = 0;
        for word in part.split(',').filter(|word| !word.is_empty()) {
            if let Some(face) = FACES.iter().position(|face| *face == word) {
                capture.face = Some(face as u32);
                continue;
            }
            let number: u32 = word.parse().map_err(|_| {
                format!("\"{word}\" is no mip level, layer or face; faces are {}", list_of(FACES))
            })?;
            match numbers {
                0 => capture.mip = number,
                1 => capture.layer = Some(number),
                _ => return Err("behind \":\" stand a mip level, a layer and a face".to_owned()),
            }
            numbers += 1;
        }
        if capture.mip > 31 {
            return Err(format!("no texture has a mip level {}", capture.mip));
        }
        Ok(capture)
    }

    /// Returns the capture of a buffer, and the format of its file; `None` if no live pass uses the buffer.
    ///
    /// # Errors
    /// A part of a texture, or the file of a picture.
    pub(super) fn of_buffer(&self, plan: &Plan) -> Result<Option<(Contents, Format)>, Diagnostic> {
        let name = base(&self.reference);
        let wrong = |message: String, help: &str| {
            Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help))
        };
        if self.mip > 0 || self.layer.is_some() || self.face.is_some() {
            let message = format!("\"{name}\" is a buffer, which has no mip levels, layers or faces");
            return wrong(message, "leave out what stands behind \":\"");
        }
        if Format::of(&self.file).is_some_and(|format| OF_TEXTURES.iter().any(|(_, one)| *one == format)) {
            let message = format!("\"{name}\" is a buffer, of which there is no picture");
            return wrong(message, "write a file that ends in .json or .csv");
        }
        let format = files::check("--capture", &self.file, &OF_BUFFERS)?;
        let Some(buffer) = BufferCapture::new(plan, &self.reference) else { return Ok(None) };
        if format == Format::Csv {
            buffer.ensure_table()?;
        }
        Ok(Some((Contents::Buffer(buffer), format)))
    }

    /// Returns the capture of a texture, and the format of its file.
    ///
    /// # Errors
    /// The face of a texture that is no cube, or a file of another kind.
    pub(super) fn of_texture(&self, plan: &Plan) -> Result<Option<(Contents, Format)>, Diagnostic> {
        let format = files::check("--capture", &self.file, &OF_TEXTURES)?;
        let name = base(&self.reference);
        let content =
            Content::of(plan, &self.reference).or_else(|| Content::of(plan, name)).unwrap_or_default();
        let layer = match (self.layer, self.face) {
            (layer, None) => layer,
            (cube, Some(face)) if content.is_cube => {
                Some(cube.unwrap_or(0).saturating_mul(6).saturating_add(face))
            }
            (_, Some(_)) => {
                let message = format!("\"{name}\" is no cube, so it has no faces");
                return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help("name a layer"));
            }
        };
        Ok(Some((Contents::Texture { content, layer, is_volume: false }, format)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capture_is_a_resource_a_version_a_part_and_a_file() {
        let parsed = CaptureArgument::parse("cubes@points:1,2,-y=a=b.png").unwrap();
        assert_eq!((parsed.reference.as_str(), parsed.mip, parsed.layer), ("cubes@points", 1, Some(2)));
        assert_eq!((parsed.face, parsed.file), (Some(3), PathBuf::from("a=b.png")));
        let parsed = CaptureArgument::parse("maps=x.exr").unwrap();
        assert_eq!((parsed.mip, parsed.layer, parsed.face), (0, None, None));
        for wrong in ["maps", "maps=", "maps:up=x.png", "maps:1,2,3=x.png", "maps:99=x.png"] {
            assert!(CaptureArgument::parse(wrong).is_err(), "{wrong}");
        }
    }
}
