//! The time of the scene's animations, and the resolution that the device has time for.

use std::time::{Duration, Instant};

/// The step of the animation time for one frame, in seconds.
pub(crate) const STEP: f64 = 1.0 / 30.0;

/// The clock of the scene's animations.
pub(crate) struct Clock {
    pub(crate) time: f64,
    pub(crate) is_playing: bool,
    last: Option<Instant>,
}

impl Clock {
    pub(crate) fn new() -> Self {
        Self { time: 0.0, is_playing: false, last: None }
    }

    /// Advances the animation time by the time since the last call (at most 0.5 s), or by `fixed` if given. A paused
    /// clock stands still. Returns `true` if the clock is playing.
    pub(crate) fn advance(&mut self, fixed: Option<Duration>) -> bool {
        let now = Instant::now();
        let passed = self.last.map_or(Duration::ZERO, |last| now - last);
        self.last = Some(now);
        if self.is_playing {
            // A window that was hidden goes on where it was.
            self.time += fixed.unwrap_or(passed.min(Duration::from_millis(500))).as_secs_f64();
        }
        self.is_playing
    }
}

/// The frame time budget in milliseconds while the user changes something. `STILL` is the budget otherwise.
const MOVING: f64 = 60.0;
const STILL: f64 = 1500.0;

/// The resolution of the frame in texels per pixel: chosen by the user, or adapted to the frame time.
pub(crate) struct Resolution {
    pub(crate) fixed: Option<f32>,
    /// The estimated frame time at one texel per pixel, in milliseconds.
    whole: f64,
    moved: Instant,
}

/// The selectable resolutions, in texels per pixel along each side.
pub(crate) const STEPS: [f32; 5] = [1.0, 0.75, 0.5, 0.35, 0.25];

impl Resolution {
    pub(crate) fn new(fixed: Option<f32>) -> Self {
        Self { fixed, whole: 500.0, moved: Instant::now() }
    }

    /// Notes that the user or the animation changes the frame, which selects the shorter frame time budget.
    pub(crate) fn touch(&mut self) {
        self.moved = Instant::now();
    }

    /// Updates the estimated frame time with a measurement in milliseconds. `scale` is the resolution of the measured
    /// frame, in texels per pixel along each side.
    pub(crate) fn measured(&mut self, milliseconds: f64, scale: f32) {
        let whole = milliseconds / f64::from(scale * scale);
        self.whole += 0.3 * (whole - self.whole);
    }

    /// Returns `true` if the frame was changed within the last 400 ms.
    pub(crate) fn is_moving(&self) -> bool {
        self.moved.elapsed() < Duration::from_millis(400)
    }

    /// The resolution of the next frame, in texels per pixel along each side.
    pub(crate) fn scale(&self) -> f32 {
        self.fixed.unwrap_or_else(|| fitting(if self.is_moving() { MOVING } else { STILL }, self.whole))
    }

    /// Selects a resolution `by` steps coarser (finer if negative), and ends the adaptation.
    pub(crate) fn step(&mut self, by: isize) {
        let now = self.scale();
        let at = STEPS.iter().position(|step| *step <= now + 0.01).unwrap_or(STEPS.len() - 1);
        self.fixed = Some(STEPS[at.saturating_add_signed(by).min(STEPS.len() - 1)]);
    }
}

/// The finest resolution whose estimated frame time is at most `allowed` milliseconds, else the coarsest. `whole` is
/// the estimated frame time at one texel per pixel, in milliseconds.
fn fitting(allowed: f64, whole: f64) -> f32 {
    let fits = |step: &&f32| whole * f64::from(**step * **step) <= allowed;
    STEPS.iter().find(fits).or(STEPS.last()).copied().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_device_draws_fewer_texels() {
        assert_eq!([fitting(60.0, 20.0), fitting(60.0, 240.0), fitting(60.0, 1e6)], [1.0, 0.5, 0.25]);
        let mut resolution = Resolution::new(Some(0.5));
        resolution.step(1);
        assert_eq!(resolution.scale(), 0.35);
        resolution.step(-2);
        assert_eq!(resolution.scale(), 0.75);
        resolution.step(-9);
        assert_eq!(resolution.scale(), 1.0);
    }

    #[test]
    fn a_paused_clock_stands_still() {
        let mut clock = Clock::new();
        assert!(!clock.advance(Some(Duration::from_secs(1))));
        clock.is_playing = true;
        assert!(clock.advance(Some(Duration::from_secs(1))) && clock.time == 1.0);
    }
}
