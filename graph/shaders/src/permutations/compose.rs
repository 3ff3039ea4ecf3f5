//! Proving all texts by a few of them.
//!
//! ```text
//! texts ──units──▶ what nobody has proven ──cover──▶ few texts ──prove──▶ accepted and refused units, summaries ─┐
//!            ▲                                                                                                   │
//!            └──────────────────────── until every text is of proven units ◀─────────────────────────────────────┘
//! ```
//!
//! A text is valid for a profile if each of its units was accepted in some text for that profile, and invalid if one of
//! them was refused. What is said of a refused unit is said of all texts with it. A rejection that no unit can be blamed for
//! (writers of targets mostly do not say what they reject) concerns one text; its units stay unproven, so that every text
//! with them is proven by itself, until one with them is accepted. So is a text that cannot be taken apart.
//!
//! Limits: writers name things over the whole module, and validators of others judge whole texts; both see the cover. With
//! `exhaustive` every text is proven by itself.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::Options;
use super::cause::Failure;
use super::cover::cover;
use super::failure::{self, place_rejection};
use super::kept::{Keep, Kept};
use super::prove::{self, Proof, Subject, Task};
use super::proven::{Explored, Verdict};
use super::units::{Declarations, Profiles, Refusal, Units};
use super::validator::Opinion;
use crate::codes;
use crate::reflection::Reflection;
use crate::rendering::templates::TemplateSet;
use crate::rules::uniform_branches;
use crate::written::declarations::{self, Kind};
use crate::written::rejection::{Rejection, Scope};
use crate::written::text_map::Source;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

/// A distinct text.
pub(super) struct Text<'a> {
    pub(super) subject: Arc<Subject<'a>>,
    /// The index of the subject.
    pub(super) table: usize,
    /// The first request that has it, and its index there.
    pub(super) at: (usize, usize),
    pub(super) state: State,
}

/// What is known of a text so far.
#[derive(Default)]
pub(super) struct State {
    units: Vec<u32>,
    /// Declarations that see a function of which no summary is known.
    open: Vec<u32>,
    module: Option<u32>,
    /// Whether nothing more has to be proven for it.
    is_settled: bool,
    /// What was found in it and in no unit of it, where it was proven.
    own: Option<(Vec<Refusal>, Option<Arc<Reflection>>)>,
}

/// All texts, and what is proven of them.
pub(super) struct Composition<'a> {
    pub(super) templates: &'a TemplateSet,
    pub(super) explored: Vec<Explored<'a>>,
    pub(super) declarations: Declarations,
    pub(super) texts: Vec<Text<'a>>,
    /// One for each subject.
    pub(super) tables: Vec<Units>,
    /// The reason of each validator that cannot run.
    unavailable: BTreeMap<usize, String>,
    /// The number of texts that were proven by themselves.
    pub(super) proven: usize,
    /// The parts of texts that were chosen to be proven.
    tried: HashSet<u64>,
    /// How many texts beyond a cover are chosen, where parts were tried in vain.
    more: usize,
}

/// What is to be proven of a text.
#[derive(Clone, Copy)]
enum Part {
    Unit,
    /// A declaration of which no unit is known yet.
    Open,
    /// A unit in a text where an entry point reaches it.
    Reached,
}

/// Advice about branches, where functions come together: by table and units.
type Advised = HashMap<(usize, Vec<u32>), Vec<(u32, usize)>>;

fn all(subject: &Subject<'_>) -> Profiles {
    Profiles::MAX >> (Profiles::BITS as usize - subject.profiles.len().clamp(1, Profiles::BITS as usize))
}

impl<'a> Composition<'a> {
    pub(super) fn new(
        templates: &'a TemplateSet,
        explored: Vec<Explored<'a>>,
        declarations: Declarations,
        texts: Vec<Text<'a>>,
        tables: usize,
    ) -> Self {
        let tables = std::iter::repeat_with(Units::default).take(tables).collect();
        Self {
            templates,
            explored,
            declarations,
            texts,
            tables,
            unavailable: BTreeMap::new(),
            proven: 0,
            tried: HashSet::new(),
            more: 0,
        }
    }

