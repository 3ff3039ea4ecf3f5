//! [`Target`] and [`Choice`]: what a session is asked about.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::graph::compiler::PlanOptions;
use crate::graph::pipeline::{Override, Overrides};
use crate::graph::shader::TargetProfile;

/// A pipeline to be answered about: the path of its file, and the extensions that are added to it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct Target {
    /// The path of the pipeline file.
    pub path: PathBuf,
    /// The paths of extension files, in the order in which they are added.
    pub extensions: Vec<PathBuf>,
    /// A document that is included after the extensions, as its name and text.
    pub included: Option<(String, String)>,
}

impl Target {
    /// Creates a target for a pipeline file without extensions.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), ..Self::default() }
    }

    /// Sets the extension files.
    #[must_use]
    pub fn extensions(self, extensions: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { extensions: extensions.into_iter().collect(), ..self }
    }

    /// Includes a further document, given as text.
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
    /// Resources that the host reads between frames, as if the pipeline declared them `exposed`.
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

    /// Sets the resources that the host reads between frames.
    #[must_use]
    pub fn exposed(self, exposed: BTreeSet<String>) -> Self {
        Self { exposed, ..self }
    }

    /// The inputs of a load besides the document and the templates.
    pub(crate) fn configuration(&self) -> Configuration {
        Configuration {
            profile: self.profile.clone(),
            overrides: written(&self.overrides),
            exposed: self.exposed.clone(),
        }
    }
}

/// The inputs of a load besides the document and the templates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Configuration {
    profile: TargetProfile,
    overrides: String,
    exposed: BTreeSet<String>,
}

/// Overrides as a text that is the same where they are, places included.
pub(crate) fn written(overrides: &Overrides) -> String {
    let mut text = String::new();
    let mut write = |kind: char, Override { name, value, place }: &Override| {
        let _ = writeln!(text, "{kind}{name:?}{place:?}{:?}{}", value.span, value.to_json());
    };
    overrides.parameters.iter().for_each(|one| write('p', one));
    overrides.features.iter().for_each(|one| write('f', one));
    text
}
