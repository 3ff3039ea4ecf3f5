//! The number of cases that a property is tried on, and their seed.
//!
//! Ordinarily both are fixed, so that nobody's test fails by chance. `cargo xtask soak` sets other seeds and more
//! cases, and prints what repeats them. A failure that it finds is kept as a test of its own, by name: seeds of
//! generators that change later would keep nothing.

use proptest::test_runner::{Config, RngSeed};

use crate::environment::{self, Lookup};

/// The environment variable with a seed that replaces the fixed one.
pub const SEED: &str = "UMBRAGRAPH_SEED";
/// The environment variable with the factor for the number of cases.
pub const TIMES: &str = "UMBRAGRAPH_TIMES";

/// Returns the configuration of a property test with this number of cases, before the factor of [`TIMES`].
#[must_use]
pub fn config(cases: u32) -> Config {
    from(&environment::process, cases)
}

/// Returns the seed for tests that generate random cases by other means.
#[must_use]
pub fn seed() -> u64 {
    number(&environment::process, SEED).unwrap_or(1)
}

/// Returns the factor for the number of cases; 1 by default.
#[must_use]
pub fn times() -> u32 {
    number(&environment::process, TIMES).unwrap_or(1)
}

/// Returns every `out_of`-th case of a long test, at an offset that the seed determines. Returns all cases if [`times`]
/// is above 1.
#[must_use]
pub fn part<T>(cases: impl IntoIterator<Item = T>, out_of: u64) -> Vec<T> {
    part_of(cases, if times() > 1 { 1 } else { out_of }, seed())
}

fn part_of<T>(cases: impl IntoIterator<Item = T>, out_of: u64, seed: u64) -> Vec<T> {
    let cases = cases.into_iter().enumerate();
    let is_in = |at: usize| (at as u64).wrapping_add(seed).is_multiple_of(out_of.max(1));
    let part: Vec<T> = cases.filter(|(at, _)| is_in(*at)).map(|(_, case)| case).collect();
    assert!(!part.is_empty(), "no case is in the part, and so nothing is tested");
    part
}

fn from(lookup: Lookup<'_>, cases: u32) -> Config {
    let times: u32 = number(lookup, TIMES).unwrap_or(1);
    Config {
        cases: cases.saturating_mul(times),
        max_global_rejects: 1024u32.saturating_mul(times),
        rng_seed: RngSeed::Fixed(number(lookup, SEED).unwrap_or(1)),
        failure_persistence: None,
        ..Config::default()
    }
}

fn number<T: std::str::FromStr>(lookup: Lookup<'_>, name: &str) -> Option<T> {
    let text = lookup(name).filter(|text| !text.is_empty())?.into_string().unwrap_or_default();
    match text.parse() {
        Ok(number) => Some(number),
        Err(_) => panic!("{name} is no number: `{text}`"),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::strategy::ValueTree as _;
    use proptest::test_runner::TestRunner;

    use super::*;

    fn drawn(config: Config) -> Vec<u64> {
        let mut runner = TestRunner::new(config);
        (0..4).map(|_| any::<u64>().new_tree(&mut runner).expect("a number").current()).collect()
    }

    #[test]
    fn cases_are_the_same_each_time_and_others_with_another_seed() {
        let other = |name: &str| (name == SEED).then(|| "2".into());
        let plain = drawn(from(&|_| None, 9));
        assert_eq!(plain, drawn(from(&|_| None, 9)));
        assert_ne!(plain, drawn(from(&other, 9)));
    }

    #[test]
    fn every_case_is_in_the_part_of_some_seed() {
        let parts: Vec<Vec<u32>> = (0..3).map(|seed| part_of(0..8, 3, seed)).collect();
        let mut all = parts.concat();
        all.sort_unstable();
        assert_eq!(all, (0..8).collect::<Vec<_>>());
        assert!(parts.iter().all(|part| part.len() >= 2));
        assert_eq!(part_of(0..8, 1, 5).len(), 8);
    }

    #[test]
    fn there_are_as_many_cases_as_are_asked_for() {
        let many = |name: &str| (name == TIMES).then(|| "100".into());
        assert_eq!((from(&|_| None, 9).cases, from(&many, 9).cases), (9, 900));
    }

    #[test]
    #[should_panic(expected = "UMBRAGRAPH_TIMES is no number: `often`")]
    fn what_is_no_number_is_named() {
        let _ = from(&|name: &str| (name == TIMES).then(|| "often".into()), 9);
    }
}
