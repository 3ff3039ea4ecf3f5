//! What is seen of older writes, through newer ones that cover parts of them or can be off.
//!
//! A look goes back through the writers of a resource, the newest first. What has not been covered so far is a set of
//! disjoint boxes (mips × layers × aspects × bytes), each with the states of toggles in which it is open. A writer covers
//! its part in the frames in which it runs; since it has one condition at most, what is left open is a conjunction of
//! single conditions: those of the looker, and the opposite of each newer writer's. A writer is seen if some box that it
//! writes is open in a state in which it runs. This is exact: no state is forgotten, and none has to be enumerated.
//!
//! How many mips, layers and bytes there are is not known yet. What lies beyond all that is named may not exist, so it
//! keeps older writes in sight, but is never said to be missing.
//!
//! Cost: boxes times writers, so it is for resources of which a writer can be off or writes several subresources at
//! once. Every covering cuts a box into nine at most.

use crate::pipeline::{Aspect, Condition, Part, Run};

/// What a part covers of mips, layers, aspects and bytes: the first, and the first after it. Everything has no end.
type Extents = [(u64, u64); 4];

/// What is still to be seen.
pub(super) struct View<W> {
    boxes: Vec<Open<W>>,
}

struct Open<W> {
    extents: Extents,
    /// What has to hold in the frames in which it is open.
    conditions: Vec<Condition>,
    /// The newest write over it that is not always there.
    newest: Option<(W, Condition)>,
}

impl<W: Copy + Ord> View<W> {
    /// A look at a part in frames in which conditions hold that do not contradict each other.
    pub(super) fn new(part: Part, known: &[Condition]) -> Self {
        Self { boxes: vec![Open { extents: extents(part), conditions: known.to_vec(), newest: None }] }
    }

    /// Whether something of a write is seen.
    pub(super) fn sees(&self, part: Part, condition: Option<Condition>) -> bool {
        let extents = extents(part);
        self.boxes.iter().any(|open| common(open.extents, extents).is_some() && open.is_open_where(condition))
    }

    /// A write, which covers all of its part whenever it happens.
    pub(super) fn cover(&mut self, part: Part, condition: Option<Condition>, writer: W) {
        let extents = extents(part);
        let mut boxes = Vec::with_capacity(self.boxes.len());
        for open in self.boxes.drain(..) {
            let covered = common(open.extents, extents).filter(|_| open.is_open_where(condition));
            let Some(covered) = covered else {
                boxes.push(open);
                continue;
            };
            let mut inside = open.extents;
            for axis in 0..inside.len() {
                let (first, end) = inside[axis];
                for beside in [(first, covered[axis].0), (covered[axis].1, end)] {
                    if beside.0 < beside.1 {
                        let mut rest = inside;
                        rest[axis] = beside;
                        boxes.push(Open {
                            extents: rest,
                            conditions: open.conditions.clone(),
                            newest: open.newest,
                        });
                    }
                }
                inside[axis] = covered[axis];
            }
            let Some(condition) = condition.filter(|condition| !open.conditions.contains(condition)) else {
                continue;
            };
            let mut conditions = open.conditions;
            conditions.push(condition.opposite());
            let newest = open.newest.or(Some((writer, condition)));
            boxes.push(Open { extents: inside, conditions, newest });
        }
        self.boxes = boxes;
    }

