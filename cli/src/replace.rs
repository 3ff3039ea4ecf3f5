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

/// Writes a file as a whole, as [`files::replace`] does.
///
/// # Errors
/// As of it.
pub(crate) fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Diagnostic> {
    watch();
    files::replace(path, contents)
}

/// Writes a text over a known one, as [`files::replace_if`] does.
///
/// # Errors
/// As of it.
pub(crate) fn replace_if(path: &Path, known: &str, text: &str) -> Result<(), Diagnostic> {
    watch();
    files::replace_if(path, known, text)
}

/// Begins a file.
///
/// # Errors
/// As of [`Unfinished::create`].
#[cfg(feature = "gpu")]
pub(crate) fn create(path: &Path) -> Result<(Unfinished, File), Diagnostic> {
    watch();
    Unfinished::create(path)
}

/// Sets the handler of interrupts, of which a command without pictures has none.
fn watch() {
    #[cfg(feature = "gpu")]
    interrupt::watch();
}
