//! Pipelines that are asked about, and the kinds of things in them.

use serde::Serialize;

use crate::check::CheckReport;
use umbragraph_pipeline::compose::Composed;
use umbragraph_pipeline::model::Model;
use umbragraph_pipeline::pipeline::Overrides;
use umbragraph_pipeline::source::Sources;

/// A checked pipeline whose named parts can be explained.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The pipeline document, composed of all its files.
    pub composed: &'a Composed,
    /// The declarations and strings of the document, with the resolved uses of names.
    pub model: &'a Model,
    /// The caller's values of parameters and features; a later value replaces an earlier one.
    pub overrides: &'a Overrides,
    /// The results of checking the pipeline.
    pub checked: &'a CheckReport,
    /// The texts of the source files.
    pub sources: &'a Sources,
}

/// The kind of a named part of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A pass, a loop of passes, or a use of a subgraph.
    Pass,
    /// A texture, a buffer or data on the CPU.
    Resource,
    /// A parameter, of the pipeline or of one use of a subgraph.
    Parameter,
    /// A feature: a boolean or an enumeration that chooses shader variants and passes.
    Feature,
    /// A derived value, of the pipeline or of one use of a subgraph.
    Derived,
    /// A runtime toggle that the host can switch in each frame.
    Toggle,
    /// A preset: a named set of values of parameters and features.
    Preset,
    /// A named group of settings that passes can share.
    SharedSettings,
    /// A subgraph: a reusable group of passes.
    Subgraph,
    /// An input of a use of a subgraph.
    Input,
    /// A named point between passes at which extension files can insert passes.
    ExtensionPoint,
    /// The vertex inputs and bindings that the host's draws provide.
    Geometry,
}

impl Kind {
    /// The kind in words with its article, such as "a pass".
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
