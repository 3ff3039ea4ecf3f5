//! The bars above and below the frame, and the list of diagnostics.

use eframe::egui::{self, Color32, RichText};
use eframe::egui_wgpu::RenderState;
use umbragraph::diagnostic::{Diagnostic, Severity, counted};
use umbragraph::low_level::report::bytes_in_words;
use umbragraph::low_level::source::Sources;

use crate::actions::{Action, KEYED, key_of};
use crate::app::Viewer;
use crate::camera::Mode;
use crate::clock::STEPS;
use crate::dock::Pane;
use crate::notices;

/// The width of the buttons at the right end of the bar, in points.
const PANEL_BUTTONS: f32 = 330.0;

impl Viewer {
    /// Shows the bar above the frame and carries out the actions of its buttons.
    pub(crate) fn bar(&mut self, ui: &mut egui::Ui, state: &RenderState) {
        let mut actions = Vec::new();
        ui.add_space(3.0);
        ui.horizontal(|ui| {
            self.animation(ui, &mut actions);
            ui.separator();
            let is_fly = self.view.as_ref().is_some_and(|view| view.mode == Mode::Fly);
            self.button(ui, if is_fly { "Fly" } else { "Orbit" }, "mode", Action::Mode, false, &mut actions);
            self.button(ui, "Home", "home", Action::Home, false, &mut actions);
            self.button(ui, "+ Bookmark", "bookmark", Action::Bookmark, false, &mut actions);
            for at in 0..self.bookmarks.len().min(KEYED) {
                let label = (at + 1).to_string();
                self.button(ui, &label, &format!("visit {label}"), Action::Visit(at), false, &mut actions);
            }
            ui.separator();
            self.resolutions(ui);
            ui.separator();
            let is_clip = self.clip.is_some();
            self.button(ui, "Screenshot", "screenshot", Action::Screenshot, false, &mut actions);
            let clip = if is_clip { "End clip" } else { "Clip" };
            self.button(ui, clip, "clip", Action::Clip, is_clip, &mut actions);
            self.button(ui, "Copy command", "copy command", Action::CopyCommand, false, &mut actions);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                // In a narrow window the menu alone opens panels.
                let has_room = ui.available_width() >= PANEL_BUTTONS;
                self.button(ui, "?", "help", Action::Help, self.has_help, &mut actions);
                self.layout_menu(ui, &mut actions);
                for pane in [Pane::Notices, Pane::Times, Pane::Graph, Pane::Values] {
                    if !has_room {
                        break;
                    }
                    let (title, is_shown) = (pane.title(), self.dock.is_shown(pane));
                    let name = title.to_lowercase();
                    self.button(ui, title, &name, Action::Panel(pane), is_shown, &mut actions);
                }
            });
        });
        ui.add_space(3.0);
        for action in actions {
            self.act(action, ui.ctx(), Some(state));
        }
    }

    /// Shows the menu of the panels: which are open, and the default layout.
    fn layout_menu(&mut self, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
        let menu = ui.menu_button("Layout", |ui| {
            for pane in Pane::ALL.into_iter().filter(|pane| *pane != Pane::Frame) {
                let mut is_open = self.dock.is_open(pane);
                let key = key_of(Action::Panel(pane));
                let open = ui.checkbox(&mut is_open, format!("{}   {key}", pane.title()));
                self.places.note(&format!("open {}", pane.title()), &open);
                if open.clicked() {
                    match is_open {
                        true => self.dock.open(pane, true),
                        false => self.close_panel(pane),
                    }
                }
            }
            ui.separator();
            let reset = ui.button("Reset layout");
            self.places.note("reset layout", &reset);
            if reset.clicked() {
                actions.push(Action::ResetPanels);
                ui.close();
            }
        });
        self.places.note("layout menu", &menu.response);
    }

    fn button(
        &mut self,
        ui: &mut egui::Ui,
        label: &str,
        name: &str,
        action: Action,
        is_on: bool,
        actions: &mut Vec<Action>,
    ) {
        let button = ui.add(egui::Button::new(label).selected(is_on));
        self.places.note(name, &button);
        let key = key_of(action);
        let button = if key.is_empty() { button } else { button.on_hover_text(format!("key: {key}")) };
        if button.clicked() {
            actions.push(action);
        }
    }

    /// Shows the controls of the animation: play, step and time.
    fn animation(&mut self, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
        let label = if self.clock.is_playing { "Pause" } else { "Play" };
        self.button(ui, label, "play", Action::Play, self.clock.is_playing, actions);
        self.button(ui, "Step", "step", Action::Step, false, actions);
        let animations = self.stage.scene().map(|scene| &scene.animations);
        let longest =
            animations.into_iter().flatten().fold(0.0, |longest: f64, one| longest.max(one.duration));
        ui.spacing_mut().slider_width = 90.0;
        let end = if longest > 0.0 { longest } else { 10.0 };
        let before = self.clock.time % end.max(1e-3);
        let mut time = before;
        let slider = egui::Slider::new(&mut time, 0.0..=end).fixed_decimals(2).suffix(" s");
        let slider = ui.add(slider).on_hover_text("The time of the scene's animations");
        self.places.note("time", &slider);
        // It rounds what it shows; that is no change.
        if slider.changed() && (time - before).abs() > 0.006 {
            self.clock.time = time;
            self.stage.touch();
        }
    }

    /// Shows the list of frame resolutions.
    fn resolutions(&mut self, ui: &mut egui::Ui) {
        let percent = |scale: f32| format!("{:.0} %", scale * 100.0);
        let now = self.resolution.scale();
        let text = match self.resolution.fixed {
            Some(scale) => percent(scale),
            None => format!("auto {}", percent(now)),
        };
        let list = egui::ComboBox::from_id_salt("resolution").width(92.0).selected_text(text);
        let list = list.show_ui(ui, |ui| {
            ui.selectable_value(&mut self.resolution.fixed, None, "auto");
            for step in STEPS {
                let response = ui.selectable_value(&mut self.resolution.fixed, Some(step), percent(step));
                self.places.note(&format!("resolution={step}"), &response);
            }
        });
        self.places.note("resolution", &list.response);
        list.response.on_hover_text("Texels of the frame per pixel of the window (− and +)");
    }

    /// Shows the status bar at the bottom of the window.
    pub(crate) fn status(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            let errors = self.stage.error().map_or(0, |error| error.error_count());
            let is_warning = |one: &&Diagnostic| one.severity == Severity::Warning;
            let warnings = self.stage.warnings().0.iter().filter(is_warning).count();
            let (words, color) = match (errors, self.stage.targets.shown().is_some()) {
                (0, true) if warnings > 0 => {
                    (format!("live, {}", counted(warnings, "warning")), notices::color_of(Severity::Warning))
                }
                (0, true) => ("live".to_owned(), Color32::from_rgb(126, 200, 140)),
                (0, false) => ("loading".to_owned(), Color32::GRAY),
                (_, true) => {
                    ("broken: the frame is the last good one".to_owned(), notices::color_of(Severity::Error))
                }
                (_, false) => ("broken".to_owned(), notices::color_of(Severity::Error)),
            };
            let status = ui.link(RichText::new(words).color(color).strong());
            self.places.note("status", &status);
            if status.clicked() {
                self.dock.open(Pane::Notices, true);
            }
            ui.separator();
            if let Some((_, [width, height])) = self.stage.targets.shown() {
                ui.label(format!("{width} × {height}"));
            }
            if let Some(times) = self.timings.whole_frames() {
                ui.label(format!("{:.1} ms", times.median));
            }
            if let Some(plan) = &self.stage.plan {
                let count = plan.textures.len() + plan.buffers.len();
                let words = format!("{} in {count} textures and buffers", bytes_in_words(plan.bytes));
                ui.label(words).on_hover_text("Device memory of the plan that runs");
            }
            if let Some(clip) = &self.clip {
                ui.label(
                    RichText::new(format!("recording: {} frames", clip.len()))
                        .color(Color32::from_rgb(240, 120, 110)),
                );
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(RichText::new(&self.adapter).weak());
                let (said, is_bad) = &self.message;
                let color = if *is_bad {
                    notices::color_of(Severity::Error)
                } else {
                    ui.visuals().strong_text_color()
                };
                ui.add(egui::Label::new(RichText::new(said).color(color)).truncate());
            });
        });
    }

    /// Shows the diagnostics of the files and the notices of the frame.
    pub(crate) fn notices(&mut self, ui: &mut egui::Ui) {
        let mut wish = None;
        let lists = self.diagnostics();
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut first = 0;
            for (heading, list, sources) in lists.iter().filter(|list| !list.1.is_empty()) {
                ui.label(RichText::new(*heading).small().strong().weak());
                let clicked = notices::show(ui, list.iter(), first, sources, &mut self.places);
                wish = wish.take().or(clicked);
                first += list.len();
            }
            if first == 0 {
                ui.label(
                    RichText::new("Nothing is wrong with the files, and the frame has no notices.").weak(),
                );
            }
        });
        match wish {
            Some(notices::Wish::Open(place)) => self.open(&place),
            Some(notices::Wish::Mend(diagnostic, sources)) => {
                let said = notices::mend(&diagnostic, &sources);
                self.say(said);
            }
            None => {}
        }
    }

    /// The lists of diagnostics with their headings and sources: errors of the files, else their warnings; then what
    /// the frame lacks.
    fn diagnostics(&mut self) -> [(&'static str, Vec<Diagnostic>, Sources); 3] {
        let (errors, sources) = match self.stage.error() {
            Some(error) => (error.iter().cloned().collect(), error.sources().clone()),
            None => (Vec::new(), Sources::new()),
        };
        let (warnings, of_files) = self.stage.warnings();
        // An error comes with the warnings of its files.
        let warnings = if errors.is_empty() { warnings } else { Vec::new() };
        let of_plan = self.stage.plan.as_ref().map(|plan| plan.pipeline.sources.clone()).unwrap_or_default();
        [
            ("ERRORS", errors, sources),
            ("WARNINGS", warnings, of_files),
            ("NOTICES OF THE FRAME", self.stage.notices(), of_plan),
        ]
    }
}
