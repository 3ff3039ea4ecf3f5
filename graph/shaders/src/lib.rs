//! Shaders: WGSL generated from templates, with every variant proven.
//!
//! ```text
//! templates + axes ──render──▶ WGSL + map ──parse, validate──▶ module ──reflect──▶ ShaderModule
//! ```
//!
//! - A [`TemplateSet`] holds templates (`NAME.wgsl.jinja`) and the axes declared beside them (`NAME.axes.json`).
//! - [`compile`] makes one variant: values for the axes in, a [`ShaderModule`] out, or diagnostics placed in the
//!   templates.
//! - A [`TargetProfile`] says what a target guarantees.
//! - [`Reflection`] is the one source of what host and shader agree on: bindings, memory layouts, entry points.
//!
//! Folders, the lowest first: `targets`, `written` (the text), `reflection`, `rules`, `module` (text to a validated
//! module), `axes`, `jinja` (the template language), `rendering`, `variant`, `permutations`.

pub mod axes;
pub mod codes;
mod jinja;
mod module;
pub mod permutations;
mod reflection;
mod rendering;
mod rules;
mod targets;
#[cfg(test)]
mod tests;
mod variant;
mod written;

pub use axes::{Axes, Axis, AxisKind, AxisMode, schema as axes_schema};
pub use module::backend::Emitted;
pub use permutations::ShaderCache;
pub use reflection::{
    Binding, EntryPoint, FragmentOutput, Member, Reflection, Scalar, ScalarKind, Stage, TypeLayout,
    VertexInput, interface,
};
pub use rendering::templates::{TEMPLATE_ENDS, TemplateSet};
pub use rules::limits::exceeded_by_layout;
pub use targets::capabilities::Capability;
pub use targets::profile::{TargetLanguage, TargetProfile};
pub use umbragraph_text::diagnostic::{AxisValue, AxisValues, describe};
pub use variant::compile::{ShaderModule, compile, complete, generate};
pub use variant::texture_reads::texture_reads;
pub use written::text_map::TextMap;
