//! Visibility of older writes, through newer ones that cover ranges of them or can be off.
//!
//! A look goes back through the writers of a resource, the newest first. What has not been covered so far is a set of
//! disjoint boxes (mips × layers × aspects × bytes), each with the states of toggles in which it is open. A writer
//! covers its subresource range in the frames in which it runs; since it has one condition at most, what is left open
//! is a conjunction of single conditions: those of the looker, and the opposite of each newer writer's. A writer is
//! seen if some box that it writes is open in a state in which it runs. This is exact: no state is forgotten, and none
//! has to be enumerated.
//!
//! The numbers of mips, layers and bytes are not known yet. A range beyond all named ones may not exist, so it keeps
//! older writes in sight, but is never said to be missing.
//!
//! **Passing on.** A writer that can be off and loads what it writes over feeds on what is below it, so that whoever
//! reads it depends on that, too. A look that has found many writers goes [on](View::pass_on) only for what two such
//! writers with different conditions do not pass on, so that many of them make about as many edges.
//!
//! **Bound.** Every covering cuts a box into nine at most. A look at more than [`MAX_BOXES`] boxes goes on with those
//! that it has: it is [coarse](View::is_coarse), takes what would have to be cut for not covered, and so sees more than
//! there is, never less. It finds nothing to be missing. The looks at one resource share an [`Effort`]; those that come
//! when it is used up do not cut at all.
//!
//! Cost: boxes times writers, so it is for resources of which a writer can be off or writes several subresources at
//! once.

use smallvec::SmallVec;

use crate::regions::extents::{Extents, beside, common, extents};
use umbragraph_pipeline::pipeline::{Condition, SubresourceRange};

/// The maximum number of boxes that one [`View`] keeps.
const MAX_BOXES: usize = 1024;
/// The maximum number of box visits by all views of one resource before they become coarse.
const MAX_STEPS: usize = 1 << 23;

/// The work done so far by all views of one resource, counted in visited boxes.
#[derive(Debug, Default)]
pub(crate) struct Effort {
    steps: usize,
}

impl Effort {
    /// Returns `true` if the work limit is reached, so that further results are coarse.
    pub(crate) fn is_used_up(&self) -> bool {
        self.steps >= MAX_STEPS
    }
}

/// A search for the writes that are visible in a subresource range: the boxes that newer writes leave uncovered.
pub(crate) struct View<'a, W> {
    looked_at: Extents,
    boxes: Vec<Open<W>>,
    effort: &'a mut Effort,
    /// Whether a limit made the search inexact, so that it may find more writes than are visible.
    pub(crate) is_coarse: bool,
    passes_on: bool,
}

/// A write to a subresource range. `W` identifies the writer.
#[derive(Clone, Copy)]
pub(crate) struct Write<W> {
    pub(crate) range: SubresourceRange,
    /// The toggle condition under which the write happens; `None` if it happens in every frame.
    pub(crate) condition: Option<Condition>,
    /// The writer; a newer writer compares as greater.
    pub(crate) writer: W,
    /// Whether the writer loads earlier contents, and no older write without loading has the same toggle condition.
    pub(crate) passes_on: bool,
}

#[derive(Clone)]
struct Open<W> {
    extents: Extents,
    /// The toggle conditions of the frames in which the box is uncovered, sorted; all must hold.
    conditions: Vec<Condition>,
    /// The newest write with a toggle that covers the box, with its condition; `None` if there is none.
    newest: Option<(W, Condition)>,
    /// The conditions of newer writers that load the box and so pass on older contents. At most two different ones are
    /// kept.
    passed_on: SmallVec<[Condition; 2]>,
}

impl<'a, W: Copy + Ord> View<'a, W> {
    /// Starts with all of a subresource range, in frames in which the conditions `known` hold. They must not contradict
    /// each other.
    pub(crate) fn new(range: SubresourceRange, known: &[Condition], effort: &'a mut Effort) -> Self {
        let mut conditions = known.to_vec();
        conditions.sort_unstable();
        let looked_at = extents(range);
        let open = Open { extents: looked_at, conditions, newest: None, passed_on: SmallVec::new() };
        Self { looked_at, boxes: vec![open], effort, is_coarse: false, passes_on: false }
    }

    /// Ends the search in boxes whose older contents two writers with different conditions already load and pass on.
    pub(crate) fn pass_on(&mut self) {
        self.passes_on = true;
        self.boxes.retain(|open| open.passed_on.len() < 2);
    }

