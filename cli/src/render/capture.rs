//! `--capture` and `--capture-all`: the textures and buffers that are captured, and the files for them.

use std::path::{Path, PathBuf};

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::{self, Capture, CaptureDocument, Wanted};
use umbragraph::low_level::pipeline::ResourceKind;
use umbragraph::low_level::sheet::{Content, Sheet, is_volume, sheet};

use super::buffer::BufferCapture;
use super::files::{self, Compression, Format};

/// The value of one `--capture`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CaptureArgument {
    reference: String,
    mip: u32,
    layer: Option<u32>,
    /// The face of a cube map, from 0 (+X) to 5 (−Z); `None` if no face is given.
    face: Option<u32>,
    file: PathBuf,
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
        let (what, file) =
            text.split_once('=').ok_or("a capture is RESOURCE[@PASS][:MIP,LAYER,FACE]=FILE")?;
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
    fn of_buffer(&self, plan: &Plan) -> Result<Option<(Contents, Format)>, Diagnostic> {
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
        Ok(BufferCapture::new(plan, &self.reference).map(|buffer| (Contents::Buffer(buffer), format)))
    }

    /// Returns the capture of a texture, and the format of its file.
    ///
    /// # Errors
    /// The face of a texture that is no cube, or a file of another kind.
    fn of_texture(&self, plan: &Plan) -> Result<Option<(Contents, Format)>, Diagnostic> {
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

/// What is known of a captured resource before it is read back.
#[derive(Clone, Debug)]
enum Contents {
    Texture {
        content: Content,
        layer: Option<u32>,
        /// Whether only the middle slice is shown.
        is_volume: bool,
    },
    Buffer(BufferCapture),
}

/// The captured contents of a resource, read back from the device.
pub(super) enum Captured {
    Texels {
        texels: Texels,
        /// The number of samples a texel, of which the first was read.
        samples: u32,
    },
    Bytes(Vec<u8>),
}

/// A resource to capture, and the file for it.
#[derive(Clone, Debug)]
pub(super) struct CaptureFile {
    pub(super) capture: Capture,
    contents: Contents,
    /// The file to write; `None` for the report page.
    file: Option<PathBuf>,
    format: Format,
}

/// Returns the captures of a plan, and the document that adds them to its pipeline. `all` is the folder for files of
/// every texture and buffer; `is_reported` adds the captures of the report page.
///
/// # Errors
/// Resources that do not exist or cannot be captured, and files that cannot be written: all of them at once.
pub(super) fn captures(
    plan: &Plan,
    arguments: &[CaptureArgument],
    all: Option<&Path>,
    is_reported: bool,
) -> Result<(Vec<CaptureFile>, CaptureDocument), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let mut captures = Vec::new();
    for argument in arguments {
        let found = match kind(plan, base(&argument.reference)) {
            Some(ResourceKind::Buffer(_)) => argument.of_buffer(plan),
            _ => argument.of_texture(plan),
        };
        match found {
            // The check of names below says why.
            Ok(None) => {}
            Ok(Some((contents, format))) => {
                let capture = Capture { reference: argument.reference.clone(), mip: argument.mip };
                captures.push(CaptureFile { capture, contents, file: Some(argument.file.clone()), format });
            }
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    // Errors in names are listed as well if a file cannot be written.
    let named = arguments.iter().map(|one| Capture { reference: one.reference.clone(), mip: one.mip });
    if let Err(others) = capture::document(plan, &named.collect::<Vec<_>>(), Wanted::PicturesAndBuffers) {
        diagnostics.extend(others);
    }
    if let Some(folder) = all {
        // It is made when there is something to write.
        if let Some(file) = folder.ancestors().find(|path| path.exists()).filter(|path| !path.is_dir()) {
            let reason = format!("\"{}\" is a file", file.display());
            diagnostics.push(crate::replace::unwritable(folder, &reason).help("name another folder"));
        }
        for (name, resource) in &plan.resources {
            let is_single = resource.size.is_none_or(|size| size.samples == 1);
            let Some(mut capture) =
                contents_of(plan, name, name).filter(|_| is_single && !is_volume(plan, name))
            else {
                continue;
            };
            let extension = if matches!(capture.format, Format::Json) { "json" } else { "png" };
            capture.file = Some(folder.join(format!("{}.{extension}", name.replace('@', "_at_"))));
            captures.push(capture);
        }
    }
    if is_reported {
        captures.extend(versions(plan));
    }
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    let asked: Vec<Capture> = captures.iter().map(|one| one.capture.clone()).collect();
    Ok((captures, capture::document(plan, &asked, Wanted::All)?))
}

/// Returns a capture of every texture and buffer after each pass that writes it.
fn versions(plan: &Plan) -> Vec<CaptureFile> {
    let mut captures = Vec::new();
    for (name, resource) in plan.resources.iter().filter(|(name, _)| !name.contains('@')) {
        let writers = plan.passes.iter().filter(|pass| plan.writes(pass.handle, resource.handle));
        captures.extend(writers.filter_map(|pass| contents_of(plan, name, &format!("{name}@{}", pass.name))));
    }
    captures
}

/// Returns the capture of a texture or buffer for the report page; `None` for other resources.
fn contents_of(plan: &Plan, name: &str, reference: &str) -> Option<CaptureFile> {
    let (contents, format) = match kind(plan, name)? {
        ResourceKind::Texture(_) => {
            let (content, is_volume) = (Content::of(plan, name)?, is_volume(plan, name));
            (Contents::Texture { content, layer: None, is_volume }, Format::Png)
        }
        ResourceKind::Buffer(_) => (Contents::Buffer(BufferCapture::new(plan, reference)?), Format::Json),
        _ => return None,
    };
    let capture = Capture { reference: reference.to_owned(), mip: 0 };
    Some(CaptureFile { capture, contents, file: None, format })
}

fn kind<'p>(plan: &'p Plan, name: &str) -> Option<&'p ResourceKind> {
    let handle = plan.resources.get(name).map(|one| one.handle).or_else(|| plan.pipeline.find_resource(name));
    Some(&plan.pipeline.resource(handle?).kind)
}

