//! GPU times of passes, by timestamps at the begin and the end of render and compute passes, and around copies if the
//! device can write timestamps between passes.
//!
//! Off by default, as are the CPU times. Passes that are recorded as one render pass count with the first of them; a
//! pass that draws into several layers has a render pass for each, all of which count.
//!
//! Limits: a device without `timestamp-query` measures nothing. The clears of layers that no view draws into do not
//! count. Not for the web, where the underlying library needs a process number.

use std::time::Duration;

use wgpu_profiler::{GpuProfiler, GpuProfilerQuery, GpuProfilerSettings};

/// The time of one pass on the GPU.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuTime {
    /// The name of the pass.
    pub pass: String,
    /// Time from the first timestamp of the frame to the begin of the pass.
    pub start: Duration,
    /// Time from the begin to the end of the pass.
    pub time: Duration,
}

/// Timestamps of the last record.
#[derive(Default)]
pub(crate) struct GpuTimes {
    is_on: bool,
    profiler: Option<GpuProfiler>,
}

impl GpuTimes {
    /// Switches measuring on or off. Returns `true` if the device supports timestamp queries.
    pub(crate) fn switch(&mut self, is_on: bool, device: &wgpu::Device) -> bool {
        let can = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        *self = Self { is_on: is_on && can, profiler: None };
        can
    }

    /// Begins a record, and drops the timestamps of the record before, whose encoder may never have been submitted.
    pub(crate) fn reset(&mut self, device: &wgpu::Device) {
        let settings = GpuProfilerSettings { enable_debug_groups: false, ..GpuProfilerSettings::default() };
        self.profiler = if self.is_on { GpuProfiler::new(device, settings).ok() } else { None };
    }

    /// Begins the timestamps of a render or compute pass.
    pub(crate) fn pass(&self, name: &str, encoder: &mut wgpu::CommandEncoder) -> Option<GpuProfilerQuery> {
        self.profiler.as_ref().map(|profiler| profiler.begin_pass_query(name, encoder))
    }

    /// Begins the timestamps of commands that are recorded between passes.
    pub(crate) fn between(&self, name: &str, encoder: &mut wgpu::CommandEncoder) -> Option<GpuProfilerQuery> {
        self.profiler.as_ref().map(|profiler| profiler.begin_query(name, encoder))
    }

    /// Ends the timestamps of a pass, or of commands between passes.
    pub(crate) fn end(&self, encoder: &mut wgpu::CommandEncoder, query: Option<GpuProfilerQuery>) {
        if let (Some(profiler), Some(query)) = (&self.profiler, query) {
            profiler.end_query(encoder, query);
        }
    }

    /// Ends a record, and resolves its timestamps.
    pub(crate) fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(profiler) = &mut self.profiler {
            profiler.resolve_queries(encoder);
        }
    }

    /// Waits for the GPU and returns the pass times of the last submitted record; empty if measuring is off.
    pub(crate) fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Vec<GpuTime> {
        let Some(mut profiler) = self.profiler.take() else { return Vec::new() };
        if profiler.end_frame().is_err() || device.poll(wgpu::PollType::wait_indefinitely()).is_err() {
            return Vec::new();
        }
        let measured = profiler.process_finished_frame(queue.get_timestamp_period()).unwrap_or_default();
        let ranges = measured.into_iter().filter_map(|one| Some((one.label, one.time?)));
        let mut ranges: Vec<_> = ranges.collect();
        ranges.sort_by(|(_, one), (_, other)| one.start.total_cmp(&other.start));
        let first = ranges.first().map_or(0.0, |(_, range)| range.start);
        let seconds = |time: f64| Duration::try_from_secs_f64(time.max(0.0)).unwrap_or_default();
        let times = ranges.into_iter().map(|(pass, range)| GpuTime {
            pass,
            start: seconds(range.start - first),
            time: seconds(range.end - range.start),
        });
        times.collect()
    }
}
