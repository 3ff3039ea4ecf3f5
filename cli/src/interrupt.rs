//! Interrupts by the user or the system: files under construction are removed before the process ends.
//!
//! The handler is set with the first such file. Where a command has set its own, as `tune` does, that one stays, and
//! calls [`end`] itself.

use std::sync::Once;

use umbragraph::low_level::files;

/// The exit status of a process that was interrupted.
const INTERRUPTED: i32 = 130;

/// Sets the handler, before the first file.
pub(crate) fn watch() {
    static HANDLER: Once = Once::new();
    // Where no handler can be set an interrupt ends the process, as it does elsewhere.
    HANDLER.call_once(|| drop(ctrlc::try_set_handler(|| end())));
}

/// Removes files under construction, and ends the process.
pub(crate) fn end() -> ! {
    files::give_up(|| leave(INTERRUPTED))
}

/// Ends the process at once: another thread may be drawing, and what the driver does at the end of a process must not
/// run meanwhile.
#[cfg(unix)]
pub(crate) fn leave(status: i32) -> ! {
    signal_hook::low_level::exit(status)
}

#[cfg(not(unix))]
pub(crate) fn leave(status: i32) -> ! {
    std::process::exit(status)
}
