//! The texts that are to be proven next: few that hold all of what nobody has proven.

use std::collections::BTreeSet;

use super::compose::{Composition, State, wanted_bits};
use super::cover::cover;
use super::units::{Profiles, Units};

/// A part of a WGSL module that is not validated yet: a declaration, or a validation unit (a declaration with all that
/// it depends on).
#[derive(Clone, Copy)]
enum Part {
    Unit,
    /// A declaration whose validation unit is not known yet.
    Open,
    /// A validation unit that no entry point of a validated module has reached yet.
    Reached,
}

/// The WGSL modules that are validated in the next round.
pub(super) struct Chosen {
    /// The indices of the modules whose result also counts for their declarations in other modules.
    pub(super) of_units: BTreeSet<usize>,
    /// The indices of the modules whose result counts for no other module.
    pub(super) alone: Vec<usize>,
}

impl Composition<'_> {
    /// Chooses the WGSL modules to validate in the next round, among every `step`-th module. `exhaustive` chooses all
    /// of these. The result is empty if their validation is complete.
    pub(super) fn choose(&mut self, exhaustive: bool, step: usize) -> Chosen {
        let (mut alone, mut open) = (Vec::new(), Vec::new());
        for at in (0..self.texts.len()).step_by(step) {
            if self.texts[at].state.is_settled {
                continue;
            }
            let (subject, overrides) = (self.texts[at].subject.clone(), self.texts[at].overrides);
            let (request, own) = self.texts[at].at;
            let split = self.explored[request].exploration.texts[own].declarations.as_deref();
            // Without a profile nothing is validated, and no summary ever known.
            let is_validated =
                !subject.wanted.is_empty() && subject.profiles.len() <= Profiles::BITS as usize;
            let split = split.filter(|_| !exhaustive && is_validated && !self.is_irregular);
            let Some(split) = split else {
                alone.push(at);
                continue;
            };
            let units = &mut self.units;
            let part = |id: u32, kind: Part| u64::from(id) | (kind as u64) << 32;
            let everything = wanted_bits(&subject);
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
                let resolved = units.resolve(&self.declarations, (split, &self.overrides[overrides]), None);
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
                    // A module counts as a unit only once all others are proven: until then it need not be.
                    if parts.is_empty() {
                        let module = &mut units.all[interface.module as usize];
                        if module.accepted & pending != pending {
                            let (fits, reflection) = interface.proven(&subject);
                            module.accepted |= fits & pending;
                            module.reflection.get_or_insert_with(|| reflection.clone());
                        }
                        state.units.push(interface.module);
                        state.module = Some(interface.module);
                        parts = unproven(units, state).1;
                    }
                }
            }
            let state = &mut self.texts[at].state;
            state.is_settled = parts.is_empty();
            if !state.is_settled {
                open.push((at, parts));
            }
        }
        // A unit can stay unproven in every text that has it. Each further round takes twice as many such texts.
        let is_stubborn =
            |(_, parts): &&(usize, Vec<u64>)| parts.iter().any(|part| self.tried.contains(part));
        let stubborn: Vec<usize> = open.iter().filter(is_stubborn).map(|(at, _)| *at).collect();
        self.more = if stubborn.is_empty() { 0 } else { (self.more * 2).max(1) };
        let mut chosen: BTreeSet<usize> = cover(&open).into_iter().collect();
        chosen.extend(stubborn.into_iter().take(self.more));
        self.tried
            .extend(open.into_iter().filter(|(at, _)| chosen.contains(at)).flat_map(|(_, parts)| parts));
        Chosen { of_units: chosen, alone }
    }
}