/// Returns the name of a resource without its `@PASS` suffix.
pub(super) fn base(reference: &str) -> &str {
    reference.split('@').next().unwrap_or(reference)
}

impl CaptureFile {
    /// Returns `true` if the capture is for the report page.
    pub(super) fn is_reported(&self) -> bool {
        self.file.is_none()
    }

    /// Returns the sheet of captured texels, with a remark about what it leaves out, if anything.
    ///
    /// # Errors
    /// A layer that does not exist.
    pub(super) fn sheet(
        &self,
        texels: &Texels,
        samples: u32,
    ) -> Result<(Sheet, Content, String), Diagnostic> {
        let Contents::Texture { content, layer, is_volume } = self.contents else {
            let message = format!("\"{}\" is no texture", self.capture.reference);
            return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message));
        };
        if let Some(layer) = layer.filter(|layer| *layer >= texels.layers) {
            let message = format!("\"{}\" has no layer {layer}", self.capture.reference);
            let help = format!("its layers are 0 to {}", texels.layers - 1);
            return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help));
        }
        let shown = if is_volume { Some(texels.layers / 2) } else { layer };
        let remark = match texels.layers {
            layers if is_volume => format!("slice {} of {layers}", layers / 2),
            _ if samples > 1 => format!("sample 0 of {samples}"),
            6 if content.is_cube => "faces +x, -x, +y, -y, +z, -z".to_owned(),
            layers if layers > 1 => format!("{layers} layers"),
            _ => String::new(),
        };
        Ok((sheet(texels, content, shown), content, remark))
    }

    /// Returns the captured buffer; `None` for a texture.
    pub(super) fn buffer(&self) -> Option<&BufferCapture> {
        match &self.contents {
            Contents::Buffer(buffer) => Some(buffer),
            Contents::Texture { .. } => None,
        }
    }

    /// Writes the captured contents to the file, and returns a description of them. `overwritten` names the pass that
    /// later overwrites the contents, if any.
    ///
    /// # Errors
    /// A layer that does not exist, a buffer that is no table, or a file that cannot be written.
    pub(super) fn write(
        &self,
        captured: &Captured,
        compression: Compression,
        overwritten: Option<&str>,
    ) -> Result<String, Diagnostic> {
        let Some(file) = &self.file else { return Ok(String::new()) };
        let about = match (captured, &self.contents) {
            (Captured::Bytes(bytes), Contents::Buffer(buffer)) => {
                buffer.write(file, self.format == Format::Csv, bytes)?
            }
            (Captured::Bytes(_), Contents::Texture { .. }) => String::new(),
            (Captured::Texels { texels, samples }, _) => {
                let (sheet, content, _) = self.sheet(texels, *samples)?;
                self.write_sheet(file, &sheet, content, compression, texels)?
            }
        };
        let (file, reference) = (file.display(), &self.capture.reference);
        let before = overwritten.map(|pass| format!(", before \"{pass}\" overwrites it")).unwrap_or_default();
        Ok(format!("{file}: {reference}, {about}{before}\n"))
    }

    fn write_sheet(
        &self,
        file: &Path,
        sheet: &Sheet,
        content: Content,
        compression: Compression,
        texels: &Texels,
    ) -> Result<String, Diagnostic> {
        let ranges = sheet.ranges(content);
        match self.format {
            Format::Exr => files::write_exr(file, sheet, content.is_depth)?,
            _ => {
                let rgba = sheet.rgba(content, &ranges);
                files::write_png(file, [sheet.width, sheet.height], &rgba, compression)?;
            }
        }
        let shown: Vec<String> = ["red", "green", "blue", "alpha"]
            .iter()
            .zip(&ranges)
            .map(|(name, range)| {
                let name = if ranges.len() == 1 { "range" } else { name };
                format!("{name} {} to {}", range.min, range.max)
            })
            .collect();
        let layers = if texels.layers > 1 { format!(", {} layers", texels.layers) } else { String::new() };
        let ranges = if shown.is_empty() { String::new() } else { format!(", {}", shown.join(", ")) };
        Ok(format!("{} by {}{layers}{ranges}", texels.width, texels.height))
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
