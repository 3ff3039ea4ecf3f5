//! Files that the command writes; an interrupt leaves no half one.

#[cfg(feature = "gpu")]
use std::fs::File;
use std::path::Path;

#[cfg(feature = "gpu")]
use crate::interrupt;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::files;

#[cfg(feature = "gpu")]
pub(crate) use umbragraph::low_level::files::Unfinished;
pub(crate) use umbragraph::low_level::files::unwritable;

/// Writes a file atomically, as [`files::replace`] does.
///
/// # Errors
/// The errors of [`files::replace`].
pub(crate) fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Diagnostic> {
    watch();
    files::replace(path, contents)
}

/// Replaces a text file if its contents are still `known`, as [`files::replace_if`] does.
///
/// # Errors
/// The errors of [`files::replace_if`].
pub(crate) fn replace_if(path: &Path, known: &str, text: &str) -> Result<(), Diagnostic> {
    watch();
    files::replace_if(path, known, text)
}

/// Begins to write a file, which appears under its path once it is complete.
///
/// # Errors
/// The errors of [`Unfinished::create`].
#[cfg(feature = "gpu")]
pub(crate) fn create(path: &Path) -> Result<(Unfinished, File), Diagnostic> {
    watch();
    Unfinished::create(path)
}

/// Installs the interrupt handler, which removes unfinished files.
fn watch() {
    #[cfg(feature = "gpu")]
    interrupt::watch();
}
