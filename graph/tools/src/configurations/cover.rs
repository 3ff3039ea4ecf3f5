//! Combinations of values that features allow, and a few that stand for all.
//!
//! All are listed where they are few. Else the list is a pairwise cover: the given values, every setting changed alone,
//! and as many more as show each value of a setting together with each value of every other (most defects need no more
//! than two; Cohen, Dalal, Fredman and Patton, "The AETG system", 1997). The cover is greedy: the first pair that is
//! not shown yet, completed setting by setting with the value that shows most further pairs.

use std::collections::{BTreeMap, BTreeSet};

use crate::configurations::varied_setting::Varied;
use umbragraph_pipeline::diagnostic::{AxisValue, AxisValues, Count};
use umbragraph_pipeline::language::FeatureDeclaration;
use umbragraph_pipeline::shader::axes::{Condition, Constraint, Rule};
use umbragraph_pipeline::shader::permutations::Space;
use umbragraph_pipeline::source::Span;

/// The maximum number of settings for which pairs of values are covered.
pub(super) const MAX_PAIRED: usize = 128;

/// The maximum number of non-default values, over all settings, for which pairs of values are covered.
const MAX_CHANGES: usize = 512;

/// The maximum number of values that one search for an allowed combination tries.
const MAX_STEPS: usize = 1 << 16;

/// The extent to which a list covers all configurations of a document.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cover {
    /// The list holds all configurations.
    #[default]
    All,
    /// The list shows each pass with every combination of the settings on which it depends.
    Passes,
    /// The list shows every value of a setting together with every value of each other setting.
    Pairs,
    /// The list is a sample, since there are too many pairs of values, or too many states of a pass.
    Some,
}

/// The rules that features declare for one another; numbers are indices into the list of settings.
pub(super) struct Rules {
    /// Whether the feature is on, for each setting and each of its values.
    on: Vec<Vec<bool>>,
    /// The features that each feature requires; `None` for a required feature that is not declared.
    requires: Vec<Vec<Option<usize>>>,
    excludes: Vec<Vec<usize>>,
    /// The groups of features of which exactly one is on.
    groups: Vec<Vec<usize>>,
}

impl Rules {
    pub(super) fn new(varied: &[Varied]) -> Self {
        let position =
            |name: &String| varied.iter().position(|each| each.feature.is_some() && each.name == *name);
        let named = |of: fn(&FeatureDeclaration) -> &Vec<String>| {
            varied.iter().map(move |each| each.feature.as_ref().map(of).map_or(&[][..], Vec::as_slice))
        };
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (at, each) in varied.iter().enumerate() {
            if let Some(group) = each.group() {
                groups.entry(group).or_default().push(at);
            }
        }
        Self {
            groups: groups.into_values().collect(),
            on: varied
                .iter()
                .map(|each| each.values.iter().map(|value| each.is_on(value)).collect())
                .collect(),
            requires: named(|each| &each.requires)
                .map(|names| names.iter().map(position).collect())
                .collect(),
            excludes: named(|each| &each.excludes)
                .map(|names| names.iter().filter_map(position).collect())
                .collect(),
        }
    }

    fn len(&self) -> usize {
        self.on.len()
    }

    /// Returns a group of settings extended by all features that requirements, exclusions or groups tie to it, directly
    /// or through other features.
    pub(super) fn with_tied(&self, mut group: BTreeSet<usize>) -> BTreeSet<usize> {
        let others = |at: usize| {
            let grouped = self.groups.iter().filter(move |group| group.contains(&at)).flatten();
            self.requires[at].iter().flatten().chain(&self.excludes[at]).chain(grouped)
        };
        loop {
            let tied = |at: &usize| group.contains(at) || others(*at).any(|other| group.contains(other));
            let mut more: BTreeSet<usize> = (0..self.len()).filter(tied).collect();
            let theirs: Vec<usize> = more.iter().flat_map(|at| others(*at)).copied().collect();
            more.extend(theirs);
            if more.len() == group.len() {
                return group;
            }
            group = more;
        }
    }

