//! Pipeline to graph to plan.
//!
//! - [`build`]: passes and resource versions as a petgraph, with every hazard an edge;
//! - culling: what leads to an output stays, with the reason;
//! - order: deterministic, by the order of the document where the graph leaves a choice, or for an [`Objective`];
//! - [`plan`](self::plan()): lifetimes, physical resources, load and store operations, sizes, dispatches.
//!
//! [`CpuPasses`] and [`Switches`] are what changes from frame to frame without a device: what CPU passes keep and publish,
//! and how toggles are switched.
//!
//! [`Assembly`] makes pipelines in code, without a text.

mod assemble;
mod contents;
mod frame;
mod graph;
mod memory;
mod plan;
mod regions;
mod request;
mod resources;
mod schedule;
mod values;
mod work;

pub use assemble::{Assembly, AssemblyPass};
pub use frame::cpu_passes::CpuPasses;
pub use frame::parameters::{Parameters, TakeOver};
pub use frame::switches::Switches;
pub use graph::build::build;
pub use graph::{Edge, Graph, GraphNode, Hazard};
pub use memory::history::{InitialValue, PlannedHistory};
pub use memory::physical::{Physical, PhysicalBuffer, PhysicalTexture};
pub use plan::plan;
pub use plan::planned::{Plan, PlannedAttachment, PlannedPass, PlannedResource, StoreOperation};
pub use request::objective::{MemoryOrder, Objective, OrderMethod, OrderReport};
pub use request::options::{ImportDescriptor, PlanOptions};
pub use request::texture_size::TextureSize;
pub use resources::subresources::set_aside;
pub use schedule::cull::{CullReason, KeepReason, Kept, ReaderName, surviving_writers};
pub use values::packed::PackedBlock;
pub use values::settings::{PlannedParameter, PlannedSetting};
pub use work::copies::{PlannedCopy, TexelOrigin, TexelRows};
