//! `--import NAME=FILE`: pictures as the imported textures that a pipeline only reads, such as a table of colors.
//!
//! A texture takes the texels of its file as they are stored. A format such as rgba8unorm-srgb tells the sampler that
//! they are sRGB-encoded, another format that they are not. The slices of a volume, the layers of an array and the
//! faces of a cube stand side by side in the file, or below one another.

mod cube;
mod picture;
mod texels;

use std::path::PathBuf;

use self::picture::Picture;
use self::texels::FORMATS;
use super::environment;
use super::files::{Stamp, stamp};
use crate::diagnostic::{Diagnostic, codes, list_of};
use crate::low_level::compiler::PlannedResource;
use crate::low_level::language::format_name;
use crate::{Plan, wgpu};

pub use super::codes::IMPORT_FILE;

/// The name of an imported texture, and the file with its picture: the value of `--import NAME=FILE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportArgument {
    /// The name of the resource.
    pub name: String,
    /// The path of the picture.
    pub path: PathBuf,
}

impl ImportArgument {
    /// Parses `NAME=FILE`.
    ///
    /// # Errors
    /// A message about a text that has no name or no file.
    pub fn parse(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').filter(|(name, path)| !name.is_empty() && !path.is_empty());
        let (name, path) = parts.ok_or("write NAME=FILE, such as palette=colors.png")?;
        Ok(Self { name: name.to_owned(), path: path.into() })
    }
}

/// A picture for an imported texture, and its state on the device.
#[derive(Clone)]
struct ImportFile {
    argument: ImportArgument,
    /// The size and time of the file when it was read.
    stamp: Stamp,
    /// The last picture that could be read; `None` before the first one.
    picture: Option<Picture>,
    /// The reason why the file, as it is now, cannot be read; `None` if it can.
    error: Option<Diagnostic>,
    /// The texture that contains the picture; `None` until it is written.
    written: Option<wgpu::Texture>,
}

/// The pictures for imported textures.
#[derive(Clone, Default)]
pub struct ImportFiles(Vec<ImportFile>);

impl ImportFiles {
    /// Reads the pictures. [`ImportFiles::errors`] returns the errors.
    pub fn read(arguments: &[ImportArgument]) -> Self {
        let file = |argument: &ImportArgument| {
            let argument = argument.clone();
            ImportFile { argument, stamp: None, picture: None, error: None, written: None }
        };
        let mut files = Self(arguments.iter().map(file).collect());
        files.0.iter_mut().for_each(ImportFile::read);
        files
    }

    /// Reads the files whose size or time has changed. A file that cannot be read keeps its last picture. Returns
    /// `true` if a file was read.
    pub fn read_again(&mut self) -> bool {
        let changed = self.0.iter_mut().filter(|file| stamp(&file.argument.path) != file.stamp);
        changed.map(ImportFile::read).count() > 0
    }

    /// The errors of a plan with these pictures: files that cannot be read, a name with two files, and textures that
    /// no file fills or that differ from their picture in size or format.
    pub fn errors(&self, plan: &Plan) -> Vec<Diagnostic> {
        let twice = self.0.iter().enumerate().filter_map(|(at, file)| {
            let ImportArgument { name, path } = &file.argument;
            let first = self.0[..at].iter().find(|other| other.argument.name == *name)?;
            let (first, path) = (first.argument.path.display(), path.display());
            let message = format!("\"{name}\" has two files, \"{first}\" and \"{path}\"");
            Some(
                Diagnostic::in_file(IMPORT_FILE, path.to_string(), "", message)
                    .help("give one --import for each"),
            )
        });
        let broken = self.0.iter().filter_map(|file| {
            let misfit = || file.picture.as_ref().and_then(|picture| file.misfit(picture, plan));
            file.error.clone().or_else(misfit)
        });
        twice.chain(broken).collect()
    }

    /// The errors about names that no imported texture has.
    pub fn unknown<'a>(&'a self, plan: &'a Plan) -> impl Iterator<Item = Diagnostic> + 'a {
        let unknown =
            self.0.iter().filter(|file| !plan.imports().any(|(name, _)| name == file.argument.name));
        unknown.map(|file| {
            let ImportArgument { name, path } = &file.argument;
            let message = format!("no pass uses an imported texture \"{name}\"");
            Diagnostic::in_file(IMPORT_FILE, path.display().to_string(), "", message).help(fillable(plan))
        })
    }

