//! The executor: a plan, instantiated with wgpu and recorded into an encoder of the host's.
//!
//! It is middleware, not a framework: the host owns device, queue, encoder and surface, submits and presents. An
//! [`Executor`] creates textures, pipelines and bind groups when it is made or given another plan; recording a frame
//! then runs the CPU passes, packs their data into one buffer, and records the passes in the plan's order. In a steady
//! frame nothing is created on the device and nothing allocated but by wgpu itself: three full-screen passes with
//! blocks make 33 allocations, as do the same calls by hand (`cargo test --test device allocations`).
//!
//! - `instantiate`: everything that a plan needs, taken over from the plan before where it can be (`reuse`, `cache`);
//!   `creation` counts it and catches the device's errors, `requirements` says beforehand what a device lacks;
//! - `textures`, `imports`, `resources`: the plan's textures and buffers, the host's, and views of both;
//! - `histories`: what earlier frames left, in copies that take turns;
//! - `shared`, `pipelines`: shader modules, layouts and pipelines; `preparation` makes them off the caller's thread;
//! - `blocks`, `pool`: where the blocks of one record lie, and buffers that records in flight do not share;
//! - `groups`, `host_groups`: bind groups of what the module binds, and of the host's materials and objects;
//! - `inputs`: what a frame brings, checked;
//! - `record`, `attachments`, `scene`, `buffer_draw`: render passes, and the draws in them;
//! - `redraw`: views that are not drawn again while nothing changes; `scroll`: those that moved by whole texels;
//! - `read_back`, `samples`: what a texture or buffer holds, for the host to look at;
//! - `times`: how long the processor works on each pass.
//!
//! Whatever happens, an error is a value, nothing is recorded, and the next frame is possible. A device that is lost is
//! the host's to replace: it makes a new device and a new executor.
//!
//! Limits: one pass has at most eight color attachments, and its depth and stencil are of one texture.

mod binding;
mod drawing;
#[cfg(feature = "noop")]
mod dry_run;
mod executor;
mod frame;
mod instance;
mod measure;
mod memory;
mod objects;

pub use binding::draw::{DrawPass, DrawSource};
#[cfg(feature = "noop")]
pub use dry_run::DryRun;
pub use executor::Executor;
pub use frame::input::Frame;
pub use instance::parameters::{Parameter, ParameterValue};
pub use instance::preparation::{PlanPreparer, PreparedPlan};
pub use measure::gpu_times::GpuTime;
pub use measure::statistics::{PassCounts, Statistics};
pub use memory::imports::{
    FrameImports, Given, Import, ImportHandle, Importable, imported_buffer, imported_texture,
};
pub use memory::read_back::{Texels, read_back, read_buffer, read_bytes};
pub use memory::samples::read_sample;
pub use wgpu;
