//! Work that dispatches a compute shader.

use crate::work::Subresource;
use crate::work::binding::{BoundSlot, Deferred};
use crate::work::handle::{ProgramHandle, ResourceHandle};
use crate::work::live::Live;

/// The work of a pass that dispatches a compute shader.
#[derive(Clone, Debug)]
pub struct ComputeWork {
    /// The compute shader that is dispatched.
    pub program: ProgramHandle,
    /// The bindings of the shader program.
    pub bindings: Vec<BoundSlot>,
    /// The number of workgroups that are dispatched.
    pub dispatch: Dispatch,
}

/// The number of workgroups of a dispatch.
#[derive(Clone, Debug)]
pub enum Dispatch {
    /// Expressions for the numbers of workgroups along x, y and z.
    Workgroups([Live<Deferred>; 3]),
    /// A buffer with the numbers of workgroups as three `u32`.
    Indirect(Subresource),
    /// One invocation for each texel of a texture: workgroups cover its width, height and layers.
    Over {
        /// The texture whose texels are covered.
        resource: ResourceHandle,
        /// The mip level whose size determines the number of workgroups.
        mip: u32,
    },
}