    /// Takes over what earlier runs have proven.
    pub(super) fn recall(&mut self, keep: &dyn Keep) {
        for text in &self.texts {
            let units = &mut self.tables[text.table];
            if units.kept.is_none() {
                units.kept = Some(Kept::of(keep.get(&text.subject.key()), all(&text.subject)));
            }
        }
    }

    /// Hands what is proven to later runs.
    pub(super) fn remember(&mut self, keep: &dyn Keep) {
        for text in &self.texts {
            let units = &mut self.tables[text.table];
            if let Some(kept) = units.kept.take()
                && let Some(bytes) = kept.with(&units.all)
            {
                keep.put(&text.subject.key(), &bytes);
            }
        }
    }

    /// Proves as many texts as it takes to know of all.
    pub(super) fn prove(&mut self, options: &Options<'_>) {
        loop {
            let chosen = self.choose(options.exhaustive);
            let settled = self.texts.iter().filter(|text| text.state.is_settled).count();
            let (done, count) = (AtomicUsize::new(settled), self.texts.len());
            if chosen.is_empty() {
                (options.progress)(count, count);
                return;
            }
            let prove = |at: &usize| {
                if options.is_cancelled() {
                    return None;
                }
                let text = self.texts.get(*at)?;
                let each = self.explored.get(text.at.0)?;
                let source = each.exploration.source(self.templates, &each.request.template, text.at.1)?;
                let task = Task { source, subject: text.subject.clone() };
                let proof = prove::prove(&task);
                let opinions = failure::judge(&task, &proof, options.external);
                (options.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, count);
                Some((*at, task.source, proof, opinions))
            };
            let found: Vec<_> = chosen.par_iter().map(prove).collect();
            self.proven += found.len();
            for (at, source, proof, opinions) in found.into_iter().flatten() {
                self.learn(at, &source, proof, &opinions, options);
            }
            // Whatever could not be rendered again has nothing to prove.
            for at in chosen {
                if let Some(text) = self.texts.get_mut(at) {
                    text.state.is_settled = true;
                    text.state.own.get_or_insert_default();
                }
            }
        }
    }

    /// The texts that are to be proven next.
    fn choose(&mut self, exhaustive: bool) -> Vec<usize> {
        let (mut alone, mut open) = (Vec::new(), Vec::new());
        for at in 0..self.texts.len() {
            if self.texts[at].state.is_settled {
                continue;
            }
            let (table, subject) = (self.texts[at].table, self.texts[at].subject.clone());
            let (request, own) = self.texts[at].at;
            let split = self.explored[request].exploration.texts[own].declarations.as_deref();
            // Without a profile nothing is validated, and no summary ever known.
            let count = 1..=Profiles::BITS as usize;
            let split = split.filter(|_| !exhaustive && count.contains(&subject.profiles.len()));
            let Some(split) = split else {
                alone.push(at);
                continue;
            };
            let units = &mut self.tables[table];
            let part = |id: u32, kind: Part| u64::from(id) | (table as u64) << 34 | (kind as u64) << 32;
            let everything = all(&subject);
            let unproven = |units: &Units, state: &State| -> (Profiles, Vec<u64>) {
                let refused = |all, unit: &u32| all | units.all[*unit as usize].refused();
                let pending = everything & !state.units.iter().fold(0, refused);
                let is_unproven = |unit: &&u32| units.all[**unit as usize].accepted & pending != pending;
                let mut parts: Vec<u64> =
                    state.units.iter().filter(is_unproven).map(|unit| part(*unit, Part::Unit)).collect();
                if pending != 0 {
                    parts.extend(state.open.iter().map(|id| part(*id, Part::Open)));
                }
                (pending, parts)
            };
            let state = &mut self.texts[at].state;
            // Whatever is not open stays what it is.
            let is_resolved = !state.units.is_empty() && state.open.is_empty();
            let mut parts = if is_resolved { unproven(units, state).1 } else { Vec::new() };
            if parts.is_empty() {
                let resolved = units.resolve(&self.declarations, split, None);
                if resolved.is_circular {
                    alone.push(at);
                    continue;
                }
                (state.units, state.open, state.module) =
                    (resolved.units.clone(), resolved.open.clone(), resolved.module);
                let pending;
                (pending, parts) = unproven(units, state);
                if parts.is_empty() && pending != 0 && state.module.is_none() {
                    let Some(interface) = units.interface(&self.declarations, split, &resolved) else {
                        alone.push(at);
                        continue;
                    };
                    let is_unreached = |unit: &&u32| units.all[**unit as usize].reached & pending != pending;
                    let unreached = interface.reached.iter().filter(is_unreached);
                    parts.extend(unreached.map(|unit| part(*unit, Part::Reached)));
                    let (fits, reflection) = interface.proven(subject.profiles);
                    let module = &mut units.all[interface.module as usize];
                    if parts.is_empty() {
                        module.accepted |= fits & pending;
                        module.reflection.get_or_insert_with(|| Arc::new(reflection.clone()));
                    }
                    state.units.push(interface.module);
                    state.module = Some(interface.module);
                    let (_, more) = unproven(units, state);
                    parts.extend(more);
                }
            }
            let state = &mut self.texts[at].state;
            state.is_settled = parts.is_empty();
            if !state.is_settled {
                open.push((at, parts));
            }
        }
        // Units that stayed unproven in a text that was proven may do so in all: there are more texts in each round then.
        let is_stubborn =
            |(_, parts): &&(usize, Vec<u64>)| parts.iter().any(|part| self.tried.contains(part));
        let stubborn: Vec<usize> = open.iter().filter(is_stubborn).map(|(at, _)| *at).collect();
        self.more = if stubborn.is_empty() { 0 } else { (self.more * 2).max(1) };
        let mut chosen: BTreeSet<usize> = cover(&open).into_iter().chain(alone).collect();
        chosen.extend(stubborn.into_iter().take(self.more));
        self.tried
            .extend(open.into_iter().filter(|(at, _)| chosen.contains(at)).flat_map(|(_, parts)| parts));
        chosen.into_iter().collect()
    }