    /// Counts the combinations of values that the rules between features allow.
    pub(super) fn count(&self, span: Span) -> Count {
        let name = |at: usize| format!("{at:04}");
        let value = |value: usize| AxisValue::Integer(value as i64);
        let values = |on: &Vec<bool>| (0..on.len().max(1)).map(value).collect();
        let condition = |at: usize, is_on: bool| {
            let off = self.on[at].iter().position(|on| !on);
            // What has no value with which it is off is on.
            Condition { axis: name(at), value: value(off.unwrap_or(self.on[at].len())), equal: !is_on }
        };
        let ties =
            (0..self.len()).filter(|at| !self.requires[*at].is_empty() || !self.excludes[*at].is_empty());
        let mut rules: Vec<Rule> = Vec::new();
        for at in ties {
            // What is not declared is never on.
            let required =
                |other: &Option<usize>| other.map_or(condition(at, false), |other| condition(other, true));
            let all = self.requires[at].iter().map(required).collect();
            rules.push(Rule::Requires { when: Some(condition(at, true)), all });
            let none = self.excludes[at].iter().map(|other| condition(*other, true)).collect();
            rules.push(Rule::Excludes { when: Some(condition(at, true)), none });
        }
        let one_of = |group: &Vec<usize>| Rule::OneOf(group.iter().map(|at| condition(*at, true)).collect());
        rules.extend(self.groups.iter().map(one_of));
        let constraints = rules.into_iter().map(|rule| Constraint { rule, span }).collect();
        let axes = self.on.iter().enumerate().map(|(at, on)| (name(at), values(on))).collect();
        Space::of(axes, constraints).count(&AxisValues::new())
    }

    fn is_on(&self, at: usize, pick: &[Option<usize>]) -> Option<bool> {
        let value = (*pick.get(at)?)?;
        self.on.get(at)?.get(value).copied()
    }

    /// Returns `true` if a complete choice of values obeys the rules. `pick` holds the value index of each setting.
    pub(super) fn allow(&self, pick: &[usize]) -> bool {
        !self.contradict(&pick.iter().copied().map(Some).collect::<Vec<_>>())
    }

    /// Returns `true` if the values chosen so far break a rule. `pick` holds a value index for each setting, or `None`
    /// if it is still open.
    pub(super) fn contradict(&self, pick: &[Option<usize>]) -> bool {
        let not_one = |group: &Vec<usize>| {
            let count =
                |wanted: Option<bool>| group.iter().filter(|at| self.is_on(**at, pick) == wanted).count();
            count(Some(true)) > 1 || count(Some(false)) == group.len()
        };
        if self.groups.iter().any(not_one) {
            return true;
        }
        (0..self.len()).filter(|at| self.is_on(*at, pick) == Some(true)).any(|at| {
            let is_off = |other: &Option<usize>| match other {
                Some(other) => self.is_on(*other, pick) == Some(false),
                None => true,
            };
            self.requires[at].iter().any(is_off)
                || self.excludes[at].iter().any(|other| self.is_on(*other, pick) == Some(true))
        })
    }
}

/// Returns all configurations if there are no more than `limit`, or else a pairwise cover of at most `limit`. Each
/// configuration is a list of the value index of each setting. The one with only defaults comes first; the others
/// follow by the number of settings that differ from it.
pub(super) fn picks(rules: &Rules, limit: usize) -> (Vec<Vec<usize>>, Cover) {
    let plain = vec![0; rules.len()];
    let changes = |pick: &Vec<usize>| pick.iter().filter(|value| **value > 0).count();
    let mut search = All { rules, limit, found: Vec::new(), steps: 0 };
    if search.extend(&mut vec![None; rules.len()], 0) {
        let mut found = search.found;
        // What the caller asks for is always looked at, even where it contradicts itself.
        found.retain(|pick| *pick != plain);
        found.insert(0, plain);
        found.sort_by_key(changes);
        return (found, Cover::All);
    }
    let mut list = vec![plain.clone()];
    let mut seen = BTreeSet::from([plain.clone()]);
    let single = |at: usize| (1..rules.on[at].len()).map(move |value| (at, value));
    let singles: Vec<Chosen> = (0..rules.len()).flat_map(single).collect();
    let is_open = rules.len() <= MAX_PAIRED && singles.len() <= MAX_CHANGES;
    let around = |(at, one): (usize, &Chosen)| {
        let others = singles[at + 1..].iter().filter(|two| !is_open && two.0 != one.0);
        others.map(|two| [*one, *two]).collect::<Vec<_>>()
    };
    // Where there are too many pairs to look for a cover, those of changes of the given values, as far as they fit.
    let alone = singles.iter().map(|one| [*one, *one]);
    for changes in alone.chain(singles.iter().enumerate().flat_map(around)) {
        if list.len() >= limit {
            break;
        }
        let mut pick = plain.clone();
        changes.into_iter().for_each(|(at, value)| pick[at] = value);
        if rules.allow(&pick) && seen.insert(pick.clone()) {
            list.push(pick);
        }
    }
    if !is_open {
        return (list, Cover::Some);
    }
    let mut pairs = Pairs::new(rules);
    list.iter().for_each(|pick| pairs.cover(pick));
    let mut cover = Cover::Pairs;
    while let Some(pair) = pairs.open.first().copied() {
        if list.len() >= limit {
            cover = Cover::Some;
            break;
        }
        if let Some(pick) = pairs.complete(pair) {
            pairs.cover(&pick);
            if seen.insert(pick.clone()) {
                list.push(pick);
            }
        }
        // A pair that nothing completes is forbidden.
        pairs.open.remove(&pair);
    }
    list.sort_by_key(changes);
    (list, cover)
}

