//! The choices of what is shown of a texture or buffer: the version, what it is compared with, and the part of it.
//!
//! By default a version is compared with the one that it replaced. Any other texture of the same size, or any other
//! buffer, can be compared, as any pass leaves it.

use eframe::egui;
use umbragraph::low_level::report::Report;
use umbragraph::low_level::sheet::{Content, is_volume};
use umbragraph::{Plan, wgpu};

use crate::buffers::size_of;
use crate::contents::{Contents, cannot};
use crate::inspector::versions;
use crate::places::Places;

/// The version of a resource that is shown: after the pass, the one before it or another, or their difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Side {
    #[default]
    After,
    Before,
    Difference,
}

impl Side {
    pub(crate) const ALL: [(Self, &'static str); 3] =
        [(Self::After, "after"), (Self::Before, "before"), (Self::Difference, "difference")];
}

/// The selected resource, its version, and the options of its view.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Look {
    pub(crate) name: String,
    /// The pass after which the resource is shown; `None` if no pass writes the resource.
    pub(crate) pass: Option<String>,
    /// The previous pass that writes the resource; `None` if there is none.
    pub(crate) before: Option<String>,
    /// The resource to compare with, and the pass after which it is compared; `None` compares with `before`.
    pub(crate) against: Option<(String, Option<String>)>,
    pub(crate) side: Side,
    pub(crate) mip: u32,
    /// The layer of an array or slice of a volume; `None` for all.
    pub(crate) layer: Option<u32>,
    /// The sample that is shown of a texture with several samples.
    pub(crate) sample: u32,
    /// The index of the shown tile; `None` for the whole texture.
    pub(crate) tile: Option<usize>,
    /// The channel that is shown alone; `None` for all as a colour.
    pub(crate) channel: Option<usize>,
    /// Whether the stencil aspect is shown instead of the depth.
    pub(crate) is_stencil: bool,
    /// The index of the layout used to decode a buffer, among the layouts of its shaders.
    pub(crate) layout: usize,
    /// The values shown as black and as white; `None` fits them to the contents.
    pub(crate) range: Option<[f32; 2]>,
}

impl Look {
    /// The resource and pass that the shown version is compared with; `None` if there is nothing to compare with.
    pub(crate) fn other(&self) -> Option<(&str, Option<&str>)> {
        match &self.against {
            Some((name, pass)) => Some((name, pass.as_deref())),
            None => self.before.as_deref().map(|pass| (self.name.as_str(), Some(pass))),
        }
    }
}

/// The parts of a texture among which a look chooses.
pub(crate) struct Parts {
    pub(crate) mips: u32,
    pub(crate) samples: u32,
    pub(crate) has_both_aspects: bool,
    is_volume: bool,
    /// The layers of an array, or the slices of mip level 0 of a volume.
    all_layers: u32,
}

impl Parts {
    /// The parts of a resource; one of each for what is no texture.
    pub(crate) fn of(plan: &Plan, name: &str) -> Self {
        let resource = plan.resources.get(name);
        let [mips, layers, samples] = match resource.and_then(|one| one.size) {
            Some(size) => [size.mips, size.layers, size.samples],
            None => [1; 3],
        };
        // A stencil of several samples cannot be copied to a buffer.
        let format = resource.and_then(|one| one.format).filter(|_| samples == 1);
        let has_both = |format: wgpu::TextureFormat| format.has_depth_aspect() && format.has_stencil_aspect();
        Self {
            mips,
            samples,
            has_both_aspects: format.is_some_and(has_both),
            is_volume: is_volume(plan, name),
            all_layers: layers,
        }
    }

    /// The number of layers, or of slices of a mip level.
    pub(crate) fn layers(&self, mip: u32) -> u32 {
        if self.is_volume { (self.all_layers >> mip.min(31)).max(1) } else { self.all_layers }
    }
}

/// The names of the resources that a texture, or a buffer, can be compared with.
pub(crate) fn comparable<'a>(
    plan: &'a Plan,
    report: &'a Report,
    is_buffer: bool,
) -> impl Iterator<Item = &'a String> {
    let names = report.resources.iter().map(|one| &one.name);
    names.filter(move |name| cannot(plan, name).is_none() && size_of(plan, name).is_some() == is_buffer)
}