    /// Takes over what the proof of a text says of it and of its units.
    fn learn(
        &mut self,
        at: usize,
        source: &Source,
        proof: Proof,
        opinions: &[Opinion],
        options: &Options<'_>,
    ) {
        let text = &self.texts[at];
        let (request, own) = text.at;
        let each = &self.explored[request];
        let split = each.exploration.texts[own].declarations.as_deref().filter(|_| !options.exhaustive);
        let ranges = split.and_then(|_| declarations::split(&source.wgsl)).unwrap_or_default();
        let mut summaries = proof.summaries;
        for range in &ranges {
            let name = declarations::Declaration::new(&source.wgsl[range.clone()]).name;
            let known = summaries.as_mut().zip(name).and_then(|(all, name)| all.get_mut(&name));
            known.into_iter().for_each(|summary| summary.branches.counted_from(range.start));
        }
        let units = &mut self.tables[text.table];
        let resolved = split.map(|split| units.resolve(&self.declarations, split, summaries.as_ref()));
        let mut resolved = resolved.filter(|resolved| !resolved.is_circular);
        let mut reached = Vec::new();
        if let Some(resolved) = resolved.as_mut().filter(|resolved| resolved.open.is_empty())
            && let Some(split) = split
        {
            if let Some(reflection) = &proof.reflection {
                units.reflected(&self.declarations, split, resolved, reflection);
            }
            let is_seen = |unit: &u32| units.all[*unit as usize].accepted != 0;
            let is_known = proof.reflection.is_some() || resolved.units.iter().all(is_seen);
            let interface = is_known.then(|| units.interface(&self.declarations, split, resolved)).flatten();
            if let Some(interface) = interface {
                units.is_irregular |= proof.reflection.as_ref().is_some_and(|found| !interface.is(found));
                reached = interface.reached;
                resolved.units.push(interface.module);
                resolved.module = Some(interface.module);
            }
        }
        let everything = all(&text.subject);
        let bits = |profiles: &[usize]| match profiles {
            [] => everything,
            some => some.iter().fold(0, |all, at| all | 1_u64.checked_shl(*at as u32).unwrap_or(everything)),
        };
        let unit_of = |rejection: &Rejection| {
            let resolved = resolved.as_ref()?;
            match &rejection.scope {
                Scope::Text => None,
                Scope::EntryPoint(name) => {
                    let is_it = |id: &u32| {
                        let (kind, own) = (self.declarations.kind(*id), self.declarations.name_of(*id));
                        kind == Kind::EntryPoint && own == name
                    };
                    let at = split?.iter().position(is_it)?;
                    resolved.of_declarations.get(at).copied().flatten()
                }
                Scope::Interface => resolved.module,
                Scope::Declaration => {
                    let start = rejection.range.as_ref()?.start;
                    // What is missing at the end is missing in the last declaration.
                    let behind = ranges.iter().rposition(|range| range.start <= start)?;
                    resolved.of_declarations.get(behind).copied().flatten()
                }
            }
        };
        let external: Vec<Rejection> = opinions
            .iter()
            .zip(options.external)
            .filter_map(|(opinion, validator)| failure::disagreement(opinion, *validator, source))
            .collect();
        // Where functions come together is looked at for every text that is of units.
        let branches = proof.branches.iter().filter(|_| resolved.is_none());
        let fatal = proof.rejections.iter().map(|(one, profiles)| (one, bits(profiles), true));
        let others = proof.advice.iter().chain(branches).chain(&external).map(|one| (one, everything, false));
        let mut own_refusals = Vec::new();
        for (rejection, profiles, is_fatal) in fatal.chain(others) {
            let refusal = Refusal {
                diagnostic: place_rejection(self.templates, each, own, source, rejection),
                profiles,
                excess: rejection.excess.clone(),
                overrides: rejection.overrides.clone(),
                is_fatal,
            };
            match unit_of(rejection) {
                Some(unit) => add(&mut units.all[unit as usize].refusals, refusal),
                None => own_refusals.push(refusal),
            }
        }
        let rejected = proof.rejections.iter().fold(0, |all, (_, profiles)| all | bits(profiles));
        let accepted = if external.is_empty() { everything & !rejected } else { 0 };
        for (at, opinion) in opinions.iter().enumerate() {
            if let Opinion::Unavailable(message) = opinion {
                self.unavailable.entry(at).or_insert_with(|| message.clone());
            }
        }
        let state = &mut self.texts[at].state;
        if let Some(resolved) = resolved {
            resolved.units.iter().for_each(|unit| units.all[*unit as usize].accepted |= accepted);
            reached.iter().for_each(|unit| units.all[*unit as usize].reached |= accepted);
            if let Some(module) = resolved.module {
                let known = &mut units.all[module as usize].reflection;
                *known = known.take().or_else(|| proof.reflection.clone());
            }
            (state.units, state.open, state.module) = (resolved.units, resolved.open, resolved.module);
        }
        state.own = Some((own_refusals, proof.reflection));
        state.is_settled = true;
    }

