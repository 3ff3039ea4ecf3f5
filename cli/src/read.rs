//! Files of the user that are neither documents nor scenes, read whole.

use std::path::Path;

use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::compose::{read_bytes, unreadable};

/// The maximum size in bytes of a file.
const MAX_BYTES: u64 = 1 << 30;

/// Returns the bytes of a regular file. Other files, such as pipes, are rejected since they may never end.
///
/// # Errors
/// A file that is missing, not regular or larger than 1 GiB, or an error of the operating system.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, Diagnostic> {
    let bytes = read_bytes(path, MAX_BYTES)
        .and_then(|bytes| bytes.ok_or_else(|| std::io::Error::other("it is larger than 1 GiB")));
    bytes.map_err(|error| unreadable(&path.display().to_string(), &error))
}
