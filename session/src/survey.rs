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

/// A function that returns, for a target profile, a further check of each plan, such as a dry run on a device.
pub type Judges<'a> = &'a mut dyn FnMut(&TargetProfile) -> Box<dyn FnMut(&Arc<Plan>) -> Diagnostics>;

/// The maximum number of sets of shader variants whose validation results are cached.
const KEPT_PROOFS: usize = 16;

/// The settings of a check of all configurations of a pipeline.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Survey {
    /// The target profiles to check.
    pub profiles: Vec<TargetProfile>,
    /// Values of parameters and features that all checked configurations have in common.
    pub overrides: Overrides,
    /// The options of the plans, such as the viewport size.
    pub plan: PlanOptions,
    /// Whether only one configuration is checked, with the values of `overrides`; `false` checks all.
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

    /// Sets the values of parameters and features that all checked configurations have in common.
    #[must_use]
    pub fn overrides(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }

    /// Sets whether only one configuration is checked, with the values of the overrides; `false` checks all.
    #[must_use]
    pub fn only_one(self, only_one: bool) -> Self {
        Self { only_one, ..self }
    }

    /// Sets an independent algorithm that verifies each plan; `None` skips this.
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
    /// The coverage of the first profile, with the shader variants and verifier violations of all profiles.
    pub coverage: Coverage,
    /// The checked configurations of one profile: the one that has the most of them.
    pub configurations: Configurations,
    /// The names of the checked target profiles.
    pub profiles: Vec<String>,
    /// The number of configurations of the first profile that can differ in their shaders or passes, over all values of
    /// parameters and features. `None` if only one configuration was requested.
    pub reachable: Option<Count>,
    /// The diagnostics of the check, besides those of [`Loaded::diagnostics`].
    pub diagnostics: Diagnostics,
}

/// Plans a pipeline in every configuration for each profile, and validates its shader variants. Returns `None` if a
/// file of the pipeline is broken or missing, or if there are no profiles.
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

/// Diagnostics without duplicates: a diagnostic that several profiles have in common is kept once.
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

/// Validates shader variants for every profile whose configurations use them: checks the profile's limits, and
/// translates the variants to its shading language. Features that a profile lacks are off, so variants that need them
/// are not validated for it.
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