    /// What is known of a text.
    pub(super) fn verdict(&self, text: usize) -> Verdict {
        let Some(Text { subject, table, state, .. }) = self.texts.get(text) else {
            return Verdict::default();
        };
        let units = &self.tables[*table].all;
        let own = state.own.iter().flat_map(|(refusals, _)| refusals);
        let refused = own.filter(|one| one.is_fatal).fold(0, |all, one| all | one.profiles);
        let refused = state.units.iter().fold(refused, |all, unit| all | units[*unit as usize].refused());
        let shared = state.module.and_then(|module| units[module as usize].reflection.clone());
        let reflection = state.own.as_ref().and_then(|(_, own)| own.clone()).or(shared);
        let is_accepted = subject.profiles.is_empty() || refused & all(subject) != all(subject);
        Verdict { is_valid: refused == 0, reflection: reflection.filter(|_| is_accepted) }
    }

    /// The diagnostics about validators that cannot run.
    pub(super) fn unavailable(&self, options: &Options<'_>) -> Vec<Diagnostic> {
        let found = self.unavailable.iter().filter_map(|(at, message)| {
            let place = options.external.get(*at)?.place();
            Some(Diagnostic::error(codes::EXTERNAL_UNAVAILABLE, place, message))
        });
        found.collect()
    }

