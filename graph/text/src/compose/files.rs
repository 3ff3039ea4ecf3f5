//! Where the texts that a document names come from: the disk, memory, or what a host makes of [`Files`].
//!
//! [`read_source`], and [`Disk`] with it, is all that opens files.

use std::collections::BTreeMap;
use std::path::Path;

use crate::diagnostic::{Diagnostic, codes};
use crate::source::{FileId, MAXIMUM_FILE_BYTES, Sources, Span};

/// Finds the texts that a document names.
pub trait Files {
    /// Reads and registers the text at a path.
    ///
    /// # Errors
    /// A finding without a place worth naming; the caller adds where the path is named.
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic>;
}

/// The files of the file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        read_source(path, sources)
    }
}

/// Texts in memory, by path.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub BTreeMap<String, String>);

impl Files for Memory {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.to_string_lossy().replace('\\', "/");
        match self.0.get(&name) {
            Some(text) => Ok(sources.add(name, text.as_str())),
            None => Err(Diagnostic::in_file(
                codes::FILE_UNREADABLE,
                &name,
                "",
                format!("the file \"{name}\" cannot be read: it does not exist"),
            )
            .help("paths are relative to the folder of the file that names them")),
        }
    }
}

/// Reads and registers a text file; findings show it by the path as given.
///
/// # Errors
/// A file that cannot be read, is too large, or is not UTF-8.
pub fn read_source(path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        let reason = match error.kind() {
            std::io::ErrorKind::NotFound => "it does not exist".to_owned(),
            std::io::ErrorKind::PermissionDenied => "permission is denied".to_owned(),
            _ => error.to_string(),
        };
        Diagnostic::in_file(
            codes::FILE_UNREADABLE,
            &name,
            "",
            format!("the file \"{name}\" cannot be read: {reason}"),
        )
        .help("paths are relative to the current folder")
    };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(unreadable(std::io::Error::other("it is a folder")));
    }
    if metadata.len() > MAXIMUM_FILE_BYTES as u64 {
        let message = format!("the file \"{name}\" has {} bytes", metadata.len());
        return Err(Diagnostic::in_file(codes::FILE_TOO_LARGE, &name, "", message)
            .help(format!("texts have at most {MAXIMUM_FILE_BYTES} bytes")));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    match String::from_utf8(bytes) {
        // Some editors begin UTF-8 with a byte-order mark; it is no part of the text.
        Ok(text) => Ok(sources.add(name, text.strip_prefix('\u{feff}').unwrap_or(&text))),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let file = sources.add(name.clone(), text);
            Err(Diagnostic::error(
                codes::FILE_NOT_UTF8,
                Span::new(file, at..at + 1),
                format!("the file \"{name}\" is not UTF-8"),
            )
            .help("save it as UTF-8"))
        }
    }
}
