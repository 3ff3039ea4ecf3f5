//! Declarations at the top of a pipeline, and what every pass can say.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{AnyExpr, Expr, Ref, ResourceDeclaration};

/// A pipeline: passes over named resources, and the parameters and features that choose among their forms.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PipelineDeclaration {
    /// The version of the language: 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: u32,
    /// The pipeline's name.
    pub name: String,
    /// The target profiles that the pipeline claims to run on, such as "webgpu".
    #[serde(default)]
    pub profiles: Vec<String>,
    /// The sections that extensions can have as well.
    #[serde(flatten)]
    pub sections: Sections,
    /// The passes: each has one key that names its node kind, and may have common keys beside it.
    pub passes: BTreeMap<String, serde_json::Value>,
}

/// The common sections of pipelines and extensions: other files, and declarations.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Sections {
    /// The schema, for editors.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The file, or files (the lowest first), over which this one is laid: objects are merged, null deletes. A file
    /// that several of them extend is laid once, below all of them.
    pub extends: Option<Paths>,
    /// Files whose sections stand beside this file's own; nothing may stand in both.
    pub include: Option<Paths>,
    /// A description for people.
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
    /// Named conditions on parameters, features and derived values, each with what is said where it does not hold.
    #[serde(default)]
    pub constraints: BTreeMap<String, ConstraintDeclaration>,
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
    /// Named groups of settings that passes share: parts of passes, which a pass takes over with "extends". What stands
    /// under "settings" is for whichever node kind the pass has.
    #[serde(default)]
    pub shared_settings: BTreeMap<String, serde_json::Value>,
}

/// A part of a pipeline that passes can use, each time with inputs and parameters of its own.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SubgraphDeclaration {
    /// The schema, for editors.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// The version of the language: 1.
    pub format: Option<u32>,
    /// The subgraph's name.
    pub name: Option<String>,
    /// A description for people.
    pub description: Option<String>,
    /// Resources that the user gives, each with what it is for.
    #[serde(default)]
    pub inputs: BTreeMap<String, String>,
    /// Values that the user gives; without one the default.
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterDeclaration>,
    /// Named values that follow from the parameters and one another: an expression each.
    #[serde(default)]
    pub derived: BTreeMap<String, Expr>,
    /// Textures and buffers of each use.
    #[serde(default)]
    pub resources: BTreeMap<String, ResourceDeclaration>,
    /// Named groups of settings that the passes share, and take over with "extends". What stands under
    /// "settings" is for whichever node kind the pass has.
    #[serde(default)]
    pub shared_settings: BTreeMap<String, serde_json::Value>,
    /// The passes.
    pub passes: BTreeMap<String, serde_json::Value>,
}

/// A named set of values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PresetDeclaration {
    /// A description for people.
    pub description: Option<String>,
    /// Values of parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Values of features.
    #[serde(default)]
    pub features: BTreeMap<String, serde_json::Value>,
}

/// A point at which other files can put passes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtensionPointDeclaration {
    /// A description for people.
    pub description: Option<String>,
    /// The passes after which it lies.
    #[serde(default)]
    pub after: Vec<String>,
    /// The passes before which it lies.
    #[serde(default)]
    pub before: Vec<String>,
}

/// One path or several, relative to the folder of the file that names them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Paths {
    /// The path.
    One(String),
    /// The paths.
    Several(Vec<String>),
}

/// One name or several.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Names {
    /// The name.
    One(String),
    /// The names.
    Several(Vec<String>),
}

/// A named value that a user can set.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterDeclaration {
    /// The type.
    #[serde(rename = "type")]
    pub parameter_type: ParameterType,
    /// The value where nobody sets one.
    pub default: serde_json::Value,
    /// The minimum value (of each element).
    pub min: Option<f64>,
    /// The maximum value (of each element).
    pub max: Option<f64>,
    /// The fewest elements of a list.
    pub min_length: Option<u32>,
    /// The maximum number of elements of a list.
    pub max_length: Option<u32>,
    /// The order of the elements of a list.
    pub order: Option<Order>,
    /// The words of an enumeration; a subgraph's that lists none takes any, such as the name of a geometry.
    #[serde(default)]
    pub values: Vec<String>,
    /// The unit, such as "m", "texel", "ndc", "degree", "1" for a plain number.
    pub unit: Option<String>,
    /// A description for people.
    pub description: Option<String>,
}

/// The type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
pub enum ParameterType {
    /// A number.
    #[serde(rename = "f32")]
    F32,
    /// A whole number from 0.
    #[serde(rename = "u32")]
    U32,
    /// A whole number.
    #[serde(rename = "i32")]
    I32,
    /// true or false.
    #[serde(rename = "bool")]
    Bool,
    /// One of the words under "values".
    #[serde(rename = "enum")]
    Enum,
    /// A list of numbers.
    #[serde(rename = "f32[]")]
    F32List,
    /// A list of whole numbers from 0.
    #[serde(rename = "u32[]")]
    U32List,
}

