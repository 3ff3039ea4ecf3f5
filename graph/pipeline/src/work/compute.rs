//! Work that dispatches a compute shader.

use crate::work::Subresource;
use crate::work::binding::{BoundSlot, Deferred};
use crate::work::handle::{ProgramHandle, ResourceHandle};
use crate::work::live::Live;

/// Dispatching a compute shader.
#[derive(Clone, Debug)]
pub struct ComputeWork {
    /// The shader.
    pub program: ProgramHandle,
    /// The bindings.
    pub bindings: Vec<BoundSlot>,
    /// The size of the dispatch.
    pub dispatch: Dispatch,
}

/// The size of a dispatch.
#[derive(Clone, Debug)]
pub enum Dispatch {
    /// So many workgroups.
    Workgroups([Live<Deferred>; 3]),
    /// The number of workgroups is in three words of a buffer.
    Indirect(Subresource),
    /// One invocation for each texel of a texture: workgroups cover its width, height and layers.
    Over {
        /// The texture.
        resource: ResourceHandle,
        /// The mip level whose size counts.
        mip: u32,
    },
}
