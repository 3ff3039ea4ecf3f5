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

mod access;
mod allocate;
mod assemble;
mod attachments;
mod build;
mod conditions;
mod copies;
mod cpu_passes;
mod cull;
mod cycle;
mod device_rules;
mod discards;
mod dispatch;
mod drawn_buffers;
mod extents;
mod format;
mod graph;
mod history;
mod implied;
mod jagged_array;
mod later;
mod lifetime;
mod merge;
mod options;
mod order;
mod order_memory;
mod order_report;
mod parameters;
mod partial_read;
mod pass_sizes;
mod physical;
mod plan;
mod planned;
mod planner;
mod ready;
mod resize;
mod resolved_resources;
mod runs;
mod size;
mod subresources;
mod switches;
mod target_constants;
mod texture_rules;
mod texture_size;
mod toggles;
mod uninitialised;
mod values;
mod visible;
mod writers;

pub use assemble::{Assembly, AssemblyPass};
pub use build::build;
pub use copies::{PlannedCopy, TexelOrigin, TexelRows};
pub use cpu_passes::CpuPasses;
pub use cull::{CullReason, KeepReason, Kept, ReaderName, surviving_writers};
pub use graph::{Edge, Graph, GraphNode, Hazard};
pub use history::{InitialValue, PlannedHistory};
pub use options::{ImportDescriptor, PlanOptions};
pub use order_report::{MemoryOrder, Objective, OrderMethod, OrderReport};
pub use parameters::{Parameters, PlannedParameter, PlannedSetting, TakeOver};
pub use physical::{Physical, PhysicalBuffer, PhysicalTexture};
pub use plan::plan;
pub use planned::{Plan, PlannedAttachment, PlannedPass, PlannedResource, StoreOperation};
pub use subresources::set_aside;
pub use switches::Switches;
pub use texture_size::TextureSize;
pub use values::PackedBlock;
