//! The most scalars that are alive at once in a function. A value is alive from its making to its last use.
//!
//! A value that is made before a loop and used in it lives until the loop ends.

use std::ops::Range;

use naga::{Expression, Handle};

/// The live ranges of a function's values. Time is counted in statements and expressions.
#[derive(Debug, Default)]
pub(super) struct Lives {
    now: usize,
    /// For each expression, indexed by its handle: the number of scalars, and the times of its creation and of its last
    /// use. `None` for an expression without a value.
    values: Vec<Option<(u64, usize, usize)>>,
    loops: Vec<Range<usize>>,
}

impl Lives {
    pub(super) fn now(&self) -> usize {
        self.now
    }

    /// Advances the time by one step and returns it.
    pub(super) fn tick(&mut self) -> usize {
        self.now += 1;
        self.now
    }

    pub(super) fn make(&mut self, value: Handle<Expression>, scalars: u64) {
        let at = value.index();
        if self.values.len() <= at {
            self.values.resize(at + 1, None);
        }
        self.values[at] = Some((scalars, self.now, self.now));
    }

    pub(super) fn use_it(&mut self, value: Handle<Expression>) {
        if let Some(Some((_, _, last))) = self.values.get_mut(value.index()) {
            *last = self.now;
        }
    }

    /// Records a loop that began at time `began` and ends at the current time.
    pub(super) fn end_loop(&mut self, began: usize) {
        self.loops.push(began..self.now);
    }

    /// Returns the number of live scalars, indexed by time.
    pub(super) fn alive(mut self) -> Vec<u64> {
        // Inner loops end before outer ones.
        for inside in &self.loops {
            for (_, made, last) in self.values.iter_mut().flatten() {
                if *made < inside.start && inside.contains(last) {
                    *last = inside.end;
                }
            }
        }
        let mut changes = vec![0_i64; self.now + 2];
        for (scalars, made, last) in self.values.into_iter().flatten() {
            let scalars = i64::try_from(scalars).unwrap_or(i64::MAX / 2);
            changes[made] = changes[made].saturating_add(scalars);
            changes[last + 1] = changes[last + 1].saturating_sub(scalars);
        }
        let mut now = 0_i64;
        changes
            .into_iter()
            .map(|change| {
                now = now.saturating_add(change);
                now.max(0).unsigned_abs()
            })
            .collect()
    }
}
