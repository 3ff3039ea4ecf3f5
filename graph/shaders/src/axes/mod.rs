//! Axes: what a template varies in, declared beside it.
//!
//! `forward.axes.json` declares the axes of `forward.wgsl.jinja`:
//!
//! ```jsonc
//! {
//!   "inherits": ["lib/noise.wgsl.jinja"],        // included templates, whose axes and constraints hold here too
//!   "axes": {
//!     "sscs":   { "type": "bool", "default": false, "requires": ["depth_prepass"] },
//!     "filter": { "type": "enum", "values": ["hard", "pcf", "evsm"], "default": "pcf" },
//!     "taps":   { "type": "integer", "min": 1, "max": 64, "default": 16, "as": "override" },
//!     "encode": { "type": "bool", "default": true, "as": "override", "from": "linear_target" },
//!     "target": { "type": "texture_format", "values": ["rgba16float", "rgba32float"], "default": "rgba16float" }
//!   },
//!   "constraints": [
//!     { "when": "filter=evsm", "excludes": ["msaa"] },
//!     { "one_of": ["filter=hard", "filter=pcf", "filter=evsm"] }
//!   ]
//! }
//! ```
//!
//! A *template* axis is a variable of the template, with one variant per value that changes the text. An *override*
//! axis is a pipeline-overridable constant of the module instead: one text, any value. One that is `from` the target is
//! true where that has a format without `-srgb`, unless a pass or pipeline says otherwise. Constraints narrow the
//! product of all axes; `requires` and `excludes` inside an axis are short for a constraint whose `when` is the axis
//! itself.
//!
//! Limits: an axis name is a WGSL identifier; an integer axis spans at most 2³² values.

mod axis;
mod condition;
mod constraint;
mod diagram;
mod domain;
mod parse;
mod schema;
mod set;
mod space;

pub use axis::{Axis, AxisKind, AxisMode};
pub use condition::Condition;
pub use constraint::{Constraint, Rule};
pub(crate) use domain::Domain;
pub(crate) use parse::{Declaration, parse};
pub use schema::schema;
pub use set::Axes;
pub use space::Space;
