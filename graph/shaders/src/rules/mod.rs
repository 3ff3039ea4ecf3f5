//! Rules that naga does not enforce and browsers or targets do: uniform control flow, aliasing, limits; and the cost of
//! shaders.

pub(crate) mod aliasing;
pub(crate) mod behaviors;
pub(crate) mod constant_arguments;
pub(crate) mod cost;
pub(crate) mod empty_vectors;
pub(crate) mod limits;
pub(crate) mod spelled;
pub(crate) mod stage_variables;
mod steps;
pub(crate) mod summary;
pub(crate) mod texture_arguments;
pub(crate) mod types;
pub(crate) mod uniform_branches;
pub(crate) mod uniformity;
pub(crate) mod untyped;
pub(crate) mod uses;
