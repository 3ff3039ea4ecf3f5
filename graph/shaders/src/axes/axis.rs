//! One axis: its name, its values, its form in WGSL.

use umbragraph_text::diagnostic::{AxisValue, list_of};
use umbragraph_text::source::Span;

/// The type of a shader-variant axis, with the values that the axis allows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AxisKind {
    /// `false` and `true`.
    Bool,
    /// The members of an enumeration, in the order of their declaration.
    Enum(Vec<String>),
    /// All integers from `min` to `max`, both included.
    Integer {
        /// The smallest value.
        min: i64,
        /// The largest value.
        max: i64,
    },
    /// Names of texture formats in WGSL spelling (`rgba16float`), in the order of their declaration.
    TextureFormat(Vec<String>),
}

impl AxisKind {
    /// Returns the number of values that the axis can have.
    pub fn count(&self) -> u64 {
        match self {
            AxisKind::Bool => 2,
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => names.len() as u64,
            AxisKind::Integer { min, max } => max.abs_diff(*min).saturating_add(1),
        }
    }

    /// Returns `true` if the axis can have this value.
    pub fn contains(&self, value: &AxisValue) -> bool {
        match (self, value) {
            (AxisKind::Bool, AxisValue::Bool(_)) => true,
            (AxisKind::Enum(names) | AxisKind::TextureFormat(names), AxisValue::Name(name)) => {
                names.contains(name)
            }
            (AxisKind::Integer { min, max }, AxisValue::Integer(value)) => (min..=max).contains(&value),
            _ => false,
        }
    }

    /// Describes the allowed values for messages: `false or true`, `1 to 64`, `hard, pcf or evsm`.
    pub fn describe(&self) -> String {
        match self {
            AxisKind::Bool => "false or true".to_owned(),
            AxisKind::Integer { min, max } => format!("{min} to {max}"),
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => match names.split_last() {
                Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", list_of(rest)),
                Some((last, _)) => last.clone(),
                None => "nothing".to_owned(),
            },
        }
    }
}

/// The way in which the value of an axis enters the WGSL: through the template or as an override constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisMode {
    /// A variable of the template: each value may generate different WGSL.
    Template,
    /// A pipeline-overridable constant of the module: all values share the same WGSL.
    Override,
}

/// One axis of a template: a named parameter that selects among shader variants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// The name of the axis. The template variable or the WGSL override constant has the same name.
    pub name: String,
    /// The type of the axis and its allowed values.
    pub kind: AxisKind,
    /// The value that the axis has if a pass sets none.
    pub default: AxisValue,
    /// A description of the axis for people; empty if the declaration has none.
    pub description: String,
    /// The way in which the value enters the WGSL: through the template or as an override constant.
    pub mode: AxisMode,
    /// Whether validation of all variants covers only some values of an integer axis: minimum, default and maximum. If
    /// constraints name values of the axis, those values and one other are covered too. Values that pipelines set are
    /// always validated.
    pub ends: bool,
    /// Whether variants with different values of the axis use different bind-group layouts. Two such variants may
    /// declare different resources at one binding; all other variants of a template must agree.
    pub own_layout: bool,
    /// Whether the axis follows the first color attachment of the pass if no value is set: `true` if its format has no
    /// `-srgb` suffix.
    pub from_target: bool,
    /// The source span of the axis's name in its declaration.
    pub span: Span,
}
