//! Files of the user that are neither documents nor scenes, read whole.

use std::path::Path;

use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::compose::{read_bytes, unreadable};

/// The largest file that is read.
const MAX_BYTES: u64 = 1 << 30;

/// The bytes of a regular file: a pipe may never end.
///
/// # Errors
/// No such file, one that is not regular or larger than 1 GiB, or an error of the system.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, Diagnostic> {
    let bytes = read_bytes(path, MAX_BYTES)
        .and_then(|bytes| bytes.ok_or_else(|| std::io::Error::other("it is larger than 1 GiB")));
    bytes.map_err(|error| unreadable(&path.display().to_string(), &error))
}
