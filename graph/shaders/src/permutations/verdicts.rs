//! The verdict of each text once all are settled, and its failures.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use super::Options;
use super::cause::Failure;
use super::compose::{Composition, Text, all};
use super::failure::place_rejection;
use super::proven::{Explored, Verdict};
use super::units::{Profiles, Refusal};
use crate::codes;
use crate::rules::uniform_branches;
use crate::written::declarations;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

/// Advice about branches, where functions come together: by table and units.
type Advised = HashMap<(usize, Vec<u32>), Vec<(u32, usize)>>;

impl<'a> Composition<'a> {
    /// The verdict of a text.
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

    /// The failures of the texts of each request.
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
            let (ids, functions): (Vec<u32>, Vec<_>) =
                self.tables[table].branches(&self.declarations, units).unzip();
            let decided = uniform_branches::decided(&functions).into_iter();
            decided.filter_map(|(function, at)| Some((*ids.get(function)?, at))).collect()
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

/// The subject of a refusal.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Blamed {
    Unit(u32, usize),
    Branch(u32, usize),
    Text(usize, usize),
}

fn failure(each: &Explored<'_>, refusal: Refusal, leaves: BTreeSet<usize>) -> Failure {
    let Refusal { diagnostic, profiles, excess, overrides, .. } = refusal;
    let is_of = |at: &usize| profiles.checked_shr(*at as u32).unwrap_or(1) & 1 == 1;
    let names = each.request.profiles.iter().enumerate().filter(|(at, _)| is_of(at));
    let profiles = names.map(|(_, profile)| profile.name.clone()).collect();
    Failure { diagnostic, leaves, profiles, excess, overrides }
}
