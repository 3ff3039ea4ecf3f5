//! The contents of a texture: its picture, range and histogram, the value under the cursor, before and after each pass,
//! and compared with any other. Of a buffer the fields ([`crate::buffers`]). What is chosen is in [`crate::choices`].

use eframe::egui::{self, Color32, RichText, TextureHandle, TextureOptions, pos2, vec2};
use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::Capture;
use umbragraph::low_level::report::Report;
use umbragraph::low_level::sheet::{Content, Range, Sheet, sheet};

use crate::buffers::{Field, List, compared, fields, layouts, size_of};
use crate::capture::{Captured, Request};
use crate::choices::{Look, Side};
use crate::dock::FOCUS;
use crate::histogram;
use crate::inspector::versions;
use crate::places::Places;
use crate::texels::{Channel, channel, channels, difference, part, shown, with_visible_alpha};
use crate::tiles::Tile;

/// The inspected texture or buffer, and its last captures.
#[derive(Default)]
pub(crate) struct Contents {
    pub(crate) look: Look,
    /// The tiles of the shown texture in the last capture.
    pub(crate) tiles: Vec<Tile>,
    captured: Vec<Texels>,
    /// The bytes of the captures of a buffer: after the pass, then before it.
    bytes: Vec<Vec<u8>>,
    /// The decoded fields of a buffer that are shown.
    fields: Vec<Field>,
    list: List,
    layout: String,
    /// The request whose contents `captured` or `bytes` holds.
    of: Request,
    pub(crate) drawn: Option<Drawn>,
    pub(crate) error: Option<String>,
    /// Whether the range is to get the keyboard.
    pub(crate) wants_range: bool,
    cursor: Option<([u32; 2], [f32; 4])>,
}

/// The picture made of the captures, with its statistics.
pub(crate) struct Drawn {
    look: Look,
    texture: TextureHandle,
    sheet: Sheet,
    ranges: Vec<Range>,
    pub(crate) channels: Vec<Channel>,
    layers: u32,
    /// The place of the picture in the texture, in texels: the corner of a tile.
    origin: [u32; 2],
}

impl Contents {
    /// Selects the version of a resource after `pass`; `None` if no pass writes the resource.
    pub(crate) fn look_at(&mut self, name: &str, pass: Option<String>) {
        if self.look.name != name {
            (self.look, self.cursor) = (Look { name: name.to_owned(), ..Look::default() }, None);
            self.list = List::default();
            self.tiles.clear();
        }
        self.look.pass = pass;
    }

    /// The captures to request for the shown frame; none if the resource cannot be shown.
    pub(crate) fn wanted(&self, plan: &Plan) -> Request {
        let look = &self.look;
        if cannot(plan, &look.name).is_some() {
            return Request::default();
        }
        let capture = |name: &str, pass: Option<&str>| {
            let mips = plan.resources.get(name).and_then(|one| one.size).map_or(1, |size| size.mips);
            let reference = pass.map_or_else(|| name.to_owned(), |pass| format!("{name}@{pass}"));
            Capture { reference, mip: look.mip.min(mips - 1) }
        };
        let mut captures = vec![capture(&look.name, look.pass.as_deref())];
        let other = look.other().filter(|(name, _)| look.side != Side::After && cannot(plan, name).is_none());
        captures.extend(other.map(|(name, pass)| capture(name, pass)));
        Request { captures, is_stencil: look.is_stencil, sample: look.sample }
    }

    /// The name of the selected resource, and the pass after which it is shown; empty if there is none.
    pub(crate) fn shown(&self) -> [&str; 2] {
        [&self.look.name, self.look.pass.as_deref().unwrap_or_default()]
    }

    /// Stores the captures of a frame and discards the previous ones.
    pub(crate) fn take(&mut self, request: Request, captured: Vec<Captured>, tiles: Vec<Tile>) {
        (self.of, self.drawn, self.error, self.tiles) = (request, None, None, tiles);
        (self.captured, self.bytes, self.fields) = (Vec::new(), Vec::new(), Vec::new());
        self.layout.clear();
        for one in captured {
            match one {
                Captured::Texels(texels) => self.captured.push(texels),
                Captured::Bytes(bytes) => self.bytes.push(bytes),
            }
        }
    }

    /// Discards the captures, so that others are shown only once they are there.
    pub(crate) fn forget(&mut self) {
        self.captured.clear();
    }