impl Contents {
    /// Shows all choices. `versions` are the passes that write the resource, with the position of the shown one.
    pub(crate) fn choices(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Plan,
        report: &Report,
        (versions, at): (&[String], Option<usize>),
        places: &mut Places,
    ) {
        if !versions.is_empty() {
            version(ui, &mut self.look, versions, at, places);
        }
        sides(ui, &mut self.look, places);
        against(ui, &mut self.look, plan, report, places);
        if size_of(plan, &self.look.name).is_some() {
            return;
        }
        ui.horizontal_wrapped(|ui| {
            part(ui, &mut self.look, plan, places);
            let labels: Vec<&str> = self.tiles.iter().map(|tile| tile.label.as_str()).collect();
            tiles(ui, &mut self.look, &labels, places);
            channels(ui, &mut self.look, places);
            if stencil(ui, &mut self.look, plan, places) {
                self.forget();
            }
        });
        let fitted = self.fitted();
        let is_typed = std::mem::take(&mut self.wants_range);
        ui.horizontal(|ui| range(ui, &mut self.look.range, fitted, is_typed, places));
    }

    /// Begins a range of one's own, and gives its first number the keyboard; ends one that is there.
    pub(crate) fn turn_range(&mut self) {
        self.wants_range = self.look.range.is_none();
        self.look.range = self.wants_range.then(|| self.fitted());
    }

    /// The range of the shown contents.
    fn fitted(&self) -> [f32; 2] {
        let channel = self.drawn.as_ref().and_then(|drawn| drawn.channels.first());
        channel.map_or([0.0, 1.0], |channel| [channel.min, channel.max])
    }
}

