//! Generated WGSL as text: where its parts come from, why it is rejected, and what is read off it before naga does.

pub(crate) mod complexity;
pub(crate) mod hint;
pub(crate) mod ir;
pub(crate) mod rejection;
pub(crate) mod stages;
pub(crate) mod text_map;
