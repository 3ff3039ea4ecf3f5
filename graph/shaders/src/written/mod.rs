//! Generated WGSL as text: the origins of its parts, the reasons for its rejection, and analyses that run before naga.

pub(crate) mod attributes;
pub mod builtins;
pub(crate) mod complexity;
pub(crate) mod constructors;
pub(crate) mod declarations;
mod foreign;
pub(crate) mod hint;
pub(crate) mod ir;
pub(crate) mod letters;
pub(crate) mod nesting;
pub(crate) mod newer;
pub(crate) mod operators;
pub(crate) mod rejection;
pub(crate) mod scopes;
pub(crate) mod stages;
pub(crate) mod stricter;
pub(crate) mod text_map;
pub(crate) mod tokens;
