//! Values of a work that can change from frame to frame.
//!
//! A node kind declares one with [`PassBuilder::live_value`](crate::pipeline::PassBuilder::live_value). A value that
//! follows from no parameter stays the one of the load; any other has a position among the live settings of its pass,
//! whose expression is evaluated again when a parameter changes. [`LiveValue::read`] judges the value at both times.

use crate::whole_number::whole_number;
use umbragraph_text::diagnostic::{Diagnostic, Place, codes};
use umbragraph_text::expression::Value;

/// A value of a pass that can change from frame to frame, with the index of the setting that determines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Live<T> {
    /// The current value: from loading the pipeline, or from the last update.
    pub value: T,
    /// The index of the determining setting in [`Pass::live`](crate::pipeline::Pass::live); `None` for a value that
    /// never changes.
    pub setting: Option<usize>,
}

/// Creates a value that never changes.
impl<T> From<T> for Live<T> {
    fn from(value: T) -> Self {
        Self { value, setting: None }
    }
}

impl<T: LiveValue> Live<T> {
    /// Updates the value from the values of all live settings of the pass. An invalid value is ignored.
    pub fn update(&mut self, values: &[Value]) {
        let value = self.setting.and_then(|at| values.get(at));
        if let Some(Ok(value)) = value.map(T::read) {
            self.value = value;
        }
    }
}

/// Returns the diagnostic for a value of the wrong type. `wanted` and `found` describe the expected and the actual
/// value, such as "a number".
pub(crate) fn wrong_type(wanted: &str, found: &str) -> Diagnostic {
    let message = format!("{wanted} is wanted here, this is {found}");
    Diagnostic::error(codes::EXPRESSION_TYPE, Place::Nowhere, message)
        .help(format!("make the expression yield {wanted}"))
}

fn out_of_bounds(message: String, help: &str) -> Diagnostic {
    Diagnostic::error(codes::OUT_OF_BOUNDS, Place::Nowhere, message).help(help)
}

/// A type whose values can change from frame to frame. Reading a valid value allocates nothing.
pub trait LiveValue: Copy {
    /// Converts the value of an expression to this type.
    ///
    /// # Errors
    /// Returns a diagnostic without a place for a value of another type, or one out of range.
    fn read(value: &Value) -> Result<Self, Diagnostic>;
}

/// A color, such as a clear color: red, green, blue and alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Color(pub [f64; 4]);

impl From<Color> for wgpu_types::Color {
    fn from(Color([r, g, b, a]): Color) -> Self {
        Self { r, g, b, a }
    }
}

impl LiveValue for Color {
    fn read(value: &Value) -> Result<Self, Diagnostic> {
        let count = match value {
            Value::List(list) => {
                if let [r, g, b, a] = list.as_slice()
                    && let (Some(r), Some(g), Some(b), Some(a)) =
                        (r.number(), g.number(), b.number(), a.number())
                {
                    return Ok(Self([r, g, b, a]));
                }
                list.iter().all(|one| one.number().is_some()).then_some(list.len())
            }
            Value::Number(_) => Some(1),
            _ => None,
        };
        let Some(count) = count else {
            return Err(wrong_type("a list of numbers", value.kind_name()));
        };
        let message = format!("a color has four numbers, not {count}");
        Err(out_of_bounds(message, "write red, green, blue and alpha: [0, 0, 0, 1]"))
    }
}

/// A depth from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Depth(pub f64);

impl From<Depth> for f32 {
    fn from(Depth(depth): Depth) -> Self {
        depth as f32
    }
}

impl LiveValue for Depth {
    fn read(value: &Value) -> Result<Self, Diagnostic> {
        match value {
            Value::Number(depth) if (0.0..=1.0).contains(depth) => Ok(Self(*depth)),
            Value::Number(depth) => {
                Err(out_of_bounds(format!("depth is cleared to {depth}"), "depth lies between 0 and 1"))
            }
            other => Err(wrong_type("a number", other.kind_name())),
        }
    }
}

/// An 8-bit stencil value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Byte(pub u8);

impl From<Byte> for u32 {
    fn from(Byte(byte): Byte) -> Self {
        byte.into()
    }
}

impl LiveValue for Byte {
    fn read(value: &Value) -> Result<Self, Diagnostic> {
        let count = u32::read(value)?;
        let outside = |_| {
            let message = format!("stencil has eight bits, not {count}");
            out_of_bounds(message, "0 to 255 are possible")
        };
        u8::try_from(count).map(Self).map_err(outside)
    }
}

/// A count: a whole number from 0 to `u32::MAX`.
impl LiveValue for u32 {
    fn read(value: &Value) -> Result<Self, Diagnostic> {
        let wanted = |number: &f64| wrong_type("a whole number from 0", &number.to_string());
        match value {
            Value::Number(number) => whole_number(value, 0..=u32::MAX).ok_or_else(|| wanted(number)),
            other => Err(wrong_type("a number", other.kind_name())),
        }
    }
}
