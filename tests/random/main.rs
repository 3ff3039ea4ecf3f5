//! Random pipelines against a simulation, and faults planted in templates.

#![cfg(all(feature = "gpu", feature = "gltf"))]

#[path = "../common/mod.rs"]
mod common;

#[cfg(feature = "noop")]
mod hosts;
mod mutants;
#[cfg(feature = "noop")]
mod random_pipelines;
