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

use umbragraph_text::{diagnostic, document, language, source};

mod aliasing;
mod aside;
pub mod axes;
mod backend;
pub mod codes;
mod comparisons;
mod compile;
mod complexity;
mod filters;
mod guard;
mod hint;
pub mod interface;
mod ir;
mod limits;
mod listing;
mod markers;
mod named_limits;
pub mod permutations;
mod profile;
mod reflection;
mod render;
mod scan;
mod stages;
mod syntax_help;
mod template;
mod template_error;
mod templates;
#[cfg(test)]
mod tests;
mod text_map;
mod texture_reads;
mod tree;
mod uniform_branches;
mod uniformity;
mod wgsl;
mod wgsl_error;

pub use crate::diagnostic::{AxisValue, AxisValues, describe};
pub use axes::{Axes, Axis, AxisKind, AxisMode, schema as axes_schema};
pub use backend::Emitted;
pub use compile::{ShaderModule, compile, complete, generate};
pub use limits::exceeded_by_layout;
pub use profile::{TargetLanguage, TargetProfile};
pub use reflection::{
    Binding, EntryPoint, FragmentOutput, Member, Reflection, Scalar, ScalarKind, Stage, TypeLayout,
    VertexInput,
};
pub use templates::{TEMPLATE_ENDS, TemplateSet};
pub use text_map::TextMap;
pub use texture_reads::texture_reads;
