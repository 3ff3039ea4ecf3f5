//! [`Target`] and [`Choice`]: what a session is asked about.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::graph::compiler::PlanOptions;
use crate::graph::pipeline::{Override, Overrides};
use crate::graph::shader::TargetProfile;

/// A pipeline that a session is to load: the path of its file, and documents that are added to it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct Target {
    /// The path of the pipeline file.
    pub path: PathBuf,
    /// The paths of extension files, in the order in which they are added.
    pub extensions: Vec<PathBuf>,
    /// The name and text of a document that is included after the extensions; `None` if there is none.
    pub included: Option<(String, String)>,
}

impl Target {
    /// Creates a target for a pipeline file without extensions.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), ..Self::default() }
    }

    /// Sets the paths of extension files, in the order in which they are added.
    #[must_use]
    pub fn extensions(self, extensions: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { extensions: extensions.into_iter().collect(), ..self }
    }

    /// Sets a document that is included after the extensions, given as name and text.
    #[must_use]
    pub fn include(self, name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { included: Some((name.into(), text.into())), ..self }
    }
}

/// One configuration of a pipeline, with the target profile and options of its plan.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Choice {
    /// The target profile.
    pub profile: TargetProfile,
    /// Values of parameters and features; a later value overrides an earlier one.
    pub overrides: Overrides,
    /// The options of the plan.
    pub plan: PlanOptions,
    /// The names of resources that the host reads between frames, as if the pipeline declared them `exposed`.
    pub exposed: BTreeSet<String>,
}

impl Choice {
    /// Creates a choice of the pipeline's default values, for a profile.
    pub fn new(profile: TargetProfile, plan: PlanOptions) -> Self {
        Self { profile, overrides: Overrides::default(), plan, exposed: BTreeSet::new() }
    }

    /// Sets the values of parameters and features.
    #[must_use]
    pub fn overrides(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }

    /// Sets the names of the resources that the host reads between frames.
    #[must_use]
    pub fn exposed(self, exposed: BTreeSet<String>) -> Self {
        Self { exposed, ..self }
    }

    /// Returns the part of the choice that identifies a cached plan: profile, overrides and exposed resources.
    pub(crate) fn configuration(&self) -> Configuration {
        Configuration {
            profile: self.profile.clone(),
            overrides: written(&self.overrides),
            exposed: self.exposed.clone(),
        }
    }
}

/// The part of a [`Choice`] that identifies a cached plan: profile, overrides and exposed resources.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Configuration {
    profile: TargetProfile,
    overrides: String,
    exposed: BTreeSet<String>,
}

/// Formats overrides as a string for use in cache keys. Equal strings mean equal values, given at the same source
/// places.
pub(crate) fn written(overrides: &Overrides) -> String {
    let mut text = String::new();
    let mut write = |kind: char, Override { name, value, place }: &Override| {
        let _ = writeln!(text, "{kind}{name:?}{place:?}{:?}{}", value.span, value.to_json());
    };
    overrides.parameters.iter().for_each(|one| write('p', one));
    overrides.features.iter().for_each(|one| write('f', one));
    text
}
