//! The draw contract: how the host's meshes get into a pass.
//!
//! The pipeline's `geometry` says what a template may want. The host says here, once and without a device, how it
//! stores that: a [`HostInterface`] with vertex buffers, blocks with their members' offsets, and the combinations of
//! mesh properties that occur. The module checks it against every shader that draws it, builds all pipelines and bind
//! groups, and at record time hands the host a `DrawPass` for each view: the host binds its vertex buffers and issues
//! draws, choosing properties, material and object by number.
//!
//! Conventions: bind group 2 is the material, one bind group for each of the host's materials; bind group 3 is the
//! object, one bind group in all, whose blocks are moved by a dynamic offset of a fixed stride for each object, and whose
//! arrays stay in place: shaders index them by instance. A host that has bind groups of its own for one of the two says
//! their layout, and binds them itself. Front faces are counter-clockwise.
//!
//! Meshes whose vertices are stored otherwise than most have a property, and their sets of properties have vertex
//! buffers of their own. What is in vertex buffers can change from instance to instance, too.

mod check;
mod interface;

pub use check::check_host;
pub(crate) use check::misspelt_hosts;
pub use interface::{
    DOUBLE_SIDED, HostAttribute, HostFilters, HostInterface, HostMember, HostResource, HostResourceKind,
    HostVertexBuffer, MATERIAL_GROUP, OBJECT_GROUP, PropertySet,
};
