//! Pipeline to graph to plan.
//!
//! - [`graph`](self::build): passes and resource versions as a petgraph, with every hazard an edge;
//! - culling: what leads to an output stays, with the reason;
//! - order: deterministic, by the order of the document where the graph leaves a choice;
//! - [`plan`](self::plan()): lifetimes, physical resources, load and store operations, sizes, dispatches.

mod cull;
mod cycle;
mod format;
mod graph;
mod lifetime;
mod plan;
mod size;
mod values;

pub use cull::{CullReason, KeepReason};
pub use size::TextureSize;
pub use graph::{Edge, Graph, GraphNode, Hazard, build};
pub use plan::{
    Import, Physical, PhysicalBuffer, PhysicalTexture, Plan, PlanOptions, PlannedAttachment, PlannedPass,
    PlannedResource, StoreOperation, plan,
};
pub use values::PackedBlock;
