//! Interrupts by the user or the system: files under construction are removed before the process ends.
//!
//! The handler is set with the first such file. Where a command has set its own, as `tune` does, that one stays, and
//! calls [`end`] itself.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once, PoisonError};

/// The exit status of a process that was interrupted.
const INTERRUPTED: i32 = 130;

static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file is under construction from here on.
pub(crate) fn begun(file: &Path) {
    static HANDLER: Once = Once::new();
    // Where no handler can be set an interrupt ends the process, as it does elsewhere.
    HANDLER.call_once(|| drop(ctrlc::try_set_handler(|| end())));
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).insert(file.to_owned());
}

/// A file is finished, or given up.
pub(crate) fn ended(file: &Path) {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).remove(file);
}

/// Removes files under construction, and ends the process.
pub(crate) fn end() -> ! {
    // Held until the end, so that no other thread begins a file.
    let unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for file in unfinished.iter() {
        let _ = std::fs::remove_file(file);
    }
    exit()
}

/// Ends the process at once: another thread may be drawing, and what the driver does at the end of a process must not run
/// meanwhile.
#[cfg(unix)]
fn exit() -> ! {
    signal_hook::low_level::exit(INTERRUPTED)
}

#[cfg(not(unix))]
fn exit() -> ! {
    std::process::exit(INTERRUPTED)
}