impl ParameterType {
    /// Its name in a pipeline.
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

/// The order of the elements of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Each element is greater than the one before.
    StrictlyIncreasing,
    /// Each element is smaller than the one before.
    StrictlyDecreasing,
}

/// A named switch.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FeatureDeclaration {
    /// The type.
    #[serde(rename = "type")]
    pub feature_type: FeatureType,
    /// The value where nobody sets one.
    pub default: serde_json::Value,
    /// The words of an enumeration.
    #[serde(default)]
    pub values: Vec<String>,
    /// Features that have to be on where this one is.
    #[serde(default)]
    pub requires: Vec<String>,
    /// Features that have to be off where this one is on.
    #[serde(default)]
    pub excludes: Vec<String>,
    /// The name of a group: exactly one of the features with the same name here is on. Switching one on switches those
    /// off that are on by default alone.
    pub one_of: Option<String>,
    /// The minimum limits that the feature needs of the target, by name, such as
    /// "max_storage_buffers_per_shader_stage". If the target profile, or the device, has less, the feature is off and
    /// cannot be switched on.
    #[serde(default)]
    pub required_limits: BTreeMap<String, u64>,
    /// Optional features of WebGPU that it needs, such as "float32-filterable", and parts of WebGPU's core mode that
    /// OpenGL or compatibility mode lack, such as "view-formats". Where the target profile, or the device, does not
    /// have one, the feature is off and cannot be switched on.
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
    /// The severity of the diagnostic where it does not hold; "error" without it.
    #[serde(default)]
    pub severity: ConstraintSeverity,
    /// The message of the diagnostic: what is wrong then, in one sentence.
    pub message: String,
}

/// The severity of the diagnostic where a constraint does not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ConstraintSeverity {
    /// The pipeline cannot be used.
    #[default]
    Error,
    /// The pipeline can be used.
    Warning,
}

/// A runtime toggle that the host switches from frame to frame. Unlike a feature it changes no shader and no size, so
/// that expressions cannot see it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToggleDeclaration {
    /// Whether it is on where the host says nothing.
    pub default: bool,
    /// A description for people.
    pub description: Option<String>,
}

/// The contract between pipeline and application: the data that the host's draws provide. Shaders see these names only.
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
    /// Properties of meshes and materials that choose a shader variant, such as "alpha_masked"; boolean.
    #[serde(default)]
    pub variants: Vec<String>,
}

/// The name of a vertex format.
pub type VertexFormatName = String;

/// A binding that the host fills.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum HostBinding {
    /// A texture or sampler, by its WGSL type.
    Opaque(String),
    /// A uniform block: the names of its members, each with its WGSL type, in any order.
    Block(BTreeMap<String, String>),
    /// An array of structs in a storage buffer, which shaders index by instance: a list with the members of an element,
    /// as of a block.
    Array([BTreeMap<String, String>; 1]),
}

/// The keys of every pass beside its node kind.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PassCommon {
    /// A description for people.
    pub description: Option<String>,
    /// The group, or groups (the lowest first), of "shared_settings" over which the pass is laid: objects are merged,
    /// null deletes.
    pub extends: Option<Names>,
    /// Whether the pass is there at all: an expression over parameters and features.
    pub when: Option<Expr>,
    /// Repeats the pass: one variable, with a count or a list as an expression, such as { "level": "=levels - 1" }.
    /// Rounds are named NAME.0, NAME.1, …
    pub for_each: Option<BTreeMap<String, Expr>>,
    /// Instead of a node kind: the subgraph that stands here, by its name under "subgraphs", or the path of a file that
    /// is one, relative to this file, such as "parts/blur.json".
    #[serde(rename = "use")]
    pub subgraph: Option<String>,
    /// Inputs and parameters of the subgraph.
    #[schemars(with = "Option<BTreeMap<String, AnyExpr>>")]
    pub with: Option<BTreeMap<String, Expr>>,
    /// Passes that have to run before this one, where no data says so. The name of a loop or of a use of a subgraph
    /// means all of its passes, and on such a one "after" holds for all of them; one alone is NAME.0 or NAME.PASS.
    #[serde(default)]
    pub after: Vec<String>,
    /// Whether the pass, or each pass of the subgraph, is kept even if nothing reads what it writes.
    #[serde(default)]
    pub side_effect: bool,
    /// The toggle with which the pass runs in a frame, or with "!" in front the one without which it runs.
    pub toggle: Option<String>,
    /// For resources that only passes with this toggle write: what readers see instead in a frame without them.
    #[serde(default)]
    pub passthrough: BTreeMap<String, Ref>,
}
