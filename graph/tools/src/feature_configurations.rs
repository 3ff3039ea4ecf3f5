//! The configurations that the static features of a pipeline can reach.
//!
//! A configuration gives each feature one of its values, so that `requires`, `excludes` and `one_of` hold. All of them
//! are enumerated where there are no more than [`MAXIMUM`]; else the list is a pairwise cover: the given values, every
//! feature changed alone, and as many more as show each value of a feature together with each value of every other
//! (most defects need no more than two; Cohen, Dalal, Fredman and Patton, "The AETG system", 1997). The cover is greedy:
//! the first pair that is not shown yet, completed feature by feature with the value that shows most further pairs.
//!
//! Features that the caller gives a value keep it. Each preset is one configuration more, with its own parameters.

use std::collections::{BTreeMap, BTreeSet};

use super::configurations::{Varied, choice, count, feature_values};
use crate::diagnostic::Diagnostics;
use crate::document::{Document, Value};
use crate::language::FeatureDeclaration;
use crate::pipeline::{Choice, of_preset};
use crate::shader::TargetProfile;
use crate::shader::permutations::Count;

/// The most configurations of features that are listed one by one.
pub const MAXIMUM: usize = 256;

/// The most features of which pairs are covered.
const MAXIMUM_PAIRED: usize = 128;

/// The most steps of one search for values that fit together.
const MAXIMUM_STEPS: usize = 1 << 16;

/// How much of the configurations a list holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cover {
    /// All of them.
    #[default]
    All,
    /// Every value of a feature with every value of each other.
    Pairs,
    /// As many as fit: pairs alone would be too many.
    Some,
}

/// One configuration.
#[derive(Clone, Debug)]
pub struct Configuration {
    /// The values, with those that the caller gives.
    pub choice: Choice,
    /// The preset that it is.
    pub preset: Option<String>,
    /// The index of each feature's value; 0 is the default, or what the caller gives.
    pick: Vec<usize>,
}

/// The configurations of a document: the caller's own first, then by the number of features that differ from it.
#[derive(Clone, Debug, Default)]
pub struct FeatureConfigurations {
    /// The configurations.
    pub list: Vec<Configuration>,
    /// How many the features can reach, presets not counted.
    pub number: Count,
    /// How much of them the list holds.
    pub cover: Cover,
    names: Vec<String>,
    values: Vec<Vec<Value>>,
}

/// The configurations that the features of a document can reach on a profile where the caller gives the values `base`.
pub fn feature_configurations(
    document: &Document,
    base: &Choice,
    profile: &TargetProfile,
) -> FeatureConfigurations {
    let varied = varied(document, base, profile);
    let rules = Rules::new(&varied);
    let (picks, cover) = picks(&rules);
    let configuration = |pick: Vec<usize>| Configuration {
        choice: base.clone().under(choice(&varied, &pick)),
        preset: None,
        pick,
    };
    let mut list: Vec<Configuration> = picks.into_iter().map(configuration).collect();
    for preset in document.root.get("presets").and_then(Value::entries).unwrap_or_default() {
        let values = of_preset(document, &preset.key, preset.key_span, &mut Diagnostics::new());
        if !values.parameters.is_empty() || !values.features.is_empty() {
            let choice = values.under(base.clone());
            list.push(Configuration { choice, preset: Some(preset.key.clone()), pick: Vec::new() });
        }
    }
    FeatureConfigurations {
        list,
        number: count(&varied),
        cover,
        names: varied.iter().map(|each| each.name.clone()).collect(),
        values: varied.into_iter().map(|each| each.values).collect(),
    }
}

impl FeatureConfigurations {
    /// The caller's configuration alone.
    pub fn one(base: &Choice) -> Self {
        let only = Configuration { choice: base.clone(), preset: None, pick: Vec::new() };
        Self { list: vec![only], number: Count { number: 1, exact: true }, ..Self::default() }
    }

