//! Sources of the texts that a document names: a [disk](super::disk), memory, or a host's own [`Files`].

use std::collections::BTreeMap;
use std::path::Path;

use crate::diagnostic::{DID_YOU_MEAN, Diagnostic, Diagnostics, begun, codes, suggested_name};
use crate::document::{self, Document};
use crate::source::{FileId, MAX_FILE_BYTES, Sources, Span};

/// A source of the files that a document names, such as a disk or memory.
pub trait Files {
    /// Reads the file at a path, and registers its contents in `sources`.
    ///
    /// # Errors
    /// A file that cannot be read. The caller replaces the place of the diagnostic with the place at which the document
    /// names the file.
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic>;

    /// Parses a registered file as a document.
    ///
    /// # Errors
    /// The diagnostics of a file that is not valid.
    fn parse(&mut self, file: FileId, sources: &Sources) -> Result<Document, Diagnostics> {
        document::parse(sources, file).valid()
    }

    /// Parses a registered file as far as it can be understood, even if it is not valid.
    fn recover(&mut self, file: FileId, sources: &Sources) -> Document {
        document::parse(sources, file).document
    }

    /// Returns `true` if this source resolves names that begin with `scheme` and `:`, which are then not paths relative
    /// to a folder.
    fn has_scheme(&self, _scheme: &str) -> bool {
        false
    }
}

/// Files in memory: contents by path, with `/` as separator.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub BTreeMap<String, String>);

impl Files for Memory {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.to_string_lossy().replace('\\', "/");
        match self.0.get(&name) {
            Some(text) => Ok(sources.add(name, text.as_str())),
            None => {
                let is_folder = self.0.keys().any(|known| {
                    known.strip_prefix(name.trim_end_matches('/')).is_some_and(|rest| rest.starts_with('/'))
                });
                let reason = if is_folder { "it is a folder" } else { "it does not exist" };
                let message = format!("the file \"{name}\" cannot be read: {reason}");
                let diagnostic = Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", message)
                    .help("paths are relative to the folder of the file that names them");
                let beside = self.0.keys().map(Path::new).filter(|known| known.parent() == path.parent());
                let names = beside.filter_map(|known| known.file_name()?.to_str());
                Err(with_meant(diagnostic, meant_among(names, path, &DOCUMENTS)))
            }
        }
    }
}

/// The file name extensions of documents.
pub(super) const DOCUMENTS: [&str; 2] = [".json", ".jsonc"];

pub(super) fn meant_among<'n>(
    names: impl Iterator<Item = &'n str>,
    path: &Path,
    ends: &[&str],
) -> Option<String> {
    // The ending makes no name like another.
    let stem = |name: &'n str| ends.iter().find_map(|end| name.strip_suffix(end));
    let known: BTreeMap<&str, &str> = names.filter_map(|name| Some((stem(name)?, name))).collect();
    let wanted = path.file_name()?.to_str()?;
    let wanted = ends.iter().find_map(|end| wanted.strip_suffix(end)).unwrap_or(wanted);
    let names: Vec<&str> = known.keys().copied().collect();
    let meant =
        known.get(suggested_name(wanted, names.iter().copied()).or_else(|| begun(wanted, &names))?)?;
    Some(format!("{DID_YOU_MEAN} \"{meant}\", which lies beside it?"))
}

pub(super) fn with_meant(diagnostic: Diagnostic, meant: Option<String>) -> Diagnostic {
    Diagnostic { help: meant.or(diagnostic.help), ..diagnostic }
}

/// Registers the bytes of a file under a name. A leading UTF-8 byte-order mark is removed.
///
/// # Errors
/// Bytes that are not UTF-8, which are registered with replacement characters, or more bytes than [`MAX_FILE_BYTES`].
pub fn add_bytes(bytes: Vec<u8>, name: String, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    if bytes.len() > MAX_FILE_BYTES {
        return Err(too_large(&name));
    }
    match String::from_utf8(bytes) {
        // Some editors begin UTF-8 with a byte-order mark; it is no part of the text.
        Ok(text) => Ok(sources.add(name, text.strip_prefix('\u{feff}').unwrap_or(&text))),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let file = sources.add(name.clone(), text);
            let message = format!("the file \"{name}\" is not UTF-8");
            Err(Diagnostic::error(codes::FILE_NOT_UTF8, Span::new(file, at..at + 1), message)
                .help("save it as UTF-8"))
        }
    }
}

pub(super) fn too_large(name: &str) -> Diagnostic {
    let message = format!("the file \"{name}\" has more than {MAX_FILE_BYTES} bytes");
    Diagnostic::in_file(codes::FILE_TOO_LARGE, name, "", message)
        .help(format!("texts have at most {MAX_FILE_BYTES} bytes"))
}
