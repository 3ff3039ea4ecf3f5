//! Plays a frame through, region by region.
//!
//! A resource is cut into regions at each mip, layer and byte where some access begins or ends, and into depth and
//! stencil where an access distinguishes them. So every access covers whole regions. The player records for each region
//! the pass that wrote it last, or that it was dropped. Then:
//!
//! - a read of the newest version must follow every write of the region by another pass, except writes that `after`
//!   orders after the reader;
//! - a read of a named pass's version must find that pass's result in a region that it writes; a read of the previous
//!   contents must find nothing of this frame;
//! - a range that is read must be written in at least one region, and dropped in none;
//! - at the end of the frame, nothing that outlives the frame may be dropped;
//! - a read of an earlier frame of a history finds that frame's final contents, and nothing of this frame. If a planned
//!   pass reads earlier frames, this frame's final contents must have all of their writers;
//! - two writers of a region must be ordered by data, by `after` or by a named version. Exception: the first is the
//!   only one that does not load, and `after` does not order it after another. An order found for one resource can
//!   explain that of another.
//!
//! If passes that use a resource have toggles, its frame is played in every state of those toggles, with the passes and
//! accesses of that state only. With more than [`MAX_TOGGLES`] it is played with all on, all off, and each one alone,
//! up to [`MAX_WORK`]; `back` finds the data edges of the other states.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::regions::{Event, Flow, Regions, Uses};
use crate::schedule::Schedule;
use crate::violation::{ViolationKind as Kind, Violations};
use crate::{attachments, back, uninitialised};
use umbragraph_compiler::Plan;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Access, Condition, Usage, Version};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle, Work};

/// The maximum number of toggles of one resource for which every combination of states is simulated.
const MAX_TOGGLES: usize = 6;
/// The approximate number of region visits spent on one resource with more toggles than `MAX_TOGGLES`.
const MAX_WORK: usize = 1 << 22;

/// The contents of a region at one point of the simulated frame.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    Nothing,
    Written(PassHandle),
    Dropped(PassHandle),
}

/// The edges of the pass order that follow from the pipeline document alone.
struct Explained {
    next: HashMap<PassHandle, Vec<PassHandle>>,
}

impl Explained {
    fn add(&mut self, from: PassHandle, to: PassHandle) {
        self.next.entry(from).or_default().push(to);
    }

    fn leads(&self, schedule: &Schedule, from: PassHandle, to: PassHandle) -> bool {
        let mut seen = HashSet::from([from]);
        let mut stack = vec![from];
        while let Some(pass) = stack.pop() {
            let list = self.next.get(&pass).map_or(&[][..], Vec::as_slice);
            if list.contains(&to) {
                return true;
            }
            for next in list {
                // What runs later than the goal leads back to it only over a pass that is out of order.
                let early = schedule.of(*next).is_none() || schedule.of(*next) < schedule.of(to);
                if early && seen.insert(*next) {
                    stack.push(*next);
                }
            }
        }
        false
    }
}

