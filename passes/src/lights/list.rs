//! The node kind `light_list`: all lights of a frame, and the descriptors of their shadows.
//!
//! Published: [`shape`].
//!
//! Shaders declare `light` and `map` as arrays of structs with these members.
//!
//! The cone of a spot: the light is multiplied with the square of `clamp(cosine · scale + offset, 0, 1)`, cosine
//! between axis and ray, as the glTF extension KHR_lights_punctual gives it.
//!
//! Limits: lights beyond the capacity are left out, the least important first, and reported by name. Unusable lights
//! (see [`Light::check`]) are left out.

use glam::{DVec4, Vec3, Vec4};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, Component, DataShape, ValueType};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, list_of};
use umbragraph_pipeline::frame::{FrameInput, Light, LightKind};
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

use super::placement::{self, rank};
use super::slots::{self, SlotSettings, Slots};
use super::{descriptor, word};
use crate::cascades::light::radiance;
use crate::codes;
use crate::if_said::if_said;
use crate::importance::Eye;
use crate::words::{CONTACT_SHADOW, HARDNESS};

/// The index that stands for none: no shadow descriptor, no slot, or no light in a slot.
pub const NO_SHADOW: u32 = u32::MAX;

/// Publishes all lights of a frame by kind, and the descriptors of their shadows by backing.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightList {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// The maximum number of lights.
    pub lights: Expr,
    /// The maximum number of shadow descriptors; 1 by default.
    pub descriptors: Option<Expr>,
    /// The blackboard data that a `shadow_atlas` pass publishes; without this key no light casts shadows.
    pub placement: Option<Ref>,
    /// The blackboard data that a `spot_shadows` pass publishes, with the shadow descriptors of spot lights.
    pub tiles: Option<Ref>,
    /// The blackboard data that a `cube_shadows` pass publishes, with the shadow descriptors of point lights.
    pub cubes: Option<Ref>,
    /// The blackboard data that a `cascades` pass with "placement" publishes, with the shadow descriptors of
    /// directional lights.
    pub layers: Option<Ref>,
    /// The slots for lights in textures as large as the picture; none by default.
    pub slots: Option<SlotSettings>,
    /// The priority below which a light has hard shadows, unless it declares a shadow filter itself; 0 by default.
    pub hard_below: Option<Expr>,
}

impl Node for LightList {
    const NAME: &'static str = "light_list";
    const SUMMARY: &'static str =
        "Publishes all lights by kind, and the descriptors of their shadows by backing.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let lights = placement::capacity(pass, &self.lights, "/lights", placement::MAX_CAPACITY);
        let descriptors = if_said(&self.descriptors, |expr| {
            placement::capacity(pass, expr, "/descriptors", placement::MAX_CAPACITY)
        });
        let mut inputs = Vec::new();
        let mut sound = true;
        let mut input = |name: &Option<Ref>, pointer: &str, expected: &[(&str, ValueType)]| {
            let handle = pass.data_with(name.as_ref()?, pointer, expected);
            sound &= handle.is_some();
            inputs.push(handle?);
            Some(inputs.len() - 1)
        };
        let descriptor = descriptor::expected();
        let placement = input(&self.placement, "/placement", &placement::expected());
        let described = [(&self.tiles, "/tiles"), (&self.cubes, "/cubes"), (&self.layers, "/layers")];
        let described = described.map(|(name, pointer)| input(name, pointer, &descriptor));
        let slots = if_said(&self.slots, |settings| Slots::declare(pass, settings));
        if !sound {
            return None;
        }
        let slots = slots?;
        let hard_below = pass.live(|pass| pass.number_or(&self.hard_below, "/hard_below", 0.0))?;
        let (lights, descriptors) = (lights?, descriptors?.unwrap_or(1));
        let output = pass.publish(&self.to, "/to", shape(lights, descriptors))?;
        let node = RunLightList {
            setting: self.hard_below.clone(),
            capacity: lights as usize,
            placement,
            described,
            slots,
            hard_below,
        };
        pass.produce(Work::Cpu(CpuWork::new(node, output, inputs)))
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", shape(1, 1))]
    }
}

/// The shape of the published data for up to `lights` lights and `descriptors` shadow descriptors; lengths are in
/// metres. Directional lights come first, then spot lights, then point lights.
pub fn shape(lights: u32, descriptors: u32) -> DataShape {
    let number = ValueType::U32;
    let vectors = ValueType::VEC4.array(lights);
    let shape = DataShape::new()
        .value("directional_end", number, "where the directional lights end, which come first")
        .value("spot_end", number, "where the spot lights end")
        .value("point_end", number, "where the point lights end: the number of lights")
        .value("tile_end", number, "where the tiles end among the descriptors")
        .value("cube_end", number, "where the cubes end")
        .value("layer_end", number, "where the layers end: the number of descriptors")
        .value("light.position_range", vectors, "position; range, 0 without one")
        .value(
            "light.direction_scale",
            vectors,
            "the unit vector to a directional light, that along the axis of a spot; the scale of its cone",
        )
        .value(
            "light.color_offset",
            vectors,
            "colour times intensity (lux, or candela); the offset of its cone",
        )
        .value(
            "light.shadow",
            ValueType::vector(Component::U32, 4).array(lights),
            "first descriptor, or 2³² − 1 without a shadow; number of descriptors; slot, or 2³² − 1; 1 with contact shadows, and twice the hardness (1 hard, 2 soft, 3 PCSS)",
        )
        .value(
            "slot",
            ValueType::vector(Component::U32, 4).array(slots::GROUPS),
            "the position in this list of the light of each slot, or 2³² − 1",
        );
    descriptor::add(shape, descriptors)
}

