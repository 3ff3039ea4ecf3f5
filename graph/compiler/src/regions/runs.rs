//! Runs of whole numbers, such as layers or bytes.

/// Runs of whole numbers as first and end (exclusive), in ascending order, with a gap after each run.
pub(crate) type Runs = Vec<(u64, u64)>;

/// Sorts runs, drops empty runs, and joins runs that overlap or touch.
pub(crate) fn joined(mut runs: Runs) -> Runs {
    runs.retain(|(first, end)| first < end);
    runs.sort_unstable();
    let mut all = Runs::with_capacity(runs.len());
    for (first, end) in runs {
        match all.last_mut() {
            Some(last) if first <= last.1 => last.1 = last.1.max(end),
            _ => all.push((first, end)),
        }
    }
    all
}

/// Returns the parts of the run `all` that `runs` do not cover. `runs` must be sorted.
pub(crate) fn between(runs: &[(u64, u64)], all: (u64, u64)) -> Runs {
    let mut left = Runs::new();
    let mut next = all.0;
    for (first, end) in runs {
        if next < (*first).min(all.1) {
            left.push((next, (*first).min(all.1)));
        }
        next = next.max(*end);
    }
    if next < all.1 {
        left.push((next, all.1));
    }
    left
}