/// Simulates the frame of a plan, reports wrong reads, writes and orders, and returns the data flow.
pub(crate) fn check(plan: &Plan, schedule: &Schedule, violations: &mut Violations) -> Flow {
    let pipeline = &plan.pipeline;
    let mut flow = Flow { feeds: HashSet::new(), lasting: BTreeSet::new(), carried: HashMap::new() };
    let mut explained = Explained { next: HashMap::new() };
    for pass in pipeline.pass_handles() {
        for before in &pipeline.pass(pass).after {
            explained.add(*before, pass);
        }
    }
    let by_name: HashMap<&str, PassHandle> =
        pipeline.pass_handles().map(|pass| (pipeline.pass(pass).name.as_str(), pass)).collect();
    let mut after = Explained { next: explained.next.clone() };
    for pass in pipeline.pass_handles() {
        for one in pipeline.pass(pass).accesses() {
            if let Version::WrittenBy(name) = &one.version
                && let Some(named) = by_name.get(name.as_str())
            {
                after.add(*named, pass);
            }
        }
    }
    let accesses = plan.passes.iter().flat_map(|planned| pipeline.pass(planned.handle).accesses());
    let histories = accesses.filter_map(|one| pipeline.resource(one.resource).history);
    let read_back = histories.filter(|history| history.back > 0).map(|history| history.of).collect();
    let mut all: Vec<Vec<(PassHandle, &Access)>> = vec![Vec::new(); pipeline.resources.len()];
    for pass in plan
        .passes
        .iter()
        .map(|planned| planned.handle)
        .chain(pipeline.pass_handles().filter(|pass| schedule.of(*pass).is_none()))
    {
        for one in pipeline.pass(pass).accesses() {
            all[one.resource.index()].push((pass, one));
        }
    }
    let mut sequences: Vec<(ResourceHandle, Vec<(PassHandle, bool)>)> = Vec::new();
    for handle in pipeline.resource_handles() {
        let accesses = &all[handle.index()];
        if accesses.is_empty() {
            continue;
        }
        let regions = Regions::new(accesses.iter().map(|(_, one)| *one));
        let events = accesses
            .iter()
            .map(|(pass, one)| Event { pass: *pass, one, regions: regions.of(one.range) })
            .collect();
        let uses = Uses { plan, schedule, handle, events, regions };
        uninitialised::check(&uses, violations);
        let mut known: HashSet<(Kind, String)> = HashSet::new();
        let single = has_single_first(&uses, &after);
        let (states, are_all) = states(&uses);
        if !are_all {
            back::search(&uses, &mut flow);
        }
        for state in states {
            // Sorted by toggle, and has those of all accesses.
            let holds = |one: Condition| state.binary_search(&(one.toggle, one.on)).is_ok();
            let happens = |event: &&Event<'_>| uses.conditions(event).all(holds);
            let events: Vec<&Event<'_>> = uses.events.iter().filter(happens).collect();
            let mut found = Violations(Vec::new());
            let mut player = Player {
                uses: &uses,
                by_name: &by_name,
                read_back: &read_back,
                single,
                state: &state,
                flow: &mut flow,
                after: &after,
                explained: &mut explained,
                violations: &mut found,
            };
            let played = player.play(&events);
            sequences.extend(played.into_iter().map(|sequence| (handle, sequence)));
            for violation in found.0 {
                if known.insert((violation.kind, violation.message.clone())) {
                    violations
                        .add(violation.kind, format!("{}{}", violation.message, in_words(plan, &state)));
                }
            }
        }
    }
    sequences.sort();
    sequences.dedup();
    explain(plan, schedule, &mut explained, sequences, violations);
    flow
}

/// A toggle state: the index of each toggle with `true` if it is on, sorted by index.
type State = Vec<(usize, bool)>;

/// Returns the toggle states to simulate for a resource, and `true` if these are all states. If the accesses depend on
/// no toggle, the only state is empty.
fn states(uses: &Uses<'_>) -> (Vec<State>, bool) {
    let (events, regions) = (&uses.events, uses.regions.count());
    let conditions = events.iter().flat_map(|event| uses.conditions(event));
    let toggles: BTreeSet<usize> = conditions.map(|condition| condition.toggle).collect();
    let toggles: Vec<usize> = toggles.into_iter().collect();
    let state = |is_on: &dyn Fn(usize) -> bool| -> State {
        toggles.iter().enumerate().map(|(bit, toggle)| (*toggle, is_on(bit))).collect()
    };
    if toggles.len() <= MAX_TOGGLES {
        let all = (0..1usize << toggles.len()).map(|off| state(&|bit| off & (1 << bit) == 0));
        return (all.collect(), true);
    }
    // A read looks at the writers of each of its regions.
    let written: usize =
        events.iter().filter(|one| one.one.usage.writes()).map(|one| one.regions.len()).sum();
    let each = 1 + written / regions.max(1);
    let work = |event: &Event<'_>| event.regions.len() * if event.one.usage.reads() { each } else { 1 };
    let work: usize = events.iter().map(work).sum::<usize>() + events.len() + regions;
    let mut states = vec![state(&|_| true), state(&|_| false)];
    for alone in 0..toggles.len().min(MAX_WORK / (2 * work)) {
        states.extend([state(&|bit| bit == alone), state(&|bit| bit != alone)]);
    }
    (states, false)
}

