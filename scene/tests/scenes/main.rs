//! Scenes from documents that the tests build themselves.

mod accessors;
mod bad_input;
mod bad_meshes;
mod bad_nodes;
#[cfg(feature = "gpu")]
mod device;
mod document;
mod hostile_input;
mod loading;
mod own_scenes;