    /// Returns `true` if some box of a write is visible in some toggle state, that is, not covered by the writes added
    /// so far.
    pub(crate) fn sees(&mut self, range: SubresourceRange, condition: Option<Condition>) -> bool {
        let extents = extents(range);
        self.effort.steps += self.boxes.len();
        self.boxes.iter().any(|open| {
            let is_wanted = !self.passes_on || !open.is_passed_on(condition);
            common(open.extents, extents).is_some() && is_wanted && open.is_open_where(condition)
        })
    }

    /// Adds a write, which covers its subresource range in the frames in which it happens.
    pub(crate) fn cover(&mut self, write: Write<W>) {
        let extents = extents(write.range);
        self.effort.steps += self.boxes.len();
        let max = if self.effort.is_used_up() { 1 } else { MAX_BOXES };
        let mut boxes = Vec::with_capacity(self.boxes.len());
        let mut left = self.boxes.len();
        for mut open in self.boxes.drain(..) {
            left -= 1;
            let condition = write.condition;
            let covered = common(open.extents, extents).filter(|_| open.is_open_where(condition));
            let Some(covered) = covered else {
                boxes.push(open);
                continue;
            };
            let pieces = beside(open.extents, covered);
            if !pieces.is_empty() && boxes.len() + left + pieces.len() + 1 > max {
                self.is_coarse = true;
                boxes.push(open);
                continue;
            }
            boxes.extend(pieces.into_iter().map(|extents| Open { extents, ..open.clone() }));
            let place = |condition: &Condition| open.conditions.binary_search(condition).err();
            let Some(condition) = condition.filter(|condition| place(condition).is_some()) else {
                continue;
            };
            if write.passes_on && open.passed_on.len() < 2 && !open.passed_on.contains(&condition) {
                open.passed_on.push(condition);
                if self.passes_on && open.passed_on.len() == 2 {
                    continue;
                }
            }
            let opposite = condition.opposite();
            if let Some(at) = place(&opposite) {
                open.conditions.insert(at, opposite);
            }
            let newest = open.newest.or(Some((write.writer, condition)));
            boxes.push(Open { extents: covered, newest, ..open });
        }
        self.boxes = boxes;
    }

    /// Returns `true` if writes cover the full subresource range in every toggle state.
    pub(crate) fn is_covered(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Returns `true` if a subresource of a range that is certain to exist is uncovered in some toggle state. Returns
    /// `false` if the search is coarse.
    pub(crate) fn is_open_in(&self, range: SubresourceRange) -> bool {
        let extents = extents(range);
        !self.is_coarse && self.boxes.iter().filter_map(|open| common(open.extents, extents)).any(exists)
    }

    /// Returns the boxes that no write covers in any frame in which the reader runs; empty if the search is coarse.
    /// Parts of a box may lie outside of the resource.
    pub(crate) fn unwritten(&self) -> Vec<Extents> {
        let open = self.boxes.iter().filter(|open| !self.is_coarse && open.newest.is_none());
        open.map(|open| open.extents).collect()
    }

    /// Returns the boxes that are uncovered in some toggle state; empty if the search is coarse. Parts of a box may lie
    /// outside of the resource.
    pub(crate) fn open(&self) -> Vec<Extents> {
        self.boxes.iter().filter(|_| !self.is_coarse).map(|open| open.extents).collect()
    }

    /// Returns the boxes that a write covers in one toggle state and no write covers in another, each with the newest
    /// such write. Empty if the search is coarse; parts of a box may lie outside of the resource.
    pub(crate) fn toggled(&self) -> Vec<(Extents, W, Condition)> {
        let open = self.boxes.iter().filter(|_| !self.is_coarse);
        open.filter_map(|open| open.newest.map(|(writer, condition)| (open.extents, writer, condition)))
            .collect()
    }

    /// Returns the newest write with a toggle that covers the full range, if some toggle state leaves the full range
    /// unwritten. `None` if there is no such write, or the search is coarse.
    pub(crate) fn missing(&self) -> Option<(W, Condition)> {
        let open = self.boxes.iter().filter(|open| !self.is_coarse && open.extents == self.looked_at);
        open.filter_map(|open| open.newest).max_by_key(|(writer, _)| *writer)
    }
}

impl<W> Open<W> {
    fn is_open_where(&self, condition: Option<Condition>) -> bool {
        condition.is_none_or(|condition| self.conditions.binary_search(&condition.opposite()).is_err())
    }

