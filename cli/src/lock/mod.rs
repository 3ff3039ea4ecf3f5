//! `permutations.lock`: the shaders that pipelines reach, as a text to commit.
//!
//! A change of a pipeline or a template can multiply what is compiled and shipped, and nobody sees it in review. The
//! lock holds, for each pass and profile, the values of the axes, the counts, and a hash of all texts; its difference in
//! a pull request says what the change adds ([`difference`] in words). `--locked` holds a run to it.
//!
//! Only figures that follow from documents and templates are in it: not what had to be proven, which depends on the
//! cache, and not the number of configurations, which is a lower bound. There is no sum over pipelines or passes, so
//! changes of two passes merge without a conflict.

mod difference;
mod file;
mod text;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use umbragraph::low_level::shader::AxisValue;
use umbragraph::low_level::shader::permutations::{Count, TemplateReport};

pub(crate) use difference::{Change, difference};
pub(crate) use file::{LockFile, PassPlaces, hold, read, update};
use text::Parsed;

/// The program of a pass: the name of the pass, and the template.
pub(crate) type Program = (String, String);

/// The shaders that pipelines reach, by the paths of the pipelines.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Lock {
    pub(crate) pipelines: BTreeMap<String, Pipeline>,
}

/// The shaders that one pipeline reaches.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<Section>", into = "Vec<Section>")]
pub(crate) struct Pipeline {
    pub(crate) programs: BTreeMap<Program, BTreeMap<String, Texts>>,
}

/// All texts of a pass for a profile.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Texts {
    /// The values of the axes that the texts read.
    pub(crate) axes: BTreeMap<String, BTreeSet<AxisValue>>,
    /// The number of combinations of values, as it is printed: it may be a lower bound.
    pub(crate) combinations: String,
    /// The number of distinct texts.
    pub(crate) texts: usize,
    /// The number of distinct declarations in them: what proving costs.
    pub(crate) declarations: usize,
    /// The bytes of all distinct texts.
    pub(crate) bytes: usize,
    /// The hash of all distinct texts.
    pub(crate) hash: String,
}

/// Passes and profiles that reach the same texts; the form in which a lock is written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Section {
    pub(crate) passes: BTreeSet<String>,
    pub(crate) template: String,
    pub(crate) profiles: BTreeSet<String>,
    #[serde(flatten)]
    pub(crate) texts: Texts,
}

/// Passes that have a program, and the request that proves texts of it.
#[derive(Clone, Debug)]
pub(crate) struct Reaching {
    pub(crate) passes: Vec<String>,
    pub(crate) template: String,
    pub(crate) profiles: Vec<String>,
    pub(crate) request: usize,
}

impl Pipeline {
    /// The programs of passes, of the reports on the requests.
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
                Texts::new(requests.iter().filter_map(|request| by_request.get(request).copied()))
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

    /// The passes and profiles that reach the same, together.
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

    /// The profiles of all passes.
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
    fn new<'r>(reports: impl Iterator<Item = &'r TemplateReport>) -> Self {
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
        Self {
            axes,
            combinations: combinations.to_string(),
            texts: bytes_of.len(),
            declarations: declarations.len(),
            bytes: bytes_of.values().sum(),
            hash: hash.as_str().chars().take(16).collect(),
        }
    }
}
