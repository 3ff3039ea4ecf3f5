//! The other files of the language: what an extension, and what a parameter file, can say.
//!
//! Both are composed, or read, section by section; these types are what their schemas say.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::Sections;

/// An extension: passes for the extension points of a pipeline, and what they need beside what the pipeline has.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtensionDeclaration {
    /// The version of the language: 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// The extension's name.
    pub name: Option<String>,
    /// The sections that pipelines can have as well.
    #[serde(flatten)]
    pub sections: Sections,
    /// For extension points of the pipeline, by name, the passes that are put there, in their order.
    pub inserts: BTreeMap<String, BTreeMap<String, serde_json::Value>>,
}

/// A parameter file: values of a pipeline's parameters and features, such as those that fit it to a scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterFileDeclaration {
    /// The schema, for editors.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The version of the language: 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// A description for people.
    pub description: Option<String>,
    /// The preset of the pipeline over which the values are laid.
    pub preset: Option<String>,
    /// Values of parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Values of features.
    #[serde(default)]
    pub features: BTreeMap<String, serde_json::Value>,
}
