//! Settings of a pass beyond its reads and writes: the state of attachments and draws, its bindings and their uploaded
//! values, copies. Each setting is a name and a value, both in words, so that pages can list them and [`super::diff`]
//! can compare them without knowing what they mean.

use std::collections::BTreeMap;

use serde::Serialize;

use umbragraph_compiler::{Plan, PlannedPass};
use umbragraph_pipeline::data::Component;
use umbragraph_pipeline::pipeline::element_type;
use umbragraph_pipeline::shader::{Member, TypeLayout};
use umbragraph_pipeline::work::{
    BlockValues, BoundSlot, Draw, DrawCounts, Live, LoadOperation, Redraw, RenderWork, ResourceHandle,
    SlotSource, Subresource, TextureView, Work,
};

/// The maximum number of elements of a list setting that a report shows.
const MAX_NUMBERS: usize = 16;

/// Returns the settings of a pass by name, as text.
pub(super) fn settings(plan: &Plan, planned: &PlannedPass) -> BTreeMap<String, String> {
    let mut settings = Settings { plan, planned, told: BTreeMap::new() };
    match plan.pipeline.pass(planned.handle).work() {
        Work::Nothing | Work::Cpu(_) => {}
        Work::Render(render) => settings.render(render),
        Work::Compute(compute) => settings.bindings(&compute.bindings),
        Work::Transfer(_) => {
            for (number, copy) in planned.copies.iter().enumerate() {
                settings.told.insert(format!("copy {number}"), word(copy));
            }
        }
    }
    settings.told
}

struct Settings<'a> {
    plan: &'a Plan,
    planned: &'a PlannedPass,
    told: BTreeMap<String, String>,
}

impl Settings<'_> {
    fn name(&self, resource: ResourceHandle) -> &str {
        &self.plan.pipeline.resource(resource).name
    }

    fn tell(&mut self, setting: String, value: impl Into<String>) {
        self.told.insert(setting, value.into());
    }

    fn render(&mut self, render: &RenderWork) {
        for color in &render.color {
            let name = self.target(&color.to);
            self.clear(&name, color.load);
            if let Some(blend) = &color.blend {
                self.tell(format!("blend of {name}"), word(blend));
            }
            if color.write_mask != wgpu_types::ColorWrites::ALL {
                self.tell(format!("write mask of {name}"), word(&color.write_mask));
            }
            if let Some(format) = &color.format {
                self.tell(format!("format of {name}"), word(format));
            }
            if let Some(resolved) = &color.resolve {
                let to = self.target(resolved);
                self.tell(format!("resolve of {name}"), to);
            }
        }
        if let Some(constant) = &render.blend_constant {
            self.tell("blend constant".to_owned(), word(&constant.value));
        }
        if let Some(depth) = &render.depth {
            let name = self.target(&depth.to);
            self.clear(&name, depth.load);
            self.tell(format!("compare of {name}"), word(&depth.compare));
            self.tell(format!("write of {name}"), if depth.write { "on" } else { "off" });
            if depth.slope_bias != 0.0 {
                self.tell(format!("slope bias of {name}"), depth.slope_bias.to_string());
            }
        }
        if let Some(stencil) = &render.stencil {
            let name = format!("{} (stencil)", self.target(&stencil.to));
            self.clear(&name, stencil.load);
            self.tell(format!("state of {name}"), word(&stencil.state));
            self.tell(format!("reference of {name}"), stencil.reference.value.0.to_string());
        }
        let cull = |face: Option<wgpu_types::Face>| face.map_or("none".to_owned(), |face| word(&face));
        match &render.draw {
            Draw::Fullscreen { .. } => {}
            Draw::Buffers(draw) => {
                self.tell("topology".to_owned(), word(&draw.topology));
                self.tell("cull".to_owned(), cull(draw.cull));
                let counts = match &draw.counts {
                    DrawCounts::Direct { count, instances } => {
                        format!("{} × {}", count.value, instances.value)
                    }
                    DrawCounts::Indirect(counts) => {
                        format!("{} from byte {}", self.name(counts.resource), counts.offset())
                    }
                };
                self.tell("count".to_owned(), counts);
            }
            Draw::Scene(scene) => {
                self.tell("geometry".to_owned(), scene.geometry.as_str());
                self.tell("mesh_filter".to_owned(), scene.filter.as_str());
                let views = self.name(scene.views.resource).to_owned();
                self.tell("views".to_owned(), views);
                self.tell("order".to_owned(), word(&scene.order));
                self.tell("cull".to_owned(), cull(scene.cull));
                if let Some(Redraw { clear, base, every, scroll }) = &scene.redraw {
                    let base = base.as_ref().map(|base| self.name(base.resource).to_owned());
                    let base = base.unwrap_or_else(|| clear.value.0.to_string());
                    let scrolled = if *scroll { ", scrolled" } else { "" };
                    let redraw = format!("changed{scrolled}, every {every:?} frames, over {base}");
                    self.tell("redraw".to_owned(), redraw);
                }
            }
        }
        self.bindings(render.draw.bound().1);
    }

    /// Formats an attachment: the resource name, followed by the mip level and the array layer where they are above 0.
    fn target(&self, to: &Subresource) -> String {
        let target = to.target();
        let mut words = self.name(target.resource).to_owned();
        if target.mip > 0 {
            words.push_str(&format!(" mip {}", target.mip));
        }
        if let Some(layer) = target.layer.filter(|layer| *layer > 0) {
            words.push_str(&format!(" layer {layer}"));
        }
        words
    }

    fn clear<T: Serialize>(&mut self, name: &str, load: LoadOperation<Live<T>>) {
        if let LoadOperation::Clear(value) = load {
            self.tell(format!("clear of {name}"), word(&value.value));
        }
    }

    fn bindings(&mut self, slots: &[BoundSlot]) {
        for slot in slots {
            let bound = match &slot.source {
                SlotSource::Texture(texture) => self.view(&texture.view()),
                SlotSource::Buffer { buffer, .. } => match buffer.range.bytes {
                    Some(run) => {
                        format!("{} bytes {} to {}", self.name(buffer.resource), run.first, run.end())
                    }
                    None => self.name(buffer.resource).to_owned(),
                },
                SlotSource::Sampler(sampler) => word(sampler),
                SlotSource::Data { data, .. } => self.name(data.resource).to_owned(),
                SlotSource::View => "the view".to_owned(),
                SlotSource::Values(_) => "values".to_owned(),
            };
            self.tell(format!("binding {}", slot.name), bound);
            if let Some(values) = slot.source.values() {
                self.values(slot, values);
            }
        }
    }

    fn view(&self, view: &TextureView) -> String {
        let mut words = format!("{} as {}", self.name(view.resource), word(&view.shape));
        for (what, run) in [("mips", view.mip), ("layers", view.layer)] {
            if let Some(run) = run {
                words.push_str(&format!(", {what} {} to {}", run.first, run.end()));
            }
        }
        if let Some(format) = &view.format {
            words.push_str(&format!(", in {}", word(format)));
        }
        words
    }

    fn values(&mut self, slot: &BoundSlot, values: &BlockValues) {
        let TypeLayout::Struct { members, .. } = &values.layout else { return };
        let block = |block: &&umbragraph_compiler::PackedBlock| {
            (block.group, block.binding) == (slot.group, slot.binding)
        };
        let Some(block) = self.planned.blocks.iter().find(block) else { return };
        for (name, _) in &values.expressions {
            if let Some(value) = members
                .iter()
                .find(|member| member.name == *name)
                .and_then(|member| numbers(member, &block.bytes))
            {
                self.told.insert(format!("value {}.{name}", slot.name), value);
            }
        }
    }
}

