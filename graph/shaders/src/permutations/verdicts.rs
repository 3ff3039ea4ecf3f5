//! The result of proving each text, accepted or with its failures, once all units are proven.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use super::Options;
use super::cause::Failure;
use super::compose::{Composition, Text};
use super::failure::place_rejection;
use super::interned::Id;
use super::proven::{Explored, Verdict};
use super::units::{Profiles, Refusal, bit};
use crate::codes;
use crate::rules::uniform_branches::{self, Branches};
use crate::targets::profile::TargetProfile;
use crate::written::declarations;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

/// A cache for the search for branches that depend on uniform buffers only.
#[derive(Default)]
struct Advised<'u> {
    /// The kind of each function: a number for each distinct pair of function name and branches.
    kinds: HashMap<(Id, &'u Branches), u32>,
    /// The kind of each unit; `None` for a unit that is no function with branches.
    kind_of: HashMap<u32, Option<u32>>,
    /// For the sorted kinds of a module's functions, the branch conditions that depend on uniform buffers only: index
    /// of the kind in the list, and index of the condition in the function.
    found: HashMap<Vec<u32>, Vec<(usize, usize)>>,
}

impl<'a> Composition<'a> {
    /// The bit set of a request's profiles.
    pub(super) fn wanted(&self, each: &Explored<'a>) -> Profiles {
        each.request.profiles.iter().fold(0, |all, own| all | self.bit_of(own))
    }

    fn bit_of(&self, own: &TargetProfile) -> Profiles {
        self.profiles.iter().position(|profile| *profile == own).map_or(0, bit)
    }

    /// Returns the verdict on a module for the profiles in the bit set `wanted`.
    pub(super) fn verdict(&self, wanted: Profiles, text: usize) -> Verdict {
        let Some(Text { state, .. }) = self.texts.get(text) else {
            return Verdict::default();
        };
        let units = &self.units.all;
        let own = state.own.iter().flat_map(|own| &own.refusals);
        let refused = own.filter(|one| one.is_fatal).fold(0, |all, one| all | one.profiles);
        let refused = state.units.iter().fold(refused, |all, unit| all | units[*unit as usize].refused());
        let shared = state.module.and_then(|module| units[module as usize].reflection.clone());
        let reflection = state.own.as_ref().and_then(|own| own.reflection.clone()).or(shared);
        let is_accepted = wanted == 0 || refused & wanted != wanted;
        let is_valid = if wanted == 0 { refused == 0 } else { refused & wanted == 0 };
        Verdict { is_valid, reflection: reflection.filter(|_| is_accepted), ..Verdict::default() }
    }

    /// Returns a diagnostic for each external validator that cannot run.
    pub(super) fn unavailable(&self, options: &Options<'_>) -> Vec<Diagnostic> {
        let found = self.unavailable.iter().filter_map(|(at, message)| {
            let place = options.external.get(*at)?.place();
            Some(Diagnostic::error(codes::EXTERNAL_UNAVAILABLE, place, message))
        });
        found.collect()
    }

    /// Returns the failures of each request, in the order of the explored requests.
    pub(super) fn failures(&self) -> Vec<Vec<Failure>> {
        let (mut advised, mut advice) = (Advised::default(), HashMap::new());
        let of = |each: &Explored<'a>| {
            let mut found: BTreeMap<Blamed, (Refusal, BTreeSet<usize>)> = BTreeMap::new();
            let wanted = self.wanted(each);
            for (own, at) in each.tasks.iter().enumerate() {
                let Some(Text { state, .. }) = self.texts.get(*at) else { continue };
                let leaves = each.exploration.leaves_of(own);
                let mut note = |blamed: Blamed, refusal: &Refusal| {
                    if wanted != 0 && refusal.profiles & wanted == 0 {
                        return;
                    }
                    let known = found.entry(blamed).or_insert_with(|| (refusal.clone(), BTreeSet::new()));
                    known.1.extend(leaves);
                };
                for unit in &state.units {
                    for (number, refusal) in self.units.all[*unit as usize].refusals.iter().enumerate() {
                        note(Blamed::Unit(*unit, number), refusal);
                    }
                }
                for (number, refusal) in state.own.iter().flat_map(|own| &own.refusals).enumerate() {
                    note(Blamed::Text(*at, number), refusal);
                }
                for (unit, condition) in self.conditions(&state.units, &mut advised) {
                    let refusal = advice
                        .entry((unit, condition))
                        .or_insert_with(|| self.advice(each, own, (unit, condition)));
                    refusal.iter().for_each(|refusal| note(Blamed::Branch(unit, condition), refusal));
                }
            }
            found.into_values().map(|(refusal, leaves)| self.failure(each, refusal, leaves)).collect()
        };
        self.explored.iter().map(of).collect()
    }

    fn failure(&self, each: &Explored<'_>, refusal: Refusal, leaves: BTreeSet<usize>) -> Failure {
        let Refusal { diagnostic, profiles, excess, overrides, .. } = refusal;
        let names = each.request.profiles.iter().filter(|own| profiles & self.bit_of(own) != 0);
        let profiles = names.map(|profile| profile.name.clone()).collect();
        Failure { diagnostic, leaves, profiles, excess, overrides }
    }

    /// Returns the branch conditions in a module that depend on uniform buffers only, each as id of the unit and index
    /// of the condition.
    fn conditions<'u>(&'u self, units: &[u32], known: &mut Advised<'u>) -> Vec<(u32, usize)> {
        let Advised { kinds, kind_of, found } = known;
        let mut kind = |unit: u32| {
            let new = || {
                let of = self.units.all.get(unit as usize)?;
                let branches = &of.summary.as_ref()?.branches;
                let next = kinds.len() as u32;
                (!branches.is_empty())
                    .then(|| *kinds.entry((of.name.unwrap_or(Id::MAX), branches)).or_insert(next))
            };
            *kind_of.entry(unit).or_insert_with(new)
        };
        let mut functions: Vec<(u32, u32)> =
            units.iter().filter_map(|unit| Some((kind(*unit)?, *unit))).collect();
        functions.sort_unstable();
        let work = || {
            let branches = functions.iter().filter_map(|(_, unit)| self.branches(*unit));
            let branches: Vec<(&str, &Branches)> = branches.collect();
            uniform_branches::decided(&branches).into_iter().collect()
        };
        let key = functions.iter().map(|(kind, _)| *kind).collect();
        let found: &Vec<(usize, usize)> = found.entry(key).or_insert_with(work);
        found.iter().filter_map(|(at, condition)| Some((functions.get(*at)?.1, *condition))).collect()
    }

    /// The name and the branches of a function; `None` if the unit is no function with a summary.
    fn branches(&self, unit: u32) -> Option<(&str, &Branches)> {
        let unit = self.units.all.get(unit as usize)?;
        Some((self.declarations.name(unit.name?), &unit.summary.as_ref()?.branches))
    }

    /// Creates the advice about one branch condition, placed in the template that generates it; `None` if the place
    /// cannot be found.
    fn advice(&self, each: &Explored<'a>, own: usize, (unit, condition): (u32, usize)) -> Option<Refusal> {
        let summary = self.units.all.get(unit as usize)?.summary.clone()?;
        let source = each.exploration.source(self.templates, &each.request.template, own)?;
        let split = each.exploration.texts.get(own)?.declarations.as_deref()?;
        let at = self.units.position(&self.declarations, split, unit)?;
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

/// The source of a finding: a validation unit, a branch condition or a whole module, each by id and index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Blamed {
    Unit(u32, usize),
    Branch(u32, usize),
    Text(usize, usize),
}
