//! `--capture` and `--capture-all`: the textures and buffers that are captured, and the files for them.

mod argument;
mod buffer;

use std::path::{Path, PathBuf};

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::{self, Capture, CaptureDocument, Wanted};
use umbragraph::low_level::pipeline::ResourceKind;
use umbragraph::low_level::sheet::{Content, Sheet, is_volume, sheet};

pub(crate) use self::argument::CaptureArgument;
use self::buffer::BufferCapture;
pub(super) use self::buffer::Preview;
use super::files::{self, Compression, Format};

/// The kind of a captured resource, with what is needed to write it.
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
pub(crate) enum Captured {
    Texels {
        texels: Texels,
        /// The number of samples of each texel. The texels are those of the first sample.
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
    /// Whether the command line names the resource, so that it must be captured.
    is_named: bool,
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
            Some(_) => argument.of_texture(plan),
            // The check of names below says what there is.
            None => Ok(None),
        };
        match found {
            Ok(None) => {}
            Ok(Some((contents, format))) => {
                let capture = Capture { reference: argument.reference.clone(), mip: argument.mip };
                let file = Some(argument.file.clone());
                captures.push(CaptureFile { capture, contents, file, format, is_named: true });
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
    let document = document(plan, &captures)?;
    Ok((captures, document))
}

fn document(plan: &Plan, captures: &[CaptureFile]) -> Result<CaptureDocument, Diagnostics> {
    let asked: Vec<Capture> = captures.iter().map(|one| one.capture.clone()).collect();
    capture::document(plan, &asked, Wanted::All)
}

/// A capture that the pipeline does not allow, and the reason.
pub(super) struct LeftOut {
    pub(super) capture: CaptureFile,
    pub(super) reason: String,
}

/// Removes captures for which `reason` returns a reason, and returns them. Captures that the command line names stay.
/// `reason` gets the name of the pass that copies. `document` is made anew from the captures that stay.
///
/// # Errors
/// As of [`captures`].
pub(super) fn leave_out(
    plan: &Plan,
    captures: &mut Vec<CaptureFile>,
    document: &mut CaptureDocument,
    reason: impl Fn(&CaptureFile, &str) -> Option<String>,
) -> Result<Vec<LeftOut>, Diagnostics> {
    let mut left_out = Vec::new();
    let mut kept = Vec::new();
    for (capture, import) in captures.drain(..).zip(&document.imports) {
        let copy = format!("{}.copy", import.trim_end_matches(".contents"));
        match reason(&capture, &copy).filter(|_| !capture.is_named) {
            Some(reason) => left_out.push(LeftOut { capture, reason }),
            None => kept.push(capture),
        }
    }
    *captures = kept;
    *document = self::document(plan, captures)?;
    Ok(left_out)
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
    Some(CaptureFile { capture, contents, file: None, format, is_named: false })
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
    /// Returns `true` if the captured texture has several samples a texel.
    pub(super) fn has_samples(&self, plan: &Plan) -> bool {
        let resource = plan.resources.get(base(&self.capture.reference));
        resource.and_then(|resource| resource.size).is_some_and(|size| size.samples > 1)
    }

    /// Returns the line about a capture that is left out.
    pub(super) fn left_out(&self, reason: &str) -> String {
        let file = self.file.as_ref().map_or_else(String::new, |file| format!("{}: ", file.display()));
        format!("{file}{} is left out: {reason}\n", self.capture.reference)
    }

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