/// A depth-first search for all configurations that the rules allow.
struct All<'r> {
    rules: &'r Rules,
    limit: usize,
    found: Vec<Vec<usize>>,
    steps: usize,
}

impl All<'_> {
    /// Adds to `found` every allowed completion of `pick` from the setting `at` on. Returns `false` if there are more
    /// than `limit`, or if the search takes too many steps.
    fn extend(&mut self, pick: &mut Vec<Option<usize>>, at: usize) -> bool {
        let Some(values) = self.rules.on.get(at) else {
            self.found.push(pick.iter().map(|value| value.unwrap_or(0)).collect());
            return self.found.len() <= self.limit;
        };
        for value in 0..values.len() {
            self.steps += 1;
            pick[at] = Some(value);
            if self.steps > MAX_STEPS || (!self.rules.contradict(pick) && !self.extend(pick, at + 1)) {
                return false;
            }
        }
        pick[at] = None;
        true
    }
}

/// A setting and one of its values, both as indices.
type Chosen = (usize, usize);

/// The pairs of values that no configuration of the list has yet.
struct Pairs<'r> {
    rules: &'r Rules,
    open: BTreeSet<(Chosen, Chosen)>,
}

impl<'r> Pairs<'r> {
    fn new(rules: &'r Rules) -> Self {
        let chosen: Vec<Chosen> =
            (0..rules.len()).flat_map(|at| (0..rules.on[at].len()).map(move |value| (at, value))).collect();
        let later = |one: Chosen| chosen.iter().copied().filter(move |two| one.0 < two.0);
        let open = chosen.iter().flat_map(|one| later(*one).map(|two| (*one, two))).collect();
        Self { rules, open }
    }

    fn cover(&mut self, pick: &[usize]) {
        for (one, first) in pick.iter().enumerate() {
            for (two, second) in pick.iter().enumerate().skip(one + 1) {
                self.open.remove(&((one, *first), (two, *second)));
            }
        }
    }

    /// Returns a configuration with a pair of values, and greedily with as many other open pairs as possible. `None` if
    /// no allowed configuration with the pair is found.
    fn complete(&self, pair: (Chosen, Chosen)) -> Option<Vec<usize>> {
        let mut pick = vec![None; self.rules.len()];
        pick[pair.0.0] = Some(pair.0.1);
        pick[pair.1.0] = Some(pair.1.1);
        let fits = !self.rules.contradict(&pick) && self.extend(&mut pick, 0, &mut 0);
        fits.then(|| pick.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn extend(&self, pick: &mut Vec<Option<usize>>, from: usize, steps: &mut usize) -> bool {
        let Some(at) = (from..pick.len()).find(|at| pick[*at].is_none()) else { return true };
        let shows = |value: usize| {
            let others = pick.iter().enumerate().filter_map(|(other, chosen)| Some((other, (*chosen)?)));
            others
                .filter(|other| self.open.contains(&((at, value).min(*other), (at, value).max(*other))))
                .count()
        };
        let mut values: Vec<(usize, usize)> =
            (0..self.rules.on[at].len()).map(|value| (usize::MAX - shows(value), value)).collect();
        values.sort_unstable();
        for (_, value) in values {
            *steps += 1;
            if *steps > MAX_STEPS {
                return false;
            }
            pick[at] = Some(value);
            if !self.rules.contradict(pick) && self.extend(pick, at + 1, steps) {
                return true;
            }
        }
        pick[at] = None;
        false
    }
}
