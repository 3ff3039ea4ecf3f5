//! All configurations of a pipeline at once: what `check` says.

use std::collections::HashSet;
use std::sync::{Arc, PoisonError};

use crate::cancel::{Cancel, Cancelled};
use crate::choice::written;
use crate::done::Done;
use crate::graph::compiler::{Plan, PlanOptions};
use crate::graph::diagnostic::{Code, Diagnostic, Diagnostics, Place};
use crate::graph::pipeline::{Configurations, Overrides};
use crate::graph::shader::TargetProfile;
use crate::graph::shader::permutations::{self, Count, Request};
use crate::graph::source::Sources;
use crate::graph::{CheckOptions, Coverage, Examination, Verify, check_configurations};
use crate::loaded::Loaded;
use crate::templates::{Proof, Reached};

/// Further checks of the plans for a profile, such as a dry run.
pub type Judges<'a> = &'a mut dyn FnMut(&TargetProfile) -> Box<dyn FnMut(&Arc<Plan>) -> Diagnostics>;

/// Sets of variants whose proofs are kept.
const KEPT_PROOFS: usize = 16;

/// The settings of a check of all configurations of a pipeline.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Survey {
    /// The target profiles to check.
    pub profiles: Vec<TargetProfile>,
    /// Values that every configuration has.
    pub overrides: Overrides,
    /// The options of the plans.
    pub plan: PlanOptions,
    /// Whether only the configuration of the overrides is checked.
    pub only_one: bool,
    /// An independent algorithm that verifies each plan; `None` skips this.
    pub verify: Option<Verify>,
    /// The number of threads that validate shaders.
    pub threads: usize,
}

impl Survey {
    /// Creates a survey of all configurations, with shaders validated by one thread.
    pub fn new(profiles: Vec<TargetProfile>, plan: PlanOptions) -> Self {
        let overrides = Overrides::default();
        Self { profiles, overrides, plan, only_one: false, verify: None, threads: 1 }
    }

    /// Sets values that every configuration has.
    #[must_use]
    pub fn overrides(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }

    /// Whether only the configuration of these values is checked.
    #[must_use]
    pub fn only_one(self, only_one: bool) -> Self {
        Self { only_one, ..self }
    }

    /// Sets a second algorithm that checks each plan.
    #[must_use]
    pub fn verify(self, verify: Option<Verify>) -> Self {
        Self { verify, ..self }
    }

    /// Sets the number of threads that validate shaders.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// The cache key of the survey. The number of threads is not part of it, since it does not change the answer.
    pub(crate) fn key(&self) -> String {
        let Self { profiles, overrides, plan, only_one, verify, threads: _ } = self;
        format!("{profiles:?}{}{plan:?}{only_one}{}", written(overrides), verify.is_some())
    }
}

/// The results of checking the configurations of a pipeline.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Surveyed {
    /// Variants, violations and remarks; of profiles together.
    pub coverage: Coverage,
    /// The configurations of the profile with the most.
    pub configurations: Configurations,
    /// The names of the profiles.
    pub profiles: Vec<String>,
    /// The number of configurations that differ in their shaders or passes, with all values of parameters; `None` if
    /// only one configuration was requested.
    pub reachable: Option<Count>,
    /// The diagnostics, besides those of [`Loaded`].
    pub diagnostics: Diagnostics,
}

