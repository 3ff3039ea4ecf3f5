//! The graph, laid out as the page of `umbragraph graph` lays it out: passes in their order, and below them a lane for
//! each piece of memory, with a bar from the first to the last pass that uses a resource.
//!
//! Culled passes are dashed; a lane of several bars is memory that resources share. Dots are writes, rings are reads.

use std::collections::BTreeMap;

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};
use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::build;
use umbragraph::low_level::language::Lifetime;
use umbragraph::low_level::report::{PassReport, Report, ResourceReport, bytes_in_words};

use crate::dock::FOCUS;
use crate::places::Places;
use crate::steps::{Cursor, arrow, stepped};

const COLUMN: f32 = 118.0;
const BOX: egui::Vec2 = vec2(108.0, 36.0);
const LANE: f32 = 22.0;
const GUTTER: f32 = 190.0;
const HEAD: f32 = 8.0;

/// The selected pass or resource, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Selected {
    Pass(String),
    Resource(String),
}

/// The report of a plan, from which the graph is drawn; `None` if the graph cannot be built.
pub(crate) fn report(plan: &Plan) -> Option<Report> {
    let graph = build(&plan.pipeline, &mut Diagnostics::new())?;
    Some(Report::new(plan, &graph, &plan.pipeline.sources))
}

/// A row of the graph: the bars of resources that share memory.
struct Lane<'a> {
    label: String,
    detail: String,
    resources: Vec<&'a ResourceReport>,
}

/// The rows of the graph for live resources whose name contains `search`. Resources that share memory share a row.
fn lanes<'a>(report: &'a Report, search: &str) -> Vec<Lane<'a>> {
    let mut lanes: Vec<Lane<'_>> = Vec::new();
    let mut by_place: BTreeMap<&str, usize> = BTreeMap::new();
    let wanted = |one: &&ResourceReport| one.live && one.name.to_lowercase().contains(search);
    let mut resources: Vec<&ResourceReport> = report.resources.iter().filter(wanted).collect();
    // Textures and buffers first; the host's own before all.
    resources.sort_by_key(|one| {
        (one.kind == "data", one.lifetime != Lifetime::Imported, one.columns, one.name.as_str())
    });
    for resource in resources {
        let is_shared = !resource.shares_with.is_empty();
        if let Some(at) = by_place.get(resource.place.as_str()).filter(|_| is_shared) {
            lanes[*at].resources.push(resource);
            continue;
        }
        by_place.insert(&resource.place, lanes.len());
        lanes.push(Lane {
            label: if is_shared { resource.place.clone() } else { resource.name.clone() },
            detail: if resource.bytes > 0 { bytes_in_words(resource.bytes) } else { resource.place.clone() },
            resources: vec![resource],
        });
    }
    lanes
}

/// The colour of a kind of work, such as `draw` or `compute`.
pub(crate) fn color_of(work: &str) -> Color32 {
    match work {
        "draw" => Color32::from_rgb(109, 157, 240),
        "compute" => Color32::from_rgb(176, 136, 240),
        "copy" => Color32::from_rgb(120, 180, 160),
        "cpu" => Color32::from_rgb(224, 186, 96),
        _ => Color32::GRAY,
    }
}

