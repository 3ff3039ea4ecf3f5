//! Facts of a pass or a resource, as the plan has them, and pictures of captures.

use std::sync::Arc;

use eframe::egui::{self, Color32, RichText};
use eframe::egui_wgpu::RenderState;
use umbragraph::Plan;
use umbragraph::low_level::report::{PassReport, Report, ResourceReport, bytes_in_words};

use crate::app::Viewer;
use crate::capture::{Planning, Request};
use crate::contents::Contents;
use crate::dock::Pane;
use crate::graph::Selected;
use crate::places::Places;
use crate::timings::Timings;

/// The inspector panel: the selected pass or resource, and captured contents.
#[derive(Default)]
pub(crate) struct Inspector {
    pub(crate) selected: Option<Selected>,
    pub(crate) contents: Contents,
}

/// A request of the inspector to the window.
pub(crate) enum Wish {
    Select(Selected),
    /// Opens the declaration at `file:line` in an editor.
    Open(String),
    Close,
}

impl Viewer {
    /// Captures the inspected resource once for each shown frame, when no frame is in progress.
    pub(crate) fn capture(&mut self, state: &RenderState, context: &egui::Context, size: [u32; 2]) {
        let Some(plan) = self.stage.plan.clone() else { return };
        let is_open = self.dock.is_shown(Pane::Inspector);
        let wanted = if is_open { self.inspector.wanted(&plan) } else { Request::default() };
        self.stage.look(!wanted.captures.is_empty());
        if wanted.captures.is_empty() || self.stage.is_busy() || plan.viewport != size {
            return;
        }
        if self.planning.as_ref().is_some_and(|planning| planning.is_for(&plan, &wanted))
            && let Some(outcome) = self.planning.as_ref().and_then(Planning::take)
        {
            match outcome {
                Ok(planned) => (self.planned, self.captured.0) = (Some(planned), 0),
                Err(error) => self.inspector.contents.error = Some(error.to_string()),
            }
        }
        match self.planned.take().filter(|planned| planned.is_for(&plan, &wanted)) {
            Some(planned) => {
                if self.captured.0 != self.stage.index || self.captured.1 != wanted {
                    match self.stage.capture(state, &planned, wanted.sample) {
                        Ok(captured) => {
                            let [name, pass] = self.inspector.contents.shown();
                            let tiles = self.stage.tiles(name, pass);
                            self.inspector.contents.take(wanted.clone(), captured, tiles);
                        }
                        Err(error) => self.inspector.contents.error = Some(error.to_string()),
                    }
                    // Once for each frame and look, whatever came of it.
                    self.captured = (self.stage.index, wanted);
                    context.request_repaint();
                }
                self.planned = Some(planned);
            }
            None => {
                if !self.planning.as_ref().is_some_and(|planning| planning.is_for(&plan, &wanted)) {
                    let (library, pipeline) = (&self.stage.library, &self.arguments.pipeline);
                    self.planning = Some(Planning::begin(library, pipeline, &plan, wanted, context));
                }
            }
        }
    }
}

impl Inspector {
    /// Selects a pass or a resource; a resource is shown after the last pass that writes it.
    pub(crate) fn select(&mut self, selected: Selected, report: &Report) {
        if let Selected::Resource(name) = &selected {
            let versions = versions(report, name);
            self.contents.look_at(name, versions.last().cloned());
        }
        self.selected = Some(selected);
    }

    /// Selects a resource as it is after a pass.
    pub(crate) fn select_version(&mut self, name: &str, pass: &str) {
        self.contents.look_at(name, Some(pass.to_owned()));
        self.selected = Some(Selected::Resource(name.to_owned()));
    }

    /// The captures to request for the selected resource; none if no resource is selected, or it cannot be shown.
    pub(crate) fn wanted(&self, plan: &Plan) -> Request {
        match &self.selected {
            Some(Selected::Resource(_)) => self.contents.wanted(plan),
            _ => Request::default(),
        }
    }

    /// Shows the panel. Returns the user's request, if any.
    pub(crate) fn show(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Arc<Plan>,
        report: &Report,
        timings: &Timings,
        places: &mut Places,
    ) -> Option<Wish> {
        let mut wish = None;
        match self.selected.clone() {
            None => {
                ui.label(RichText::new("Click a pass or a resource in the graph.").weak());
            }
            Some(Selected::Pass(name)) => match report.passes.iter().find(|pass| pass.name == name) {
                Some(pass) => self.pass(ui, pass, timings, places, &mut wish),
                None => missing(ui, &name),
            },
            Some(Selected::Resource(name)) => match report.resources.iter().find(|one| one.name == name) {
                Some(resource) => {
                    title(ui, &name, &resource.kind, &resource.declared, places, &mut wish);
                    facts(ui, resource);
                    ui.separator();
                    self.contents.show(ui, plan, report, &name, places);
                }
                None => missing(ui, &name),
            },
        }
        wish
    }

