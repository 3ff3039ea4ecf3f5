//! Draws: a triangle that covers everything, vertices of the pipeline, or the host's meshes.

use serde::{Deserialize, Serialize};

use crate::work::Subresource;
use crate::work::binding::BoundSlot;
use crate::work::handle::ProgramHandle;
use crate::work::live::{Depth, Live};

/// The geometry that a render pass draws.
#[derive(Clone, Debug)]
pub enum Draw {
    /// One triangle that covers the attachment.
    Fullscreen {
        /// The shader program that draws the triangle.
        program: ProgramHandle,
        /// The bindings of the program.
        bindings: Vec<BoundSlot>,
    },
    /// Vertices from buffers of the pipeline.
    Buffers(Box<BufferDraw>),
    /// Meshes of the host.
    Scene(SceneDraw),
}

impl Draw {
    /// The shader program and its bindings. If the host's meshes are drawn, groups 2 and 3 are the host's and are not
    /// included.
    pub fn bound(&self) -> (ProgramHandle, &[BoundSlot]) {
        match self {
            Draw::Fullscreen { program, bindings } => (*program, bindings),
            Draw::Buffers(draw) => (draw.program, &draw.bindings),
            Draw::Scene(scene) => (scene.program, &scene.bindings),
        }
    }
}

/// A draw of vertices from buffers of the pipeline.
#[derive(Clone, Debug)]
pub struct BufferDraw {
    /// The shader program that draws the vertices.
    pub program: ProgramHandle,
    /// The bindings of the program.
    pub bindings: Vec<BoundSlot>,
    /// The vertex buffers in the order of their slots.
    pub vertices: Vec<VertexStream>,
    /// The index buffer; `None` for a draw without indices.
    pub indices: Option<IndexStream>,
    /// The numbers of vertices (or indices) and instances of the draw.
    pub counts: DrawCounts,
    /// The primitive topology, such as a triangle list.
    pub topology: wgpu_types::PrimitiveTopology,
    /// The side of triangles that is culled; `None` for no culling.
    pub cull: Option<wgpu_types::Face>,
}

/// A vertex buffer of a draw, with one element for each vertex or for each instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexStream {
    /// The buffer and the range of its bytes.
    pub buffer: Subresource,
    /// The distance from one element to the next, in bytes.
    pub stride: u64,
    /// Whether the buffer has one element for each vertex or for each instance.
    pub step: wgpu_types::VertexStepMode,
    /// The attributes with their shader locations.
    pub attributes: Vec<wgpu_types::VertexAttribute>,
}

/// An index buffer of a draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndexStream {
    /// The buffer and the range of its bytes.
    pub buffer: Subresource,
    /// The format of the indices: 16 or 32 bits.
    pub format: wgpu_types::IndexFormat,
}

/// The numbers of vertices (or indices) and instances of a draw.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawCounts {
    /// Numbers that are known without a buffer.
    Direct {
        /// The number of vertices, or of indices if there is an index buffer.
        count: Live<u32>,
        /// The number of instances.
        instances: Live<u32>,
    },
    /// A buffer with WebGPU's indirect draw arguments: four `u32`, or five with indices.
    Indirect(Subresource),
}

/// Draws of the host's meshes, once for each view.
#[derive(Clone, Debug)]
pub struct SceneDraw {
    /// The name of the geometry contract that the draws follow.
    pub geometry: String,
    /// The name of the draw filter, by which the host selects the meshes to draw.
    pub filter: String,
    /// The blackboard data whose views are drawn.
    pub views: Subresource,
    /// The shader program that draws the meshes.
    pub program: ProgramHandle,
    /// The bindings of groups 0 and 1; groups 2 and 3 are the host's.
    pub bindings: Vec<BoundSlot>,
    /// The side of triangles that is culled; `None` for no culling. Double-sided meshes are never culled.
    pub cull: Option<wgpu_types::Face>,
    /// The order of the draws.
    pub order: DrawOrder,
    /// The level of detail of each view's draws; 0 is the finest. The last entry applies to all further views.
    pub detail: Vec<u32>,
    /// The rule for redrawing views if the depth attachment keeps its contents from frame to frame, else `None`.
    pub redraw: Option<Redraw>,
}

/// The rule for redrawing a view whose texels are kept from frame to frame. A view is drawn again if it differs from
/// the view as last drawn, or if draws that pass the mesh filter have changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Redraw {
    /// The depth to which a view's texels are cleared before the redraw.
    pub clear: Live<Depth>,
    /// The depth texture from which a view's texels are copied instead of being cleared; `None` to clear them.
    pub base: Option<Subresource>,
    /// For each view, the number of frames between draws of changed meshes; the last entry applies to all further
    /// views.
    pub every: Vec<u32>,
    /// Whether texels that stay visible are copied to their new place if a view moved parallel to its image plane by
    /// whole texels.
    pub scroll: bool,
}

/// The order of opaque draws. Blended draws always follow, from back to front.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrawOrder {
    /// Sorted by pipeline and bindings, for the fewest state changes.
    #[default]
    State,
    /// Sorted by distance along the view, the nearest first; for a light's view, by distance to the light.
    FrontToBack,
}