    /// Which configurations those at these (increasing) positions are, in words; `None` where they are all.
    pub fn describe(&self, found: &[usize]) -> Option<String> {
        let all = self.list.len();
        let first = found.first().filter(|_| found.len() < all).and_then(|first| self.list.get(*first))?;
        let checked = if self.cover == Cover::All { "" } else { "checked " };
        let text = format!("in {} of {all} {checked}configurations", found.len());
        if let Some(preset) = &first.preset {
            return Some(format!("{text}: with --preset {preset}"));
        }
        let changes: Vec<String> = first
            .pick
            .iter()
            .enumerate()
            .filter(|(_, value)| **value > 0)
            .map(|(at, value)| self.write(at, *value))
            .collect();
        Some(match (changes.as_slice(), self.cause(found)) {
            ([], None) => format!("{text}, the default one among them"),
            ([], Some(cause)) => format!("{text}: with {cause}, which are the defaults"),
            (changes, _) => format!("{text}; the fewest choices that show it: {}", changes.join(", ")),
        })
    }

    fn write(&self, at: usize, value: usize) -> String {
        let value = self.values.get(at).and_then(|values| values.get(value)).map(Value::to_json);
        let text = match value {
            Some(serde_json::Value::String(word)) => word,
            Some(value) => value.to_string(),
            None => String::new(),
        };
        format!("{}={text}", self.names.get(at).map_or("", String::as_str))
    }

    /// One or two default values that are in these configurations and in no others.
    fn cause(&self, found: &[usize]) -> Option<String> {
        let found: BTreeSet<usize> = found.iter().copied().collect();
        let explains = |features: &[usize]| {
            let features_list = self.list.iter().enumerate().filter(|(_, one)| !one.pick.is_empty());
            features_list.into_iter().all(|(at, one)| {
                let holds = features.iter().all(|feature| one.pick.get(*feature) == Some(&0));
                holds == found.contains(&at)
            })
        };
        let count = self.names.len().min(MAXIMUM_PAIRED);
        let single = (0..count).find(|feature| explains(&[*feature])).map(|feature| vec![feature]);
        let pair = || {
            (0..count)
                .flat_map(|one| (one + 1..count).map(move |two| vec![one, two]))
                .find(|pair| explains(pair))
        };
        let names = single.or_else(pair)?;
        Some(names.into_iter().map(|at| self.write(at, 0)).collect::<Vec<_>>().join(", "))
    }
}

/// The features with their values, the default or what the caller gives first; the latter has no others.
fn varied(document: &Document, base: &Choice, profile: &TargetProfile) -> Vec<Varied> {
    let entries = document.root.get("features").and_then(Value::entries).unwrap_or_default();
    let mut varied: BTreeMap<&str, Varied> = BTreeMap::new();
    for entry in entries {
        let Ok(declaration) = entry.value.decode::<FeatureDeclaration>() else {
            continue;
        };
        let given = base.features.iter().rev().find(|setting| setting.name == entry.key);
        let values = match given {
            Some(setting) => vec![setting.value.clone()],
            None => feature_values(&declaration, entry, entries, profile),
        };
        let name = entry.key.clone();
        varied.insert(&entry.key, Varied { name, values, feature: Some(declaration), exhaustive: true });
    }
    varied.into_values().collect()
}

/// What features demand of one another, by their positions.
struct Rules {
    /// Whether each value of each feature means that it is on.
    on: Vec<Vec<bool>>,
    /// Of each feature those that it requires; `None` for one that is not declared.
    requires: Vec<Vec<Option<usize>>>,
    excludes: Vec<Vec<usize>>,
    /// Groups of which exactly one is on.
    groups: Vec<Vec<usize>>,
}

