//! Draws: a triangle that covers everything, vertices of the pipeline, or the host's meshes.

use serde::{Deserialize, Serialize};

use crate::work::Subresource;
use crate::work::binding::BoundSlot;
use crate::work::handle::ProgramHandle;
use crate::work::live::{Depth, Live};

/// The draw.
#[derive(Clone, Debug)]
pub enum Draw {
    /// One triangle that covers the attachment.
    Fullscreen {
        /// The shader.
        program: ProgramHandle,
        /// The bindings.
        bindings: Vec<BoundSlot>,
    },
    /// Vertices from the pipeline's own buffers.
    Buffers(Box<BufferDraw>),
    /// The host's draws.
    Scene(SceneDraw),
}

impl Draw {
    /// The shader, and what its bindings are; those of groups 2 and 3 are the host's where its meshes are drawn.
    pub fn bound(&self) -> (ProgramHandle, &[BoundSlot]) {
        match self {
            Draw::Fullscreen { program, bindings } => (*program, bindings),
            Draw::Buffers(draw) => (draw.program, &draw.bindings),
            Draw::Scene(scene) => (scene.program, &scene.bindings),
        }
    }
}

/// Vertices from the pipeline's own buffers.
#[derive(Clone, Debug)]
pub struct BufferDraw {
    /// The shader.
    pub program: ProgramHandle,
    /// The bindings.
    pub bindings: Vec<BoundSlot>,
    /// The vertex buffers in the order of their slots.
    pub vertices: Vec<VertexStream>,
    /// The indices, if vertices are drawn by them.
    pub indices: Option<IndexStream>,
    /// The counts of vertices and instances.
    pub counts: DrawCounts,
    /// The primitive topology.
    pub topology: wgpu_types::PrimitiveTopology,
    /// The faces that are culled.
    pub cull: Option<wgpu_types::Face>,
}

/// A buffer of vertices, or of what changes from instance to instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexStream {
    /// The buffer.
    pub buffer: Subresource,
    /// Bytes from one element to the next.
    pub stride: u64,
    /// Whether elements belong to vertices or to instances.
    pub step: wgpu_types::VertexStepMode,
    /// The attributes, by the locations of the shader.
    pub attributes: Vec<wgpu_types::VertexAttribute>,
}

/// A buffer of indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndexStream {
    /// The buffer.
    pub buffer: Subresource,
    /// Their format.
    pub format: wgpu_types::IndexFormat,
}

/// The counts of vertices, or indices, and instances of a draw.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawCounts {
    /// So many.
    Direct {
        /// Vertices, or indices.
        count: Live<u32>,
        /// Instances.
        instances: Live<u32>,
    },
    /// The counts are in a buffer: four `u32`, or five with indices, as WebGPU lays them out.
    Indirect(Subresource),
}

/// The host's draws, once for each view.
#[derive(Clone, Debug)]
pub struct SceneDraw {
    /// The contract that the draws follow.
    pub geometry: String,
    /// The filter of the host's draws: a word that the host knows.
    pub filter: String,
    /// The data whose views are drawn.
    pub views: Subresource,
    /// The shader.
    pub program: ProgramHandle,
    /// The bindings of groups 0 and 1; groups 2 and 3 are the host's.
    pub bindings: Vec<BoundSlot>,
    /// The faces that are culled; double-sided meshes are drawn from both sides whatever this says.
    pub cull: Option<wgpu_types::Face>,
    /// The order of the draws.
    pub order: DrawOrder,
    /// The level of detail of each view's draws, 0 the finest; the last counts for all beyond.
    pub detail: Vec<u32>,
    /// The rule for drawing views again, if the depth attachment keeps its contents from frame to frame.
    pub redraw: Option<Redraw>,
}

/// When a view is drawn again whose texels are kept: where it is not as it was drawn, or where draws have changed that
/// its filter lets through.
#[derive(Clone, Debug, PartialEq)]
pub struct Redraw {
    /// The depth to which a view's texels are cleared before.
    pub clear: Live<Depth>,
    /// The depth texture from which they are taken instead.
    pub base: Option<Subresource>,
    /// The number of frames between draws of changed meshes, for each view; the last counts for all beyond.
    pub every: Vec<u32>,
    /// Whether what a view still shows is moved along where it moved by whole texels over its plane.
    pub scroll: bool,
}

/// The order of opaque draws. Blended ones are drawn after them, from back to front, whatever this says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrawOrder {
    /// By pipeline and bindings, so that state changes least.
    #[default]
    State,
    /// By their distance along the view, the nearest first: for a light's view by their distance to the light.
    FrontToBack,
}
