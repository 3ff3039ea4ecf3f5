//! The window: bars above and below, and between them the live frame with panels around it ([`crate::dock`]).
//!
//! Nothing here draws a pipeline ([`Stage`] does) or knows a control ([`crate::parameters`], [`crate::graph`],
//! [`crate::inspector`], [`crate::timings`], [`crate::notices`]): it says what is where, and carries actions out
//! ([`crate::act`]).

use std::time::{Duration, Instant};

use eframe::egui::{self, Color32};
use eframe::egui_wgpu::RenderState;
use umbragraph::low_level::camera_path::CameraPath;
use umbragraph::low_level::report::Report;
use umbragraph::wgpu;

use crate::actions;
use crate::arguments::Arguments;
use crate::camera::View;
use crate::capture::{Planned, Planning, Request};
use crate::clock::{Clock, Resolution};
use crate::dock::{Dock, FOCUS, Pane};
use crate::graph::{Selected, report};
use crate::inspector::{Inspector, Wish};
use crate::output::{Clip, Picture};
use crate::parameters::Panel;
use crate::places::Places;
use crate::save::Written;
use crate::stage::{Shot, Stage};
use crate::timings::Timings;
use crate::values::Values;

/// The delay between the last change of the frame's area and the change of the frame's resolution.
const SIZE_SETTLES: Duration = Duration::from_millis(150);

/// The time for which the status bar shows a message.
const MESSAGE_STAYS: Duration = Duration::from_secs(30);

/// The application: the state of the window and its panels.
pub(crate) struct Viewer {
    pub(crate) arguments: Arguments,
    pub(crate) stage: Stage,
    pub(crate) view: Option<View>,
    /// The path that the camera follows; [`CameraPath::Scene`] once the user moves it by hand.
    pub(crate) path: CameraPath,
    pub(crate) bookmarks: Vec<View>,
    pub(crate) values: Values,
    pub(crate) clock: Clock,
    pub(crate) resolution: Resolution,
    pub(crate) panel: Panel,
    pub(crate) inspector: Inspector,
    pub(crate) timings: Timings,
    /// The report of the running plan, shown as the graph; `None` if there is no plan.
    pub(crate) report: Option<Report>,
    pub(crate) search: String,
    pub(crate) dock: Dock,
    /// The selection of the inspector in the last frame; a new one opens it.
    was_selected: Option<Selected>,
    /// Whether a control had the keyboard at the end of the last frame.
    had_focus: bool,
    pub(crate) has_help: bool,
    pub(crate) wants_search: bool,
    pub(crate) wants_graph_search: bool,
    pub(crate) places: Places,
    pub(crate) clip: Option<Clip>,
    /// The message in the status bar, and whether it is an error.
    pub(crate) message: (String, bool),
    /// The time of the message, after which it fades.
    pub(crate) said: Instant,
    pub(crate) adapter: String,
    pub(crate) planning: Option<Planning>,
    pub(crate) planned: Option<Planned>,
    /// The value of `Stage::index` just after the last captures, and these captures.
    pub(crate) captured: (u64, Request),
    /// The size of the frame's area in pixels, and the time of its last change.
    area: ([u32; 2], Instant),
    pub(crate) size: Option<[u32; 2]>,
    /// The parameter file that the window has written.
    pub(crate) written: Option<Written>,
    /// The values that were saved into the document, until the document's own count again; `None` otherwise.
    pub(crate) saved: Option<Values>,
    /// The last error about an unknown name for which values of the window were looked through; `None` without one.
    pub(crate) unknown: Option<String>,
    /// Whether a dropped scene has not been shown yet.
    pub(crate) has_dropped_scene: bool,
    /// Whether the files had errors in the last frame, so that their diagnostics have been opened once.
    was_broken: bool,
}

impl Viewer {
    /// Creates the application.
    ///
    /// # Errors
    /// An error message if the state log cannot be written, or files cannot be watched.
    pub(crate) fn new(
        context: &eframe::CreationContext<'_>,
        arguments: Arguments,
        path: CameraPath,
    ) -> Result<Self, String> {
        let state = context.wgpu_render_state.as_ref().ok_or("eframe draws without wgpu\n")?;
        let places =
            Places::new(arguments.log_state.as_deref()).map_err(|error| format!("--log-state: {error}\n"))?;
        let stage = Stage::new(&arguments, state, &context.egui_ctx).map_err(|error| error.to_string())?;
        let environment = arguments.environment.as_ref().map(|_| ("environment".to_owned(), true.into()));
        let values = Values {
            preset: arguments.preset.clone(),
            parameters: arguments.set.iter().cloned().collect(),
            features: arguments.feature.iter().cloned().chain(environment).collect(),
            toggles: arguments.toggle.iter().cloned().collect(),
        };
        let info = state.adapter.get_info();
        crate::start::style(&context.egui_ctx);
        Ok(Self {
            stage,
            view: None,
            path,
            bookmarks: Vec::new(),
            values,
            clock: Clock::new(),
            resolution: Resolution::new(arguments.scale),
            panel: Panel::default(),
            inspector: Inspector::default(),
            timings: Timings::default(),
            report: None,
            search: String::new(),
            dock: Dock::default(),
            was_selected: None,
            had_focus: false,
            has_help: false,
            wants_search: false,
            wants_graph_search: false,
            places,
            clip: None,
            message: (String::new(), false),
            said: Instant::now(),
            adapter: format!("{} ({})", info.name, info.backend),
            planning: None,
            planned: None,
            captured: (0, Request::default()),
            area: ([0; 2], Instant::now()),
            size: None,
            written: None,
            saved: None,
            unknown: None,
            has_dropped_scene: false,
            was_broken: false,
            arguments,
        })
    }

