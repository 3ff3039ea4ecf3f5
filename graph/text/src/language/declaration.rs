//! Declarations at the top of a pipeline, and what every pass can say.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{AnyExpr, Expr, Ref, ResourceDeclaration};

/// A render pipeline: passes over named resources, with the parameters and features that configure it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PipelineDeclaration {
    /// The version of the pipeline language, which is 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: u32,
    /// The pipeline's name.
    pub name: String,
    /// The target profiles that the pipeline supports, such as "webgpu".
    #[serde(default)]
    pub profiles: Vec<String>,
    /// The sections that pipelines and extensions have in common.
    #[serde(flatten)]
    pub sections: Sections,
    /// The passes by name. Each has one key that names its node kind, and may have common keys such as "when" beside
    /// it.
    pub passes: BTreeMap<String, serde_json::Value>,
}

/// The common sections of pipelines and extensions: the files that they extend or include, and their declarations.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Sections {
    /// The path or URL of the JSON Schema, used by editors only.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The base file or files that this file overrides; later ones override earlier ones. Objects are merged by key,
    /// other values replaced, and null deletes a member. A file that several of them extend is applied once, before
    /// them.
    pub extends: Option<Paths>,
    /// Files whose declarations are added to those of this file. A name that two of the files declare is an error.
    pub include: Option<Paths>,
    /// A description for people.
    pub description: Option<String>,
    /// Named values that a user can set.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterDeclaration>,
    /// Named booleans and enumerations that choose shader variants and passes.
    #[serde(default)]
    pub features: BTreeMap<String, FeatureDeclaration>,
    /// Named values that are computed from parameters, features and other derived values, each by an expression.
    #[serde(default)]
    pub derived: BTreeMap<String, Expr>,
    /// Named conditions on parameters, features and derived values, each with the message to report if the condition
    /// does not hold.
    #[serde(default)]
    pub constraints: BTreeMap<String, ConstraintDeclaration>,
    /// Runtime toggles that the host can switch in each frame, without planning the pipeline again.
    #[serde(default)]
    pub toggles: BTreeMap<String, ToggleDeclaration>,
    /// Contracts for the draws of the host application, by name: the vertex inputs and bindings that the draws provide.
    #[serde(default)]
    pub geometry: BTreeMap<String, GeometryDeclaration>,
    /// Textures and buffers by name.
    #[serde(default)]
    pub resources: BTreeMap<String, ResourceDeclaration>,
    /// Reusable groups of passes by name, which a pass instantiates with "use".
    #[serde(default)]
    pub subgraphs: BTreeMap<String, SubgraphDeclaration>,
    /// Named sets of values of parameters and features.
    #[serde(default)]
    pub presets: BTreeMap<String, PresetDeclaration>,
    /// Named points between passes at which extension files can insert passes.
    #[serde(default)]
    pub extension_points: BTreeMap<String, ExtensionPointDeclaration>,
    /// Named groups of settings that passes share. A pass inherits a group with "extends". Members under "settings"
    /// apply to the node kind of the pass, whichever kind that is.
    #[serde(default)]
    pub shared_settings: BTreeMap<String, serde_json::Value>,
}

/// A reusable group of passes. Each pass that instantiates it with "use" gives its own inputs and parameters.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SubgraphDeclaration {
    /// The path or URL of the JSON Schema, used by editors only.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The version of the pipeline language, which is 1.
    pub format: Option<u32>,
    /// The subgraph's name.
    pub name: Option<String>,
    /// A description for people.
    pub description: Option<String>,
    /// Resources that each use provides, by name, each with a description of its purpose.
    #[serde(default)]
    pub inputs: BTreeMap<String, String>,
    /// Values that each use can set, by name; a parameter that is not set has its default.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterDeclaration>,
    /// Named values that are computed from the parameters and other derived values, each by an expression.
    #[serde(default)]
    pub derived: BTreeMap<String, Expr>,
    /// Textures and buffers by name; each use of the subgraph has its own.
    #[serde(default)]
    pub resources: BTreeMap<String, ResourceDeclaration>,
    /// Named groups of settings that the passes share. A pass inherits a group with "extends". Members under "settings"
    /// apply to the node kind of the pass, whichever kind that is.
    #[serde(default)]
    pub shared_settings: BTreeMap<String, serde_json::Value>,
    /// The passes by name.
    pub passes: BTreeMap<String, serde_json::Value>,
}