    fn pass(
        &mut self,
        ui: &mut egui::Ui,
        pass: &PassReport,
        timings: &Timings,
        places: &mut Places,
        wish: &mut Option<Wish>,
    ) {
        title(ui, &pass.name, &pass.kind, &pass.declared, places, wish);
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let state = if pass.live { "Kept" } else { "Culled" };
            ui.label(RichText::new(format!("{state}: {}", pass.why.join(", "))).weak());
            if let Some(toggle) = &pass.toggle {
                ui.label(format!("runs with the toggle {toggle}"));
            }
            for (who, times) in ["CPU", "GPU"].into_iter().zip(timings.of(&pass.name)) {
                if let Some(times) = times {
                    let said =
                        format!("{who} {:.3} ms, 95 % {:.3}, max {:.3}", times.median, times.p95, times.max);
                    ui.monospace(said);
                }
            }
            for (what, names) in [("Reads", &pass.reads), ("Writes", &pass.writes)] {
                ui.add_space(6.0);
                ui.label(RichText::new(what).strong());
                for name in names {
                    ui.horizontal(|ui| {
                        let link = ui.link(name);
                        places.note(&format!("{} {name}", what.to_lowercase()), &link);
                        if link.clicked() {
                            *wish = Some(Wish::Select(Selected::Resource(name.clone())));
                        }
                        if what == "Writes" && pass.live {
                            let after = ui.small_button("after");
                            places.note(&format!("after {name}"), &after);
                            if after.on_hover_text("The contents as this pass leaves them").clicked() {
                                self.select_version(name, &pass.name);
                            }
                        }
                    });
                }
            }
            let attachments = pass.attachments.iter().map(|one| {
                (format!("{} {}", one.kind, one.resource), format!("load {}, store {}", one.load, one.store))
            });
            let settings = pass.settings.iter().map(|(name, value)| (name.clone(), value.clone()));
            let groups =
                pass.workgroups.iter().map(|groups| ("workgroups".to_owned(), format!("{groups:?}")));
            let variants = pass.variants.iter().map(|one| ("shader".to_owned(), one.clone()));
            ui.add_space(6.0);
            egui::Grid::new("settings").num_columns(2).striped(true).show(ui, |ui| {
                for (name, value) in attachments.chain(groups).chain(variants).chain(settings) {
                    ui.label(RichText::new(name).small());
                    ui.add(egui::Label::new(RichText::new(value).small().monospace()).wrap());
                    ui.end_row();
                }
            });
        });
    }
}

fn missing(ui: &mut egui::Ui, name: &str) {
    ui.label(RichText::new(format!("The plan has no \"{name}\" any more.")).weak());
}

/// Shows the name and kind, a link to the declaration, and a button that closes the panel.
fn title(
    ui: &mut egui::Ui,
    name: &str,
    kind: &str,
    declared: &str,
    places: &mut Places,
    wish: &mut Option<Wish>,
) {
    ui.horizontal(|ui| {
        ui.heading(name);
        ui.label(RichText::new(kind).weak());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let close = ui.small_button("Close");
            places.note("close inspector", &close);
            if close.clicked() {
                *wish = Some(Wish::Close);
            }
        });
    });
    let open = ui.link(RichText::new(declared).small()).on_hover_text("Open in the editor");
    places.note("declared", &open);
    if open.clicked() {
        *wish = Some(Wish::Open(declared.to_owned()));
    }
}

fn facts(ui: &mut egui::Ui, resource: &ResourceReport) {
    let bytes =
        if resource.bytes > 0 { format!(" · {}", bytes_in_words(resource.bytes)) } else { String::new() };
    let lifetime = format!("{:?}", resource.lifetime).to_lowercase();
    ui.label(format!("{}{bytes} · {lifetime}", resource.description));
    if !resource.shares_with.is_empty() {
        let color = Color32::from_rgb(224, 186, 96);
        ui.label(
            RichText::new(format!("shares memory with {}", resource.shares_with.join(", "))).color(color),
        );
    }
    if !resource.live {
        ui.label(RichText::new("No pass that runs uses it: it has no memory.").weak());
    }
}

/// The names of the live passes that write a resource, in their order.
pub(crate) fn versions(report: &Report, name: &str) -> Vec<String> {
    let writes = |pass: &&PassReport| pass.live && pass.writes.iter().any(|written| written == name);
    report.passes.iter().filter(writes).map(|pass| pass.name.clone()).collect()
}
