//! The times of passes over the last frames: on the CPU, and on the GPU where the device measures them.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use eframe::egui::{self, Color32, RichText, vec2};
use serde_json::{Value, json};
use umbragraph::Executor;
use umbragraph::low_level::report::Report;

use crate::chart::{self, Line};
use crate::places::Places;

/// The width of the table of times, in points; the lines have the rest.
const TABLE: f32 = 752.0;

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
    /// The pass whose row is under the pointer, or has the keyboard.
    hovered: Option<String>,
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

    /// Shows the table of times, with a line for each pass. Returns the name of the pass that was clicked. `has_gpu` is
    /// `false` if the device measures no GPU times.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, has_gpu: bool, places: &mut Places) -> Option<String> {
        let area = ui.available_rect_before_wrap();
        let width = (area.width() - TABLE).max(220.0).min(area.width() / 2.0);
        let (table, chart) = area.split_left_right_at_x(area.right() - width);
        let response = ui.interact(chart, ui.scope_id().with("chart"), egui::Sense::hover());
        places.note("chart", &response);
        chart::plot(ui, chart, &self.lines(), FRAMES);
        let table = egui::UiBuilder::new().max_rect(table);
        ui.scope_builder(table, |ui| self.table(ui, has_gpu, places)).inner
    }

    /// Shows the times of complete frames, and the table. Returns the name of the pass that was clicked.
    fn table(&mut self, ui: &mut egui::Ui, has_gpu: bool, places: &mut Places) -> Option<String> {
        let mut clicked = None;
        ui.horizontal_wrapped(|ui| {
            let frames = self.frames.len();
            ui.label(RichText::new(format!("the last {frames} frames")).small().weak());
            if let Some(times) = self.whole_frames() {
                ui.label(RichText::new("whole frame").small());
                ui.monospace(said(&times));
            }
            if !has_gpu {
                ui.label(RichText::new("The device measures no times of passes (timestamp-query).").weak());
            }
        });
        ui.separator();
        let mut hovered = None;
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            egui::Grid::new("times").striped(true).num_columns(5).spacing([18.0, 4.0]).show(ui, |ui| {
                for title in
                    ["pass", "CPU: median · 95 % · max (ms)", "", "GPU: median · 95 % · max (ms)", ""]
                {
                    ui.label(RichText::new(title).small().weak());
                }
                ui.end_row();
                for (number, name) in self.names.iter().enumerate() {
                    let color = chart::color_of(number);
                    let text = RichText::new(name).color(color);
                    let pass = ui.selectable_label(self.hovered.as_ref() == Some(name), text);
                    places.note(&format!("time {name}"), &pass);
                    if pass.clicked() {
                        clicked = Some(name.clone());
                    }
                    if pass.hovered() || pass.has_focus() {
                        hovered = Some(name.clone());
                    }
                    for ((at, color), times) in [(0, CPU), (1, GPU)].into_iter().zip(self.of(name)) {
                        ui.monospace(times.map_or_else(|| "–".to_owned(), |times| said(&times)));
                        let (rect, _) = ui.allocate_exact_size(vec2(110.0, 20.0), egui::Sense::hover());
                        if times.is_some() {
                            chart::lines(ui, rect, &[Line { times: self.times(name, at), color }], FRAMES);
                        }
                    }
                    ui.end_row();
                }
            });
        });
        if self.hovered != hovered {
            self.hovered = hovered;
            ui.ctx().request_repaint();
        }
        clicked
    }

    /// The CPU times (0) or GPU times (1) of a pass in milliseconds, the newest last.
    fn times(&self, name: &str, at: usize) -> Vec<f64> {
        self.passes.get(name).into_iter().flatten().map(|times| times[at]).collect()
    }

    /// A line for each pass: of its GPU times, or else of its CPU times. The pass under the pointer is in front of the
    /// others.
    fn lines(&self) -> Vec<Line> {
        let line = |(number, name): (usize, &String)| {
            let kind = usize::from(self.of(name)[1].is_some());
            let is_behind = self.hovered.as_ref().is_some_and(|hovered| hovered != name);
            let color = chart::color_of(number).gamma_multiply(if is_behind { 0.25 } else { 1.0 });
            (!is_behind, Line { times: self.times(name, kind), color })
        };
        let mut lines: Vec<_> = self.names.iter().enumerate().map(line).collect();
        lines.sort_by_key(|(is_in_front, _)| *is_in_front);
        lines.into_iter().map(|(_, line)| line).collect()
    }

    /// The number of frames in the line of each pass as JSON, for the log that tests read.
    pub(crate) fn state(&self) -> Value {
        let lines = self.names.iter().map(|name| (name.clone(), json!(self.times(name, 0).len())));
        Value::Object(lines.collect())
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
