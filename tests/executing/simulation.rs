//! Random pipelines, drawn and compared with what running their passes one after the other gives.
//!
//! A pipeline is a list of passes in the order in which they are meant: fills, blends, fills of one half, sums of two
//! textures, copies of textures and buffers, clears and updates of buffers, of subresource ranges (mips, layers, bytes)
//! of transient, persistent and history resources, some with toggles. Every two accesses of one subresource range, one
//! of which writes, are ordered by the text: by `after`, by the name of a version, or since a plain name is the newest.
//! The keys are shuffled. What is left is copied to layers of the picture, in several frames with the toggles thrown at
//! random.
//!
//! The simulation keeps for each mip of each layer what the left and the right half hold, and for each quarter of a
//! buffer one number. No plan may be rejected or accused by the checker, and each picture has to be equal.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::sync::Arc;

use umbragraph::compiler::{Plan, PlanOptions, verify};
use umbragraph::executor::Frame;
use umbragraph::wgpu;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::common::gpu::import;
use crate::stage::{SIDE, executor, texels, try_plan_of_text};
use crate::views::frame;

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

/// What a unit holds: red of the left and the right half, or a number of a buffer.
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

/// What a pass does to what it writes.
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

    /// Passes that only read what is there in every state in which they run.
    fn invent(&mut self, random: &mut Random) {
        let mut written: BTreeMap<Unit, u8> = BTreeMap::new();
        for (at, resource) in self.resources.clone().iter().enumerate() {
            if resource.lifetime == Lifetime::Persistent {
                written.extend(resource.units(at).into_iter().map(|unit| (unit, ALL_STATES)));
            }
            if resource.lifetime == Lifetime::History {
                for unit in resource.units(at) {
                    self.add(None, vec![unit], Deed::Fill(random.below(40) as u32));
                    written.insert(unit, ALL_STATES);
                }
            }
        }
        for _ in 0..4 + random.below(9) {
            let toggle = random.one_in(4).then(|| (random.below(TOGGLES), random.one_in(2)));
            let probe = Pass { name: String::new(), toggle, writes: Vec::new(), deed: Deed::Zero };
            let states = probe.states();
            let resource = random.below(self.resources.len());
            let to = random.one_of(&self.resources[resource].units(resource));
            let number = 1 + random.below(60) as u32;
            let is_there = |unit: &Unit| written.get(unit).copied().unwrap_or(0) & states == states;
            let reads = self.readable(random, &to, &is_there);
            let (mut writes, mut deed) = (vec![to], None);
            if self.resources[resource].is_buffer {
                match random.below(4) {
                    0 => deed = Some(Deed::Zero),
                    1 | 2 if is_there(&to) => deed = Some(Deed::Bump(number)),
                    _ => {
                        deed = random
                            .one_in(2)
                            .then(|| reads.first().map(|read| Deed::Copy(vec![*read])))
                            .flatten();
                    }
                }
                // A clear of several quarters.
                if matches!(deed, Some(Deed::Zero)) && random.one_in(3) {
                    let count = 1 + random.below(4 - to.at);
                    writes = (to.at..to.at + count).map(|at| Unit { at, ..to }).collect();
                }
            } else {
                match random.below(8) {
                    0 | 1 => deed = Some(Deed::Fill(number)),
                    2 if is_there(&to) => deed = Some(Deed::FillLeft(number)),
                    3 if is_there(&to) => deed = Some(Deed::Add(number)),
                    4 | 5 if !reads.is_empty() => {
                        deed = Some(Deed::Sum([random.one_of(&reads), random.one_of(&reads)]));
                    }
                    6 if !reads.is_empty() => {
                        let reads: Vec<Read> =
                            reads.iter().copied().filter(|read| read.unit.mip == to.mip).collect();
                        deed = (!reads.is_empty()).then(|| Deed::Copy(vec![random.one_of(&reads)]));
                    }
                    7 => {
                        deed = self.layers(random, &to, &is_there).map(|(units, reads)| {
                            writes = units;
                            Deed::Copy(reads)
                        });
                    }
                    _ => {}
                }
            }
            let deed = deed.unwrap_or(if self.resources[resource].is_buffer {
                Deed::Zero
            } else {
                Deed::Fill(number)
            });
            for unit in &writes {
                *written.entry(*unit).or_default() |= states;
            }
            self.add(toggle, writes, deed);
        }
        // Without anything that is there in every state there is nothing to see, which is rejected.
        if !written.values().any(|states| *states == ALL_STATES) {
            let first = self.resources[0].units(0)[0];
            self.add(None, vec![first], Deed::Fill(1));
        }
    }

    /// What a pass that writes a unit can read: units of the same kind and size, not those that it writes.
    fn readable(&self, random: &mut Random, to: &Unit, is_there: &dyn Fn(&Unit) -> bool) -> Vec<Read> {
        let mut reads = Vec::new();
        let own = &self.resources[to.resource];
        for (at, resource) in self.resources.iter().enumerate() {
            for unit in resource.units(at) {
                let fits = resource.is_buffer == own.is_buffer
                    && unit.mip == to.mip
                    && unit != *to
                    && !(own.is_buffer && unit.resource == to.resource);
                if !fits {
                    continue;
                }
                if is_there(&unit) {
                    reads.push(Read { unit, when: When::Now });
                }
                let is_first = self.writers(&unit, self.passes.len()).is_empty();
                match resource.lifetime {
                    Lifetime::Persistent if is_first && random.one_in(4) => {
                        reads.push(Read { unit, when: When::Before });
                    }
                    Lifetime::History if random.one_in(2) => reads.push(Read { unit, when: When::Back }),
                    _ => {}
                }
            }
        }
        reads
    }

    /// A copy of both layers of a texture to those of another.
    fn layers(
        &self,
        random: &mut Random,
        to: &Unit,
        is_there: &dyn Fn(&Unit) -> bool,
    ) -> Option<(Vec<Unit>, Vec<Read>)> {
        let both = |resource: usize| [0, 1].map(|at| Unit { resource, mip: to.mip, at }).to_vec();
        let sources: Vec<usize> = (0..self.resources.len())
            .filter(|at| {
                let resource = &self.resources[*at];
                let fits = !resource.is_buffer && resource.layers == 2 && resource.mips > to.mip;
                fits && *at != to.resource && both(*at).iter().all(is_there)
            })
            .collect();
        if self.resources[to.resource].layers < 2 || sources.is_empty() {
            return None;
        }
        let reads = both(random.one_of(&sources)).into_iter().map(|unit| Read { unit, when: When::Now });
        Some((both(to.resource), reads.collect()))
    }

    /// The text, with what is seen in the end.
    fn written(&mut self, random: &mut Random) -> String {
        let mut observed: Vec<Unit> =
            (0..self.resources.len()).flat_map(|at| self.resources[at].units(at)).collect();
        let written = |unit: &Unit| {
            let states = self.passes.iter().filter(|pass| pass.writes.contains(unit)).map(Pass::states);
            states.fold(0, |all, states| all | states) == ALL_STATES
                || self.resources[unit.resource].lifetime == Lifetime::Persistent
        };
        observed.retain(written);
        while observed.len() > OBSERVED || observed.len() > 2 && random.one_in(4) {
            observed.remove(random.below(observed.len()));
        }
        let first_observer = self.passes.len();
        for (layer, unit) in observed.iter().enumerate() {
            let read = Read { unit: *unit, when: When::Now };
            let picture = Unit { resource: usize::MAX, mip: 0, at: layer };
            self.add(None, vec![picture], Deed::Copy(vec![read]));
        }
        let mut entries: Vec<String> =
            (0..self.passes.len()).map(|at| self.entry(random, at, at >= first_observer)).collect();
        random.shuffle(&mut entries);
        let mut resources = String::new();
        for resource in &self.resources {
            let lifetime = match resource.lifetime {
                Lifetime::Transient => "",
                Lifetime::Persistent => r#", "lifetime": "persistent""#,
                Lifetime::History => r#", "lifetime": "history", "initial": [0, 0, 0, 1]"#,
            };
            let _ = match resource.is_buffer {
                true => write!(
                    resources,
                    r#""{}": {{ "buffer": {{ "size": {} {lifetime} }} }},"#,
                    resource.name,
                    4 * QUARTER
                ),
                false => write!(
                    resources,
                    r#""{}": {{ "texture": {{ "format": "rgba8unorm", "size": "viewport", "mips": {}, "layers": {} {lifetime} }} }},"#,
                    resource.name, resource.mips, resource.layers
                ),
            };
        }
        let toggles: Vec<String> = (0..TOGGLES)
            .filter(|toggle| {
                self.passes.iter().any(|pass| pass.toggle.is_some_and(|(other, _)| other == *toggle))
            })
            .map(|toggle| format!(r#""s{toggle}": {{ "default": true }}"#))
            .collect();
        format!(
            "{{ \"format\": 1, \"name\": \"test\", \"toggles\": {{ {} }},\n\"resources\": {{ {resources}\n\"target\": {{ \
             \"texture\": {{ \"format\": \"rgba8unorm\", \"size\": \"viewport\", \"layers\": {OBSERVED}, \
             \"lifetime\": \"imported\" }} }} }},\n\"passes\": {{\n{}\n}} }}",
            toggles.join(", "),
            entries.join(",\n")
        )
    }

    /// The passes before one that write a unit, the last one last.
    fn writers(&self, unit: &Unit, before: usize) -> Vec<usize> {
        (0..before).filter(|at| self.passes[*at].writes.contains(unit)).collect()
    }

    /// One pass, with what orders it.
    fn entry(&self, random: &mut Random, at: usize, is_observer: bool) -> String {
        let pass = &self.passes[at];
        let mut after: BTreeSet<usize> = BTreeSet::new();
        let mut names: Vec<String> = Vec::new();
        // Several units of one reference have one version.
        let last = |read: &Read| self.writers(&read.unit, at).last().copied();
        let reads = pass.reads();
        let mut named = random.one_in(2);
        let is_one =
            matches!(pass.deed, Deed::Sum(_)) || reads.windows(2).all(|two| last(&two[0]) == last(&two[1]));
        for read in reads {
            if matches!(pass.deed, Deed::Sum(_)) {
                named = random.one_in(2);
            }
            let name = &self.resources[read.unit.resource].name;
            let writers = self.writers(&read.unit, at);
            let is_last =
                !(at + 1..self.passes.len()).any(|later| self.passes[later].writes.contains(&read.unit));
            names.push(match (read.when, writers.last()) {
                (When::Before, _) => format!("{name}@0"),
                (When::Back, _) => format!("{name}@-1"),
                (When::Now, Some(writer)) if !pass.loads() && is_one && named => {
                    format!("{name}@{}", self.passes[*writer].name)
                }
                (When::Now, _) if is_last && !pass.loads() && !named => name.clone(),
                (When::Now, None) => name.clone(),
                (When::Now, Some(_)) => {
                    after.extend(writers);
                    name.clone()
                }
            });
        }
        // What was written, or read, before it is written over.
        for unit in &pass.writes {
            after.extend(self.writers(unit, at));
            let reads = |earlier: &Pass| {
                earlier.reads().iter().any(|read| read.unit == *unit && read.when != When::Back)
            };
            after.extend((0..at).filter(|earlier| reads(&self.passes[*earlier])));
        }
        after.remove(&at);
        let mut text = format!("\"{}\": {{ ", pass.name);
        if !after.is_empty() {
            let list: Vec<String> = after.iter().map(|at| format!("\"{}\"", self.passes[*at].name)).collect();
            let _ = write!(text, "\"after\": [{}], ", list.join(", "));
        }
        if let Some((toggle, on)) = pass.toggle {
            let _ = write!(text, "\"toggle\": \"{}s{toggle}\", ", if on { "" } else { "!" });
        }
        let work = match is_observer {
            true => self.observer(pass, &names[0]),
            false => self.work(pass, &names),
        };
        text + &work + " }"
    }

    fn work(&self, pass: &Pass, names: &[String]) -> String {
        let to = pass.writes[0];
        let name = &self.resources[to.resource].name;
        let texel = |number: u32| format!("[\"{number} / 255\", 0, 0, 0]");
        let attached = |more: &str| {
            format!(r#""color": [{{ "to": "{name}", "mip": {}, "layer": {} {more} }}]"#, to.mip, to.at)
        };
        let fill = |shader: &str, number: u32, more: &str| {
            format!(
                r#""fullscreen": {{ "shader": "{shader}.wgsl.jinja",
                "bind": {{ "settings": {{ "values": {{ "color": {} }} }} }}, {} }}"#,
                texel(number),
                attached(more)
            )
        };
        let bytes = |unit: &Unit, count: usize| {
            format!(r#""offset": {}, "size": {}"#, unit.at as u32 * QUARTER, count as u32 * QUARTER)
        };
        match &pass.deed {
            Deed::Fill(number) => fill("fill", *number, ""),
            Deed::FillLeft(number) => fill("left", *number, ""),
            Deed::Add(number) => fill("fill", *number, r#", "blend": "add""#),
            Deed::Sum(reads) => {
                let bound = |at: usize| {
                    let Unit { mip, at: layer, .. } = reads[at].unit;
                    format!(
                        r#"{{ "texture": {{ "name": "{}", "mip": {mip}, "layer": {layer} }} }}"#,
                        names[at]
                    )
                };
                format!(
                    r#""fullscreen": {{ "shader": "add.wgsl.jinja", "bind": {{ "one": {}, "other": {} }}, {} }}"#,
                    bound(0),
                    bound(1),
                    attached("")
                )
            }
            Deed::Copy(reads) => {
                let end = |name: &str, unit: &Unit| match self.resources[unit.resource].is_buffer {
                    true => format!(r#"{{ "name": "{name}", {} }}"#, bytes(unit, 1)),
                    false => format!(
                        r#"{{ "name": "{name}", "mip": {}, "layer": {}, "layers": {} }}"#,
                        unit.mip,
                        unit.at,
                        reads.len()
                    ),
                };
                format!(
                    r#""copy": {{ "from": {}, "to": {} }}"#,
                    end(&names[0], &reads[0].unit),
                    end(name, &to)
                )
            }
            Deed::Zero => format!(r#""clear": {{ "buffer": "{name}", {} }}"#, bytes(&to, pass.writes.len())),
            Deed::Bump(number) => format!(
                r#""compute": {{ "shader": "bump.wgsl.jinja", "workgroups": [1, 1, 1], "bind": {{
                "settings": {{ "values": {{ "number": {number} }} }},
                "words": {{ "buffer": {{ "name": "{name}", {} }} }} }} }}"#,
                bytes(&to, 1)
            ),
        }
    }

    /// A pass that shows a unit in a layer of the picture.
    fn observer(&self, pass: &Pass, name: &str) -> String {
        let Deed::Copy(reads) = &pass.deed else { return String::new() };
        let Unit { resource, mip, at } = reads[0].unit;
        let to = format!(r#""color": [{{ "to": "target", "layer": {} }}]"#, pass.writes[0].at);
        match self.resources[resource].is_buffer {
            true => format!(
                r#""fullscreen": {{ "shader": "word.wgsl.jinja", "bind": {{ "words": {{ "buffer": {{
                "name": "{name}", "offset": {}, "size": {QUARTER} }} }} }}, {to} }}"#,
                at as u32 * QUARTER
            ),
            false => format!(
                r#""fullscreen": {{ "shader": "enlarge.wgsl.jinja", "bind": {{ "picture": {{ "texture": {{
                "name": "{name}", "mip": {mip}, "layer": {at} }} }} }}, {to} }}"#
            ),
        }
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

/// What is wrong with the pictures of a graph, if anything is.
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
fn pictures_of_random_graphs_are_those_of_running_their_passes_one_after_the_other() {
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