/// Plans a pipeline in every configuration for each profile, and proves its shaders; `None` for files that are no
/// document, and without profiles.
pub(crate) fn survey(
    loaded: &Loaded,
    survey: &Survey,
    judges: Judges<'_>,
    sources: &Sources,
    (done, cancel): (&mut Done, &Cancel),
) -> Result<Option<Surveyed>, Cancelled> {
    let Survey { profiles, overrides, plan, only_one, verify, .. } = survey;
    let Some((document, model)) = loaded.document().zip(loaded.model()) else { return Ok(None) };
    let mut found = New::default();
    let mut widest = Configurations::default();
    let mut first: Option<Coverage> = None;
    let mut reached = Reached::new();
    for (at, profile) in profiles.iter().enumerate() {
        let configurations = if *only_one {
            Configurations::one(overrides)
        } else {
            Configurations::of_features(document, overrides, profile)
        };
        let (registry, templates) = (loaded.registry(), loaded.templates());
        let options = CheckOptions { registry, templates, profile, overrides, plan };
        let mut judge = judges(profile);
        let mut diagnostics = Diagnostics::new();
        let shaders = loaded.kept_templates().shaders(profile);
        let rendered = shaders.rendered();
        let mut coverage = check_configurations(
            document,
            &options,
            Examination {
                configurations: &configurations,
                model,
                shaders: &shaders,
                verify: *verify,
                judge: &mut *judge,
                cancelled: cancel.flag(),
            },
            sources,
            &mut diagnostics,
        );
        cancel.check()?;
        done.rendered += shaders.rendered() - rendered;
        done.loaded += configurations.list.len();
        done.planned += configurations.list.len();
        found.extend(diagnostics);
        for variant in &coverage.variants {
            reached.entry(variant.clone()).or_default().push(at);
        }
        match &mut first {
            Some(first) => {
                first.variants.append(&mut coverage.variants);
                coverage.violations.retain(|violation| !first.violations.contains(violation));
                first.violations.append(&mut coverage.violations);
            }
            None => first = Some(coverage),
        }
        // Profiles that lack what features require have fewer.
        if configurations.list.len() > widest.list.len() {
            widest = configurations;
        }
    }
    let Some(coverage) = first else { return Ok(None) };
    found.extend(proven(loaded, &reached, survey, (done, cancel))?);
    let reachable = profiles
        .first()
        .filter(|_| !only_one)
        .map(|profile| Configurations::all((document, model), loaded.templates(), profile).number);
    let profiles = profiles.iter().map(|profile| profile.name.clone()).collect();
    Ok(Some(Surveyed { coverage, configurations: widest, profiles, reachable, diagnostics: found.all }))
}

/// Diagnostics; what holds for several profiles is said once.
#[derive(Default)]
struct New {
    all: Diagnostics,
    known: HashSet<(Code, Place, String)>,
}

impl New {
    fn extend(&mut self, diagnostics: Diagnostics) {
        let is_new = |new: &Diagnostic| !self.known.contains(&new.key());
        let new: Vec<_> = diagnostics.into_iter().filter(is_new).collect();
        self.known.extend(new.iter().map(Diagnostic::key));
        self.all.extend(new);
    }
}

/// Holds shader variants to the limits of each profile whose configurations reach them, and to the writers of its
/// language. A feature that a profile lacks is off there, and so are the variants that only it reaches.
fn proven(
    loaded: &Loaded,
    variants: &Reached,
    survey: &Survey,
    (done, cancel): (&mut Done, &Cancel),
) -> Result<Diagnostics, Cancelled> {
    let templates = loaded.kept_templates();
    let profiles = &survey.profiles;
    let is_it = |proof: &&Proof| proof.variants == *variants && proof.profiles == *profiles;
    let proofs = || templates.proofs.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = proofs().iter().find(is_it) {
        return Ok(known.diagnostics.clone());
    }
    done.proven += 1;
    let requests: Vec<Request> = variants
        .iter()
        .map(|((template, axes), reaching)| {
            let reaching: Vec<TargetProfile> = reaching.iter().map(|at| profiles[*at].clone()).collect();
            Request::one(&templates.set, template, axes, &reaching)
        })
        .collect();
    let (threads, cancelled) = (survey.threads, cancel.flag());
    let options = permutations::Options { threads, cancelled, ..permutations::Options::default() };
    let diagnostics = permutations::check(&templates.set, &requests, &options).diagnostics;
    cancel.check()?;
    let proof =
        Proof { variants: variants.clone(), profiles: profiles.clone(), diagnostics: diagnostics.clone() };
    let mut proofs = proofs();
    proofs.insert(0, proof);
    proofs.truncate(KEPT_PROOFS);
    Ok(diagnostics)
}
