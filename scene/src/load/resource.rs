//! Files that a document refers to by URI: buffers and images.
//!
//! A `data:` URI contains its bytes (base64 only, as glTF requires). Any other URI must be a relative path, which a
//! [`Resolver`] turns into bytes. [`Folder`] reads files below its roots, next to the document; [`NoFiles`] rejects all
//! paths, for a document in memory. A host with an archive or a network implements its own. Nothing is fetched here.

use base64::Engine;
use std::path::{Path, PathBuf};

use umbragraph_pipeline::compose::{Roots, Unreachable, find_below, read_bytes};
use umbragraph_pipeline::diagnostic::Code;

use super::limits::MAX_FILE_BYTES;
use super::report::Report;

/// The error for a buffer or image whose bytes cannot be read from its URI.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// The file with this name does not exist.
    #[error("{0:?} does not exist")]
    NotFound(String),
    /// The file exists but cannot be read.
    #[error("{name:?} cannot be read: {reason}")]
    Unreadable {
        /// The name of the file, as written in the document.
        name: String,
        /// The error message of the operating system.
        reason: String,
    },
    /// The file with this name lies outside the folders that may be read.
    #[error("{0:?} is outside of the folders that may be read")]
    Outside(String),
    /// The file with this name has more than [`MAX_FILE_BYTES`] bytes.
    #[error("{0:?} is larger than a scene file may be")]
    TooLarge(String),
    /// The URI is not a usable relative path: it is empty or absolute, or has a scheme or a null character.
    #[error("{0:?} is not a relative path")]
    NotRelative(String),
    /// A `data:` URI does not contain valid base64 data.
    #[error("the data URI is not valid base64")]
    BrokenData,
    /// The resolver reads no files, but the document references a file with this name.
    #[error("{0:?} is a file of its own, and this scene is read from memory alone")]
    NoFiles(String),
}

/// Reads the files that a document references by relative paths.
pub trait Resolver {
    /// Reads the bytes of the file at `path`, a relative, percent-decoded path with `/` between its parts.
    fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError>;
}

/// A resolver that rejects all paths, for documents that contain all buffers and images themselves.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError> {
        Err(ResolveError::NoFiles(path.to_owned()))
    }
}

/// A resolver that reads files relative to a folder. Each file must lie below one of the root folders after links and
/// `..` are resolved.
#[derive(Clone, Debug)]
pub struct Folder {
    folder: PathBuf,
    roots: Roots,
}

impl Folder {
    /// Creates a resolver for paths relative to `folder`. Files may lie below `folder` and below the working folder.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        let roots = Roots::below(&folder);
        Self { folder, roots }
    }

    /// Replaces the root folders below which files may lie.
    #[must_use]
    pub fn below(self, roots: Roots) -> Self {
        Self { roots, ..self }
    }
}

impl Resolver for Folder {
    fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError> {
        match find_below(&self.roots, &self.folder.join(path)) {
            Ok(found) => read_file(&found, path),
            Err(Unreachable::Outside) => Err(ResolveError::Outside(path.to_owned())),
            Err(Unreachable::Failed(error)) => Err(failed(path, &error)),
        }
    }
}

/// Reads a file of at most [`MAX_FILE_BYTES`] bytes; `name` is its name in diagnostics.
pub(super) fn read_file(path: &Path, name: &str) -> Result<Vec<u8>, ResolveError> {
    match read_bytes(path, MAX_FILE_BYTES) {
        Ok(Some(bytes)) => Ok(bytes),
        Ok(None) => Err(ResolveError::TooLarge(name.to_owned())),
        Err(error) => Err(failed(name, &error)),
    }
}

fn failed(name: &str, error: &std::io::Error) -> ResolveError {
    match error.kind() {
        std::io::ErrorKind::NotFound => ResolveError::NotFound(name.to_owned()),
        _ => ResolveError::Unreadable { name: name.to_owned(), reason: error.to_string() },
    }
}

/// Reads the bytes that a URI in a document refers to. The URI is a `data:` URI or a relative path.
fn resolve(uri: &str, resolver: &dyn Resolver) -> Result<Vec<u8>, ResolveError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").ok_or(ResolveError::BrokenData)?.1;
        return base64::engine::general_purpose::STANDARD
            .decode(encoded)
            .map_err(|_| ResolveError::BrokenData);
    }
    let path = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let has_scheme = path.split('/').next().is_some_and(|first| first.contains(':'));
    if path.is_empty() || path.starts_with(['/', '\\']) || has_scheme || path.contains('\0') {
        return Err(ResolveError::NotRelative(shortened(uri)));
    }
    resolver.read(&path)
}

/// Reads the bytes that the URI of a glTF object refers to. Diagnostics name the object with `object`, such as "image
/// 3"; `at` is its JSON pointer. Returns `None` after reporting an error.
pub(super) fn resolve_of(
    uri: &str,
    resolver: &dyn Resolver,
    code: Code,
    object: &str,
    at: &str,
    report: &mut Report,
) -> Option<Vec<u8>> {
    match resolve(uri, resolver) {
        Ok(bytes) => Some(bytes),
        Err(error) => {
            let help = "put the file beside the document, or export the scene as one .glb file";
            report.reject(code, &format!("{at}/uri"), format!("{object}: {error}"), help)
        }
    }
}

/// Cuts a URI with more than 80 characters after 80 characters, and adds an ellipsis, for diagnostics.
fn shortened(uri: &str) -> String {
    match uri.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &uri[..end]),
        None => uri.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Echo;
    impl Resolver for Echo {
        fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError> {
            Ok(path.as_bytes().to_vec())
        }
    }

    #[test]
    fn paths_are_percent_decoded_and_data_is_decoded() {
        assert_eq!(resolve("my%20textures/stone.png", &Echo).unwrap(), b"my textures/stone.png");
        assert_eq!(resolve("data:application/octet-stream;base64,AAEC/w==", &Echo).unwrap(), [0, 1, 2, 255]);
    }

    #[test]
    fn only_relative_paths_reach_the_resolver() {
        for uri in ["/etc/hosts", "https://example.org/a.bin", "C:/a.bin", "%2Fetc/hosts", "", "a%00b"] {
            assert!(matches!(resolve(uri, &Echo), Err(ResolveError::NotRelative(_))), "{uri}");
        }
        for uri in ["data:,plain", "data:;base64,***"] {
            assert_eq!(resolve(uri, &Echo), Err(ResolveError::BrokenData), "{uri}");
        }
    }
}
