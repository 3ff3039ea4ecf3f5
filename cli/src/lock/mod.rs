//! `permutations.lock`: the shaders that pipelines reach, as a text to commit.
//!
//! A change of a pipeline or a template can multiply what is compiled and shipped, and nobody sees it in review. The
//! lock holds, for each pass and profile, the values of the axes, the counts, and a hash of all texts; its difference
//! in a pull request says what the change adds ([`difference`] in words). `--locked` holds a run to it.
//!
//! Only figures that follow from documents and templates are in it: not what had to be proven, which depends on the
//! cache, and not the number of configurations, which is a lower bound. There is no sum over pipelines or passes, so
//! changes of two passes merge without a conflict.

mod difference;
mod file;
mod text;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use umbragraph::low_level::shader::permutations::{Count, TemplateReport, VariantReport};
use umbragraph::low_level::shader::{AxisValue, AxisValues};

pub(crate) use difference::{Change, difference};
pub(crate) use file::{DEFAULT, LockFile, PassPlaces, Shown, hold, read, update};
use text::Parsed;
pub(crate) use text::with_values;

/// The key of a pass's shaders: the name of the pass and of its template.
pub(crate) type Program = (String, String);

/// The reachable shaders of pipelines, by the paths of the pipelines.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Lock {
    pub(crate) pipelines: BTreeMap<String, Pipeline>,
}

/// The reachable shaders of one pipeline, by pass and template, then by profile.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<Section>", into = "Vec<Section>")]
pub(crate) struct Pipeline {
    pub(crate) programs: BTreeMap<Program, BTreeMap<String, Texts>>,
}

/// Figures of all shader sources of a pass for a profile.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Texts {
    /// The values of the axes that the shader sources depend on.
    pub(crate) axes: BTreeMap<String, BTreeSet<AxisValue>>,
    /// The number of combinations of axis values, as it is printed: it may be a lower bound.
    pub(crate) combinations: String,
    /// The number of distinct shader sources.
    pub(crate) texts: usize,
    /// The number of distinct declarations in the shader sources, on which the cost of validation depends.
    pub(crate) declarations: usize,
    /// The total size in bytes of all distinct shader sources.
    pub(crate) bytes: usize,
    /// The hash of all distinct shader sources.
    pub(crate) hash: String,
    /// The size in bytes of the largest shader source.
    pub(crate) largest: usize,
    /// The largest number of bindings in a shader source.
    pub(crate) bindings: usize,
    /// The largest estimated number of registers of an entry point.
    pub(crate) registers: u64,
    pub(crate) worst: Worst,
}

/// A figure of shader sources: its name, and the function that returns its value.
pub(crate) type Figure = (&'static str, fn(&Texts) -> u64);

/// The most expensive entry point of a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Worst {
    pub(crate) cost: u64,
    pub(crate) entry_point: String,
    /// The axis values that cause the cost: every variant with another value costs at least a tenth less.
    pub(crate) values: AxisValues,
}

/// Passes and profiles that reach the same shader sources: one section of a lock file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Section {
    pub(crate) passes: BTreeSet<String>,
    pub(crate) template: String,
    pub(crate) profiles: BTreeSet<String>,
    #[serde(flatten)]
    pub(crate) texts: Texts,
}

/// Passes that share a template and profiles, and the index of the validation request for them.
#[derive(Clone, Debug)]
pub(crate) struct Reaching {
    pub(crate) passes: Vec<String>,
    pub(crate) template: String,
    pub(crate) profiles: Vec<String>,
    pub(crate) request: usize,
}

impl Pipeline {
    /// Collects the shaders of passes from the reports on the validation requests.
    pub(crate) fn new(reaching: &[Reaching], reports: &[TemplateReport]) -> Self {
        let by_request: BTreeMap<usize, &TemplateReport> =
            reports.iter().map(|report| (report.request, report)).collect();
        let mut requests: BTreeMap<Program, BTreeMap<String, BTreeSet<usize>>> = BTreeMap::new();
        for Reaching { passes, template, profiles, request } in reaching {
            for (pass, profile) in passes.iter().flat_map(|pass| profiles.iter().map(move |one| (pass, one)))
            {
                let program = requests.entry((pass.clone(), template.clone())).or_default();
                program.entry(profile.clone()).or_default().insert(*request);
            }
        }
        // Most passes share the texts of others, and all profiles mostly do.
        let mut known: BTreeMap<BTreeSet<usize>, Texts> = BTreeMap::new();
        let mut texts = |requests: BTreeSet<usize>| {
            let make = |requests: &BTreeSet<usize>| {
                let reports = requests.iter().filter_map(|request| by_request.get(request).copied());
                Texts::new(&reports.collect::<Vec<_>>())
            };
            if let Some(texts) = known.get(&requests) {
                return texts.clone();
            }
            let texts = make(&requests);
            known.insert(requests, texts.clone());
            texts
        };
        let programs = requests.into_iter().map(|(program, profiles)| {
            (program, profiles.into_iter().map(|(profile, of)| (profile, texts(of))).collect())
        });
        Self { programs: programs.collect() }
    }

