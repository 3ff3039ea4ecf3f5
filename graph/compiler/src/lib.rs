//! Pipeline to graph to plan.
//!
//! - [`build`]: passes and resource versions as a petgraph, with every hazard an edge;
//! - culling: passes that lead to an output stay, each with the reason;
//! - order: deterministic, by the order of the document where the graph leaves a choice, or for an [`Objective`];
//! - [`plan`](self::plan()): lifetimes, physical resources, load and store operations, sizes, dispatches.
//!
//! # Rules
//!
//! Three passes, of which the second can be switched off from frame to frame:
//!
//! ```jsonc
//! "fill": { "fullscreen": { …, "color": [{ "to": "&color" }] } },
//! "blur": { "toggle": "soft", "passthrough": { "blurred": "&color" },
//!           "fullscreen": { …, "bind": { "source": "&color" }, "color": [{ "to": "&blurred" }] } },
//! "show": { "fullscreen": { …, "bind": { "source": "&blurred" }, "color": [{ "to": "&target" }] } }
//! ```
//!
//! - A **subresource** is one mip level of one layer of one aspect of a texture, or a range of bytes of a buffer.
//! - An **access** is a use of subresources by a pass, with a usage such as "sampled" or "color attachment": `blur` has
//!   two. Node kinds declare accesses; nothing else reads or writes.
//! - A **version** is the content of a resource after a write. `&color` is the last version, `&color@fill` the one that
//!   `fill` leaves, `&color@0` the one before the first write. A read depends on the writer of its version.
//! - A write is **visible** to a later access, subresource by subresource, if no write between them replaces it. A read
//!   of a subresource to which no write is visible is uninitialised, and reported.
//! - A **toggle** switches a pass without another plan: a writer that is off is skipped, and readers see what was
//!   before it, or its passthrough. While `soft` is off, `show` reads `color`.
//! - A **lifetime** runs from the first to the last access of a transient resource, in all toggle states: that of
//!   `color` reaches to `show`, since a passthrough may be read there. Resources whose lifetimes do not meet may share
//!   memory; one whose first write can be off shares none, since it would show what another left.
//!
//! [`CpuPasses`] and [`Switches`] are the state that changes from frame to frame without a device: data of CPU passes,
//! and toggles. [`Assembly`] makes pipelines in code, without a text.

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