/// Shows the graph. Returns the pass or resource that was clicked. With the text of the search comes whether its field
/// is to get the keyboard.
pub(crate) fn show(
    ui: &mut egui::Ui,
    report: &Report,
    selected: Option<&Selected>,
    (search, is_searched): (&mut String, bool),
    places: &mut Places,
) -> Option<Selected> {
    legend(ui, report, (search, is_searched), places);
    let wanted = search.to_lowercase();
    let lanes = lanes(report, &wanted);
    let mut keys = Keys::new(ui, report, &lanes, selected);
    let size = vec2(
        GUTTER + report.passes.len() as f32 * COLUMN + 20.0,
        HEAD + BOX.y + 14.0 + lanes.len() as f32 * LANE + 10.0,
    );
    let mut clicked = None;
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        let (area, _) = ui.allocate_exact_size(size, egui::Sense::hover());
        let origin = area.left_top();
        for (column, pass) in report.passes.iter().enumerate() {
            let is_selected = selected == Some(&Selected::Pass(pass.name.clone()));
            let is_found = wanted.is_empty() || pass.name.to_lowercase().contains(&wanted);
            let one = Selected::Pass(pass.name.clone());
            let response = pass_box(ui, origin, column, pass, [is_selected, is_found], keys.sense(&one));
            places.note(&format!("pass {}", pass.name), &response);
            keys.note(ui, one.clone(), &response);
            if response.clicked() {
                clicked = Some(one);
            }
        }
        for (at, lane) in lanes.iter().enumerate() {
            let top = origin.y + HEAD + BOX.y + 14.0 + at as f32 * LANE;
            draw_lane(ui, origin, top, at, lane, size.x);
            for resource in &lane.resources {
                let is_selected = selected == Some(&Selected::Resource(resource.name.clone()));
                let one = Selected::Resource(resource.name.clone());
                let response = bar(ui, origin, top, resource, is_selected, keys.sense(&one));
                places.note(&format!("resource {}", resource.name), &response);
                keys.note(ui, one.clone(), &response);
                if response.clicked() {
                    clicked = Some(one);
                }
            }
        }
        keys.step(ui, report, &lanes);
    });
    clicked
}

/// The pass or resource of the graph that the keyboard reaches. There is one at a time, so that Tab goes on to the next
/// panel.
struct Keys {
    cursor: Option<Cursor>,
    /// The place where the cursor is kept from frame to frame.
    id: egui::Id,
    /// The identities of all passes and resources of this frame.
    ids: Vec<(Selected, egui::Id)>,
    has_focus: bool,
}

impl Keys {
    /// The place of the last frame, or else that of the selection, or the first pass.
    fn new(ui: &egui::Ui, report: &Report, lanes: &[Lane<'_>], selected: Option<&Selected>) -> Self {
        let is_there = |at: &Selected| match at {
            Selected::Pass(name) => report.passes.iter().any(|pass| pass.name == *name),
            Selected::Resource(name) => {
                lanes.iter().flat_map(|lane| &lane.resources).any(|one| one.name == *name)
            }
        };
        let id = ui.scope_id().with("keys of the graph");
        let known: Option<Cursor> = ui.data(|data| data.get_temp(id));
        let first = || report.passes.first().map(|pass| Selected::Pass(pass.name.clone()));
        let fresh = || selected.cloned().filter(is_there).or_else(first);
        let cursor = known.filter(|cursor| is_there(&cursor.at));
        let cursor = cursor.or_else(|| fresh().map(|at| Cursor { at, column: 0 }));
        Self { cursor, id, ids: Vec::new(), has_focus: false }
    }

    /// Clicks for all, and the keyboard for one.
    fn sense(&self, one: &Selected) -> egui::Sense {
        let has_keys = self.cursor.as_ref().is_some_and(|cursor| cursor.at == *one);
        if has_keys { egui::Sense::click() } else { egui::Sense::CLICK }
    }

    /// Takes note of what was shown, and marks what has the keyboard.
    fn note(&mut self, ui: &egui::Ui, one: Selected, response: &egui::Response) {
        if response.has_focus() {
            self.has_focus = true;
            let filter =
                egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
            let stroke = Stroke::new(2.0, FOCUS);
            ui.painter().rect_stroke(response.rect.expand(2.0), 6.0, stroke, StrokeKind::Outside);
        }
        self.ids.push((one, response.id));
    }

    /// Moves the keyboard by an arrow key, and keeps its place for the next frame.
    fn step(mut self, ui: &egui::Ui, report: &Report, lanes: &[Lane<'_>]) {
        if let (true, Some(arrow), Some(cursor)) = (self.has_focus, arrow(ui), &self.cursor) {
            let rows: Vec<Vec<&ResourceReport>> = lanes.iter().map(|lane| lane.resources.clone()).collect();
            let next = stepped(cursor, arrow, &report.passes, &rows);
            if let Some((_, id)) = self.ids.iter().find(|(one, _)| *one == next.at) {
                ui.memory_mut(|memory| memory.request_focus(*id));
            }
            self.cursor = Some(next);
        }
        if let Some(cursor) = self.cursor {
            ui.data_mut(|data| data.insert_temp(self.id, cursor));
        }
    }
}

fn legend(
    ui: &mut egui::Ui,
    report: &Report,
    (search, is_searched): (&mut String, bool),
    places: &mut Places,
) {
    ui.horizontal_wrapped(|ui| {
        let field = egui::TextEdit::singleline(search).hint_text("Search graph").desired_width(150.0);
        let field = ui.add(field);
        places.note("search graph", &field);
        if is_searched {
            field.request_focus();
        }
        for work in ["cpu", "draw", "compute", "copy"] {
            let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), egui::Sense::hover());
            ui.painter().rect_filled(dot, 2.0, color_of(work));
            ui.label(egui::RichText::new(work).small());
        }
        ui.label(egui::RichText::new("dot: writes · ring: reads · dashed: culled").small().weak());
        let [live, all] = [report.live_passes(), report.passes.len()];
        let memory = &report.memory;
        let said = format!(
            "{live} passes, {} culled · {} created, {} without sharing, bound {}",
            all - live,
            bytes_in_words(memory.created),
            bytes_in_words(memory.without_aliasing),
            bytes_in_words(memory.bound),
        );
        // Whole on one line, the next if need be.
        ui.add(egui::Label::new(egui::RichText::new(said).small()).extend());
    });
}

