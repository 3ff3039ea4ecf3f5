//! Work that dispatches a compute shader.

use crate::work::Subresource;
use crate::work::binding::{BoundSlot, Deferred};
use crate::work::handle::{ProgramHandle, ResourceHandle};
use crate::work::live::Live;

/// The work of a pass that dispatches a compute shader.
#[derive(Clone, Debug)]
pub struct ComputeWork {
    /// The shader program.
    pub program: ProgramHandle,
    /// The bindings of the program.
    pub bindings: Vec<BoundSlot>,
    /// The size of the dispatch.
    pub dispatch: Dispatch,
}

/// The size of a dispatch.
#[derive(Clone, Debug)]
pub enum Dispatch {
    /// The numbers of workgroups along x, y and z.
    Workgroups([Live<Deferred>; 3]),
    /// The numbers of workgroups are three `u32` in a buffer.
    Indirect(Subresource),
    /// One invocation for each texel of a texture: workgroups cover its width, height and layers.
    Over {
        /// The texture.
        resource: ResourceHandle,
        /// The mip level whose size determines the number of workgroups.
        mip: u32,
    },
}
