//! The time of the scene's animations, and the resolution that the device has time for.

use std::time::{Duration, Instant};

/// One step of the time (seconds).
pub(crate) const STEP: f64 = 1.0 / 30.0;

/// The time of the animations.
pub(crate) struct Clock {
    pub(crate) time: f64,
    pub(crate) is_playing: bool,
    last: Option<Instant>,
}

impl Clock {
    pub(crate) fn new() -> Self {
        Self { time: 0.0, is_playing: false, last: None }
    }

    /// Goes on by the time that passed, or by a fixed step for a clip; whether the time is another.
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

/// The time that a frame may take while somebody moves something, and while nobody does.
const MOVING: f64 = 60.0;
const STILL: f64 = 1500.0;

/// Texels per pixel: chosen, or as many as there is time for.
pub(crate) struct Resolution {
    pub(crate) fixed: Option<f32>,
    /// The time that a frame of every pixel would take (milliseconds).
    whole: f64,
    moved: Instant,
}

/// The steps of the resolution.
pub(crate) const STEPS: [f32; 5] = [1.0, 0.75, 0.5, 0.35, 0.25];

impl Resolution {
    pub(crate) fn new(fixed: Option<f32>) -> Self {
        Self { fixed, whole: 500.0, moved: Instant::now() }
    }

    /// Notes that something moves.
    pub(crate) fn touch(&mut self) {
        self.moved = Instant::now();
    }

    /// Takes in the time of a frame at a scale.
    pub(crate) fn measured(&mut self, milliseconds: f64, scale: f32) {
        let whole = milliseconds / f64::from(scale * scale);
        self.whole += 0.3 * (whole - self.whole);
    }

    /// Whether something moved just now.
    pub(crate) fn is_moving(&self) -> bool {
        self.moved.elapsed() < Duration::from_millis(400)
    }

    /// Texels per pixel of the next frame.
    pub(crate) fn scale(&self) -> f32 {
        self.fixed.unwrap_or_else(|| fitting(if self.is_moving() { MOVING } else { STILL }, self.whole))
    }

    /// The next coarser or finer step.
    pub(crate) fn step(&mut self, by: isize) {
        let now = self.scale();
        let at = STEPS.iter().position(|step| *step <= now + 0.01).unwrap_or(STEPS.len() - 1);
        self.fixed = Some(STEPS[at.saturating_add_signed(by).min(STEPS.len() - 1)]);
    }
}

/// The finest step of which a frame takes no longer than a time.
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
