//! Messages of wgpu and of validation layers, on standard error.
//!
//! They go through the crate `log`, and without a logger nobody sees them. They are printed where `WGPU_DEBUG` or
//! `WGPU_VALIDATION` asks for them: warnings and errors alone, one line each and in the order in which they come.

use log::{Level, LevelFilter, Log, Metadata, Record};

use crate::streams::complain;

struct Messages;

impl Log for Messages {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let text = record.args().to_string();
            let line: Vec<&str> = text.lines().map(str::trim).collect();
            complain(&format!("{}: {}\n", record.target(), line.join(" ")));
        }
    }

    fn flush(&self) {}
}

/// Begins to print log messages of wgpu, if `WGPU_DEBUG` or `WGPU_VALIDATION` is set.
pub(super) fn listen() {
    let asks = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty() && value != "0");
    if ["WGPU_DEBUG", "WGPU_VALIDATION"].into_iter().any(asks) && log::set_logger(&Messages).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}
