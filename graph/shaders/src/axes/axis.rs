//! One axis: its name, its values, its form in WGSL.

use umbragraph_text::diagnostic::{AxisValue, list_of};
use umbragraph_text::source::Span;

/// The values of an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AxisKind {
    /// `false` and `true`.
    Bool,
    /// The members of an enumeration, in the order of their declaration.
    Enum(Vec<String>),
    /// All integers from `min` to `max`, both included.
    Integer {
        /// The minimum.
        min: i64,
        /// The maximum.
        max: i64,
    },
    /// Names of texture formats, spelt as in WGSL, in the order of their declaration.
    TextureFormat(Vec<String>),
}

impl AxisKind {
    /// The number of values.
    pub fn count(&self) -> u64 {
        match self {
            AxisKind::Bool => 2,
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => names.len() as u64,
            AxisKind::Integer { min, max } => max.abs_diff(*min).saturating_add(1),
        }
    }

    /// Whether a value belongs to the axis.
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

    /// The values in words: `false or true`, `1 to 64`, `hard, pcf or evsm`.
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

/// The form of an axis in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisMode {
    /// A variable of the template: another value may be another text.
    Template,
    /// A pipeline-overridable constant of the module: one text for all values.
    Override,
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name: the variable in the template, or the constant in the WGSL.
    pub name: String,
    /// Its values.
    pub kind: AxisKind,
    /// The value where none is given.
    pub default: AxisValue,
    /// A description for people.
    pub description: String,
    /// The form in WGSL.
    pub mode: AxisMode,
    /// Whether its minimum, default and maximum, and those that constraints name, stand for all where nothing
    /// narrows them: a number that is only a size, in a text that is otherwise the same. Pipelines are proven with the
    /// values that they reach all the same.
    pub ends: bool,
    /// Whether it is there to choose between layouts: variants with different values of it never stand for one another,
    /// so they may mean different things by one binding. All other variants of a template have to agree.
    pub own_layout: bool,
    /// Whether it defaults to true if the pass's first color attachment has a format without `-srgb`.
    pub from_target: bool,
    /// The place of its name in the declaration.
    pub span: Span,
}