/// A named set of values of parameters and features.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PresetDeclaration {
    /// A description for people.
    pub description: Option<String>,
    /// Values of parameters, by name.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Values of features, by name.
    #[serde(default)]
    pub features: BTreeMap<String, serde_json::Value>,
}

/// A named point between passes at which extension files can insert passes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtensionPointDeclaration {
    /// A description for people.
    pub description: Option<String>,
    /// The names of the passes after which inserted passes run.
    #[serde(default)]
    pub after: Vec<String>,
    /// The names of the passes before which inserted passes run.
    #[serde(default)]
    pub before: Vec<String>,
}

/// One path or a list of paths, relative to the folder of the file that contains them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Paths {
    /// A single path.
    One(String),
    /// A list of paths.
    Several(Vec<String>),
}

/// One name or a list of names.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Names {
    /// A single name.
    One(String),
    /// A list of names.
    Several(Vec<String>),
}

/// A named value that a user can set.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterDeclaration {
    /// The type of the parameter's value.
    #[serde(rename = "type")]
    pub parameter_type: ParameterType,
    /// The value that is used if none is set.
    pub default: serde_json::Value,
    /// The minimum value; for a list, of each element.
    pub min: Option<f64>,
    /// The maximum value; for a list, of each element.
    pub max: Option<f64>,
    /// The minimum number of elements of a list.
    pub min_length: Option<u32>,
    /// The maximum number of elements of a list.
    pub max_length: Option<u32>,
    /// The required order of the elements of a list; any order is allowed if the key is absent.
    pub order: Option<Order>,
    /// The allowed words of an enumeration. A subgraph's parameter without words takes any word, such as the name of a
    /// geometry.
    #[serde(default)]
    pub values: Vec<String>,
    /// The unit of the value, such as "m", "texel", "ndc" or "degree"; "1" for a plain number.
    pub unit: Option<String>,
    /// A description for people.
    pub description: Option<String>,
}

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
pub enum ParameterType {
    /// A floating-point number.
    #[serde(rename = "f32")]
    F32,
    /// An unsigned integer.
    #[serde(rename = "u32")]
    U32,
    /// A signed integer.
    #[serde(rename = "i32")]
    I32,
    /// true or false.
    #[serde(rename = "bool")]
    Bool,
    /// One of the words under "values".
    #[serde(rename = "enum")]
    Enum,
    /// A list of floating-point numbers.
    #[serde(rename = "f32[]")]
    F32List,
    /// A list of unsigned integers.
    #[serde(rename = "u32[]")]
    U32List,
}

impl ParameterType {
    /// The name of the type in pipeline files, such as `f32[]`.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::Bool => "bool",
            Self::Enum => "enum",
            Self::F32List => "f32[]",
            Self::U32List => "u32[]",
        }
    }
}

/// The order that the elements of a list must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Each element is greater than the one before.
    StrictlyIncreasing,
    /// Each element is smaller than the one before.
    StrictlyDecreasing,
}

/// A named setting, a boolean or an enumeration, that chooses shader variants and passes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FeatureDeclaration {
    /// The type of the feature's value.
    #[serde(rename = "type")]
    pub feature_type: FeatureType,
    /// The value that is used if none is set.
    pub default: serde_json::Value,
    /// The allowed words of an enumeration.
    #[serde(default)]
    pub values: Vec<String>,
    /// Features that must be on if this one is on.
    #[serde(default)]
    pub requires: Vec<String>,
    /// Features that must be off if this one is on.
    #[serde(default)]
    pub excludes: Vec<String>,
    /// The name of a group of features, exactly one of which is on. Switching one on switches off the others that are
    /// on only by default.
    pub one_of: Option<String>,
    /// The minimum limits that the feature needs of the target, by name, such as
    /// "max_storage_buffers_per_shader_stage". If the target profile, or the device, has less, the feature is off and
    /// cannot be switched on.
    #[serde(default)]
    pub required_limits: BTreeMap<String, u64>,
    /// Optional features of WebGPU that this feature needs, such as "float32-filterable", and parts of WebGPU's core
    /// mode that OpenGL or compatibility mode lack, such as "view-formats". If the target profile, or the device, lacks
    /// one, this feature is off and cannot be switched on.
    #[serde(default)]
    pub required_features: Vec<String>,
    /// A description for people.
    pub description: Option<String>,
}

