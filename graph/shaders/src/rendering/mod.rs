//! Sets of templates, and their rendering to WGSL with a map back.

pub(crate) mod aside;
pub(crate) mod context;
mod fitting;
pub(crate) mod markers;
pub(crate) mod parts;
pub(crate) mod placement;
pub(crate) mod render;
pub(crate) mod template_error;
pub(crate) mod templates;
mod twice;
mod unchanged;
mod undeclared;
