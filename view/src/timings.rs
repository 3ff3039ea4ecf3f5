//! The times of passes over the last frames: of the processor, and of the device where it measures them.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use eframe::egui::{self, Color32, RichText, vec2};
use umbragraph::Executor;
use umbragraph::low_level::report::Report;

use crate::places::Places;

/// The number of frames for which times are kept.
const FRAMES: usize = 120;

pub(crate) const CPU: Color32 = Color32::from_rgb(109, 157, 240);
pub(crate) const GPU: Color32 = Color32::from_rgb(240, 160, 90);

/// The CPU and GPU times of one pass in milliseconds, the newest last.
type Times = VecDeque<[f64; 2]>;

/// The times of the passes and of complete frames, for the last frames.
#[derive(Default)]
pub(crate) struct Timings {
    /// The names of the passes in the order of the plan.
    names: Vec<String>,
    passes: BTreeMap<String, Times>,
    /// The times of complete frames from recording to completion on the device, in milliseconds.
    frames: VecDeque<f64>,
}

/// The median, the 95th percentile and the maximum of some times, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Percentiles {
    pub(crate) median: f64,
    pub(crate) p95: f64,
    pub(crate) max: f64,
}

impl Percentiles {
    /// The percentiles of times; `None` if there are none.
    pub(crate) fn of(times: impl Iterator<Item = f64>) -> Option<Self> {
        let mut times: Vec<f64> = times.collect();
        times.sort_unstable_by(f64::total_cmp);
        let at = |part: f64| times.get(((times.len().max(1) - 1) as f64 * part).round() as usize).copied();
        Some(Self { median: at(0.5)?, p95: at(0.95)?, max: at(1.0)? })
    }
}

impl Timings {
    /// Removes all times, for a new plan.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Returns `true` if all timed passes are live passes of a report.
    pub(crate) fn is_of(&self, report: &Report) -> bool {
        self.names.iter().all(|name| report.passes.iter().any(|pass| pass.live && pass.name == *name))
    }

    /// Adds the pass times of the last recorded frame. Its GPU times are those of an earlier frame, which the device
    /// has finished.
    pub(crate) fn frame(&mut self, executor: &mut Executor) {
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
        let mut frame: BTreeMap<String, [f64; 2]> = BTreeMap::new();
        let mut names = Vec::new();
        for (name, time) in executor.times() {
            frame.entry(name.to_owned()).or_default()[0] += milliseconds(time);
            names.push(name.to_owned());
        }
        for one in executor.gpu_times() {
            frame.entry(one.pass).or_default()[1] += milliseconds(one.time);
        }
        names.dedup();
        self.names = names;
        for (name, times) in frame {
            push(self.passes.entry(name).or_default(), times);
        }
    }

    /// Adds the time of a complete frame, in milliseconds.
    pub(crate) fn whole(&mut self, milliseconds: f64) {
        push(&mut self.frames, milliseconds);
    }

    /// The percentiles of the CPU times and the GPU times of a pass; `None` for times that were not measured.
    pub(crate) fn of(&self, pass: &str) -> [Option<Percentiles>; 2] {
        let times = self.passes.get(pass);
        [0, 1].map(|at| {
            let times = times.into_iter().flatten().map(|times| times[at]).filter(|time| *time > 0.0);
            Percentiles::of(times)
        })
    }

    /// The percentiles of the times of complete frames; `None` if there are none.
    pub(crate) fn whole_frames(&self) -> Option<Percentiles> {
        Percentiles::of(self.frames.iter().copied())
    }

    /// Shows the table of times. Returns the name of the pass that was clicked. `has_gpu` is `false` if the device
    /// measures no GPU times.
    pub(crate) fn show(&self, ui: &mut egui::Ui, has_gpu: bool, places: &mut Places) -> Option<String> {
        let mut clicked = None;
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("frame").strong());
            let (rect, _) = ui.allocate_exact_size(vec2(260.0, 30.0), egui::Sense::hover());
            graph(ui, rect, self.frames.iter().copied(), CPU);
            if let Some(times) = self.whole_frames() {
                ui.monospace(said(&times));
            }
            if !has_gpu {
                ui.label(RichText::new("The device measures no times of passes (timestamp-query).").weak());
            }
        });
        ui.separator();
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            egui::Grid::new("times").striped(true).num_columns(5).spacing([18.0, 4.0]).show(ui, |ui| {
                for title in [
                    "pass",
                    "processor: median · 95 % · max (ms)",
                    "",
                    "device: median · 95 % · max (ms)",
                    "",
                ] {
                    ui.label(RichText::new(title).small().weak());
                }
                ui.end_row();
                for name in &self.names {
                    let pass = ui.selectable_label(false, name);
                    places.note(&format!("time {name}"), &pass);
                    if pass.clicked() {
                        clicked = Some(name.clone());
                    }
                    for ((at, color), times) in [(0, CPU), (1, GPU)].into_iter().zip(self.of(name)) {
                        ui.monospace(times.map_or_else(|| "–".to_owned(), |times| said(&times)));
                        let (rect, _) = ui.allocate_exact_size(vec2(84.0, 18.0), egui::Sense::hover());
                        if times.is_some() {
                            let of = self.passes.get(name).into_iter().flatten();
                            graph(ui, rect, of.map(|times| times[at]), color);
                        }
                    }
                    ui.end_row();
                }
            });
        });
        clicked
    }
}

fn push<T>(times: &mut VecDeque<T>, time: T) {
    if times.len() == FRAMES {
        times.pop_front();
    }
    times.push_back(time);
}

fn said(times: &Percentiles) -> String {
    format!("{:7.3} {:7.3} {:7.3}", times.median, times.p95, times.max)
}

/// Draws a bar for each time from the oldest to the newest, relative to the longest time.
fn graph(ui: &egui::Ui, rect: egui::Rect, times: impl Iterator<Item = f64> + Clone, color: Color32) {
    let max = times.clone().fold(1e-9, f64::max);
    let width = rect.width() / FRAMES as f32;
    ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    for (at, time) in times.enumerate() {
        let height = (time / max) as f32 * rect.height();
        let left = rect.left() + at as f32 * width;
        let bar = egui::Rect::from_min_max(
            egui::pos2(left, rect.bottom() - height),
            egui::pos2(left + (width - 0.5).max(0.5), rect.bottom()),
        );
        ui.painter().rect_filled(bar, 0.0, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_sorted_times() {
        let times = Percentiles::of((1..=101).rev().map(f64::from));
        assert_eq!(times, Some(Percentiles { median: 51.0, p95: 96.0, max: 101.0 }));
        assert_eq!(Percentiles::of(std::iter::empty()), None);
    }
}
