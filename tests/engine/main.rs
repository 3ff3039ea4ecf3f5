//! What an engine asks of the front door: its meshes as it stores them, its cameras, its textures, its threads.

#[path = "../common/mod.rs"]
mod common;
mod contract;
mod meshes;
