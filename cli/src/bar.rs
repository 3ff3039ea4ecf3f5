//! A bar on standard error with the time that is left; nothing where that is no terminal, such as in CI.

use std::io::IsTerminal as _;
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar on a terminal; empty if standard error is no terminal.
pub(crate) struct Bar(Option<ProgressBar>);

impl Bar {
    fn new(template: &str) -> Self {
        Self(std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(0);
            match ProgressStyle::with_template(template) {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        }))
    }

    /// Creates a progress bar for the given number of pipelines.
    pub(crate) fn of_pipelines(number: usize) -> Self {
        let bar = Self::new("{spinner} {msg}, {pos} of {len} done, {eta} left");
        if let Some(bar) = &bar.0 {
            bar.set_length(number as u64);
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        bar
    }

    /// Creates a progress bar for shader sources, whose number grows as they are found.
    pub(crate) fn of_texts() -> Self {
        Self::new("{bar:40} {pos} of {len} texts, {eta} left")
    }

    /// Shows the name of the pipeline that is next, and the number of pipelines done.
    pub(crate) fn step(&self, done: usize, pipeline: &Path) {
        if let Some(bar) = &self.0 {
            bar.set_message(pipeline.display().to_string());
            bar.set_position(done as u64);
        }
    }

    /// Shows the number of items done and the total. Numbers below those already shown are ignored, since threads may
    /// report out of order.
    pub(crate) fn reach(&self, done: usize, all: usize) {
        if let Some(bar) = &self.0 {
            let (done, all) = (done as u64, all as u64);
            bar.update(|state| {
                state.set_pos(done.max(state.pos()));
                state.set_len(all.max(state.len().unwrap_or(0)));
            });
        }
    }

    /// Removes the progress bar from the terminal.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