    /// Shows the layout choice and the fields of a buffer.
    fn buffer(&mut self, ui: &mut egui::Ui, plan: &Plan, name: &str, places: &mut Places) {
        let layouts = layouts(plan, name);
        self.look.layout = self.look.layout.min(layouts.len().saturating_sub(1));
        let Some(layout) = layouts.get(self.look.layout) else { return };
        let list = egui::ComboBox::from_id_salt("layout").width(250.0).selected_text(&layout.label);
        let list = list.show_ui(ui, |ui| {
            for (at, layout) in layouts.iter().enumerate() {
                ui.selectable_value(&mut self.look.layout, at, &layout.label);
            }
        });
        places.note("layout", &list.response);
        let all: Vec<_> = self.bytes.iter().map(|bytes| fields(layout, bytes)).collect();
        let Some((after, has_more)) = all.first().cloned() else { return };
        self.fields = match (self.look.side, all.get(1)) {
            (Side::After, _) | (_, None) => after,
            (Side::Before, Some(before)) => before.0.clone(),
            (Side::Difference, Some(before)) => compared(after, &before.0),
        };
        self.layout.clone_from(&layout.label);
        self.list.show(ui, &self.fields, has_more, places);
    }

    /// Shows the contents of a resource.
    pub(crate) fn show(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Plan,
        report: &Report,
        name: &str,
        places: &mut Places,
    ) {
        if let Some(reason) = cannot(plan, name) {
            ui.label(RichText::new(reason).weak());
            return;
        }
        let versions = versions(report, name);
        let at = versions.iter().position(|one| Some(one) == self.look.pass.as_ref());
        self.look.before = at.and_then(|at| versions.get(at.checked_sub(1)?)).cloned();
        self.choices(ui, plan, report, (&versions, at), places);
        if let Some(error) = &self.error {
            ui.label(RichText::new(error).color(Color32::from_rgb(240, 120, 110)));
        }
        let is_current = self.of == self.wanted(plan);
        if is_current && !self.bytes.is_empty() && size_of(plan, name).is_some() {
            self.buffer(ui, plan, name, places);
            return;
        }
        let Some(main) = self.captured.first().filter(|_| is_current) else {
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("capturing");
            });
            return;
        };
        if self.drawn.as_ref().is_none_or(|drawn| drawn.look != self.look) {
            let mut content = Content::of(plan, name).unwrap_or_default();
            if self.look.is_stencil {
                (content.is_depth, content.is_integer) = (false, true);
            }
            let texels = match (self.look.side, self.captured.get(1)) {
                (Side::After, _) | (_, None) => Some(main.clone()),
                (Side::Before, Some(other)) => Some(other.clone()),
                (Side::Difference, Some(other)) => difference(main, other),
            };
            let Some(texels) = texels else {
                let size = |one: &Texels| format!("{} × {} × {}", one.width, one.height, one.layers);
                let sizes = self.captured.iter().map(size).collect::<Vec<_>>().join(" and ");
                ui.label(format!("Their sizes differ, {sizes}: choose another resource or mip level."));
                return;
            };
            let limit = ui.ctx().input(|input| input.max_texture_side);
            let tile = self.look.tile.and_then(|at| self.tiles.get(at));
            self.drawn = draw(ui.ctx(), texels, content, &self.look, tile, limit);
        }
        let Some(drawn) = &self.drawn else {
            ui.label("The picture is too large for a texture: choose a mip level or a layer.");
            return;
        };
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            picture(ui, drawn, &mut self.cursor, places);
            histogram::show(ui, &drawn.channels, &drawn.ranges);
        });
    }

    fn references(&self) -> Vec<String> {
        self.of.captures.iter().map(|one| one.reference.clone()).collect()
    }

    /// The shown contents as JSON, for the log that tests read.
    pub(crate) fn state(&self) -> Value {
        if !self.bytes.is_empty() {
            let of = self.references();
            let mut state = json!({ "of": of, "layout": self.layout });
            for (name, value) in self.list.state(&self.fields) {
                state[name] = value;
            }
            return state;
        }
        let Some(drawn) = &self.drawn else { return Value::Null };
        let channels = drawn.channels.iter().map(|one| {
            json!({ "min": one.min, "max": one.max, "mean": one.mean, "not_finite": one.not_finite, "bars": one.bars })
        });
        json!({
            "of": self.references(),
            "mip": drawn.look.mip,
            "layer": drawn.look.layer,
            "stencil": drawn.look.is_stencil,
            "sample": drawn.look.sample,
            "tile": drawn.look.tile,
            "tiles": self.tiles.iter().map(|one| one.label.clone()).collect::<Vec<_>>(),
            "channel": drawn.look.channel,
            "range": drawn.look.range,
            "side": Side::ALL.iter().find(|one| one.0 == drawn.look.side).map(|one| one.1),
            "size": [drawn.sheet.width, drawn.sheet.height, drawn.layers],
            "channels": channels.collect::<Vec<_>>(),
            "cursor": self.cursor,
        })
    }
}

/// The reason why the contents of a resource cannot be shown; `None` if they can.
pub(crate) fn cannot(plan: &Plan, name: &str) -> Option<&'static str> {
    let Some(resource) = plan.resources.get(name) else { return Some("No pass that runs uses it.") };
    if size_of(plan, name).is_some() || resource.size.is_some() {
        return None;
    }
    Some("It is data of the host; the viewer shows contents of textures and buffers.")
}