fn center(origin: Pos2, column: usize) -> f32 {
    origin.x + GUTTER + (column as f32 + 0.5) * COLUMN
}

fn pass_box(
    ui: &egui::Ui,
    origin: Pos2,
    column: usize,
    pass: &PassReport,
    [is_selected, is_found]: [bool; 2],
    sense: egui::Sense,
) -> egui::Response {
    let at = pos2(center(origin, column), origin.y + HEAD + BOX.y / 2.0);
    let rect = Rect::from_center_size(at, BOX);
    let response = ui.interact(rect, ui.scope_id().with(("pass", column)), sense);
    if is_selected {
        // Once, when it becomes the selected one from elsewhere, the graph scrolls to it.
        let id = ui.scope_id().with("scrolled to");
        if ui.data(|data| data.get_temp::<String>(id)).as_deref() != Some(&pass.name) {
            ui.scroll_to_rect(rect.expand(60.0), None);
            ui.data_mut(|data| data.insert_temp(id, pass.name.clone()));
        }
    }
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let color = color_of(&pass.work);
    let strength = if pass.live && is_found { 1.0 } else { 0.4 };
    let fill =
        ui.visuals().widgets.inactive.bg_fill.gamma_multiply(if response.hovered() { 1.3 } else { 0.8 });
    let painter = ui.painter();
    painter.rect_filled(rect, 5.0, fill);
    painter.rect_filled(
        Rect::from_min_size(rect.min, vec2(4.0, rect.height())),
        2.0,
        color.gamma_multiply(strength),
    );
    let stroke = if is_selected {
        Stroke::new(2.0, Color32::WHITE)
    } else {
        Stroke::new(1.0, color.gamma_multiply(0.5))
    };
    if pass.live {
        painter.rect_stroke(rect, 5.0, stroke, StrokeKind::Inside);
    } else {
        let [a, b, c, d] = [rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom()];
        painter.extend(egui::Shape::dashed_line(&[a, b, c, d, a], stroke, 4.0, 3.0));
    }
    let text = ui.visuals().strong_text_color().gamma_multiply(strength);
    let painter = ui.painter_at(rect.shrink2(vec2(6.0, 0.0)));
    let write = |y: f32, words: &str, size: f32, color: Color32| {
        let galley = painter.layout_no_wrap(words.to_owned(), FontId::proportional(size), color);
        let x = (rect.center().x - galley.size().x / 2.0).max(rect.left() + 7.0);
        painter.galley(pos2(x, y), galley, color);
    };
    write(rect.top() + 4.0, &pass.name, 12.0, text);
    write(rect.top() + 19.0, &pass.kind, 10.0, text.gamma_multiply(0.7));
    let why = pass.why.iter().take(4).cloned().collect::<Vec<_>>().join("\n");
    let state = if pass.live { "kept" } else { "culled" };
    response.on_hover_text(format!("{} ({})\n{state}: {why}", pass.name, pass.kind))
}

