//! The front door: from a file to a plan with [`Library`], [`Pipeline`] and [`Options`], and from
//! frame to frame with `Renderer`.

#[cfg(feature = "gpu")]
pub mod adapter;
#[cfg(feature = "gpu")]
pub mod buffers;
mod camera_keys;
pub mod camera_path;
pub(crate) mod codes;
#[cfg(feature = "environment")]
pub mod environment;
pub mod files;
#[cfg(all(feature = "environment", feature = "gltf"))]
pub mod import;
mod library;
mod options;
mod orbit;
pub mod picture;
mod pipeline;
#[cfg(feature = "gpu")]
mod renderer;
#[cfg(feature = "gpu")]
pub mod sheet;
pub mod starter;
mod storage;
#[cfg(feature = "watch")]
mod watch;

pub use library::Library;
pub use options::{Options, Setting};
pub use pipeline::Pipeline;
#[cfg(feature = "gpu")]
pub use renderer::Renderer;
pub use storage::{DiskStorage, with_templates};
#[cfg(feature = "watch")]
pub use watch::{Reload, Watcher};
