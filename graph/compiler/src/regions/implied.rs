//! Orders between accesses of one resource that follow from others.
//!
//! Of an earlier, a middle and a later access that overlap, in frames in which each two of them can happen, the earlier
//! comes before the later as soon as it comes before the middle one, and that before the later. So from an access one
//! has to go back (or on) only to where every place was met in frames of two different conditions, or always: whoever
//! is beyond can happen together with one of the two.
//!
//! Cost: a few boxes for each access. Beyond [`MAX_BOXES`] what would have to be cut counts as not met: more orders
//! are looked for than are needed.

use crate::regions::extents::{Extents, beside, common, extents};
use umbragraph_pipeline::pipeline::{Condition, SubresourceRange};

/// The maximum number of boxes in an [`Unmet`]. Boxes beyond it are not split, which may leave redundant orders to be
/// checked.
const MAX_BOXES: usize = 64;

/// The parts of an access in which its order with further accesses does not yet follow from known orders.
pub(crate) struct Unmet {
    /// Disjoint boxes, each with the toggle condition of the accesses met there; `None` if none was met.
    boxes: Vec<(Extents, Option<Condition>)>,
    own: Option<Condition>,
}

impl Unmet {
    /// Starts with all of the subresource range of an access. `own` is the toggle condition of the access; `None` if it
    /// happens in every frame.
    pub(crate) fn new(range: SubresourceRange, own: Option<Condition>) -> Self {
        Self { boxes: vec![(extents(range), None)], own }
    }

    /// Returns `true` if the order with an access to `range` does not follow from the orders with the accesses met so
    /// far.
    pub(crate) fn has_to_meet(&self, range: SubresourceRange, condition: Option<Condition>) -> bool {
        let extents = extents(range);
        let opposite = condition.map(Condition::opposite);
        let open = self.boxes.iter().filter(|(_, met)| met.is_none() || *met == opposite);
        open.into_iter().any(|(open, _)| common(*open, extents).is_some())
    }

    /// Records that an access to `range` under `condition` is ordered with this access.
    pub(crate) fn meet(&mut self, range: SubresourceRange, condition: Option<Condition>) {
        let extents = extents(range);
        // What happens in all frames of this access is there for whoever is, too.
        let condition = condition.filter(|condition| self.own != Some(*condition));
        let mut boxes = Vec::with_capacity(self.boxes.len());
        let mut left = self.boxes.len();
        for (open, met) in self.boxes.drain(..) {
            left -= 1;
            let Some(both) = common(open, extents) else {
                boxes.push((open, met));
                continue;
            };
            if both != open && boxes.len() + left + 2 * open.len() + 1 > MAX_BOXES {
                boxes.push((open, met));
                continue;
            }
            boxes.extend(beside(open, both).into_iter().map(|rest| (rest, met)));
            if condition.is_some() && (met.is_none() || met == condition) {
                boxes.push((both, condition));
            }
        }
        self.boxes = boxes;
    }

    /// Returns `true` if the order with every further access follows from the orders with the accesses met so far.
    pub(crate) fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umbragraph_pipeline::pipeline::IndexRange;
    use umbragraph_test_support::property;

    fn accesses() -> impl Strategy<Value = Vec<(SubresourceRange, Option<Condition>)>> {
        let run = || {
            proptest::option::of((0u32..6, 1u32..4).prop_map(|(first, count)| IndexRange { first, count }))
        };
        let condition = proptest::option::of((0usize..4, any::<bool>()));
        let one = (run(), run(), condition).prop_map(|(mip, layer, condition)| {
            let condition = condition.map(|(toggle, on)| Condition { toggle, on });
            (SubresourceRange { mip, layer, ..SubresourceRange::WHOLE }, condition)
        });
        proptest::collection::vec(one, 1..40)
    }

    fn check(accesses: &[(SubresourceRange, Option<Condition>)]) -> Result<(), TestCaseError> {
        let together =
            |a: &Option<Condition>, b: &Option<Condition>| a.zip(*b).is_none_or(|(a, b)| a != b.opposite());
        // For each access those that come before it.
        let mut before: Vec<Vec<bool>> = Vec::new();
        for (at, (range, own)) in accesses.iter().enumerate() {
            let mut unmet = Unmet::new(*range, *own);
            let mut reached = vec![false; accesses.len()];
            for (earlier, (other, condition)) in accesses[..at].iter().enumerate().rev() {
                if !together(condition, own) || !unmet.has_to_meet(*other, *condition) {
                    continue;
                }
                unmet.meet(*other, *condition);
                reached[earlier] = true;
                for (place, known) in before[earlier].iter().enumerate() {
                    reached[place] |= known;
                }
                if unmet.is_empty() {
                    break;
                }
            }
            for (earlier, (other, condition)) in accesses[..at].iter().enumerate() {
                if other.overlaps(*range) && together(condition, own) {
                    prop_assert!(reached[earlier], "{} before {}", earlier, at);
                }
            }
            before.push(reached);
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn every_order_follows_from_those_that_are_looked_for(accesses in accesses()) {
            check(&accesses)?;
        }
    }

    #[test]
    fn opposite_writers_and_one_that_always_runs_are_in_order() {
        let of = |on| (SubresourceRange::WHOLE, Some(Condition { toggle: 2, on }));
        check(&[of(true), of(false), (SubresourceRange::WHOLE, None)])
            .unwrap_or_else(|failure| panic!("{failure}"));
    }
}