#[derive(Clone, Debug, PartialEq)]
struct RunLightList {
    setting: Option<Expr>,
    capacity: usize,
    /// The index of the placement among the inputs; `None` without a placement.
    placement: Option<usize>,
    /// The indices of the descriptors of tiles, cubes and layers among the inputs; `None` where a key is not set.
    described: [Option<usize>; 3],
    slots: Option<Slots>,
    hard_below: f64,
}

/// Buffers that each frame reuses, and the names in the last notices.
#[derive(Debug, Default)]
struct State {
    /// The indices of the usable lights, in the frame's list of lights.
    order: Vec<u32>,
    /// For each light of the frame: the index of its first descriptor, or [`NO_SHADOW`], and the number of its
    /// descriptors.
    shadows: Vec<(u32, u32)>,
    /// The lights that request a slot: importance and index in the frame's list, the most important first.
    asking: Vec<(f32, u32)>,
    /// The names of the lights in the last notices: first lights beyond the capacity, then lights without a slot.
    known: [Vec<String>; 2],
}

impl CpuNode for RunLightList {
    type State = State;

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        self.hard_below = settings.number_or(&self.setting, "/hard_below", 0.0)?;
        Some(())
    }

    fn run(&self, state: &mut State, context: &CpuContext<'_>, data: &mut BlackboardData) {
        let State { order, shadows, asking, known } = state;
        let frame = context.frame;
        let input = |at: Option<usize>| at.and_then(|at| context.inputs.get(at).copied());
        shadows.clear();
        shadows.resize(frame.lights.len(), (NO_SHADOW, 0));
        self.publish_descriptors(&input, shadows, data);
        self.choose(frame, order);
        // Those that are left out are told in the notices.
        order.iter().for_each(|at| data.read_light(*at as usize));
        let (listed, left_out) = order.split_at(self.capacity.min(order.len()));
        let slotted = self.slots.as_ref().map_or(0, |slots| slots.choose(frame, listed, asking));
        let (slotted, slotless) = asking.split_at(slotted);
        let [known_left_out, known_slotless] = known;
        let are_others = remember(frame, left_out.iter().copied(), known_left_out);
        if remember(frame, slotless.iter().map(|(_, at)| *at), known_slotless) || are_others {
            data.set_notices(notices(frame, known));
        }
        order.truncate(self.capacity);
        order.sort_unstable_by(|a, b| {
            let (a, b) = (&frame.lights[*a as usize], &frame.lights[*b as usize]);
            rank(a).cmp(&rank(b)).then_with(|| placement::compare(a, b))
        });
        let lights = || order.iter().map(|at| &frame.lights[*at as usize]);
        for (end, last) in [("directional_end", 0), ("spot_end", 1), ("point_end", 2)] {
            data.set_u32(end, lights().filter(|light| rank(light) <= last).count() as u32);
        }
        data.set_vec4s("light.position_range", lights().map(position_range));
        data.set_vec4s("light.direction_scale", lights().map(direction_scale));
        data.set_vec4s("light.color_offset", lights().map(color_offset));
        let shadows = order.iter().flat_map(|at| {
            let (first, count) = shadows[*at as usize];
            let slot = slotted.iter().position(|(_, slotted)| slotted == at);
            let light = &frame.lights[*at as usize];
            let flags = u32::from(light.has(CONTACT_SHADOW)) + 2 * self.hardness(light);
            [first, count, slot.map_or(NO_SHADOW, |slot| slot as u32), flags]
        });
        data.set_words("light.shadow", shadows);
        slots::publish(data, order, slotted);
    }
}

impl RunLightList {
    /// The shadow filter that a light declares: 1 hard, 2 soft, 3 PCSS. Other lights have 1 if their priority is below
    /// `hard_below`, else 0: the pipeline decides.
    fn hardness(&self, light: &Light) -> u32 {
        let said = HARDNESS.iter().position(|word| light.has(word)).map(|at| at as u32 + 1);
        said.unwrap_or(u32::from(f64::from(light.priority) < self.hard_below))
    }

    /// Collects the indices of the usable lights in `order`; the most important come first if not all fit the capacity.
    fn choose(&self, frame: &FrameInput, order: &mut Vec<u32>) {
        order.clear();
        order
            .extend((0..frame.lights.len() as u32).filter(|at| frame.lights[*at as usize].check().is_none()));
        if order.len() > self.capacity {
            let of = |at: &u32| &frame.lights[*at as usize];
            let eye = Eye::new(&frame.camera);
            let importance = |light: &Light| eye.as_ref().map_or(0.0, |eye| eye.importance(light).value());
            order.sort_by(|a, b| {
                let (a, b) = (of(a), of(b));
                importance(b).total_cmp(&importance(a)).then_with(|| placement::compare(a, b))
            });
        }
    }