    /// Shows a message in the status bar, as an error for `Err`.
    pub(crate) fn say(&mut self, outcome: Result<String, String>) {
        self.said = Instant::now();
        self.message = match outcome {
            Ok(said) => (said, false),
            Err(said) => (said, true),
        };
    }

    /// Shows the frame in its panel, and moves the camera.
    pub(crate) fn frame(&mut self, ui: &mut egui::Ui) {
        let area = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(area, egui::Sense::click_and_drag());
        self.places.note("frame", &response);
        self.follow_path();
        self.steer(ui, &response);
        self.fit(ui, area.size());
        if let Some((id, _)) = self.stage.targets.shown() {
            let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter().image(id, area, whole, Color32::WHITE);
        } else {
            let words = if self.stage.error().is_some() { "" } else { "loading …" };
            let font = egui::FontId::proportional(16.0);
            ui.painter().text(area.center(), egui::Align2::CENTER_CENTER, words, font, Color32::GRAY);
        }
        if response.has_focus() {
            let stroke = egui::Stroke::new(2.0, FOCUS);
            ui.painter().rect_stroke(area, 0.0, stroke, egui::StrokeKind::Inside);
        }
    }

    /// Draws the next frame, if there is anything to draw.
    fn update(&mut self, state: &RenderState, context: &egui::Context) {
        // Callbacks of the device come with a poll.
        let _ = state.device.poll(wgpu::PollType::Poll);
        if let Some(milliseconds) = self.stage.take_frame_time() {
            self.timings.whole(milliseconds);
            let scale = self.stage.scale_of(self.area.0);
            self.resolution.measured(milliseconds, scale);
        }
        if let Some(size) = self.size {
            if self.stage.take_scene(state) {
                self.begin_scene();
                if self.view.is_none() {
                    self.view = self.stage.scene().map(View::home);
                    self.begin_path();
                }
            }
            let shot = Shot { size, values: &self.values, view: self.view.as_ref(), time: self.clock.time };
            let is_drawn = self.stage.update(state, shot, context);
            if is_drawn {
                self.drawn(state);
            }
            self.notice_plan();
            self.follow_files();
            self.capture(state, context, size);
        }
        if !self.message.0.is_empty() {
            let left = MESSAGE_STAYS.saturating_sub(self.said.elapsed());
            if left.is_zero() {
                self.message.0.clear();
            }
            context.request_repaint_after(left);
        }
        if self.stage.is_busy() || self.resolution.is_moving() {
            context.request_repaint_after(Duration::from_millis(8));
        }
    }

    /// Returns `true` if the frame does not yet have the size of its area.
    pub(crate) fn is_resizing(&self) -> bool {
        self.area.1.elapsed() < SIZE_SETTLES
            || (self.size.is_some() && self.size != self.stage.targets.shown().map(|(_, size)| size))
    }

    /// Sets the size of the frame from its area, once the area has stopped changing.
    fn fit(&mut self, ui: &egui::Ui, area: egui::Vec2) {
        let pixels = area * ui.ctx().pixels_per_point();
        let area = [pixels.x, pixels.y].map(|side| (side.round() as u32).max(16));
        if area != self.area.0 {
            self.area = (area, Instant::now());
        }
        // The frames of a clip have one size.
        if self.size.is_some() && self.clip.is_some() {
            return;
        }
        if self.size.is_some() && self.area.1.elapsed() < SIZE_SETTLES {
            ui.ctx().request_repaint_after(SIZE_SETTLES);
            return;
        }
        let scale = self.resolution.scale();
        self.size = Some(area.map(|side| ((side as f32 * scale).round() as u32).max(16)));
    }

    /// Processes a frame that was drawn: records its times, and adds its picture to the clip.
    fn drawn(&mut self, state: &RenderState) {
        if let Some(executor) = self.stage.renderer.executor() {
            self.timings.frame(executor);
        }
        if let (Some(clip), Some(texture)) = (&mut self.clip, self.stage.targets.picture()) {
            match Picture::read(&state.device, &state.queue, texture) {
                Ok(picture) => clip.push(picture, self.clock.time, self.clock.is_playing),
                Err(reason) => {
                    (self.message, self.said) = ((reason, true), Instant::now());
                }
            }
            if clip.is_full() {
                self.end_clip();
            }
        }
    }