    /// Whether everything is covered in every state.
    pub(super) fn is_covered(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Whether something of a part, and that exists, is not covered in some state.
    pub(super) fn is_open_in(&self, part: Part) -> bool {
        let extents = extents(part);
        self.boxes.iter().filter_map(|open| common(open.extents, extents)).any(exists)
    }

    /// The newest write below which nothing is seen in some state in which it does not happen.
    pub(super) fn missing(&self) -> Option<(W, Condition)> {
        let open = self.boxes.iter().filter(|open| exists(open.extents));
        open.filter_map(|open| open.newest).max_by_key(|(writer, _)| *writer)
    }
}

impl<W> Open<W> {
    fn is_open_where(&self, condition: Option<Condition>) -> bool {
        condition.is_none_or(|condition| !self.conditions.contains(&condition.opposite()))
    }
}

fn extents(part: Part) -> Extents {
    let run = |first: Option<u64>, end: Option<u64>| (first.unwrap_or(0), end.unwrap_or(u64::MAX));
    let aspect = match part.aspect {
        Aspect::All => (0, 2),
        Aspect::DepthOnly => (0, 1),
        Aspect::StencilOnly => (1, 2),
    };
    [
        run(part.mip.map(|run| run.first.into()), part.mip.map(Run::end)),
        run(part.layer.map(|run| run.first.into()), part.layer.map(Run::end)),
        aspect,
        run(part.bytes.map(|run| run.first), part.bytes.map(Run::end)),
    ]
}

fn common(a: Extents, b: Extents) -> Option<Extents> {
    let both: Extents = std::array::from_fn(|axis| (a[axis].0.max(b[axis].0), a[axis].1.min(b[axis].1)));
    both.iter().all(|(first, end)| first < end).then_some(both)
}

/// Whether it does not lie beyond all that is named.
fn exists(extents: Extents) -> bool {
    extents.iter().all(|(first, end)| *first == 0 || *end < u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::View;
    use crate::pipeline::{Aspect, Condition, Part, Run};

    fn when(toggle: usize, on: bool) -> Option<Condition> {
        Some(Condition { toggle, on })
    }

    fn layers(first: u32, count: u32) -> Part {
        Part { layer: Some(Run { first, count }), ..Part::WHOLE }
    }

    #[test]
    fn opposite_writers_cover_what_lies_below_even_in_pieces() {
        let mut view = View::new(layers(0, 4), &[]);
        view.cover(layers(0, 2), when(0, true), 4);
        assert!(view.sees(layers(0, 1), None) && view.sees(layers(0, 1), when(0, false)));
        assert!(!view.sees(layers(0, 1), when(0, true)) && view.sees(layers(1, 2), when(0, true)));
        view.cover(layers(2, 2), None, 3);
        view.cover(Part::WHOLE, when(0, false), 2);
        assert!(view.is_covered() && view.missing().is_none());
        assert!(!view.sees(Part::WHOLE, None));
    }

    #[test]
    fn what_may_not_exist_is_not_missing_but_still_seen() {
        let mut view = View::new(Part::WHOLE, &[]);
        view.cover(Part::WHOLE, when(0, true), 4);
        view.cover(layers(0, 1), None, 3);
        assert!(!view.is_open_in(Part::WHOLE) && view.missing().is_none());
        assert!(view.is_open_in(layers(1, 1)));
        view.cover(layers(2, 1), None, 2);
        assert_eq!(view.missing(), Some((4, Condition { toggle: 0, on: true })));
        view.cover(layers(1, 1).aspect(Aspect::DepthOnly), None, 1);
        view.cover(layers(1, 1).aspect(Aspect::StencilOnly), None, 0);
        assert!(!view.is_open_in(layers(0, 3)) && !view.is_covered() && view.sees(Part::WHOLE, None));
    }

    #[test]
    fn what_the_looker_knows_decides() {
        let known = Condition { toggle: 1, on: false };
        let mut view = View::new(Part::WHOLE, &[known]);
        assert!(!view.sees(Part::WHOLE, when(1, true)));
        view.cover(Part::WHOLE, when(1, true), 9);
        assert!(!view.is_covered() && view.missing().is_none());
        view.cover(Part::WHOLE, when(2, true), 8);
        view.cover(layers(1, 1), when(3, true), 7);
        assert_eq!(view.missing(), Some((8, Condition { toggle: 2, on: true })));
        view.cover(Part::WHOLE, when(1, false), 6);
        assert!(view.is_covered());
    }

    /// Every combination of a few writers against playing all states, region by region.
    #[test]
    fn what_is_seen_is_what_playing_every_state_finds() {
        let parts = [Part::WHOLE, layers(0, 1), layers(1, 2)];
        let conditions = [None, when(0, true), when(0, false), when(1, true)];
        let kinds: Vec<_> = parts
            .iter()
            .flat_map(|part| conditions.iter().map(move |condition| (*part, *condition)))
            .collect();
        let mut at = [0usize; 4];
        loop {
            let writers: Vec<_> = at.iter().map(|kind| kinds[*kind]).collect();
            let mut view = View::new(Part::WHOLE, &[]);
            for (rank, (part, condition)) in writers.iter().enumerate() {
                let played = (0..4).any(|state| {
                    let runs = |condition: &Option<Condition>| {
                        condition.is_none_or(|condition| (state >> condition.toggle & 1 == 1) == condition.on)
                    };
                    runs(condition)
                        && (0..5).any(|layer| {
                            let covers = |(part, condition): &(Part, Option<Condition>)| {
                                part.contains(layers(layer, 1)) && runs(condition)
                            };
                            part.contains(layers(layer, 1)) && !writers[..rank].iter().any(covers)
                        })
                });
                assert_eq!(view.sees(*part, *condition), played, "{writers:?} at {rank}");
                view.cover(*part, *condition, usize::MAX - rank);
            }
            let Some(next) = (0..at.len()).find(|place| at[*place] + 1 < kinds.len()) else { break };
            at[..next].fill(0);
            at[next] += 1;
        }
    }
}
