//! How long the host's processor works on each pass.
//!
//! Off unless asked for. The time of a CPU pass is that of its function; of any other pass, that of recording it, the
//! host's own draws included. Preparing bind groups and uploading blocks belong to no pass and are told apart.
//!
//! The time that the GPU takes is not measured here: a timer for that writes timestamps at the begin and the end of the
//! render and compute passes, all of which begin in `record` and `attachments`, under the names of their passes.
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
    passes: Vec<Duration>,
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
        if self.is_on {
            self.passes.resize(passes, Duration::ZERO);
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
        if let Some(time) = self.passes.get_mut(pass) {
            *time += since.elapsed();
        }
    }

    /// Adds the time since a moment to the preparation.
    pub(super) fn add_preparation(&mut self, since: Moment) {
        self.preparation += since.elapsed();
    }

    /// The times by position; none if measuring is off.
    pub(super) fn passes(&self) -> &[Duration] {
        &self.passes
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