    /// The warnings about imported textures that passes read and that have no contents. `has_environment` tells that
    /// [`environment::IMPORT`] has some.
    pub fn empty<'a>(
        &'a self,
        plan: &'a Plan,
        has_environment: bool,
    ) -> impl Iterator<Item = Diagnostic> + 'a {
        let has_contents = move |name: &str| {
            has_environment && name == environment::IMPORT
                || self.0.iter().any(|file| file.argument.name == name)
        };
        only_read(plan).filter(move |(name, _)| !has_contents(name)).map(|(name, resource)| {
            let declared = plan.pipeline.resource(resource.handle);
            let message = format!("\"{name}\" has no contents: passes read zeros from it");
            let help = match name {
                environment::IMPORT => {
                    "give it with --environment FILE, or switch the feature \"environment\" off".to_owned()
                }
                _ => format!("your application gives this texture; here --import {name}=FILE does"),
            };
            Diagnostic::warning(codes::IMPORT, declared.place, message).pointer(&declared.pointer).help(help)
        })
    }

    /// Writes each picture that fits to the imported texture of its name, unless the texture already contains it.
    pub fn bring<'a>(
        &mut self,
        queue: &wgpu::Queue,
        plan: &Plan,
        imports: impl IntoIterator<Item = (&'a str, &'a wgpu::Texture)>,
    ) {
        for (name, texture) in imports {
            let of_name = self.0.iter_mut().find(|file| file.argument.name == name);
            let Some(file) = of_name.filter(|file| file.written.as_ref() != Some(texture)) else { continue };
            let Some(picture) = file.picture.as_ref() else { continue };
            if file.misfit(picture, plan).is_none() && texels::write(queue, texture, picture) {
                file.written = Some(texture.clone());
            }
        }
    }
}

impl ImportFile {
    fn read(&mut self) {
        self.stamp = stamp(&self.argument.path);
        match Picture::read(&self.argument.path) {
            Ok(picture) => (self.picture, self.error, self.written) = (Some(picture), None, None),
            Err(error) => self.error = Some(error),
        }
    }

    /// The error that the texture of a plan cannot take the picture; `None` if it can, or if the plan imports nothing
    /// of this name.
    fn misfit(&self, picture: &Picture, plan: &Plan) -> Option<Diagnostic> {
        let name = &self.argument.name;
        let (_, resource) = plan.imports().find(|(known, _)| known == name)?;
        let declared = plan.pipeline.resource(resource.handle);
        let file = self.argument.path.display();
        let reject = |message: String, help: String| {
            let found = Diagnostic::error(IMPORT_FILE, declared.place, message);
            Some(found.pointer(&declared.pointer).help(help))
        };
        let (Some(format), Some(size)) = (resource.format, resource.size) else {
            let message = format!("\"{name}\" is a buffer, and \"{file}\" fills a texture");
            return reject(message, fillable(plan));
        };
        if is_written(plan, resource) {
            let message =
                format!("passes write \"{name}\", and \"{file}\" fills a texture that passes only read");
            return reject(message, fillable(plan));
        }
        if size.mips > 1 || size.samples > 1 {
            let (levels, samples) = (size.mips, size.samples);
            let message = format!(
                "\"{name}\" has {levels} mip levels and {samples} samples, and \"{file}\" fills a texture of one each"
            );
            return reject(message, "remove \"mips\" and \"samples\" of the resource".to_owned());
        }
        let format_name = format_name(format);
        if texels::numbers(format).is_none() {
            let message = format!("\"{name}\" has the format {format_name}, which no picture fills");
            return reject(message, format!("use one of {FORMATS}"));
        }
        if !picture.suits(format) {
            let message = format!("\"{name}\" has the format {format_name}, and \"{file}\" holds floats");
            return reject(message, "use a PNG, or a float format such as rgba16float".to_owned());
        }
        let sides = [size.width, size.height, size.layers];
        if texels::Arrangement::of(picture.size(), sides).is_none() {
            let [width, height] = picture.size();
            let [wanted_width, wanted_height, layers] = sides;
            let (wanted, help) = match layers {
                1 => (
                    format!("{wanted_width} × {wanted_height}"),
                    format!("resize the picture, or set \"size\": [{width}, {height}]"),
                ),
                _ if width * width == height => (
                    format!("{wanted_width} × {wanted_height} × {layers}"),
                    format!(
                        "the file is a volume of {width} × {width} × {width}: give the texture this size"
                    ),
                ),
                _ => (
                    format!("{wanted_width} × {wanted_height} × {layers}"),
                    format!(
                        "place the {layers} layers side by side ({} × {wanted_height}) or below one another \
                         ({wanted_width} × {})",
                        u64::from(wanted_width) * u64::from(layers),
                        u64::from(wanted_height) * u64::from(layers),
                    ),
                ),
            };
            let message = format!("\"{name}\" has {wanted} texels, and \"{file}\" has {width} × {height}");
            return reject(message, help);
        }
        None
    }
}

fn is_written(plan: &Plan, resource: &PlannedResource) -> bool {
    plan.passes.iter().any(|pass| plan.writes(pass.handle, resource.handle))
}

/// The imported textures that passes only read.
fn only_read(plan: &Plan) -> impl Iterator<Item = (&str, &PlannedResource)> {
    plan.imports().filter(|(_, one)| one.format.is_some() && !is_written(plan, one))
}

/// A help with the names of the textures that a file can fill.
fn fillable(plan: &Plan) -> String {
    let names: Vec<&str> = only_read(plan).map(|(name, _)| name).collect();
    if names.is_empty() {
        return "this plan has no imported texture that passes only read".to_owned();
    }
    format!("imported textures that passes only read: {}", list_of(names))
}
