//! Files that are written as a whole or not at all.

use std::path::Path;

/// Puts a text in the place of a file that is there: to a temporary file beside it, which is then renamed. A link stays
/// one, and what it leads to is written; permissions stay as they are.
///
/// # Errors
/// A file that is not there, or a folder that cannot be written to; the file is as it was.
pub(crate) fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let path = path.canonicalize()?;
    let mut temporary = path.clone().into_os_string();
    temporary.push(format!(".{}.part", std::process::id()));
    let result = std::fs::write(&temporary, text)
        .and_then(|()| std::fs::set_permissions(&temporary, std::fs::metadata(&path)?.permissions()))
        .and_then(|()| std::fs::rename(&temporary, &path));
    if result.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    result
}
