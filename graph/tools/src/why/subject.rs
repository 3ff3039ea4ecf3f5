//! Pipelines that are asked about, and the kinds of things in them.

use serde::Serialize;

use crate::check::CheckReport;
use umbragraph_pipeline::compose::Composed;
use umbragraph_pipeline::model::Model;
use umbragraph_pipeline::pipeline::Overrides;
use umbragraph_pipeline::source::Sources;

/// A pipeline that is asked about.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Its document.
    pub composed: &'a Composed,
    /// The names and strings of the document.
    pub model: &'a Model,
    /// The overrides of parameters and features, the last over the first.
    pub overrides: &'a Overrides,
    /// The report of the check.
    pub checked: &'a CheckReport,
    /// The texts.
    pub sources: &'a Sources,
}

/// The kinds of things that have names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A pass, a loop of passes, or a use of a subgraph.
    Pass,
    /// A resource.
    Resource,
    /// A parameter, of the pipeline or of one use of a subgraph.
    Parameter,
    /// A feature.
    Feature,
    /// A derived value, of the pipeline or of one use of a subgraph.
    Derived,
    /// A toggle.
    Toggle,
    /// A preset.
    Preset,
    /// A group of shared settings.
    SharedSettings,
    /// A subgraph.
    Subgraph,
    /// An input of a use of a subgraph.
    Input,
    /// A point for extensions.
    ExtensionPoint,
    /// A contract with the host's draws.
    Geometry,
}

impl Kind {
    /// The word, with its article.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Pass => "a pass",
            Kind::Resource => "a resource",
            Kind::Parameter => "a parameter",
            Kind::Feature => "a feature",
            Kind::Derived => "a derived value",
            Kind::Toggle => "a toggle",
            Kind::Preset => "a preset",
            Kind::SharedSettings => "a group of shared settings",
            Kind::Subgraph => "a subgraph",
            Kind::Input => "an input",
            Kind::ExtensionPoint => "an extension point",
            Kind::Geometry => "a geometry",
        }
    }
}
