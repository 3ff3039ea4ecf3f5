//! The contents of a texture: its picture, range and histogram, the value under the cursor, before and after each pass.
//! Of a buffer the fields ([`crate::buffers`]).

use eframe::egui::{self, Color32, RichText, TextureHandle, TextureOptions, pos2, vec2};
use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::Capture;
use umbragraph::low_level::sheet::{Content, Range, Sheet, is_volume, sheet};

use crate::buffers::{Field, compared, fields, layouts, size_of};
use crate::capture::Captured;
use crate::histogram;
use crate::places::Places;
use crate::texels::{Channel, channels, difference, shown};

/// The version of a resource that is shown: after the pass, before it, or their difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Side {
    #[default]
    After,
    Before,
    Difference,
}

impl Side {
    const ALL: [(Self, &'static str); 3] =
        [(Self::After, "after"), (Self::Before, "before"), (Self::Difference, "difference")];
}

/// The selected resource, its version, and the options of its view.
#[derive(Clone, Debug, Default, PartialEq)]
struct Look {
    name: String,
    /// The pass after which the resource is shown; `None` if no pass writes the resource.
    pass: Option<String>,
    /// The previous pass that writes the resource; `None` if there is none.
    before: Option<String>,
    side: Side,
    mip: u32,
    layer: Option<u32>,
    /// Whether the stencil aspect is shown instead of the depth.
    is_stencil: bool,
    /// The index of the layout used to decode a buffer, among the layouts of its shaders.
    layout: usize,
    /// The values shown as black and as white; `None` fits them to the contents.
    range: Option<[f32; 2]>,
}

/// The inspected texture or buffer, and its last captures.
#[derive(Default)]
pub(crate) struct Contents {
    look: Look,
    captured: Vec<Texels>,
    /// The bytes of the captures of a buffer: after the pass, then before it.
    bytes: Vec<Vec<u8>>,
    /// The decoded fields of a buffer that are shown.
    fields: Vec<Field>,
    layout: String,
    /// The requested captures whose contents `captured` or `bytes` holds.
    of: Vec<Capture>,
    drawn: Option<Drawn>,
    pub(crate) error: Option<String>,
    cursor: Option<([u32; 2], [f32; 4])>,
}

/// The picture made of the captures, with its statistics.
struct Drawn {
    look: Look,
    texture: TextureHandle,
    sheet: Sheet,
    ranges: Vec<Range>,
    channels: Vec<Channel>,
    layers: u32,
}

impl Contents {
    /// Selects the version of a resource after `pass`; `None` if no pass writes the resource.
    pub(crate) fn look_at(&mut self, name: &str, pass: Option<String>) {
        if self.look.name != name {
            (self.look, self.cursor) = (Look { name: name.to_owned(), ..Look::default() }, None);
        }
        self.look.pass = pass;
    }

    /// The captures to request in the next frame; empty if the resource cannot be shown.
    pub(crate) fn wanted(&self, plan: &Plan) -> Vec<Capture> {
        if cannot(plan, &self.look.name).is_some() {
            return Vec::new();
        }
        let Look { name, pass, before, side, mip, .. } = &self.look;
        let mips = plan.resources.get(name).and_then(|one| one.size).map_or(1, |size| size.mips);
        let mip = (*mip).min(mips - 1);
        let capture = |pass: &Option<String>| {
            let reference = pass.as_ref().map_or_else(|| name.clone(), |pass| format!("{name}@{pass}"));
            Capture { reference, mip }
        };
        match (side, before) {
            (Side::After, _) | (_, None) => vec![capture(pass)],
            _ => vec![capture(pass), capture(before)],
        }
    }

    /// Stores the captures of a frame and discards the previous ones.
    pub(crate) fn take(&mut self, captures: Vec<Capture>, captured: Vec<Captured>) {
        (self.of, self.drawn, self.error) = (captures, None, None);
        (self.captured, self.bytes, self.fields) = (Vec::new(), Vec::new(), Vec::new());
        self.layout.clear();
        for one in captured {
            match one {
                Captured::Texels(texels) => self.captured.push(texels),
                Captured::Bytes(bytes) => self.bytes.push(bytes),
            }
        }
    }

    /// Returns `true` if the stencil is captured instead of the depth.
    pub(crate) fn is_stencil(&self) -> bool {
        self.look.is_stencil
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
        crate::buffers::show(ui, &self.fields, has_more, places);
    }

    /// Shows the contents of a resource; `versions` are the passes that write it.
    pub(crate) fn show(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Plan,
        name: &str,
        versions: &[String],
        places: &mut Places,
    ) {
        if let Some(reason) = cannot(plan, name) {
            ui.label(RichText::new(reason).weak());
            return;
        }
        let at = versions.iter().position(|one| Some(one) == self.look.pass.as_ref());
        self.look.before = at.and_then(|at| versions.get(at.checked_sub(1)?)).cloned();
        self.choices(ui, plan, versions, at, places);
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
                (Side::Before, Some(before)) => Some(before.clone()),
                (Side::Difference, Some(before)) => difference(main, before),
            };
            let limit = ui.ctx().input(|input| input.max_texture_side);
            self.drawn = texels.and_then(|texels| draw(ui.ctx(), &texels, content, &self.look, limit));
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

    /// Shows the choices of version, side, mip level, layer, stencil and range.
    fn choices(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Plan,
        versions: &[String],
        at: Option<usize>,
        places: &mut Places,
    ) {
        let look = &mut self.look;
        if !versions.is_empty() {
            ui.horizontal(|ui| {
                ui.label("as left by");
                for (label, to) in [("<", at.and_then(|at| at.checked_sub(1))), (">", at.map(|at| at + 1))] {
                    let version = to.and_then(|to| versions.get(to));
                    let step = ui.add_enabled(version.is_some(), egui::Button::new(label).small());
                    places.note(if label == "<" { "version before" } else { "version after" }, &step);
                    if let (true, Some(version)) = (step.clicked(), version) {
                        look.pass = Some(version.clone());
                    }
                }
                let text = look.pass.clone().unwrap_or_default();
                egui::ComboBox::from_id_salt("version").width(190.0).selected_text(text).show_ui(ui, |ui| {
                    for version in versions {
                        ui.selectable_value(&mut look.pass, Some(version.clone()), version);
                    }
                });
            });
        }
        ui.horizontal(|ui| {
            for (side, label) in Side::ALL {
                let is_there = side == Side::After || look.before.is_some();
                let button = ui.add_enabled(is_there, egui::Button::selectable(look.side == side, label));
                places.note(&format!("side {label}"), &button);
                if button.clicked() {
                    look.side = side;
                }
            }
            let size = plan.resources.get(&look.name).and_then(|one| one.size);
            let (mips, layers) = size.map_or((1, 1), |size| (size.mips, size.layers));
            look.mip = look.mip.min(mips - 1);
            if mips > 1 {
                let mip = ui
                    .add(egui::DragValue::new(&mut look.mip).range(0..=mips - 1).prefix("mip ").speed(0.05));
                places.note("mip", &mip);
            }
            if layers > 1 {
                look.layer = look.layer.map(|layer| layer.min(layers - 1));
                let is_cube = Content::of(plan, &look.name).is_some_and(|content| content.is_cube);
                let label = |layer: u32| layer_name(layer, layers, is_cube);
                let text = look.layer.map_or("all layers".to_owned(), label);
                let list = egui::ComboBox::from_id_salt("layer").width(90.0).selected_text(text);
                let list = list.show_ui(ui, |ui| {
                    ui.selectable_value(&mut look.layer, None, "all layers");
                    for layer in 0..layers {
                        let one = ui.selectable_value(&mut look.layer, Some(layer), label(layer));
                        places.note(&format!("layer={layer}"), &one);
                    }
                });
                places.note("layer", &list.response);
            } else {
                look.layer = None;
            }
            let format = plan.resources.get(&look.name).and_then(|one| one.format);
            let has_both =
                format.is_some_and(|format| format.has_depth_aspect() && format.has_stencil_aspect());
            look.is_stencil &= has_both;
            if has_both {
                let stencil = ui.checkbox(&mut look.is_stencil, "stencil");
                places.note("stencil", &stencil);
                if stencil.changed() {
                    self.captured.clear();
                }
            }
        });
        if size_of(plan, &look.name).is_some() {
            return;
        }
        ui.horizontal(|ui| {
            let mut is_own = look.range.is_some();
            let own = ui.checkbox(&mut is_own, "range");
            places.note("own range", &own);
            if own.changed() {
                let [min, max] = match self.drawn.as_ref().and_then(|drawn| drawn.channels.first()) {
                    Some(channel) => [channel.min, channel.max],
                    None => [0.0, 1.0],
                };
                look.range = is_own.then_some([min, max]);
            }
            if let Some([min, max]) = &mut look.range {
                let speed = ((*max - *min).abs() * 0.01).max(1e-5);
                places.note("range min", &ui.add(egui::DragValue::new(min).speed(speed)));
                ui.label("to");
                places.note("range max", &ui.add(egui::DragValue::new(max).speed(speed)));
            }
        });
    }

    /// The shown contents as JSON, for the log that tests read.
    pub(crate) fn state(&self) -> Value {
        if !self.bytes.is_empty() {
            let of = self.of.iter().map(|one| one.reference.clone()).collect::<Vec<_>>();
            let fields = crate::buffers::state(&self.fields);
            return json!({ "of": of, "layout": self.layout, "fields": fields });
        }
        let Some(drawn) = &self.drawn else { return Value::Null };
        let channels = drawn.channels.iter().map(|one| {
            json!({ "min": one.min, "max": one.max, "mean": one.mean, "not_finite": one.not_finite, "bars": one.bars })
        });
        json!({
            "of": self.of.iter().map(|one| one.reference.clone()).collect::<Vec<_>>(),
            "mip": drawn.look.mip,
            "layer": drawn.look.layer,
            "stencil": drawn.look.is_stencil,
            "side": Side::ALL.iter().find(|one| one.0 == drawn.look.side).map(|one| one.1),
            "size": [drawn.sheet.width, drawn.sheet.height, drawn.layers],
            "channels": channels.collect::<Vec<_>>(),
            "cursor": self.cursor,
        })
    }
}

/// The display name of a texture layer; for a cube, the name of its face, such as `face +X`.
fn layer_name(layer: u32, layers: u32, is_cube: bool) -> String {
    const FACES: [&str; 6] = ["+X", "−X", "+Y", "−Y", "+Z", "−Z"];
    match (is_cube, layers > 6) {
        (true, false) => format!("face {}", FACES[layer as usize % 6]),
        (true, true) => format!("cube {}, face {}", layer / 6, FACES[layer as usize % 6]),
        _ => format!("layer {layer}"),
    }
}

/// The reason why the contents of a resource cannot be shown; `None` if they can.
fn cannot(plan: &Plan, name: &str) -> Option<&'static str> {
    let Some(resource) = plan.resources.get(name) else { return Some("No pass that runs uses it.") };
    if size_of(plan, name).is_some() {
        return None;
    }
    let Some(size) = resource.size else {
        return Some("It is data of the host; the viewer shows contents of textures and buffers.");
    };
    if size.samples > 1 {
        return Some("It has several samples a texel: look at the texture that it is resolved to.");
    }
    is_volume(plan, name).then_some("It is a volume: look at a texture that a pass makes of one slice.")
}

/// Creates the picture of texels; `None` if it is empty or a side exceeds `limit` texels.
fn draw(
    context: &egui::Context,
    texels: &Texels,
    content: Content,
    look: &Look,
    limit: usize,
) -> Option<Drawn> {
    let layer = look.layer.filter(|layer| *layer < texels.layers);
    let sheet = sheet(texels, content, layer);
    let size = [sheet.width as usize, sheet.height as usize];
    if size.iter().any(|side| *side > limit || *side == 0) {
        return None;
    }
    let ranges = match look.range {
        Some([min, max]) => vec![Range { min, max }; sheet.channels],
        None => sheet.ranges(content),
    };
    let image = egui::ColorImage::from_rgba_unmultiplied(size, &sheet.rgba(content, &ranges));
    let texture = context.load_texture("contents", image, TextureOptions::NEAREST);
    let channels = channels(texels, layer);
    Some(Drawn { look: look.clone(), texture, sheet, ranges, channels, layers: texels.layers })
}

/// Shows the picture scaled to the panel, and the value of the texel under the pointer.
fn picture(ui: &mut egui::Ui, drawn: &Drawn, cursor: &mut Option<([u32; 2], [f32; 4])>, places: &mut Places) {
    let Sheet { width, height, channels, values, .. } = &drawn.sheet;
    let scale = (ui.available_width() / *width as f32)
        .min((ui.ctx().content_rect().height() * 0.55).max(120.0) / *height as f32);
    let size = vec2(*width as f32, *height as f32) * scale;
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    let whole = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(drawn.texture.id(), rect, whole, Color32::WHITE);
    places.note("contents", &response);
    if let Some(at) = response.hover_pos() {
        let at = (at - rect.min) / scale;
        let [x, y] = [(at.x as u32).min(width - 1), (at.y as u32).min(height - 1)];
        *cursor = values.get(y as usize * *width as usize + x as usize).map(|value| ([x, y], *value));
    }
    let said = cursor.as_ref().map(|([x, y], value)| {
        let value: Vec<String> = value.iter().take(*channels).map(|one| shown(*one)).collect();
        format!("({x}, {y})  {}", value.join("  "))
    });
    ui.monospace(said.unwrap_or_else(|| format!("{width} × {height}, {channels} channels")));
}