/// The type of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FeatureType {
    /// On or off.
    Bool,
    /// One of the words under "values".
    Enum,
}

/// A condition on parameters, features and derived values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstraintDeclaration {
    /// The condition that has to hold: an expression that yields a boolean.
    pub holds: Expr,
    /// The severity of the diagnostic if the condition does not hold; "error" by default.
    #[serde(default)]
    pub severity: ConstraintSeverity,
    /// The message of the diagnostic: one sentence that says what is wrong.
    pub message: String,
}

/// The severity of the diagnostic for a constraint that does not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ConstraintSeverity {
    /// The diagnostic is an error: the pipeline cannot be used.
    #[default]
    Error,
    /// The diagnostic is a warning: the pipeline can be used.
    Warning,
}

/// A runtime toggle that the host can switch in each frame. Unlike a feature, a toggle changes no shader and no size,
/// and expressions cannot use it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToggleDeclaration {
    /// Whether the toggle is on if the host does not set it.
    pub default: bool,
    /// A description for people.
    pub description: Option<String>,
}

/// The contract between pipeline and host application: the vertex inputs and bindings that the host's draws provide,
/// under the names that shaders use.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GeometryDeclaration {
    /// Vertex inputs by name, each with its vertex format, such as "float32x3".
    pub vertex: BTreeMap<String, VertexFormatName>,
    /// Bindings of bind group 2, which change from material to material.
    #[serde(default)]
    pub material: BTreeMap<String, HostBinding>,
    /// Bindings of bind group 3, which change from object to object.
    #[serde(default)]
    pub object: BTreeMap<String, HostBinding>,
    /// Names of boolean properties of meshes and materials that choose a shader variant, such as "alpha_masked".
    #[serde(default)]
    pub variants: Vec<String>,
}

/// The name of a WebGPU vertex format, such as "float32x3".
pub type VertexFormatName = String;

/// A shader binding whose contents the host provides.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum HostBinding {
    /// A texture or sampler, by its WGSL type.
    Opaque(String),
    /// A uniform block: the names of its members, each with its WGSL type, in any order.
    Block(BTreeMap<String, String>),
    /// An array of structs in a storage buffer, which shaders index by instance: a list of one object, the members of
    /// an element with their WGSL types.
    Array([BTreeMap<String, String>; 1]),
}

/// The common keys of all passes, beside the key that names the node kind.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PassCommon {
    /// A description for people.
    pub description: Option<String>,
    /// The group or groups of "shared_settings" that the pass inherits. Later groups override earlier ones, and the
    /// pass overrides all. Objects are merged by key; null deletes a member.
    pub extends: Option<Names>,
    /// Whether the pass is part of the graph: an expression over parameters and features; true by default.
    pub when: Option<Expr>,
    /// Repeats the pass: one variable, with a count or a list as an expression, such as { "level": "=levels - 1" }. For
    /// a count the variable runs from 0. Rounds are named NAME.0, NAME.1, …
    pub for_each: Option<BTreeMap<String, Expr>>,
    /// The subgraph that this pass instantiates, instead of a node kind: a name under "subgraphs", or the path of its
    /// file, relative to this file, such as "parts/blur.json".
    #[serde(rename = "use")]
    pub subgraph: Option<String>,
    /// The values of the subgraph's inputs and parameters, by name.
    #[schemars(with = "Option<BTreeMap<String, AnyExpr>>")]
    pub with: Option<BTreeMap<String, Expr>>,
    /// Passes that must run before this one, if no data implies that order. The name of a loop, or of a use of a
    /// subgraph, means all of its passes; NAME.0 or NAME.PASS is a single one. On a loop or a use, "after" holds for
    /// all of its passes.
    #[serde(default)]
    pub after: Vec<String>,
    /// Whether the pass, or each pass of the subgraph, is kept even if nothing reads what it writes.
    #[serde(default)]
    pub side_effect: bool,
    /// The toggle that must be on for the pass to run in a frame; with "!" before its name, the toggle that must be
    /// off.
    pub toggle: Option<String>,
    /// Fallback resources, by the name of the resource that each replaces. Only passes with the toggle of this pass may
    /// write the replaced resource. Readers get the fallback in frames in which those passes do not run.
    #[serde(default)]
    pub passthrough: BTreeMap<String, Ref>,
}