    /// Publishes the descriptors of tiles, cubes and layers one after the other. Stores in `shadows` the first
    /// descriptor of each light, and their number.
    fn publish_descriptors<'a>(
        &self,
        input: &impl Fn(Option<usize>) -> Option<&'a BlackboardData>,
        shadows: &mut [(u32, u32)],
        data: &mut BlackboardData,
    ) {
        let sets = self.described.map(input);
        let capacity = descriptor::capacity(data);
        let mut ends = [0; 3];
        let mut end = 0;
        for (at, set) in sets.iter().enumerate() {
            end = (end + set.map_or(0, |set| word(set, "count"))).min(capacity);
            ends[at] = end;
        }
        for (name, end) in ["tile_end", "cube_end", "layer_end"].into_iter().zip(ends) {
            data.set_u32(name, end);
        }
        let starts = [0, ends[0], ends[1]];
        for (name, value_type, _) in descriptor::VALUES {
            let words = value_type.element_words();
            let all = sets.iter().zip(starts.iter().zip(ends)).flat_map(|(set, (start, end))| {
                let wanted = (end - start) as usize * words;
                set.and_then(|set| set.words(name)).and_then(|all| all.get(..wanted)).unwrap_or_default()
            });
            data.set_words(name, all.copied());
        }
        let Some(placement) = input(self.placement) else { return };
        let mut next = starts;
        for entry in placement::entries(placement) {
            let backing = entry.backing.rank() as usize;
            let (_, count) = entry.backing.slots();
            let first = next[backing];
            next[backing] += count;
            if next[backing] <= ends[backing]
                && let Some(shadow) = shadows.get_mut(entry.light as usize)
            {
                *shadow = (first, count);
            }
        }
    }
}

/// Stores the names of `lights` in `known`; returns `true` if they differ from the names stored before.
fn remember(frame: &FrameInput, lights: impl Iterator<Item = u32> + Clone, known: &mut Vec<String>) -> bool {
    let names = lights.map(|at| &*frame.lights[at as usize].name);
    if names.clone().eq(known.iter().map(String::as_str)) {
        return false;
    }
    known.clear();
    known.extend(names.map(str::to_owned));
    true
}

/// Builds the notices that name lights left out of the list, and lights without a slot.
fn notices(frame: &FrameInput, [left_out, slotless]: &[Vec<String>; 2]) -> Diagnostics {
    let mut notices = Diagnostics::new();
    let named = |names: &[String]| {
        list_of(names.iter().map(|name| if name.is_empty() { "(unnamed)" } else { name.as_str() }))
    };
    if !left_out.is_empty() {
        let message = format!(
            "{} lights are left out, since a frame has more than {}: {}",
            left_out.len(),
            frame.lights.len() - left_out.len(),
            named(left_out)
        );
        let notice = Diagnostic::warning(codes::LIGHTS_LEFT_OUT, Place::Nowhere, message);
        notices.push(notice.help("raise the capacity of the light list"));
    }
    if !slotless.is_empty() {
        let message = format!(
            "nothing in screen space is kept of {} lights, since there are no more slots: {}",
            slotless.len(),
            named(slotless)
        );
        let notice = Diagnostic::warning(codes::SHADOWS_LEFT_OUT, Place::Nowhere, message);
        notices.push(notice.help("raise the number of slots, or give what matters more priority"));
    }
    notices
}

fn position_range(light: &Light) -> Vec4 {
    let range = if light.range.is_finite() { light.range } else { 0.0 };
    if light.kind == LightKind::Directional { Vec4::ZERO } else { finite(light.position).extend(range) }
}

fn direction_scale(light: &Light) -> Vec4 {
    match light.kind {
        LightKind::Directional => (-light.direction).as_vec3().extend(0.0),
        LightKind::Spot { .. } => light.direction.as_vec3().extend(cone(light).0),
        LightKind::Point => Vec4::ZERO,
    }
}

fn color_offset(light: &Light) -> Vec4 {
    radiance(light).extend(cone(light).1)
}

/// The scale and offset of a spot light's fall-off from inner to outer cone, as in `KHR_lights_punctual`; (0, 1) for
/// other lights.
fn cone(light: &Light) -> (f32, f32) {
    let LightKind::Spot { inner_angle, outer_angle } = light.kind else { return (0.0, 1.0) };
    let angle = |angle: f32| if angle.is_nan() { 0.0 } else { angle.clamp(0.0, std::f32::consts::FRAC_PI_2) };
    let (inner, outer) = (angle(inner_angle).cos(), angle(outer_angle).cos());
    let scale = 1.0 / (inner - outer).max(1e-3);
    (scale, -outer * scale)
}

fn finite(position: glam::DVec3) -> Vec3 {
    DVec4::from((position, 0.0)).as_vec4().truncate().clamp(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX))
}