    /// What is wrong with the texts of each request.
    pub(super) fn failures(&self) -> Vec<Vec<Failure>> {
        let (mut advised, mut advice) = (Advised::new(), HashMap::new());
        let of = |each: &Explored<'a>| {
            let mut found: BTreeMap<Blamed, (Refusal, BTreeSet<usize>)> = BTreeMap::new();
            for (own, at) in each.tasks.iter().enumerate() {
                let Some(Text { table, state, .. }) = self.texts.get(*at) else { continue };
                let leaves = each.exploration.leaves_of(own);
                let mut note = |blamed: Blamed, refusal: &Refusal| {
                    let known = found.entry(blamed).or_insert_with(|| (refusal.clone(), BTreeSet::new()));
                    known.1.extend(leaves);
                };
                for unit in &state.units {
                    for (number, refusal) in
                        self.tables[*table].all[*unit as usize].refusals.iter().enumerate()
                    {
                        note(Blamed::Unit(*unit, number), refusal);
                    }
                }
                for (number, refusal) in state.own.iter().flat_map(|(own, _)| own).enumerate() {
                    note(Blamed::Text(*at, number), refusal);
                }
                for (unit, condition) in self.conditions(*table, &state.units, &mut advised) {
                    let refusal = advice
                        .entry((*table, unit, condition))
                        .or_insert_with(|| self.advice(each, own, (*table, unit, condition)));
                    refusal.iter().for_each(|refusal| note(Blamed::Branch(unit, condition), refusal));
                }
            }
            found.into_values().map(|(refusal, leaves)| failure(each, refusal, leaves)).collect()
        };
        self.explored.iter().map(of).collect()
    }

    /// The branches of a text that uniforms alone decide: unit and index of the condition.
    fn conditions(&self, table: usize, units: &[u32], known: &mut Advised) -> Vec<(u32, usize)> {
        let known_units = &self.tables[table].all;
        let branches = |unit: &&u32| {
            let summary = known_units[**unit as usize].summary.as_ref();
            summary.is_some_and(|summary| !summary.branches.is_empty())
        };
        let mut key: Vec<u32> = units.iter().filter(branches).copied().collect();
        key.sort_unstable();
        let work = || {
            let all = self.tables[table].branches(&self.declarations, units);
            let branches = all.iter().map(|(name, (_, branches))| (*name, *branches)).collect();
            let decided = uniform_branches::decided(&branches).into_iter();
            decided.filter_map(|(name, at)| Some((all.get(name)?.0, at))).collect()
        };
        known.entry((table, key)).or_insert_with(work).clone()
    }

    /// The advice about a condition, as a text shows it.
    fn advice(
        &self,
        each: &Explored<'a>,
        own: usize,
        (table, unit, condition): (usize, u32, usize),
    ) -> Option<Refusal> {
        let summary = self.tables[table].all.get(unit as usize)?.summary.clone()?;
        let source = each.exploration.source(self.templates, &each.request.template, own)?;
        let split = each.exploration.texts.get(own)?.declarations.as_deref()?;
        let at = self.tables[table].position(&self.declarations, split, unit)?;
        let start = declarations::split(&source.wgsl)?.get(at)?.start;
        let Range { start: first, end } = summary.branches.place(condition);
        let rejection = uniform_branches::advice(start + first..start + end);
        Some(Refusal {
            diagnostic: place_rejection(self.templates, each, own, &source, &rejection),
            profiles: Profiles::MAX,
            excess: None,
            overrides: AxisValues::new(),
            is_fatal: false,
        })
    }
}

/// What a refusal is about.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Blamed {
    Unit(u32, usize),
    Branch(u32, usize),
    Text(usize, usize),
}

/// Adds a refusal, or its profiles to one like it.
fn add(refusals: &mut Vec<Refusal>, refusal: Refusal) {
    let key = |one: &Refusal| (one.diagnostic.key(), one.overrides.clone(), one.is_fatal);
    match refusals.iter_mut().find(|known| key(known) == key(&refusal)) {
        Some(known) => known.profiles |= refusal.profiles,
        None => refusals.push(refusal),
    }
}

fn failure(each: &Explored<'_>, refusal: Refusal, leaves: BTreeSet<usize>) -> Failure {
    let Refusal { diagnostic, profiles, excess, overrides, .. } = refusal;
    let is_of = |at: &usize| profiles.checked_shr(*at as u32).unwrap_or(1) & 1 == 1;
    let names = each.request.profiles.iter().enumerate().filter(|(at, _)| is_of(at));
    let profiles = names.map(|(_, profile)| profile.name.clone()).collect();
    Failure { diagnostic, leaves, profiles, excess, overrides }
}
