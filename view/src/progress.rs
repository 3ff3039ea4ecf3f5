//! The progress of frames on the device, which has one at a time.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use eframe::egui;
use umbragraph::wgpu;

/// The numbers of submitted and finished frames, and the time of the last one.
pub(crate) struct Progress {
    /// The number of frames that the device has finished; `submitted` is the number of submitted frames.
    done: Arc<AtomicU64>,
    submitted: u64,
    began: Instant,
    /// The time from recording to completion of the last frame, in microseconds; 0 once it has been taken.
    took: Arc<AtomicU64>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        Self { done: Arc::default(), submitted: 0, began: Instant::now(), took: Arc::default() }
    }

    /// Begins the time of a frame, which is recorded now.
    pub(crate) fn begin(&mut self) {
        self.began = Instant::now();
    }

    /// Counts a submitted frame. The window is painted again once the device has finished it.
    pub(crate) fn submitted(&mut self, queue: &wgpu::Queue, context: &egui::Context) {
        self.submitted += 1;
        let (done, took, began) = (self.done.clone(), self.took.clone(), self.began);
        let (submitted, wake) = (self.submitted, context.clone());
        queue.on_submitted_work_done(move || {
            took.store(began.elapsed().as_micros() as u64, Ordering::Relaxed);
            done.store(submitted, Ordering::Release);
            wake.request_repaint();
        });
    }

    /// Returns `true` if the device has not finished the last frame.
    pub(crate) fn is_in_flight(&self) -> bool {
        self.done.load(Ordering::Acquire) < self.submitted
    }

    /// Takes the time from recording to completion of the last frame, in milliseconds. `None` if it was already taken.
    pub(crate) fn take_time(&self) -> Option<f64> {
        let took = self.took.swap(0, Ordering::Relaxed);
        (took > 0).then_some(took as f64 / 1e3)
    }
}
