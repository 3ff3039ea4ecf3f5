//! Random pipelines, drawn and compared with what running their passes one after the other gives.
//!
//! A pipeline is a list of passes in the order in which they are meant: fills, blends, fills of one half, sums of two
//! textures, copies of textures and buffers, clears and updates of buffers, of subresource ranges (mips, layers, bytes)
//! of transient, persistent and history resources, some with toggles. Every two accesses of one subresource range, one
//! of which writes, are ordered by the text: by `after`, by the name of a version, or since a plain name is the newest.
//! The keys are shuffled. What is left is copied to layers of the picture, in several frames with the toggles switched
//! at random.
//!
//! The simulation keeps for each mip of each layer what the left and the right half hold, and for each quarter of a
//! buffer one number. No plan may be rejected or accused by the checker, and each picture has to be equal.

mod invented;
mod text;

use std::collections::BTreeMap;
use std::sync::Arc;

use umbragraph::Frame;
use umbragraph::Plan;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::wgpu;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;
use umbragraph_verify::verify;

use crate::common::gpu::import;
use crate::executing::stage::{SIDE, executor, texels, try_plan_of_text};
use crate::executing::views::frame;

/// So many graphs in ordinary tests; twice as many times what is asked for otherwise.
const GRAPHS: u64 = 100;
const FRAMES: usize = 3;
const TOGGLES: usize = 2;
const STATES: u32 = 1 << TOGGLES;
const ALL_STATES: u8 = (1 << STATES) - 1;
/// Bytes of a quarter of a buffer.
const QUARTER: u32 = 256;
const OBSERVED: usize = 6;

/// A mip of a layer of a texture, or a quarter of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Unit {
    resource: usize,
    mip: usize,
    /// The layer, or the quarter.
    at: usize,
}

/// The content of a unit: red of the left and the right half, or a number of a buffer.
type Value = [u32; 2];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lifetime {
    Transient,
    Persistent,
    History,
}

#[derive(Clone, Debug)]
struct Resource {
    name: String,
    is_buffer: bool,
    mips: usize,
    layers: usize,
    lifetime: Lifetime,
}

impl Resource {
    fn units(&self, resource: usize) -> Vec<Unit> {
        let mips = 0..self.mips;
        mips.flat_map(|mip| (0..self.layers).map(move |at| Unit { resource, mip, at })).collect()
    }
}

/// The effect of a pass on the units that it writes.
#[derive(Clone, Debug)]
enum Deed {
    Fill(u32),
    FillLeft(u32),
    Add(u32),
    /// The sum of two units, each in this frame or, if said, in the one before.
    Sum([Read; 2]),
    /// Unit by unit.
    Copy(Vec<Read>),
    Zero,
    /// Adds to each number.
    Bump(u32),
}

/// When a unit is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum When {
    /// As it is when the pass runs.
    Now,
    /// Before the first write of the frame.
    Before,
    /// As the frame before left it.
    Back,
}

#[derive(Clone, Copy, Debug)]
struct Read {
    unit: Unit,
    when: When,
}

#[derive(Clone, Debug)]
struct Pass {
    name: String,
    toggle: Option<(usize, bool)>,
    writes: Vec<Unit>,
    deed: Deed,
}

impl Pass {
    fn runs(&self, state: u32) -> bool {
        self.toggle.is_none_or(|(toggle, on)| (state >> toggle & 1 == 1) == on)
    }

    /// The states in which it runs, as bits.
    fn states(&self) -> u8 {
        (0..STATES).filter(|state| self.runs(*state)).fold(0, |all, state| all | 1 << state)
    }

    /// The units that it reads of this frame, or of what was there before it.
    fn reads(&self) -> Vec<Read> {
        let own = || self.writes.iter().map(|unit| Read { unit: *unit, when: When::Now }).collect();
        match &self.deed {
            Deed::Fill(_) | Deed::Zero => Vec::new(),
            Deed::FillLeft(_) | Deed::Add(_) | Deed::Bump(_) => own(),
            Deed::Sum(reads) => reads.to_vec(),
            Deed::Copy(reads) => reads.clone(),
        }
    }

    fn loads(&self) -> bool {
        matches!(self.deed, Deed::FillLeft(_) | Deed::Add(_) | Deed::Bump(_))
    }
}

struct Graph {
    resources: Vec<Resource>,
    passes: Vec<Pass>,
    text: String,
}

