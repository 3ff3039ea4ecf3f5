//! The executor, hosts and engines on a device.

#![cfg(all(feature = "gpu", feature = "gltf"))]

#[path = "../common/mod.rs"]
mod common;

mod caching;
mod caching_hosts;
mod engine;
mod executing;
mod executor;
mod live_parameters;
mod long_run;
mod narrowed;
mod own_meshes;
mod own_scenes;
mod steady_scenes;
#[cfg(feature = "watch")]
mod watching;