fn in_words(plan: &Plan, state: &[(usize, bool)]) -> String {
    if state.is_empty() {
        return String::new();
    }
    let one = |(toggle, on): &(usize, bool)| {
        let name = plan.pipeline.toggles.get(*toggle).map_or("", |toggle| toggle.name.as_str());
        format!("\"{name}\" {}", if *on { "on" } else { "off" })
    };
    format!(", with {}", state.iter().map(one).collect::<Vec<_>>().join(", "))
}

struct Player<'a, 'b> {
    uses: &'a Uses<'a>,
    by_name: &'a HashMap<&'a str, PassHandle>,
    /// The histories whose earlier frames planned passes read.
    read_back: &'a HashSet<ResourceHandle>,
    /// Whether one writer of the resource is certain to run first.
    single: bool,
    state: &'a [(usize, bool)],
    flow: &'b mut Flow,
    /// The edges of the pass order that `after` and named versions declare.
    after: &'a Explained,
    explained: &'b mut Explained,
    violations: &'b mut Violations,
}

impl Player<'_, '_> {
    /// Simulates the accesses of one resource. Returns the writers of each region in order, each with `true` if it
    /// loads; regions with one writer are left out.
    fn play(&mut self, events: &[&Event<'_>]) -> Vec<Vec<(PassHandle, bool)>> {
        let Uses { plan, schedule, handle, .. } = *self.uses;
        let (resource, regions) = (plan.pipeline.resource(handle), self.uses.regions.count());
        let outlives = resource.lifetime() != Lifetime::Transient;
        let lasting = outlives && resource.history.is_none_or(|history| history.back > 0);
        let mut writers: Vec<Vec<(PassHandle, bool)>> = vec![Vec::new(); regions];
        let mut culled: Vec<Vec<(PassHandle, bool)>> = vec![Vec::new(); regions];
        let is_live = |event: &Event<'_>| schedule.of(event.pass).is_some();
        for event in events.iter().filter(|event| event.one.usage.writes()) {
            let lists = if is_live(event) { &mut writers } else { &mut culled };
            for region in &event.regions {
                lists[*region].push((event.pass, event.one.usage.reads()));
            }
        }
        // What need not find anything is the first where nothing else is.
        for event in events.iter().filter(|event| event.one.usage.keeps_what_is_there()) {
            for region in &event.regions {
                if writers[*region].iter().chain(&culled[*region]).all(|(_, loads)| *loads) {
                    let list = if is_live(event) { &mut writers[*region] } else { &mut culled[*region] };
                    list.iter_mut()
                        .filter(|(pass, _)| *pass == event.pass)
                        .for_each(|(_, loads)| *loads = false);
                }
            }
        }
        let mut content = vec![Content::Nothing; regions];
        let live = events.partition_point(|event| is_live(event));
        for of_pass in events[..live].chunk_by(|a, b| a.pass == b.pass) {
            for event in of_pass.iter().filter(|event| event.one.usage.reads()) {
                self.read(event, &content, &writers, &culled, lasting);
            }
            for event in of_pass {
                let dropped = self.uses.drops(event);
                for region in &event.regions {
                    if dropped {
                        content[*region] = Content::Dropped(event.pass);
                    } else if event.one.usage.writes() {
                        content[*region] = Content::Written(event.pass);
                    }
                }
            }
        }
        if outlives {
            self.finish(&content, &writers);
        }
        if resource.history.is_some_and(|history| history.back == 0) && self.read_back.contains(&handle) {
            for (live, culled) in writers.iter().zip(&culled) {
                if let Some(needed) = needed_but_culled(live, culled, self.single) {
                    let (needed, resource) = self.names(needed);
                    let message =
                        format!("\"{resource}\" is read some frames later, but \"{needed}\" is culled");
                    self.violations.add(Kind::CulledButNeeded, message);
                }
            }
        }
        // The order of one pass's several accesses is no question.
        writers.dedup();
        writers.retain(|list| list.len() > 1);
        writers
    }

    fn read(
        &mut self,
        event: &Event<'_>,
        content: &[Content],
        writers: &[Vec<(PassHandle, bool)>],
        culled: &[Vec<(PassHandle, bool)>],
        lasting: bool,
    ) {
        let (name, resource) = self.names(event.pass);
        let own = self.uses.schedule.of(event.pass);
        let named = match &event.one.version {
            Version::WrittenBy(name) => self.by_name.get(name.as_str()).copied(),
            Version::Newest | Version::Before => None,
        };
        let is_later = |writer: PassHandle| {
            event.one.version == Version::Before || self.after.leads(self.uses.schedule, event.pass, writer)
        };
        let mut written = lasting || event.one.usage.keeps_what_is_there();
        let another_version = || {
            let message = format!("\"{name}\" reads another version of \"{resource}\" than it asks for");
            Some((Kind::WrongVersion, message))
        };
        let mut wrong: Option<(Kind, String)> = None;
        for region in &event.regions {
            match content[*region] {
                Content::Nothing => {}
                Content::Dropped(by) => {
                    let (by, _) = self.names(by);
                    let message = format!("\"{name}\" needs \"{resource}\", which \"{by}\" does not store");
                    wrong = Some((Kind::ContentsDropped, message));
                }
                Content::Written(by) => {
                    written = true;
                    self.flow.feeds.insert((by, event.pass, self.uses.handle));
                }
            }
            let written = match content[*region] {
                Content::Written(by) | Content::Dropped(by) => Some(by),
                Content::Nothing => None,
            };
            if let Some(named) = named {
                self.explained.add(named, event.pass);
                let limit = self.uses.schedule.of(named);
                // A pass that is off in this state may be culled for all that this read knows.
                let is_off = self
                    .uses
                    .plan
                    .pipeline
                    .pass(named)
                    .condition
                    .is_some_and(|condition| self.state.contains(&(condition.toggle, !condition.on)));
                // Nor can it say where in the order it would be if it writes other subresource ranges than this.
                let elsewhere = !culled[*region].iter().any(|(writer, _)| *writer == named);
                if limit.is_none() && (is_off || elsewhere) {
                    continue;
                }
                if limit.is_none() {
                    let message = format!("\"{name}\" reads \"{resource}\" of a culled pass");
                    wrong = Some((Kind::CulledButNeeded, message));
                } else if writers[*region].iter().any(|(writer, _)| *writer == named)
                    && written != Some(named)
                {
                    wrong = another_version();
                }
                for (other, _) in writers[*region].iter().filter(|(writer, _)| *writer != event.pass) {
                    match self.uses.schedule.of(*other) > own {
                        true => self.explained.add(event.pass, *other),
                        false => self.explained.add(*other, event.pass),
                    }
                }
            } else if !event.one.usage.writes() {
                let late = writers[*region].iter().find(|(writer, _)| {
                    *writer != event.pass && self.uses.schedule.of(*writer) > own && !is_later(*writer)
                });
                if event.one.version == Version::Before && written.is_some() {
                    wrong = another_version();
                }
                if let Some((late, _)) = late {
                    let (late, _) = self.names(*late);
                    let message = format!("\"{name}\" reads \"{resource}\" before \"{late}\" writes it");
                    wrong = Some((Kind::ReadTooEarly, message));
                }
                let earlier = |list: &[(PassHandle, bool)]| -> Vec<(PassHandle, bool)> {
                    list.iter().copied().filter(|(writer, _)| !is_later(*writer)).collect()
                };
                let (live, culled) = (earlier(&writers[*region]), earlier(&culled[*region]));
                if let Some(needed) = needed_but_culled(&live, &culled, self.single) {
                    let (needed, _) = self.names(needed);
                    let message = format!("\"{name}\" reads \"{resource}\", but \"{needed}\" is culled");
                    wrong = Some((Kind::CulledButNeeded, message));
                }
                for (writer, _) in writers[*region].iter().filter(|(writer, _)| *writer != event.pass) {
                    match is_later(*writer) {
                        true => self.explained.add(event.pass, *writer),
                        false => self.explained.add(*writer, event.pass),
                    }
                }
            } else if let Some(needed) = needed_but_culled(&writers[*region], &culled[*region], self.single)
                && written.is_none()
                && !(event.one.usage.keeps_what_is_there() && self.may_follow(needed, event.pass))
            {
                let (needed, _) = self.names(needed);
                let message = format!("\"{name}\" loads \"{resource}\", but \"{needed}\" is culled");
                wrong = Some((Kind::CulledButNeeded, message));
            }
        }
        if !written && !matches!(wrong, Some((Kind::ContentsDropped | Kind::CulledButNeeded, _))) {
            let message = format!("\"{name}\" reads \"{resource}\", which nothing has written");
            self.violations.add(Kind::UninitialisedRead, message);
        }
        if let Some((kind, message)) = wrong {
            self.violations.add(kind, message);
        }
    }

    /// Returns `true` if `after` or reads may order `pass` after `other`.
    fn may_follow(&self, pass: PassHandle, other: PassHandle) -> bool {
        let pipeline = &self.uses.plan.pipeline;
        let (mut seen, mut stack) = (HashSet::from([pass]), vec![pass]);
        while let Some(pass) = stack.pop() {
            let reads = |resource: ResourceHandle| {
                let mut accesses = pipeline.pass(pass).accesses().iter();
                accesses.any(|one| one.resource == resource && one.usage.reads())
            };
            let feeds = |writer: PassHandle| {
                let mut accesses = pipeline.pass(writer).accesses().iter();
                accesses
                    .any(|one| one.usage.writes() && one.resource != self.uses.handle && reads(one.resource))
            };
            for before in pipeline.pass_handles() {
                if pipeline.pass(pass).after.contains(&before) || feeds(before) {
                    if before == other {
                        return true;
                    }
                    stack.extend(seen.insert(before).then_some(before));
                }
            }
        }
        false
    }

    /// Records the writes that remain at the end of the frame in a resource that outlives the frame, and reports
    /// dropped contents.
    fn finish(&mut self, content: &[Content], writers: &[Vec<(PassHandle, bool)>]) {
        for (region, content) in content.iter().enumerate() {
            match content {
                Content::Dropped(by) if self.throws_away(*by) => {}
                Content::Dropped(by) => {
                    let (by, resource) = self.names(*by);
                    let message =
                        format!("\"{resource}\" outlives the frame, but \"{by}\" does not store it");
                    self.violations.add(Kind::OutputDropped, message);
                }
                // Storage and copies may leave texels as they were, and so may a draw to a layer for each view.
                Content::Written(_) => {
                    let is_history = self.uses.plan.pipeline.resource(self.uses.handle).history.is_some();
                    for (writer, _) in writers[region].iter().rev() {
                        if is_history {
                            self.flow.carried.entry(self.uses.handle).or_default().insert(*writer);
                        } else {
                            self.flow.lasting.insert(*writer);
                        }
                        if self.uses.covers(*writer, &writers[region]) {
                            break;
                        }
                    }
                }
                Content::Nothing => {}
            }
        }
    }

    /// Returns `true` if a pass declares that it discards its result.
    fn throws_away(&self, pass: PassHandle) -> bool {
        let Work::Render(render) = self.uses.plan.pipeline.pass(pass).work() else { return false };
        let mut attachments = attachments::declared(render).into_iter();
        attachments.any(|(target, _, discard)| discard && target.resource == self.uses.handle)
    }

    fn names(&self, pass: PassHandle) -> (String, String) {
        (
            self.uses.plan.pipeline.pass(pass).name.clone(),
            self.uses.plan.pipeline.resource(self.uses.handle).name.clone(),
        )
    }
}

/// Returns `true` if a resource has one writer that does not load, or two with opposite toggles, which runs first.
/// Returns `false` if `after` or a named version orders such a writer after another.
fn has_single_first(uses: &Uses<'_>, after: &Explained) -> bool {
    let Uses { plan, schedule, events, .. } = uses;
    let writers = |is_first: fn(Usage) -> bool| {
        let writers =
            events.iter().filter(move |event| event.one.usage.writes() && is_first(event.one.usage));
        writers.map(|event| event.pass).collect::<Vec<PassHandle>>()
    };
    let mut first = writers(|usage| !usage.reads());
    if first.is_empty() {
        first = writers(Usage::keeps_what_is_there);
    }
    let others = || events.iter().filter(|event| event.one.usage.writes()).map(|event| event.pass);
    let is_behind = |first: PassHandle| others().any(|other| after.leads(schedule, other, first));
    if first.len() <= 2 && first.iter().any(|first| is_behind(*first)) {
        return false;
    }
    let condition = |pass: PassHandle| plan.pipeline.pass(pass).condition;
    match first[..] {
        [_] => true,
        [a, b] => condition(a).zip(condition(b)).is_some_and(|(a, b)| a.toggle == b.toggle && a.on != b.on),
        _ => false,
    }
}

/// Returns a culled writer whose result is certain to be part of the newest version. `live` and `culled` are the
/// writers of a region, each with `true` if it loads; `single` is `true` if one is certain to run first. A culled
/// writer that loads counts if all writers load, or, with `single`, all but one. One that does not load counts if all
/// live writers load.
fn needed_but_culled(
    live: &[(PassHandle, bool)],
    culled: &[(PassHandle, bool)],
    single: bool,
) -> Option<PassHandle> {
    let fresh_live = live.iter().filter(|(_, loads)| !loads).count();
    let fresh_culled = culled.iter().filter(|(_, loads)| !loads).count();
    culled
        .iter()
        .find(|(_, loads)| match loads {
            true => fresh_live + fresh_culled <= usize::from(single),
            false => fresh_live == 0,
        })
        .map(|(pass, _)| *pass)
}

/// Searches the known edges for a path between each pair of neighbouring writers. Each pair found adds an edge; pairs
/// without a path are reported.
fn explain(
    plan: &Plan,
    schedule: &Schedule,
    explained: &mut Explained,
    sequences: Vec<(ResourceHandle, Vec<(PassHandle, bool)>)>,
    violations: &mut Violations,
) {
    let mut open: BTreeSet<(ResourceHandle, PassHandle, PassHandle)> = BTreeSet::new();
    for (resource, sequence) in &sequences {
        let mut fresh = sequence.iter().filter(|(_, loads)| !loads);
        let single = fresh.next().filter(|_| fresh.next().is_none());
        for pair in sequence.windows(2) {
            let ((first, _), (second, _)) = (pair[0], pair[1]);
            if single == Some(&pair[0]) || first == second {
                explained.add(first, second);
            } else {
                open.insert((*resource, first, second));
            }
        }
    }
    loop {
        let found: Vec<_> = open
            .iter()
            .copied()
            .filter(|(_, first, second)| explained.leads(schedule, *first, *second))
            .collect();
        if found.is_empty() {
            break;
        }
        for pair in found {
            open.remove(&pair);
            explained.add(pair.1, pair.2);
        }
    }
    for (resource, first, second) in open {
        let (first, second) = (&plan.pipeline.pass(first).name, &plan.pipeline.pass(second).name);
        let resource = &plan.pipeline.resource(resource).name;
        let message = format!("nothing says that \"{first}\" writes \"{resource}\" before \"{second}\"");
        violations.add(Kind::WritersUnordered, message);
    }
}
