//! CPU times of passes.
//!
//! Off by default. The time of a CPU pass is that of its function; the time of any other pass is that of its recording,
//! including the host's own draws. Preparing bind groups and uploading blocks belong to no pass and are reported
//! separately.
//!
//! [`super::gpu_times`] measures the time of the GPU.
//!
//! Limits: no clock on the web, where all times are zero.

use std::time::{Duration, Instant};

/// A point in time; `None` if measuring is off or there is no clock.
pub(crate) type Moment = Option<Instant>;

/// The CPU times of the passes of one record, by pass index in the plan.
#[derive(Default)]
pub(crate) struct Times {
    is_on: bool,
    /// The time for preparing bind groups and uploading blocks.
    pub(crate) preparation: Duration,
    /// The time of each pass; empty if measuring is off.
    pub(crate) passes: Vec<Duration>,
    /// The start of each pass, measured from the reset at the begin of the record.
    pub(crate) starts: Vec<Duration>,
    began: Moment,
}

impl Times {
    /// Switches measuring on or off.
    pub(crate) fn switch(&mut self, is_on: bool) {
        self.is_on = is_on;
        self.passes.clear();
        self.preparation = Duration::ZERO;
    }

    /// Sets all times to zero, for a number of passes.
    pub(crate) fn reset(&mut self, passes: usize) {
        self.preparation = Duration::ZERO;
        self.passes.clear();
        self.starts.clear();
        if self.is_on {
            self.passes.resize(passes, Duration::ZERO);
            self.starts.resize(passes, Duration::ZERO);
            self.began = self.now();
        }
    }

    /// The current time; `None` if measuring is off, or on WebAssembly.
    pub(crate) fn now(&self) -> Moment {
        (self.is_on && cfg!(not(target_family = "wasm"))).then(Instant::now)
    }

    /// Adds the time since a moment to a pass.
    pub(crate) fn add(&mut self, pass: usize, since: Moment) {
        if let (Some(time), Some(start)) = (self.passes.get_mut(pass), self.starts.get_mut(pass)) {
            let elapsed = time_since(since);
            *time += elapsed;
            *start = time_since(self.began).saturating_sub(elapsed);
        }
    }

    /// Adds the time since a moment to the preparation.
    pub(crate) fn add_preparation(&mut self, since: Moment) {
        self.preparation += time_since(since);
    }
}

fn time_since(moment: Moment) -> Duration {
    moment.map_or(Duration::ZERO, |moment| moment.elapsed())
}
