//! What the command is doing, as a line on a terminal, and how long each stage took.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

/// The stages of a run.
pub(crate) struct Progress {
    line: Option<ProgressBar>,
    stages: Vec<(&'static str, Duration)>,
}

impl Progress {
    /// A line on standard error, if that is a terminal.
    pub(crate) fn new() -> Self {
        let line = std::io::stderr().is_terminal().then(ProgressBar::new_spinner);
        Self { line, stages: Vec::new() }
    }

    /// Runs one stage.
    pub(crate) fn stage<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        if let Some(line) = &self.line {
            line.set_message(name);
            line.enable_steady_tick(Duration::from_millis(100));
            line.tick();
        }
        let start = Instant::now();
        let result = work();
        self.stages.push((name, start.elapsed()));
        result
    }

    /// Removes the line.
    pub(crate) fn finish(&self) {
        if let Some(line) = &self.line {
            line.finish_and_clear();
        }
    }

    /// The stages with their times.
    pub(crate) fn summary(&self) -> String {
        let total: Duration = self.stages.iter().map(|(_, time)| *time).sum();
        let stages: Vec<String> =
            self.stages.iter().map(|(name, time)| format!("{name} {:.2} s", time.as_secs_f64())).collect();
        format!("{}; together {:.2} s", stages.join(", "), total.as_secs_f64())
    }
}