fn draw_lane(ui: &egui::Ui, origin: Pos2, top: f32, at: usize, lane: &Lane<'_>, width: f32) {
    let rect = Rect::from_min_size(pos2(origin.x, top), vec2(width, LANE));
    if !ui.is_rect_visible(rect) {
        return;
    }
    if at.is_multiple_of(2) {
        ui.painter().rect_filled(rect, 0.0, ui.visuals().faint_bg_color);
    }
    let painter = ui.painter_at(Rect::from_min_size(rect.min, vec2(GUTTER - 8.0, LANE)));
    let color = ui.visuals().text_color();
    let font = FontId::proportional(11.5);
    let at = pos2(origin.x + GUTTER - 12.0, rect.center().y);
    let small = FontId::proportional(10.0);
    let detail = painter.text(at, Align2::RIGHT_CENTER, &lane.detail, small, color.gamma_multiply(0.6));
    let mut label = egui::text::LayoutJob::simple_singleline(lane.label.clone(), font, color);
    let left = origin.x + 4.0;
    label.wrap = egui::text::TextWrapping::truncate_at_width(detail.left() - 6.0 - left);
    let label = painter.layout_job(label);
    painter.galley(pos2(left, rect.center().y - label.size().y / 2.0), label, color);
}

fn bar(
    ui: &egui::Ui,
    origin: Pos2,
    top: f32,
    resource: &ResourceReport,
    is_selected: bool,
    sense: egui::Sense,
) -> egui::Response {
    let [first, last] = resource.columns;
    let rect = Rect::from_min_max(
        pos2(center(origin, first) - 44.0, top + 3.0),
        pos2(center(origin, last) + 44.0, top + LANE - 3.0),
    );
    let response = ui.interact(rect, ui.scope_id().with(("resource", &resource.name)), sense);
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let color = match resource.lifetime {
        Lifetime::Imported => Color32::from_rgb(190, 120, 90),
        Lifetime::Transient => Color32::from_rgb(80, 110, 160),
        _ => Color32::from_rgb(96, 140, 96),
    };
    let color = if resource.kind == "data" { Color32::from_rgb(140, 125, 70) } else { color };
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, color.gamma_multiply(if response.hovered() { 0.8 } else { 0.55 }));
    if is_selected {
        painter.rect_stroke(rect, 4.0, Stroke::new(2.0, Color32::WHITE), StrokeKind::Inside);
    }
    let text = Color32::from_gray(235);
    let marks: Vec<usize> = (first..=last)
        .filter(|at| resource.written_in.contains(at) || resource.read_in.contains(at))
        .collect();
    for column in &marks {
        let at = pos2(center(origin, *column) - 36.0, rect.center().y);
        if resource.written_in.contains(column) {
            painter.circle_filled(at, 3.5, text);
        } else {
            painter.circle_stroke(at, 3.0, Stroke::new(1.2, text));
        }
    }
    // The name stands behind the last mark that is left of the view, and ends before the next.
    let view = ui.clip_rect().left() - 40.0;
    let behind = marks.iter().filter(|at| center(origin, **at) - 36.0 <= view.max(rect.left() + 9.0)).count();
    let start = marks.get(behind.saturating_sub(1)).map_or(rect.left(), |at| center(origin, *at) - 36.0);
    let left = (start + 8.0).max(ui.clip_rect().left() + 6.0);
    let right = marks.get(behind.max(1)).map_or(rect.right(), |at| center(origin, *at) - 42.0);
    let clip = Rect::from_min_max(pos2(rect.left(), rect.top()), pos2(right, rect.bottom()));
    let at = pos2(left, rect.center().y);
    painter.with_clip_rect(clip.intersect(painter.clip_rect())).text(
        at,
        Align2::LEFT_CENTER,
        &resource.name,
        FontId::proportional(11.0),
        text,
    );
    response.on_hover_text(format!("{} · {}", resource.name, resource.description))
}
