//! `--timings` and `--trace`: how long the processor and the GPU work on each pass.
//!
//! The table has the mean of all frames but the first, in which objects are made, unless there is only one. The trace
//! is of all frames, in the form that Perfetto and Chrome read (JSON, complete events in microseconds): one row for the
//! processor, one for the GPU. Their clocks are not the same: the GPU's row of a frame begins where the processor's
//! record of it ends.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::json;
use umbragraph::Executor;
use umbragraph::diagnostic::Diagnostic;

use crate::replace::replace;

/// The CPU and GPU times of the rendered frames.
pub(super) struct Timings {
    /// The reason why the GPU times are missing; `None` if they are measured.
    without_gpu: Option<String>,
    /// The names of passes in the order of the plan.
    names: Vec<String>,
    /// The CPU and the GPU time of each frame, by pass.
    passes: BTreeMap<String, Vec<[Duration; 2]>>,
    preparations: Vec<Duration>,
    began: Instant,
    events: Vec<serde_json::Value>,
}

const PROCESSOR: u32 = 1;
const GPU: u32 = 2;

impl Timings {
    /// Begins to measure the times of passes.
    pub(super) fn begin(executor: &mut Executor, device: &str) -> Self {
        executor.measure_times(true);
        let can = executor.measure_gpu_times(true);
        let without_gpu = (!can)
            .then(|| format!("{device} has no timestamps (timestamp-query): the GPU's times are missing"));
        let row = |tid: u32, name: &str| json!({ "ph": "M", "name": "thread_name", "pid": 1, "tid": tid, "args": { "name": name } });
        Self {
            without_gpu,
            names: Vec::new(),
            passes: BTreeMap::new(),
            preparations: Vec::new(),
            began: Instant::now(),
            events: vec![row(PROCESSOR, "processor"), row(GPU, "GPU")],
        }
    }

    /// Adds the times of a submitted frame, which was recorded between the instants `start` and `end`.
    pub(super) fn frame(&mut self, executor: &mut Executor, [start, end]: [Instant; 2], index: u64) {
        let mut of_frame: BTreeMap<String, [Duration; 2]> = BTreeMap::new();
        let start = start.duration_since(self.began);
        let end = end.duration_since(self.began);
        self.event(PROCESSOR, &format!("frame {index}"), start, end.saturating_sub(start));
        let times: Vec<(String, Duration)> =
            executor.times().map(|(name, time)| (name.to_owned(), time)).collect();
        let starts: Vec<Duration> = executor.starts().collect();
        self.names = times.iter().map(|(name, _)| name.clone()).collect();
        for ((name, time), at) in times.into_iter().zip(starts) {
            if time > Duration::ZERO {
                self.event(PROCESSOR, &name, start + at, time);
            }
            of_frame.entry(name).or_default()[0] += time;
        }
        self.preparations.push(executor.preparation_time());
        for one in executor.gpu_times() {
            self.event(GPU, &one.pass, end + one.start, one.time);
            of_frame.entry(one.pass).or_default()[1] += one.time;
        }
        for (name, times) in of_frame {
            self.passes.entry(name).or_default().push(times);
        }
    }

    fn event(&mut self, row: u32, name: &str, start: Duration, time: Duration) {
        let microseconds = |time: Duration| time.as_secs_f64() * 1e6;
        self.events.push(json!({
            "ph": "X", "name": name, "pid": 1, "tid": row, "ts": microseconds(start), "dur": microseconds(time)
        }));
    }

    /// Returns the mean CPU and GPU time of each pass, in milliseconds.
    pub(super) fn means(&self) -> BTreeMap<String, [f64; 2]> {
        let of = |frames: &[[Duration; 2]]| {
            [0, 1].map(|at| mean(frames.iter().map(|times| times[at])).as_secs_f64() * 1e3)
        };
        self.passes.iter().map(|(name, frames)| (name.clone(), of(frames))).collect()
    }

    /// Returns a text table of the mean times.
    pub(super) fn table(&self) -> String {
        let width =
            self.names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max("preparation".len());
        let row = |name: &str, cells: [String; 2]| {
            let [processor, gpu] = cells;
            format!("  {name:<width$}  {processor:>12}  {gpu:>12}\n")
        };
        let mut table = row("pass", ["processor".to_owned(), "GPU".to_owned()]);
        let shown = |time: Duration| format!("{:.3} ms", time.as_secs_f64() * 1e3);
        let mut sum = [Duration::ZERO; 2];
        for name in &self.names {
            let frames = self.passes.get(name).map(Vec::as_slice).unwrap_or_default();
            let times = [0, 1].map(|at| mean(frames.iter().map(|times| times[at])));
            sum = [sum[0] + times[0], sum[1] + times[1]];
            let is_measured = self.without_gpu.is_none() && times[1] > Duration::ZERO;
            let gpu = if is_measured { shown(times[1]) } else { String::new() };
            table.push_str(&row(name, [shown(times[0]), gpu]));
        }
        let preparation = mean(self.preparations.iter().copied());
        table.push_str(&row("preparation", [shown(preparation), String::new()]));
        let gpu = if self.without_gpu.is_none() { shown(sum[1]) } else { String::new() };
        table.push_str(&row("together", [shown(sum[0] + preparation), gpu]));
        if let Some(reason) = &self.without_gpu {
            let _ = writeln!(table, "  {reason}");
        }
        table
    }

    /// Writes the times as a trace file, and returns a line that names the written file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn trace(&self, path: &Path) -> Result<String, Diagnostic> {
        let text = json!({ "traceEvents": self.events, "displayTimeUnit": "ms" }).to_string();
        replace(path, text + "\n")?;
        let without = self.without_gpu.as_ref().map(|reason| format!("; {reason}")).unwrap_or_default();
        Ok(format!("{}: a trace, to be opened at ui.perfetto.dev{without}\n", path.display()))
    }
}

/// Returns the mean of all times but the first, which counts only if it is the only one.
fn mean(times: impl ExactSizeIterator<Item = Duration>) -> Duration {
    let skipped = usize::from(times.len() > 1);
    let count = times.len() - skipped;
    times
        .skip(skipped)
        .sum::<Duration>()
        .checked_div(u32::try_from(count).unwrap_or(u32::MAX))
        .unwrap_or_default()
}