/// Formats the numbers of a constant block member, including padding between them; at most [`MAX_NUMBERS`]. `None` if
/// the member is no number, vector or matrix, or no array of them.
fn numbers(member: &Member, bytes: &[u8]) -> Option<String> {
    let element = match &member.layout {
        TypeLayout::Array { element, .. } => element_type(element),
        other => element_type(other),
    }?;
    let start = member.offset as usize;
    let bytes = bytes.get(start..start + member.layout.size() as usize)?;
    let (words, _) = bytes.as_chunks::<4>();
    let mut told: Vec<String> = words
        .iter()
        .take(MAX_NUMBERS)
        .map(|word| match element.component {
            Component::F32 => f32::from_le_bytes(*word).to_string(),
            Component::U32 => u32::from_le_bytes(*word).to_string(),
            Component::I32 => i32::from_le_bytes(*word).to_string(),
        })
        .collect();
    if words.len() > MAX_NUMBERS {
        told.push("…".to_owned());
    }
    Some(told.join(" "))
}

/// Formats a value from its JSON form: members one after the other, nested members in parentheses.
pub(super) fn word(value: &impl Serialize) -> String {
    serde_json::to_value(value).map_or_else(|_| String::new(), |value| words(&value, 0))
}

fn words(value: &serde_json::Value, depth: usize) -> String {
    match value {
        serde_json::Value::String(word) => word.clone(),
        serde_json::Value::Object(members) => {
            let members = members.iter().filter(|(_, value)| !value.is_null());
            let told: Vec<String> =
                members.map(|(name, value)| format!("{name} {}", words(value, depth + 1))).collect();
            if depth == 0 { told.join(", ") } else { format!("({})", told.join(", ")) }
        }
        other => other.to_string(),
    }
}