    /// Updates the graph and the timings if a new plan runs, and opens the diagnostics if the files have errors.
    fn notice_plan(&mut self) {
        let is_new = self.stage.take_new_plan();
        if is_new && let Some(plan) = &self.stage.plan {
            self.report = report(plan);
            if let Some(path) = self.stage.path().filter(|path| *path != self.arguments.pipeline) {
                self.arguments.pipeline = path.to_owned();
                // A parameter file that was written holds the values of the pipeline before.
                self.written = None;
            }
            let known = |timings: &Timings, report: &Report| timings.is_of(report);
            if self.report.as_ref().is_none_or(|report| !known(&self.timings, report)) {
                self.timings.clear();
            }
        }
        let is_broken = self.stage.error().is_some();
        if is_broken && !self.was_broken {
            self.dock.open(Pane::Notices, true);
        }
        self.was_broken = is_broken;
    }

    /// Shows the panel of parameters, features and toggles, and its save buttons.
    pub(crate) fn values_panel(&mut self, ui: &mut egui::Ui) {
        let Some(plan) = self.stage.plan.clone() else { return };
        let document = self.stage.pipeline().map(|pipeline| pipeline.document().clone());
        let mut saves = Vec::new();
        let frame = egui::Frame::new().inner_margin(egui::Margin { top: 6, bottom: 2, ..Default::default() });
        egui::Panel::bottom("save").show_separator_line(true).frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                use actions::Action;
                for (label, action) in [
                    ("Save as parameter file", Action::SaveParameters),
                    ("Save into document", Action::SaveDocument),
                ] {
                    let button = ui.add_enabled(!self.values.is_empty(), egui::Button::new(label));
                    self.places.note(&label.to_lowercase(), &button);
                    if button.on_hover_text(actions::key_of(action)).clicked() {
                        saves.push(action);
                    }
                }
            });
        });
        let before = self.values.clone();
        let search = std::mem::take(&mut self.wants_search);
        self.panel.show(ui, &plan, document.as_ref(), &mut self.values, &mut self.places, search);
        if self.values != before {
            self.resolution.touch();
        }
        for action in saves {
            self.act(action, ui.ctx(), None);
        }
    }

    /// Shows the graph of passes and resources.
    pub(crate) fn graph_panel(&mut self, ui: &mut egui::Ui) {
        let Some(report) = &self.report else { return };
        let selected = self.inspector.selected.as_ref();
        let is_searched = std::mem::take(&mut self.wants_graph_search);
        let search = (&mut self.search, is_searched);
        let clicked = crate::graph::show(ui, report, selected, search, &mut self.places);
        if let Some(clicked) = clicked {
            self.inspector.select(clicked, report);
        }
    }

    /// Shows the times of the passes.
    pub(crate) fn times_panel(&mut self, ui: &mut egui::Ui) {
        let clicked = self.timings.show(ui, self.stage.has_gpu_times, &mut self.places);
        if let (Some(pass), Some(report)) = (clicked, &self.report) {
            self.inspector.select(Selected::Pass(pass), report);
        }
    }

    /// Shows the inspector beside the frame and carries out its requests.
    pub(crate) fn inspect(&mut self, ui: &mut egui::Ui) {
        let (Some(plan), Some(report)) = (&self.stage.plan, &self.report) else { return };
        match self.inspector.show(ui, plan, report, &self.timings, &mut self.places) {
            Some(Wish::Select(selected)) => self.inspector.select(selected, report),
            Some(Wish::Open(place)) => self.open(&place),
            Some(Wish::Close) => self.inspector.selected = None,
            None => {}
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let Some(state) = frame.wgpu_render_state().cloned() else { return };
        let context = ui.ctx().clone();
        for action in actions::pressed(&context, self.had_focus) {
            self.act(action, &context, Some(&state));
        }
        self.take_dropped(&context);
        // A clip misses no moment: the next one comes once a frame shows this one.
        let step = self.clip.as_ref().map(|clip| clip.step_after(self.clock.time));
        if self.clock.advance(step) {
            self.stage.touch();
            self.resolution.touch();
        }
        egui::Panel::top("bar").show(ui, |ui| self.bar(ui, &state));
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui));
        egui::CentralPanel::no_frame().show(ui, |ui| self.panels(ui));
        self.update(&state, &context);
        if self.inspector.selected != self.was_selected {
            self.dock.open(Pane::Inspector, self.inspector.selected.is_some());
            self.was_selected.clone_from(&self.inspector.selected);
            context.request_repaint();
        }
        self.had_focus = context.memory(|memory| memory.focused().is_some());
        actions::help(&context, &mut self.has_help);
        if self.places.is_on() {
            let log = self.state(&context);
            self.places.write(log);
        }
    }
}
