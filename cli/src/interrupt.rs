//! Interrupts by the user or the system: files under construction are removed before the process ends.
//!
//! The handler is set with the first such file. Where a command has set its own, as `tune` does, that one stays, and
//! calls [`end`] itself.

use std::sync::Once;

use umbragraph::low_level::files;

/// The exit status of an interrupted process.
const INTERRUPTED: i32 = 130;

/// Installs the interrupt handler; to be called before the first file is written.
pub(crate) fn watch() {
    static HANDLER: Once = Once::new();
    // Where no handler can be set an interrupt ends the process, as it does elsewhere.
    HANDLER.call_once(|| drop(ctrlc::try_set_handler(|| end())));
}

/// Removes unfinished output files and ends the process.
pub(crate) fn end() -> ! {
    files::give_up(|| leave(INTERRUPTED))
}

/// Ends the process at once, without exit handlers. A driver's exit handlers must not run while another thread draws.
#[cfg(unix)]
pub(crate) fn leave(status: i32) -> ! {
    signal_hook::low_level::exit(status)
}

#[cfg(not(unix))]
pub(crate) fn leave(status: i32) -> ! {
    std::process::exit(status)
}
