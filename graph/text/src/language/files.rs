//! The other files of the language: what an extension, and what a parameter file, can say.
//!
//! Both are composed, or read, section by section; these types are what their schemas say.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    Expr, ExtensionPointDeclaration, FeatureDeclaration, GeometryDeclaration, ParameterDeclaration, Paths,
    PresetDeclaration, ResourceDeclaration, SubgraphDeclaration, ToggleDeclaration,
};

/// An extension: passes for the extension points of a pipeline, and what they need beside what the pipeline has.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtensionDeclaration {
    /// The schema, for editors.
    #[serde(rename = "$schema", default)]
    pub schema: Option<String>,
    /// The file, or files (the lowest first), over which this one is laid: objects are merged, null deletes.
    #[serde(default)]
    pub extends: Option<Paths>,
    /// Files whose sections stand beside this file's own; nothing may stand in both.
    #[serde(default)]
    pub include: Option<Paths>,
    /// The version of the language: 1.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// The extension's name.
    #[serde(default)]
    pub name: Option<String>,
    /// A description for people.
    #[serde(default)]
    pub description: Option<String>,
    /// Named values that a user can set.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterDeclaration>,
    /// Named switches that choose shader variants and passes.
    #[serde(default)]
    pub features: BTreeMap<String, FeatureDeclaration>,
    /// Named values that follow from parameters, features and one another: an expression each.
    #[serde(default)]
    pub derived: BTreeMap<String, Expr>,
    /// Runtime toggles that the host switches from frame to frame, without another plan.
    #[serde(default)]
    pub toggles: BTreeMap<String, ToggleDeclaration>,
    /// The contracts with the host's draws.
    #[serde(default)]
    pub geometry: BTreeMap<String, GeometryDeclaration>,
    /// Textures and buffers.
    #[serde(default)]
    pub resources: BTreeMap<String, ResourceDeclaration>,
    /// Parts of pipelines that passes can use.
    #[serde(default)]
    pub subgraphs: BTreeMap<String, SubgraphDeclaration>,
    /// Named sets of values of parameters and features.
    #[serde(default)]
    pub presets: BTreeMap<String, PresetDeclaration>,
    /// Points at which other files can put passes.
    #[serde(default)]
    pub extension_points: BTreeMap<String, ExtensionPointDeclaration>,
    /// Named groups of settings that passes share: parts of passes, which a pass takes over with "extends".
    #[serde(default)]
    pub shared_settings: BTreeMap<String, serde_json::Value>,
    /// For extension points of the pipeline, by name, the passes that are put there, in their order.
    pub inserts: BTreeMap<String, BTreeMap<String, serde_json::Value>>,
}

/// A parameter file: values of a pipeline's parameters and features, such as those that fit it to a scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterFileDeclaration {
    /// The schema, for editors.
    #[serde(rename = "$schema", default)]
    pub schema: Option<String>,
    /// The version of the language: 1.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// A description for people.
    #[serde(default)]
    pub description: Option<String>,
    /// The preset of the pipeline over which the values are laid.
    #[serde(default)]
    pub preset: Option<String>,
    /// Values of parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Values of features.
    #[serde(default)]
    pub features: BTreeMap<String, serde_json::Value>,
}
