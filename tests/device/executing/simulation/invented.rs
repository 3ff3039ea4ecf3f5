//! The passes of a random graph: each reads what is there in every state in which it runs.

use super::*;

impl Graph {
    /// Passes that only read what is there in every state in which they run.
    pub(super) fn invent(&mut self, random: &mut Random) {
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

    /// The units that a pass can read while it writes one: of the same kind and size, not those that it writes.
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
}
