//! How long the host's processor works on each pass.
//!
//! Off unless asked for. The time of a CPU pass is that of its function; of any other pass, that of recording it, the
//! host's own draws included. Preparing bind groups and uploading blocks belong to no pass and are told apart.
//!
//! The time that the GPU takes is measured by [`super::gpu_times`].
//!
//! Limits: no clock on the web, where all times are zero.

use std::time::Duration;

/// A point in time, where there is a clock.
#[derive(Clone, Copy)]
pub(super) struct Moment(#[cfg(not(target_family = "wasm"))] Option<std::time::Instant>);

/// Times of the passes of a plan by their positions.
#[derive(Default)]
pub(super) struct Times {
    is_on: bool,
    /// Preparing and uploading.
    pub(super) preparation: Duration,
    /// The times by position; none if measuring is off.
    pub(super) passes: Vec<Duration>,
    /// When each pass began, from the reset on.
    pub(super) starts: Vec<Duration>,
    began: Option<Moment>,
}

impl Times {
    /// Switches measuring on or off.
    pub(super) fn switch(&mut self, is_on: bool) {
        self.is_on = is_on;
        self.passes.clear();
        self.preparation = Duration::ZERO;
    }

    /// Sets all times to zero, for so many passes.
    pub(super) fn reset(&mut self, passes: usize) {
        self.preparation = Duration::ZERO;
        self.passes.clear();
        self.starts.clear();
        if self.is_on {
            self.passes.resize(passes, Duration::ZERO);
            self.starts.resize(passes, Duration::ZERO);
            self.began = Some(self.now());
        }
    }

    /// Now.
    pub(super) fn now(&self) -> Moment {
        #[cfg(not(target_family = "wasm"))]
        return Moment(self.is_on.then(std::time::Instant::now));
        #[cfg(target_family = "wasm")]
        return Moment();
    }

    /// Adds the time since a moment to a pass.
    pub(super) fn add(&mut self, pass: usize, since: Moment) {
        if let (Some(time), Some(start)) = (self.passes.get_mut(pass), self.starts.get_mut(pass)) {
            let elapsed = since.elapsed();
            *time += elapsed;
            *start = self.began.map_or(Duration::ZERO, Moment::elapsed).saturating_sub(elapsed);
        }
    }

    /// Adds the time since a moment to the preparation.
    pub(super) fn add_preparation(&mut self, since: Moment) {
        self.preparation += since.elapsed();
    }
}

impl Moment {
    fn elapsed(self) -> Duration {
        #[cfg(not(target_family = "wasm"))]
        return self.0.map_or(Duration::ZERO, |start| start.elapsed());
        #[cfg(target_family = "wasm")]
        return Duration::ZERO;
    }
}