    /// Returns `true` if a newer writer that can run in the same frame passes on an older write with this condition.
    fn is_passed_on(&self, condition: Option<Condition>) -> bool {
        let contradicts =
            |other: &Condition| condition.is_some_and(|condition| condition == other.opposite());
        self.passed_on.iter().any(|other| !contradicts(other))
    }
}

/// Returns `true` if part of the box is certain to exist: each axis starts at 0 or has an end that an access names.
fn exists(extents: Extents) -> bool {
    extents.iter().all(|(first, end)| *first == 0 || *end < u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::{Effort, MAX_BOXES, View, Write, extents};
    use umbragraph_pipeline::pipeline::{Aspect, Condition, IndexRange, SubresourceRange};

    fn write(range: SubresourceRange, condition: Option<Condition>, writer: usize) -> Write<usize> {
        Write { range, condition, writer, passes_on: false }
    }

    fn when(toggle: usize, on: bool) -> Option<Condition> {
        Some(Condition { toggle, on })
    }

    fn layers(first: u32, count: u32) -> SubresourceRange {
        SubresourceRange { layer: Some(IndexRange { first, count }), ..SubresourceRange::WHOLE }
    }

    #[test]
    fn opposite_writers_cover_what_lies_below_even_in_pieces() {
        let mut effort = Effort::default();
        let mut view = View::new(layers(0, 4), &[], &mut effort);
        view.cover(write(layers(0, 2), when(0, true), 4));
        assert!(view.sees(layers(0, 1), None) && view.sees(layers(0, 1), when(0, false)));
        assert!(!view.sees(layers(0, 1), when(0, true)) && view.sees(layers(1, 2), when(0, true)));
        view.cover(write(layers(2, 2), None, 3));
        view.cover(write(SubresourceRange::WHOLE, when(0, false), 2));
        assert!(view.is_covered() && view.missing().is_none());
        assert!(!view.sees(SubresourceRange::WHOLE, None));
    }

    #[test]
    fn what_may_not_exist_is_not_missing_but_still_seen() {
        let mut effort = Effort::default();
        let mut view = View::new(SubresourceRange::WHOLE, &[], &mut effort);
        view.cover(write(SubresourceRange::WHOLE, when(0, true), 4));
        view.cover(write(layers(0, 1), None, 3));
        assert!(!view.is_open_in(SubresourceRange::WHOLE) && view.missing().is_none());
        assert!(view.is_open_in(layers(1, 1)));
        view.cover(write(layers(2, 1), None, 2));
        assert!(view.is_open_in(layers(1, 1)) && view.missing().is_none());
        let toggled = view.toggled();
        assert!(
            toggled.contains(&(extents(layers(1, 1)), 4, Condition { toggle: 0, on: true })),
            "{toggled:?}"
        );
        view.cover(write(layers(1, 1).aspect(Aspect::DepthOnly), None, 1));
        view.cover(write(layers(1, 1).aspect(Aspect::StencilOnly), None, 0));
        assert!(
            !view.is_open_in(layers(0, 3)) && !view.is_covered() && view.sees(SubresourceRange::WHOLE, None)
        );
    }

    #[test]
    fn what_the_looker_knows_decides() {
        let known = Condition { toggle: 1, on: false };
        let mut effort = Effort::default();
        let mut view = View::new(SubresourceRange::WHOLE, &[known], &mut effort);
        assert!(!view.sees(SubresourceRange::WHOLE, when(1, true)));
        view.cover(write(SubresourceRange::WHOLE, when(1, true), 9));
        assert!(!view.is_covered() && view.missing().is_none());
        view.cover(write(SubresourceRange::WHOLE, when(2, true), 8));
        assert_eq!(view.missing(), Some((8, Condition { toggle: 2, on: true })));
        view.cover(write(layers(1, 1), when(3, true), 7));
        assert!(view.toggled().iter().all(|(_, writer, _)| *writer == 8) && view.missing().is_none());
        view.cover(write(SubresourceRange::WHOLE, when(1, false), 6));
        assert!(view.is_covered());
    }

    #[test]
    fn what_two_writers_pass_on_is_left_to_them() {
        let all = SubresourceRange::WHOLE;
        let passing = |toggle: usize, writer: usize| Write {
            passes_on: true,
            ..write(all, when(toggle, true), writer)
        };
        let mut effort = Effort::default();
        let mut view = View::new(all, &[], &mut effort);
        view.cover(passing(0, 9));
        view.pass_on();
        assert!(!view.sees(all, None) && !view.sees(all, when(1, true)), "the writer reads it");
        assert!(view.sees(all, when(0, false)), "it never runs with the writer");
        view.cover(passing(0, 8));
        assert!(view.sees(all, when(0, false)), "it is one and the same condition");
        view.cover(passing(1, 7));
        assert!(view.is_covered());
        // Before `pass_on`, what they pass on is looked for as well.
        for count in [0, 1] {
            let mut effort = Effort::default();
            let mut view = View::new(all, &[], &mut effort);
            view.cover(passing(0, 9));
            view.cover(passing(1, 8));
            for toggle in 0..count {
                view.cover(passing(2 + toggle, 7));
            }
            assert!(view.sees(all, None) && view.sees(all, when(3, true)) && !view.is_covered());
            view.pass_on();
            assert!(view.is_covered());
        }
    }

    /// Compares the result for every combination of four writers with a simulation of all toggle states and layers.
    #[test]
    fn what_is_seen_is_what_playing_every_state_finds() {
        let ranges = [SubresourceRange::WHOLE, layers(0, 1), layers(1, 2)];
        let conditions = [None, when(0, true), when(0, false), when(1, true)];
        let kinds: Vec<_> = ranges
            .iter()
            .flat_map(|range| conditions.iter().map(move |condition| (*range, *condition)))
            .collect();
        let mut at = [0usize; 4];
        loop {
            let writers: Vec<_> = at.iter().map(|kind| kinds[*kind]).collect();
            let mut effort = Effort::default();
            let mut view = View::new(SubresourceRange::WHOLE, &[], &mut effort);
            for (rank, (range, condition)) in writers.iter().enumerate() {
                let played = (0..4).any(|state| {
                    let runs = |condition: &Option<Condition>| {
                        condition.is_none_or(|condition| (state >> condition.toggle & 1 == 1) == condition.on)
                    };
                    runs(condition)
                        && (0..5).any(|layer| {
                            let covers = |(range, condition): &(SubresourceRange, Option<Condition>)| {
                                range.contains(layers(layer, 1)) && runs(condition)
                            };
                            range.contains(layers(layer, 1)) && !writers[..rank].iter().any(covers)
                        })
                });
                assert_eq!(view.sees(*range, *condition), played, "{writers:?} at {rank}");
                view.cover(write(*range, *condition, usize::MAX - rank));
            }
            let Some(next) = (0..at.len()).find(|place| at[*place] + 1 < kinds.len()) else { break };
            at[..next].fill(0);
            at[next] += 1;
        }
    }

    #[test]
    fn a_coarse_look_misses_nothing_and_its_work_has_a_bound() {
        const COUNT: usize = 5000;
        let mut random = umbragraph_test_support::random::Random(1);
        let mut number = |end: usize| random.below(end) as u32;
        let mut effort = Effort::default();
        let mut view = View::new(SubresourceRange::WHOLE, &[], &mut effort);
        // The states and places that are played beside the look, and which of them are written.
        let mut played: Vec<(u64, u32, u32, bool)> =
            (0..200).map(|_| (u64::from(number(1 << 30)), number(16), number(512), false)).collect();
        for at in 0..COUNT {
            let run = |first: u32, count: u32| Some(IndexRange { first, count });
            let (mip, layer) = (number(16), number(512));
            let range = SubresourceRange {
                mip: run(mip, 1 + number(3)),
                layer: run(layer, 1 + number(9)),
                ..SubresourceRange::WHOLE
            };
            let condition = Condition { toggle: number(2000) as usize, on: number(2) == 0 };
            let mut is_seen = false;
            for (seed, mip, layer, written) in &mut played {
                let happens =
                    seed.wrapping_mul(condition.toggle as u64 * 2 + 1) >> 40 & 1 == u64::from(condition.on);
                if happens && range.contains(SubresourceRange::of(Some(*mip), Some(*layer))) {
                    is_seen |= !*written;
                    *written = true;
                }
            }
            assert!(view.sees(range, Some(condition)) || !is_seen);
            view.cover(write(range, Some(condition), COUNT - at));
            assert!(view.boxes.len() <= MAX_BOXES);
        }
        assert!(view.is_coarse && view.missing().is_none() && !view.is_open_in(SubresourceRange::WHOLE));
        assert!(effort.steps <= 2 * COUNT * MAX_BOXES);
    }
}
