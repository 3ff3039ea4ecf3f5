//! Shaders: WGSL generated from templates, with every variant proven by naga.
//!
//! ```text
//! templates + axes ──render──▶ WGSL + map ──parse, validate──▶ module ──reflect──▶ ShaderModule
//! ```
//!
//! # Rules
//!
//! - A **template** is a minijinja text, `NAME.wgsl.jinja`. It includes others by name; a [`TemplateSet`] holds them
//!   all.
//! - An **axis** is a named choice of a template, declared in `NAME.axes.json`. It is a *template* axis, a variable
//!   that changes the text, or an *override* axis, a pipeline-overridable constant of one text ([`AxisMode`]).
//! - A **constraint** excludes combinations of axis values, such as PCSS without a search.
//! - A **variant** is a template with a value for each axis. Variants that render to the same text share a module.
//! - A **target profile** says what a target guarantees: limits, features, and the language that naga has to write for
//!   it (GLSL, HLSL, MSL, SPIR-V or WGSL). A variant is valid for a profile, not by itself ([`TargetProfile`]).
//! - A **proof** is what naga and our rules accept: [`compile`] proves one variant, [`permutations::check`] all
//!   variants that pipelines can reach.
//! - A **reflection** is the one source of what host and shader agree on: bindings, memory layouts, entry points
//!   ([`Reflection`]).
//! - A **diagnostic** stands in the template, not in the generated text: a [`TextMap`] leads back.
//!
//! # Example
//!
//! A fragment shader with one axis, whose tinted variant is compiled for WebGPU:
//!
//! ```
//! use umbragraph_shaders::{AxisValue, AxisValues, TargetProfile, TemplateSet, compile};
//! use umbragraph_text::diagnostic::Diagnostics;
//! use umbragraph_text::source::Sources;
//!
//! let template = "@fragment fn main() -> @location(0) vec4<f32> {\n\
//!     return vec4<f32>({{ '0.2' if tinted else '1.0' }}, 1.0, 1.0, 1.0);\n}\n";
//! let axes = r#"{ "axes": { "tinted": { "type": "bool", "default": false } } }"#;
//!
//! let (mut set, mut sources, mut diagnostics) = (TemplateSet::new(), Sources::new(), Diagnostics::new());
//! set.add(&mut sources, "fill.wgsl.jinja", template, &mut diagnostics);
//! set.add(&mut sources, "fill.axes.json", axes, &mut diagnostics);
//! set.check(&mut diagnostics);
//! assert!(diagnostics.is_empty());
//!
//! let values = AxisValues::from([("tinted".to_owned(), AxisValue::Bool(true))]);
//! let module = compile(&set, "fill.wgsl.jinja", &values, &TargetProfile::webgpu()).unwrap();
//! assert!(module.wgsl.contains("vec4<f32>(0.2, 1.0, 1.0, 1.0)"));
//! assert_eq!(module.reflection.entry_points[0].name, "main");
//! ```
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

/// The tags and the literal text of templates.
pub mod tags {
    pub use crate::jinja::scan::{Scan, Tag, TagKind, Word, WordKind, scan};
}

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
pub use written::builtins;
pub use written::text_map::TextMap;
