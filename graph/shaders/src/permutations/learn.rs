//! The lesson of a proof: about its text, and about the units that this is made of.

use super::Options;
use super::compose::{Composition, Own, State, wanted_bits};
use super::costs;
use super::failure::{self, place_rejection};
use super::prove::{Proof, Task};
use super::units::{Refusal, bit};
use super::validator::Opinion;
use crate::rules::uniform_branches;
use crate::written::declarations::{self, Kind};
use crate::written::rejection::{Rejection, Scope};

impl Composition<'_> {
    /// Records the result of validating a module, for the module itself and for its declarations.
    pub(super) fn learn(
        &mut self,
        at: usize,
        task: &Task<'_>,
        proof: Proof,
        opinions: &[Opinion],
        options: &Options<'_>,
    ) {
        let source = &task.source;
        let text = &self.texts[at];
        let (request, own) = text.at;
        let each = &self.explored[request];
        let split = each.exploration.texts[own].declarations.as_deref().filter(|_| task.is_of_units);
        let ranges = split.and_then(|_| declarations::split(&source.wgsl)).unwrap_or_default();
        let is_judged = options.external.is_empty() || proof.is_accepted(&task.subject);
        let mut summaries = proof.summaries;
        // For a text that is of units this follows from the units.
        let together = summaries.iter().filter(|_| split.is_none()).flatten();
        let together: Vec<_> = together.map(|(name, summary)| (name.as_str(), &summary.branches)).collect();
        let branches = uniform_branches::found(&together);
        for (range, id) in ranges.iter().zip(split.into_iter().flatten()) {
            let name = self.declarations.name_of(*id);
            let known = summaries.as_mut().and_then(|all| all.get_mut(name));
            known.into_iter().for_each(|summary| summary.branches.counted_from(range.start));
        }
        let (units, overrides) = (&mut self.units, &self.overrides[text.overrides]);
        let resolved =
            split.map(|split| units.resolve(&self.declarations, (split, overrides), summaries.as_ref()));
        let mut resolved = resolved.filter(|resolved| !resolved.is_circular);
        let (mut reached, mut distrusted) = (Vec::new(), false);
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
                let is_other = proof.reflection.as_ref().is_some_and(|found| !interface.is(found));
                distrusted = is_other;
                reached = interface.reached;
                resolved.units.push(interface.module);
                resolved.module = Some(interface.module);
            }
        }
        let wanted = wanted_bits(&task.subject);
        let tried = task.profiles().fold(wanted, |all, (at, _)| all | bit(at));
        let bits = |profiles: &[usize]| match profiles {
            [] => tried,
            some => some.iter().fold(0, |all, at| all | bit(*at)),
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
        let fatal = proof.rejections.iter().map(|(one, profiles)| (one, bits(profiles) & wanted, true));
        let fatal = fatal.filter(|(_, profiles, _)| *profiles != 0);
        let others = proof.advice.iter().chain(&branches).chain(&external).map(|one| (one, tried, false));
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
        let accepted = if external.is_empty() && is_judged { tried & !rejected } else { 0 };
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
        let entries =
            proof.reflection.iter().flat_map(|each| each.entry_points.iter().map(|entry| &entry.name));
        let costs = summaries.map(|all| costs::of_summaries(&all, entries)).unwrap_or_default();
        state.own = Some(Own { refusals: own_refusals, reflection: proof.reflection.clone(), costs });
        state.is_settled = true;
        if distrusted {
            // All texts are proven by themselves, as far as they were not.
            self.is_irregular = true;
            for text in self.texts.iter_mut().filter(|text| text.state.own.is_none()) {
                text.state = State::default();
            }
        }
    }
}

/// Adds a refusal to the list, or its profiles to an equal refusal in the list.
fn add(refusals: &mut Vec<Refusal>, refusal: Refusal) {
    let key = |one: &Refusal| (one.diagnostic.key(), one.overrides.clone(), one.is_fatal);
    match refusals.iter_mut().find(|known| key(known) == key(&refusal)) {
        Some(known) => known.profiles |= refusal.profiles,
        None => refusals.push(refusal),
    }
}
