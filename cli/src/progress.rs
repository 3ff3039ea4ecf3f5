//! Progress of the command as a line on a terminal, and the time of each stage.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// The progress of a run: the line on the terminal, and the stages with their times.
pub(crate) struct Progress {
    line: Option<ProgressBar>,
    stages: Vec<(&'static str, Duration)>,
    /// The time at which the last step ended.
    since: Instant,
}

impl Progress {
    /// Creates the progress of a run. Shows a line on standard error if standard error is a terminal.
    pub(crate) fn new() -> Self {
        let line = std::io::stderr().is_terminal().then(ProgressBar::new_spinner);
        Self { line, stages: Vec::new(), since: Instant::now() }
    }

    /// Runs one stage and measures its time. While counted steps are shown, the progress line stays unchanged.
    pub(crate) fn stage<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        if let Some(line) = self.line.as_ref().filter(|line| line.length().is_none()) {
            line.set_message(name);
            line.enable_steady_tick(Duration::from_millis(100));
            line.tick();
        }
        let start = Instant::now();
        let result = work();
        match self.stages.iter_mut().find(|(known, _)| *known == name) {
            Some((_, time)) => *time += start.elapsed(),
            None => self.stages.push((name, start.elapsed())),
        }
        result
    }

    /// Shows the number of done steps of `steps` and the time left. Stages that run meanwhile count the steps by
    /// [`Self::counter`].
    pub(crate) fn count(&self, name: &'static str, steps: u64) {
        if let Some(line) = &self.line {
            if steps > 1 {
                line.set_style(
                    ProgressStyle::default_bar()
                        .template("{msg} {pos} of {len}, {per_sec}, {eta} to go")
                        .unwrap_or_else(|_| ProgressStyle::default_bar()),
                );
                line.set_length(steps);
                line.set_position(0);
            }
            line.set_message(name);
        }
    }

    /// Returns a function that counts steps, on any thread.
    #[cfg(feature = "score")]
    pub(crate) fn counter(&self) -> impl Fn(u64) + Sync + use<> {
        let line = self.line.clone();
        move |steps| {
            if let Some(line) = line.as_ref().filter(|line| line.length().is_some()) {
                line.inc(steps);
            }
        }
    }

    /// Shows that `steps` steps are done, those that [`Self::counter`] did not count among them.
    #[cfg(feature = "score")]
    pub(crate) fn reach(&self, steps: u64) {
        if let Some(line) = &self.line {
            line.set_position(steps);
        }
    }

    /// Begins a stage of `steps` steps, which [`Self::advance`] counts.
    pub(crate) fn begin(&mut self, name: &'static str, steps: u64) {
        self.count(name, steps);
        if steps > 0 {
            self.stages.push((name, Duration::ZERO));
        }
        self.since = Instant::now();
    }

    /// Counts a step of the current stage.
    pub(crate) fn advance(&mut self) {
        if let Some(line) = &self.line {
            line.inc(1);
        }
        if let Some((_, time)) = self.stages.last_mut() {
            *time += self.since.elapsed();
        }
        self.since = Instant::now();
    }

    /// Removes the progress line from the terminal.
    pub(crate) fn finish(&self) {
        if let Some(line) = &self.line {
            line.finish_and_clear();
        }
    }

    /// Returns the names of the stages with their times, and the total.
    pub(crate) fn summary(&self) -> String {
        let total: Duration = self.stages.iter().map(|(_, time)| *time).sum();
        let stages: Vec<String> =
            self.stages.iter().map(|(name, time)| format!("{name} {:.2} s", time.as_secs_f64())).collect();
        format!("{}; together {:.2} s", stages.join(", "), total.as_secs_f64())
    }
}