impl Rules {
    fn new(varied: &[Varied]) -> Self {
        let position = |name: &String| varied.iter().position(|each| each.name == *name);
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (at, each) in varied.iter().enumerate() {
            if let Some(group) = each.group() {
                groups.entry(group).or_default().push(at);
            }
        }
        let declarations = || varied.iter().filter_map(|each| each.feature.as_ref());
        Self {
            groups: groups.into_values().collect(),
            on: varied
                .iter()
                .map(|each| each.values.iter().map(|value| each.is_on(value)).collect())
                .collect(),
            requires: declarations().map(|each| each.requires.iter().map(position).collect()).collect(),
            excludes: declarations()
                .map(|each| each.excludes.iter().filter_map(position).collect())
                .collect(),
        }
    }

    fn len(&self) -> usize {
        self.on.len()
    }

    fn is_on(&self, at: usize, pick: &[Option<usize>]) -> Option<bool> {
        let value = (*pick.get(at)?)?;
        self.on.get(at)?.get(value).copied()
    }

    /// Whether the values chosen so far contradict one another.
    fn contradict(&self, pick: &[Option<usize>]) -> bool {
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

/// The configurations to check, the plain one first, and how much of all they are.
fn picks(rules: &Rules) -> (Vec<Vec<usize>>, Cover) {
    let plain = vec![0; rules.len()];
    let changes = |pick: &Vec<usize>| pick.iter().filter(|value| **value > 0).count();
    let mut search = All { rules, found: Vec::new(), steps: 0 };
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
    let singles = (0..rules.len()).flat_map(|at| (1..rules.on[at].len()).map(move |value| (at, value)));
    for (at, value) in singles {
        let mut pick = plain.clone();
        pick[at] = value;
        let whole: Vec<Option<usize>> = pick.iter().copied().map(Some).collect();
        if list.len() < MAXIMUM && !rules.contradict(&whole) && seen.insert(pick.clone()) {
            list.push(pick);
        }
    }
    if rules.len() > MAXIMUM_PAIRED {
        return (list, Cover::Some);
    }
    let mut pairs = Pairs::new(rules);
    list.iter().for_each(|pick| pairs.cover(pick));
    let mut cover = Cover::Pairs;
    while let Some(pair) = pairs.open.first().copied() {
        if list.len() >= MAXIMUM {
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

/// The search for all configurations, depth first.
struct All<'r> {
    rules: &'r Rules,
    found: Vec<Vec<usize>>,
    steps: usize,
}

impl All<'_> {
    /// Whether all were found: they are not too many, and the search did not take too long.
    fn extend(&mut self, pick: &mut Vec<Option<usize>>, at: usize) -> bool {
        let Some(values) = self.rules.on.get(at) else {
            self.found.push(pick.iter().map(|value| value.unwrap_or(0)).collect());
            return self.found.len() <= MAXIMUM;
        };
        for value in 0..values.len() {
            self.steps += 1;
            pick[at] = Some(value);
            if self.steps > MAXIMUM_STEPS || (!self.rules.contradict(pick) && !self.extend(pick, at + 1)) {
                return false;
            }
        }
        pick[at] = None;
        true
    }
}

/// A feature and one of its values.
type Chosen = (usize, usize);

/// The pairs of values that no configuration shows yet.
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

    /// A configuration that shows a pair, and greedily as many others as it can.
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
            if *steps > MAXIMUM_STEPS {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;

    #[test]
    fn what_the_profile_has_no_room_for_is_off_with_all_that_requires_it() {
        let features = |most: u32| {
            format!(
                "\"big\": {{ \"type\": \"bool\", \"default\": true, \
                   \"required_limits\": {{ \"max_texture_dimension_2d\": {most} }} }}, \
                 \"bigger\": {{ \"type\": \"enum\", \"values\": [\"x\", \"y\"], \"default\": \"y\", \"requires\": [\"big\"] }}, \
                 \"other\": {{ \"type\": \"bool\", \"default\": false }}"
            )
        };
        let there = configurations(&features(8192));
        assert_eq!((there.list.len(), there.number.number), (6, 6));
        let lacking = configurations(&features(8193));
        assert_eq!((lacking.list.len(), lacking.number.number), (2, 2));
        assert_eq!(lacking.values[0].iter().map(Value::to_json).collect::<Vec<_>>(), [false]);
        assert_eq!(lacking.values[1].iter().map(Value::to_json).collect::<Vec<_>>(), ["x"]);
    }

    fn configurations(features: &str) -> FeatureConfigurations {
        let mut sources = Sources::new();
        let file = sources.add("t", format!("{{ \"features\": {{ {features} }} }}"));
        let document = crate::document::parse(&sources, file).unwrap();
        feature_configurations(&document, &Choice::default(), &TargetProfile::webgpu())
    }

    fn switches(count: usize) -> String {
        let one = |at: usize| format!("\"f{at:02}\": {{ \"type\": \"bool\", \"default\": false }}");
        (0..count).map(one).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn few_features_are_combined_in_full_and_the_forbidden_is_left_out() {
        assert_eq!(configurations(&switches(3)).list.len(), 8);
        let tied = configurations(
            "\"a\": { \"type\": \"bool\", \"default\": true }, \
             \"b\": { \"type\": \"bool\", \"default\": false, \"requires\": [\"a\"] }, \
             \"c\": { \"type\": \"enum\", \"values\": [\"x\", \"y\"], \"default\": \"x\", \"excludes\": [\"b\"] }",
        );
        assert_eq!((tied.list.len(), tied.cover), (5, Cover::All));
        assert_eq!(tied.number, Count { number: 5, exact: true });
    }

    #[test]
    fn of_a_group_exactly_one_feature_is_on() {
        let member = |name: &str, on: bool| {
            format!("\"{name}\": {{ \"type\": \"bool\", \"default\": {on}, \"one_of\": \"g\" }}")
        };
        let text = [member("a", true), member("b", false), member("c", false), switches(1)].join(", ");
        let grouped = configurations(&text);
        assert_eq!((grouped.list.len(), grouped.number), (6, Count { number: 6, exact: true }));
        let text = [text, switches(12).replace("\"f", "\"g")].join(", ");
        let grouped = configurations(&text);
        assert_eq!(grouped.cover, Cover::Pairs);
        let ons = |each: &Configuration| {
            each.pick[..3].iter().zip([1, 0, 0]).filter(|(a, b)| (**a == 0) == (*b == 1)).count()
        };
        assert!(grouped.list.iter().all(|each| ons(each) == 1));
    }

    #[test]
    fn many_features_are_covered_pair_by_pair() {
        let many = configurations(&switches(20));
        assert_eq!(many.cover, Cover::Pairs);
        assert_eq!(many.number.number, 1 << 20);
        assert!(many.list.len() <= 40, "{}", many.list.len());
        for one in 0..20 {
            for two in one + 1..20 {
                for values in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                    let shown = many.list.iter().any(|each| [each.pick[one], each.pick[two]] == values);
                    assert!(shown, "features {one} and {two} are never {values:?}");
                }
            }
        }
    }

    #[test]
    fn what_some_configurations_show_is_told_with_the_fewest_choices() {
        let three = configurations(&switches(3));
        let with = |wanted: &dyn Fn(&[usize]) -> bool| -> Vec<usize> {
            (0..8).filter(|at| wanted(&three.list[*at].pick)).collect()
        };
        assert_eq!(three.describe(&with(&|_| true)), None);
        assert_eq!(
            three.describe(&with(&|pick| pick[0] == 1 && pick[2] == 1)).unwrap(),
            "in 2 of 8 configurations; the fewest choices that show it: f00=true, f02=true"
        );
        assert_eq!(
            three.describe(&with(&|pick| pick[1] == 0)).unwrap(),
            "in 4 of 8 configurations: with f01=false, which are the defaults"
        );
    }
}