impl Graph {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..8 {
            random.below(2);
        }
        let mut resources = Vec::new();
        for at in 0..2 + random.below(2) {
            let lifetime = random.one_of(&[
                Lifetime::Transient,
                Lifetime::Transient,
                Lifetime::Persistent,
                Lifetime::History,
            ]);
            let (mips, layers) = (1 + random.below(2), 1 + random.below(2));
            resources.push(Resource { name: format!("t{at}"), is_buffer: false, mips, layers, lifetime });
        }
        for at in 0..random.below(3) {
            let lifetime = random.one_of(&[Lifetime::Transient, Lifetime::Persistent]);
            resources.push(Resource {
                name: format!("b{at}"),
                is_buffer: true,
                mips: 1,
                layers: 4,
                lifetime,
            });
        }
        let mut graph = Self { resources, passes: Vec::new(), text: String::new() };
        graph.invent(&mut random);
        graph.text = graph.written(&mut random);
        graph
    }

    fn add(&mut self, toggle: Option<(usize, bool)>, writes: Vec<Unit>, deed: Deed) {
        let name = format!("p{}", self.passes.len());
        self.passes.push(Pass { name, toggle, writes, deed });
    }

    /// Runs the passes one after the other; what is shown.
    fn step(
        &self,
        held: &mut BTreeMap<Unit, Value>,
        back: &mut BTreeMap<Unit, Value>,
        state: u32,
    ) -> Vec<Value> {
        let before = held.clone();
        let mut shown = Vec::new();
        for pass in self.passes.iter().filter(|pass| pass.runs(state)) {
            let find = |read: &Read| {
                let all = match read.when {
                    When::Now => &*held,
                    When::Before => &before,
                    When::Back => &*back,
                };
                all.get(&read.unit).copied().unwrap_or_default()
            };
            let mut new = Vec::new();
            for (at, unit) in pass.writes.iter().enumerate() {
                let [left, right] = held.get(unit).copied().unwrap_or_default();
                // Of what is no more than half a picture wide all is left.
                let is_left = SIDE >> unit.mip <= SIDE / 2;
                new.push(match &pass.deed {
                    Deed::Fill(number) => [*number; 2],
                    Deed::FillLeft(number) => [*number, if is_left { *number } else { right }],
                    Deed::Add(number) => [(left + number).min(255), (right + number).min(255)],
                    Deed::Sum(reads) => {
                        let [[a, b], [c, d]] = [find(&reads[0]), find(&reads[1])];
                        [(a + c).min(255), (b + d).min(255)]
                    }
                    Deed::Copy(reads) => find(&reads[at]),
                    Deed::Zero => [0; 2],
                    Deed::Bump(number) => [left + number, right + number],
                });
            }
            if pass.writes[0].resource == usize::MAX {
                shown.extend(new.into_iter().map(|value| value.map(|number| number.min(255))));
            } else {
                held.extend(pass.writes.iter().copied().zip(new));
            }
        }
        for (at, resource) in self.resources.iter().enumerate() {
            if resource.lifetime == Lifetime::History {
                for unit in resource.units(at) {
                    back.insert(unit, held.get(&unit).copied().unwrap_or_default());
                }
            }
        }
        shown
    }
}

/// The first error in the pictures of a graph, if there is one.
fn error(gpu: &Gpu, graph: &Graph, random: &mut Random) -> Option<String> {
    let plan: Arc<Plan> = match try_plan_of_text(graph.text.clone(), SIDE) {
        Ok(plan) => plan,
        Err(diagnostics) => return Some(format!("rejected: {diagnostics}")),
    };
    let violations = verify(&plan, &PlanOptions::new(SIDE, SIDE));
    if !violations.is_empty() {
        return Some(format!("accused: {violations:#?}"));
    }
    let mut executor = executor(gpu, &plan, None);
    let picture = import(gpu, &plan, "target");
    let (mut held, mut back) = (BTreeMap::new(), BTreeMap::new());
    for number in 0..FRAMES {
        let state = random.below(STATES as usize) as u32;
        let toggles: Vec<(String, bool)> =
            (0..TOGGLES).map(|toggle| (format!("s{toggle}"), state >> toggle & 1 == 1)).collect();
        let toggles: Vec<(&str, bool)> = (toggles.iter())
            .filter(|(name, _)| plan.toggles.contains_key(name))
            .map(|(name, on)| (name.as_str(), *on))
            .collect();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (input, imports) = (frame(&[]), [("target", &picture)]);
        let frame = Frame::new(&input).imports(&imports).toggles(&toggles);
        if let Err(diagnostics) = executor.record(&mut encoder, &frame) {
            return Some(format!("not recorded: {diagnostics:#?}"));
        }
        gpu.queue.submit([encoder.finish()]);
        for (layer, [left, right]) in graph.step(&mut held, &mut back, state).into_iter().enumerate() {
            let texels = texels(gpu, &picture, layer as u32);
            let wrong = texels.iter().enumerate().find(|(at, texel)| {
                let wanted = if *at as u32 % SIDE < SIDE / 2 { left } else { right };
                u32::from(texel[0]) != wanted
            });
            if let Some((at, texel)) = wrong {
                return Some(format!(
                    "frame {number} with {toggles:?}, layer {layer}: {} at texel {at}, not {left} and {right}",
                    texel[0]
                ));
            }
        }
    }
    None
}

#[test]
fn random_graphs_draw_as_their_passes_in_sequence() {
    let Some(gpu) = gpu::device() else { return };
    let times = u64::from(property::times());
    let graphs = if times == 1 { GRAPHS } else { 2 * GRAPHS * times };
    let mut violations = Vec::new();
    for number in 0..graphs {
        let seed = property::seed().wrapping_mul(1 << 20).wrapping_add(number);
        let graph = Graph::new(seed);
        if let Some(error) = error(&gpu, &graph, &mut Random(seed | 1)) {
            violations.push(format!("graph {number} ({seed}): {error}\n{}", graph.text));
        }
    }
    let count = |word: &str| violations.iter().filter(|error| error.contains(word)).count();
    let (rejected, accused) = (count("): rejected"), count("): accused"));
    let wrong = violations.len() - rejected - accused;
    println!("{graphs} graphs: {wrong} wrong, {rejected} rejected, {accused} accused");
    assert!(
        violations.is_empty(),
        "{wrong} wrong, {rejected} rejected, {accused} accused, such as\n{}",
        violations[0]
    );
}