/// Creates the picture of texels, or of one tile of them; `None` if it is empty or a side exceeds `limit` texels.
fn draw(
    context: &egui::Context,
    texels: Texels,
    content: Content,
    look: &Look,
    tile: Option<&Tile>,
    limit: usize,
) -> Option<Drawn> {
    let layers = texels.layers;
    let (texels, origin) = match tile.map(|tile| (tile.layer, tile.area(look.mip))) {
        Some((layer, area @ [x, y, ..])) => (part(&texels, layer, area)?, [x, y]),
        None => (texels, [0; 2]),
    };
    let texels = match look.channel {
        Some(chosen) if chosen < texels.channels && texels.channels > 1 => channel(&texels, chosen),
        _ => texels,
    };
    let layer = look.layer.filter(|layer| *layer < texels.layers && tile.is_none());
    let whole = sheet(&texels, content, layer);
    let size = [whole.width as usize, whole.height as usize];
    if size.iter().any(|side| *side > limit || *side == 0) {
        return None;
    }
    let channels = channels(&texels, layer);
    let is_difference = look.side == Side::Difference;
    let visible = is_difference.then(|| sheet(&with_visible_alpha(texels), content, layer));
    let shown = visible.as_ref().unwrap_or(&whole);
    let ranges = match look.range {
        Some([min, max]) => vec![Range { min, max }; shown.channels],
        None => shown.ranges(content),
    };
    let image = egui::ColorImage::from_rgba_unmultiplied(size, &shown.rgba(content, &ranges));
    let texture = context.load_texture("contents", image, TextureOptions::NEAREST);
    Some(Drawn { look: look.clone(), texture, sheet: whole, ranges, channels, layers, origin })
}

/// Shows the picture scaled to the panel, and the value of the texel under the pointer.
fn picture(ui: &mut egui::Ui, drawn: &Drawn, cursor: &mut Option<([u32; 2], [f32; 4])>, places: &mut Places) {
    let Sheet { width, height, channels, values, .. } = &drawn.sheet;
    let scale = (ui.available_width() / *width as f32)
        .min((ui.ctx().content_rect().height() * 0.55).max(120.0) / *height as f32);
    let size = vec2(*width as f32, *height as f32) * scale;
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let whole = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(drawn.texture.id(), rect, whole, Color32::WHITE);
    places.note("contents", &response);
    let [left, top] = drawn.origin;
    let mut texel = response.hover_pos().map(|at| {
        let at = (at - rect.min) / scale;
        [at.x as u32, at.y as u32]
    });
    if response.has_focus() {
        // The pointer rests where it was: it moves the texel only when it moves itself.
        let is_moved = ui.input(|input| input.pointer.delta() != egui::Vec2::ZERO);
        let known = cursor.map(|([x, y], _)| [x.saturating_sub(left), y.saturating_sub(top)]);
        let known = texel.filter(|_| is_moved).or(known).unwrap_or([width / 2, height / 2]);
        texel = Some(moved(ui, response.id, known));
    }
    if let Some([x, y]) = texel.map(|[x, y]| [x.min(width - 1), y.min(height - 1)]) {
        let value = values.get(y as usize * *width as usize + x as usize);
        *cursor = value.map(|value| ([left + x, top + y], *value));
        if response.has_focus() {
            let corner = rect.min + vec2(x as f32, y as f32) * scale;
            let texel = egui::Rect::from_min_size(corner, vec2(scale, scale)).expand(3.0);
            ui.painter().rect_stroke(texel, 0.0, egui::Stroke::new(1.5, FOCUS), egui::StrokeKind::Outside);
            ui.painter().rect_stroke(rect, 0.0, egui::Stroke::new(1.0, FOCUS), egui::StrokeKind::Outside);
        }
    }
    let said = cursor.as_ref().map(|([x, y], value)| {
        let value: Vec<String> = value.iter().take(*channels).map(|one| shown(*one)).collect();
        format!("({x}, {y})  {}", value.join("  "))
    });
    ui.monospace(said.unwrap_or_else(|| format!("{width} × {height}, {channels} channels")));
}

/// The texel to which the arrow keys move from another, by 1 or, with shift, by 16 texels. The control `id` keeps the
/// keyboard.
fn moved(ui: &egui::Ui, id: egui::Id, [x, y]: [u32; 2]) -> [u32; 2] {
    let arrows = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(id, arrows));
    ui.input(|input| {
        let step = if input.modifiers.shift { 16 } else { 1 };
        let presses = |key| u32::try_from(input.num_presses(key)).unwrap_or_default() * step;
        let along = |at: u32, less, more| at.saturating_add(presses(more)).saturating_sub(presses(less));
        use egui::Key::{ArrowDown, ArrowLeft, ArrowRight, ArrowUp};
        [along(x, ArrowLeft, ArrowRight), along(y, ArrowUp, ArrowDown)]
    })
}
