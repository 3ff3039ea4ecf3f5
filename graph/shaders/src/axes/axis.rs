//! One axis: its name, its values, its form in WGSL.

use umbragraph_text::diagnostic::{AxisValue, list_of};
use umbragraph_text::source::Span;

/// The type of an axis and the values that it allows.
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
    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        match self {
            AxisKind::Bool => 2,
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => names.len() as u64,
            AxisKind::Integer { min, max } => max.abs_diff(*min).saturating_add(1),
        }
    }

    /// Returns `true` if `value` is one of the axis's values.
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

    /// Describes the values in words: `false or true`, `1 to 64`, `hard, pcf or evsm`.
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

/// The way in which the value of an axis reaches the WGSL.
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
    /// The name: of the variable in the template, or of the constant in the WGSL.
    pub name: String,
    /// The type and the allowed values.
    pub kind: AxisKind,
    /// The value that is used if a pass sets none.
    pub default: AxisValue,
    /// A description for readers; empty if the declaration has none.
    pub description: String,
    /// The way in which the value reaches the WGSL.
    pub mode: AxisMode,
    /// Whether only some values of an integer axis are validated: minimum, default, maximum, those that constraints
    /// name, and one other if constraints name any. Values that pipelines use are always validated.
    pub ends: bool,
    /// Whether the axis selects a bind-group layout. Variants with different values of the axis may then declare
    /// different things at one binding; all other variants of a template must agree.
    pub own_layout: bool,
    /// Whether the default is `true` if the first color attachment of the pass has a format without `-srgb`.
    pub from_target: bool,
    /// The source span of the axis's name in its declaration.
    pub span: Span,
}
