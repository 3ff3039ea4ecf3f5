//! The other files of the language: what an extension, and what a parameter file, can say.
//!
//! Both are composed, or read, section by section; these types are what their schemas say.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::Sections;

/// An extension file: passes inserted at the extension points of a pipeline, with the declarations that they need.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtensionDeclaration {
    /// The version of the pipeline language, which is 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// The extension's name.
    pub name: Option<String>,
    /// The sections that pipelines and extensions have in common.
    #[serde(flatten)]
    pub sections: Sections,
    /// The inserted passes in their order, by name, under the name of the extension point.
    pub inserts: BTreeMap<String, BTreeMap<String, serde_json::Value>>,
}

/// A parameter file: values of a pipeline's parameters and features, for example to fit the pipeline to a scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterFileDeclaration {
    /// The path or URL of the JSON Schema, used by editors only.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The version of the pipeline language, which is 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: Option<u32>,
    /// A description for people.
    pub description: Option<String>,
    /// The preset of the pipeline whose values this file overrides.
    pub preset: Option<String>,
    /// Values of parameters, by name.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Values of features, by name.
    #[serde(default)]
    pub features: BTreeMap<String, serde_json::Value>,
}