/// Shows the pass after which the resource is shown.
fn version(ui: &mut egui::Ui, look: &mut Look, versions: &[String], at: Option<usize>, places: &mut Places) {
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

fn sides(ui: &mut egui::Ui, look: &mut Look, places: &mut Places) {
    ui.horizontal(|ui| {
        for (side, label) in Side::ALL {
            // A difference with something else is chosen below.
            let is_there = side != Side::Before || look.other().is_some();
            let shown = if side == Side::Before && look.against.is_some() { "other" } else { label };
            let button = ui.add_enabled(is_there, egui::Button::selectable(look.side == side, shown));
            places.note(&format!("side {label}"), &button);
            if button.clicked() {
                look.side = side;
            }
        }
    });
}

/// Shows what the resource is compared with, for the sides that compare.
fn against(ui: &mut egui::Ui, look: &mut Look, plan: &Plan, report: &Report, places: &mut Places) {
    if look.side == Side::After {
        return;
    }
    let is_buffer = size_of(plan, &look.name).is_some();
    ui.horizontal(|ui| {
        ui.label("with");
        let before =
            look.before.as_ref().map_or("nothing before".to_owned(), |pass| format!("before ({pass})"));
        let text = look.against.as_ref().map_or(before.clone(), |(name, _)| name.clone());
        let list = egui::ComboBox::from_id_salt("against").width(150.0).selected_text(text);
        let list = list.show_ui(ui, |ui| {
            let is_before = ui.selectable_label(look.against.is_none(), before);
            places.note("against before", &is_before);
            if is_before.clicked() {
                look.against = None;
            }
            for name in comparable(plan, report, is_buffer) {
                let is_chosen = look.against.as_ref().is_some_and(|(known, _)| known == name);
                let one = ui.selectable_label(is_chosen, name);
                places.note(&format!("against {name}"), &one);
                if one.clicked() {
                    look.against = Some((name.clone(), versions(report, name).pop()));
                }
            }
        });
        places.note("against", &list.response);
        if let Some((name, pass)) = &mut look.against {
            let text = pass.clone().unwrap_or_default();
            let list = egui::ComboBox::from_id_salt("against version").width(150.0).selected_text(text);
            let list = list.show_ui(ui, |ui| {
                for version in versions(report, name) {
                    let one = ui.selectable_value(pass, Some(version.clone()), &version);
                    places.note(&format!("against version {version}"), &one);
                }
            });
            places.note("against version", &list.response);
        }
    });
}

/// Shows the mip level, the layer or slice, and the sample.
fn part(ui: &mut egui::Ui, look: &mut Look, plan: &Plan, places: &mut Places) {
    let parts = Parts::of(plan, &look.name);
    look.mip = look.mip.min(parts.mips - 1);
    if parts.mips > 1 {
        let mip = egui::DragValue::new(&mut look.mip).range(0..=parts.mips - 1).prefix("mip ").speed(0.05);
        places.note("mip", &ui.add(mip));
    }
    let layers = parts.layers(look.mip);
    look.layer = look.layer.map(|layer| layer.min(layers - 1)).filter(|_| layers > 1);
    if layers > 1 {
        let is_cube = Content::of(plan, &look.name).is_some_and(|content| content.is_cube);
        let word = if parts.is_volume { "slice" } else { "layer" };
        let label = |layer: u32| layer_name(word, layer, layers, is_cube);
        let text = look.layer.map_or(format!("all {word}s"), label);
        let list = egui::ComboBox::from_id_salt("layer").width(90.0).selected_text(text);
        let list = list.show_ui(ui, |ui| {
            ui.selectable_value(&mut look.layer, None, format!("all {word}s"));
            for layer in 0..layers {
                let one = ui.selectable_value(&mut look.layer, Some(layer), label(layer));
                places.note(&format!("layer={layer}"), &one);
            }
        });
        places.note("layer", &list.response);
    }
    look.sample = look.sample.min(parts.samples - 1);
    if parts.samples > 1 {
        let max = parts.samples - 1;
        let sample = egui::DragValue::new(&mut look.sample).range(0..=max).prefix("sample ").speed(0.05);
        places.note("sample", &ui.add(sample));
    }
}

/// Shows the list of tiles, if the texture has any.
fn tiles(ui: &mut egui::Ui, look: &mut Look, labels: &[&str], places: &mut Places) {
    if labels.is_empty() {
        look.tile = None;
        return;
    }
    look.tile = look.tile.filter(|tile| *tile < labels.len());
    let text = look.tile.and_then(|tile| labels.get(tile)).map_or("all tiles", |label| *label);
    let list = egui::ComboBox::from_id_salt("tile").width(200.0).selected_text(text);
    let list = list.show_ui(ui, |ui| {
        ui.selectable_value(&mut look.tile, None, "all tiles");
        for (at, label) in labels.iter().enumerate() {
            let one = ui.selectable_value(&mut look.tile, Some(at), *label);
            places.note(&format!("tile={at}"), &one);
        }
    });
    places.note("tile", &list.response);
}

/// Shows the list of channels.
fn channels(ui: &mut egui::Ui, look: &mut Look, places: &mut Places) {
    const NAMES: [&str; 4] = ["R", "G", "B", "A"];
    let text = look.channel.and_then(|at| NAMES.get(at)).map_or("all channels", |name| *name);
    let list = egui::ComboBox::from_id_salt("channel").width(90.0).selected_text(text);
    let list = list.show_ui(ui, |ui| {
        ui.selectable_value(&mut look.channel, None, "all channels");
        for (at, name) in NAMES.iter().enumerate() {
            let one = ui.selectable_value(&mut look.channel, Some(at), *name);
            places.note(&format!("channel={name}"), &one);
        }
    });
    places.note("channel", &list.response);
}

/// Shows the choice between depth and stencil, if the texture has both. Returns `true` if it was changed.
fn stencil(ui: &mut egui::Ui, look: &mut Look, plan: &Plan, places: &mut Places) -> bool {
    let has_both = Parts::of(plan, &look.name).has_both_aspects;
    look.is_stencil &= has_both;
    if !has_both {
        return false;
    }
    let stencil = ui.checkbox(&mut look.is_stencil, "stencil");
    places.note("stencil", &stencil);
    stencil.changed()
}

/// Shows the range of values from black to white; `fitted` is the range that a new choice begins with. `is_typed` gives
/// its first number the keyboard.
fn range(
    ui: &mut egui::Ui,
    range: &mut Option<[f32; 2]>,
    fitted: [f32; 2],
    is_typed: bool,
    places: &mut Places,
) {
    let mut is_own = range.is_some();
    let own = ui.checkbox(&mut is_own, "range");
    places.note("own range", &own);
    if own.changed() {
        *range = is_own.then_some(fitted);
    }
    if let Some([min, max]) = range {
        let speed = ((*max - *min).abs() * 0.01).max(1e-5);
        let first = ui.add(egui::DragValue::new(min).speed(speed));
        places.note("range min", &first);
        if is_typed {
            first.request_focus();
        }
        ui.label("to");
        places.note("range max", &ui.add(egui::DragValue::new(max).speed(speed)));
    }
}

/// The display name of a texture layer; for a cube, the name of its face, such as `face +X`.
fn layer_name(word: &str, layer: u32, layers: u32, is_cube: bool) -> String {
    const FACES: [&str; 6] = ["+X", "−X", "+Y", "−Y", "+Z", "−Z"];
    match (is_cube, layers > 6) {
        (true, false) => format!("face {}", FACES[layer as usize % 6]),
        (true, true) => format!("cube {}, face {}", layer / 6, FACES[layer as usize % 6]),
        _ => format!("{word} {layer}"),
    }
}
