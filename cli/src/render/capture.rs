//! `--capture` and `--capture-all`: the textures that are captured, and the files for them.

use std::path::{Path, PathBuf};

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::{self, Capture, CaptureDocument};
use umbragraph::low_level::sheet::{Content, is_volume, sheet};

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
}

/// A texture to capture, and the file for it.
#[derive(Clone, Debug)]
pub(super) struct CaptureFile {
    pub(super) capture: Capture,
    layer: Option<u32>,
    content: Content,
    /// The file to write; `None` for pictures on the report page.
    file: Option<PathBuf>,
    format: Format,
}

/// Returns the captures of a plan, and the document that adds them to its pipeline. `all` is the folder for pictures of
/// every texture; `is_reported` adds the pictures of the report page.
///
/// # Errors
/// Resources that do not exist or cannot be shown as a picture, and files that cannot be written: all of them at once.
pub(super) fn captures(
    plan: &Plan,
    arguments: &[CaptureArgument],
    all: Option<&Path>,
    is_reported: bool,
) -> Result<(Vec<CaptureFile>, CaptureDocument), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let mut captures = Vec::new();
    let formats = [(".png", Format::Png), (".exr", Format::Exr)];
    for argument in arguments {
        let format = files::check("--capture", &argument.file, &formats).unwrap_or_else(|diagnostic| {
            diagnostics.push(diagnostic);
            Format::Png
        });
        let capture = Capture { reference: argument.reference.clone(), mip: argument.mip };
        let name = argument.reference.split('@').next().unwrap_or_default();
        let content =
            Content::of(plan, &argument.reference).or_else(|| Content::of(plan, name)).unwrap_or_default();
        let layer = match (argument.layer, argument.face) {
            (layer, None) => layer,
            (cube, Some(face)) if content.is_cube => {
                Some(cube.unwrap_or(0).saturating_mul(6).saturating_add(face))
            }
            (_, Some(_)) => {
                let message = format!("\"{name}\" is no cube, so it has no faces");
                diagnostics
                    .push(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help("name a layer"));
                continue;
            }
        };
        captures.push(CaptureFile { capture, layer, content, file: Some(argument.file.clone()), format });
    }
    if let Some(folder) = all {
        // It is made when there is something to write.
        if let Some(file) = folder.ancestors().find(|path| path.exists()).filter(|path| !path.is_dir()) {
            let reason = format!("\"{}\" is a file", file.display());
            diagnostics.push(crate::replace::unwritable(folder, &reason).help("name another folder"));
        }
        for (name, resource) in &plan.resources {
            let has_picture = resource.size.is_some_and(|size| size.samples == 1);
            let Some(content) = Content::of(plan, name).filter(|_| has_picture && !is_volume(plan, name))
            else {
                continue;
            };
            let capture = Capture { reference: name.clone(), mip: 0 };
            let file = folder.join(format!("{}.png", name.replace('@', "_at_")));
            captures.push(CaptureFile {
                capture,
                layer: None,
                content,
                file: Some(file),
                format: Format::Png,
            });
        }
    }
    if is_reported {
        captures.extend(versions(plan));
    }
    let asked: Vec<Capture> = captures.iter().map(|one| one.capture.clone()).collect();
    match capture::document(plan, &asked) {
        Ok(document) if !diagnostics.has_errors() => Ok((captures, document)),
        Ok(_) => Err(diagnostics),
        Err(others) => {
            diagnostics.extend(others);
            Err(diagnostics)
        }
    }
}

/// Returns a capture of every single-sampled, non-volume texture after each pass that writes it.
fn versions(plan: &Plan) -> Vec<CaptureFile> {
    let mut captures = Vec::new();
    for (name, resource) in &plan.resources {
        let has_picture = resource.size.is_some_and(|size| size.samples == 1) && !name.contains('@');
        let Some(content) = Content::of(plan, name).filter(|_| has_picture && !is_volume(plan, name)) else {
            continue;
        };
        let writers = plan.passes.iter().filter(|pass| plan.writes(pass.handle, resource.handle));
        let references = writers.map(|pass| format!("{name}@{}", pass.name));
        captures.extend(references.map(|reference| {
            let capture = Capture { reference, mip: 0 };
            CaptureFile { capture, layer: None, content, file: None, format: Format::Png }
        }));
    }
    captures
}

impl CaptureFile {
    /// Returns `true` if the capture is a picture on the report page.
    pub(super) fn is_reported(&self) -> bool {
        self.file.is_none()
    }

    /// Returns the size in pixels and the RGBA bytes of the picture.
    pub(super) fn picture(&self, texels: &Texels) -> ([u32; 2], Vec<u8>) {
        let sheet = sheet(texels, self.content, self.layer);
        let ranges = sheet.ranges(self.content);
        ([sheet.width, sheet.height], sheet.rgba(self.content, &ranges))
    }

    /// Writes the captured texels to the file, and returns a description of them. `overwritten` names the pass that
    /// later overwrites the contents, if any.
    ///
    /// # Errors
    /// A layer that does not exist, or a file that cannot be written.
    pub(super) fn write(
        &self,
        texels: &Texels,
        compression: Compression,
        overwritten: Option<&str>,
    ) -> Result<String, Diagnostic> {
        let Some(file) = &self.file else { return Ok(String::new()) };
        if let Some(layer) = self.layer.filter(|layer| *layer >= texels.layers) {
            let message = format!("\"{}\" has no layer {layer}", self.capture.reference);
            let help = format!("its layers are 0 to {}", texels.layers - 1);
            return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help));
        }
        let sheet = sheet(texels, self.content, self.layer);
        let ranges = sheet.ranges(self.content);
        match self.format {
            Format::Exr => files::write_exr(file, &sheet, self.content.is_depth)?,
            _ => {
                let rgba = sheet.rgba(self.content, &ranges);
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
        let (file, reference) = (file.display(), &self.capture.reference);
        let before = overwritten.map(|pass| format!(", before \"{pass}\" overwrites it")).unwrap_or_default();
        Ok(format!("{file}: {reference}, {} by {}{layers}{ranges}{before}\n", texels.width, texels.height))
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