    /// Groups the passes and profiles that reach the same shader sources.
    pub(crate) fn sections(&self) -> Vec<Section> {
        let mut passes: BTreeMap<(&str, BTreeSet<&str>, &Texts), BTreeSet<String>> = BTreeMap::new();
        for ((pass, template), profiles) in &self.programs {
            let mut alike: BTreeMap<&Texts, BTreeSet<&str>> = BTreeMap::new();
            for (profile, texts) in profiles {
                alike.entry(texts).or_default().insert(profile);
            }
            for (texts, profiles) in alike {
                passes.entry((template, profiles, texts)).or_default().insert(pass.clone());
            }
        }
        let section = |((template, profiles, texts), passes): ((&str, BTreeSet<&str>, &Texts), _)| Section {
            passes,
            template: template.to_owned(),
            profiles: profiles.into_iter().map(str::to_owned).collect(),
            texts: texts.clone(),
        };
        let mut sections: Vec<Section> = passes.into_iter().map(section).collect();
        sections.sort();
        sections
    }

    /// Returns the names of the profiles of all passes.
    pub(crate) fn profiles(&self) -> BTreeSet<&str> {
        self.programs.values().flat_map(|profiles| profiles.keys()).map(String::as_str).collect()
    }
}

impl From<Vec<Section>> for Pipeline {
    fn from(sections: Vec<Section>) -> Self {
        let mut programs: BTreeMap<Program, BTreeMap<String, Texts>> = BTreeMap::new();
        for Section { passes, template, profiles, texts } in sections {
            for pass in passes {
                let program = programs.entry((pass, template.clone())).or_default();
                program.extend(profiles.iter().map(|profile| (profile.clone(), texts.clone())));
            }
        }
        Self { programs }
    }
}

impl From<Pipeline> for Vec<Section> {
    fn from(pipeline: Pipeline) -> Self {
        pipeline.sections()
    }
}

impl Texts {
    fn new(reports: &[&TemplateReport]) -> Self {
        let mut axes: BTreeMap<String, BTreeSet<AxisValue>> = BTreeMap::new();
        let (mut combinations, mut declarations) = (Count::ZERO, BTreeSet::<u64>::new());
        let mut bytes_of: BTreeMap<&str, usize> = BTreeMap::new();
        for report in reports {
            for (axis, values) in &report.values {
                axes.entry(axis.clone()).or_default().extend(values.iter().cloned());
            }
            combinations = combinations.plus(report.covered);
            declarations.extend(&report.declarations);
            bytes_of.extend(report.variants.iter().map(|variant| (variant.hash.as_str(), variant.bytes)));
        }
        let mut hash = blake3::Hasher::new();
        for text in bytes_of.keys() {
            hash.update(text.as_bytes());
        }
        let hash = hash.finalize().to_hex();
        let variants = || reports.iter().flat_map(|report| &report.variants);
        let costs = || variants().flat_map(|variant| variant.costs.values());
        let bindings =
            |variant: &VariantReport| variant.reflection.as_ref().map_or(0, |found| found.bindings.len());
        Self {
            axes,
            combinations: combinations.to_string(),
            texts: bytes_of.len(),
            declarations: declarations.len(),
            bytes: bytes_of.values().sum(),
            hash: hash.as_str().chars().take(16).collect(),
            largest: bytes_of.values().max().copied().unwrap_or_default(),
            bindings: variants().map(bindings).max().unwrap_or_default(),
            registers: costs().map(|cost| cost.registers).max().unwrap_or_default(),
            worst: Worst::of(reports),
        }
    }
}

impl Worst {
    fn of(reports: &[&TemplateReport]) -> Self {
        let Some(worst) = worst(reports) else { return Self::default() };
        let Some((entry_point, cost)) = worst.worst() else { return Self::default() };
        let all = || reports.iter().flat_map(|report| &report.variants);
        // Where a value has no alternative, it is no cause.
        let causes = |(axis, value): &(&str, &AxisValue)| {
            let mut others = all().filter(|other| other.axes.get(axis) != Some(*value)).peekable();
            others.peek().is_some()
                && others
                    .all(|other| other.worst().is_none_or(|(_, less)| is_notable(less.total, cost.total)))
        };
        let values = worst.axes.iter().filter(causes);
        let values = values.map(|(axis, value)| (axis.to_owned(), value.clone())).collect();
        Self { cost: cost.total, entry_point: entry_point.to_owned(), values }
    }
}

/// Returns the most expensive variant; the first one on a tie, `None` if no variant has a cost.
pub(crate) fn worst<'r>(reports: &[&'r TemplateReport]) -> Option<&'r VariantReport> {
    let all = reports.iter().flat_map(|report| &report.variants).filter(|variant| variant.worst().is_some());
    let cost = |variant: &&VariantReport| variant.worst().map_or(0, |(_, cost)| cost.total);
    all.min_by_key(|variant| std::cmp::Reverse(cost(variant)))
}

/// Returns `true` if `less` is smaller than `more` by at least a tenth.
fn is_notable(less: u64, more: u64) -> bool {
    less.saturating_mul(10) <= more.saturating_mul(9) && less < more
}
