//! What a pass does, as data: the executor and the compiler interpret it, no pass touches the device itself.
//!
//! A node kind turns its settings into one [`Work`]. Render and compute work is pure data (attachments, programs,
//! bindings, sizes as expressions), so it can be checked, planned, compared and drawn without a GPU. CPU work is a
//! function from frame input to named data and views; it knows no GPU either.
//!
//! What a pass accesses follows from its work ([`Work::accesses`]) and is said nowhere else.

use std::any::Any;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::data::BlackboardData;
use crate::expression::Expression;
use crate::frame::FrameInput;
use crate::language::TextureShape;
use crate::pipeline::{Aspect, IndexRange, SubresourceRange, Usage, Version};
use crate::shader::TypeLayout;
use crate::source::Span;

/// Names a resource of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ResourceHandle(pub(crate) u32);

/// Names a pass of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct PassHandle(pub(crate) u32);

/// Names a program (a shader with all its variants) of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ProgramHandle(pub(crate) u32);

impl ResourceHandle {
    /// The handle of the resource at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::resources`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl PassHandle {
    /// The handle of the pass at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::passes`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl ProgramHandle {
    /// The handle of the program at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::programs`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A resource and the part of it that a setting names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subresource {
    /// The resource.
    pub resource: ResourceHandle,
    /// The part, as it is written.
    pub range: SubresourceRange,
    /// The version, where it is read.
    pub version: Version,
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

impl Subresource {
    /// The part as an attachment: one mip level, and one layer or the one that each view names.
    pub fn target(&self) -> AttachmentTarget {
        let (mip, layer) = (self.range.mip.map_or(0, |run| run.first), self.range.layer.map(|run| run.first));
        AttachmentTarget { resource: self.resource, mip, layer }
    }

    /// The first byte; of all of a buffer 0.
    pub fn offset(&self) -> u64 {
        self.range.bytes.map_or(0, |run| run.first)
    }
}

/// The work of a pass.
#[derive(Clone, Debug)]
pub enum Work {
    /// Nothing: of a pass that is assembled only what it accesses is known.
    Nothing,
    /// Computes data and views on the CPU.
    Cpu(CpuWork),
    /// Draws into attachments.
    Render(Box<RenderWork>),
    /// Dispatches a compute shader.
    Compute(Box<ComputeWork>),
    /// Copies texels or bytes, or clears a buffer.
    Transfer(Box<TransferWork>),
}

impl Work {
    /// What it accesses and how, in the order in which it is done.
    pub fn accesses(&self) -> Vec<(&Subresource, Usage)> {
        let mut all = Vec::new();
        match self {
            Work::Nothing => {}
            Work::Cpu(cpu) => {
                all.extend(cpu.inputs.iter().map(|input| (input, Usage::BlackboardRead)));
                all.push((&cpu.output, Usage::BlackboardWrite));
            }
            Work::Render(render) => {
                match &render.draw {
                    Draw::Fullscreen { bindings, .. } => all.extend(bound(bindings)),
                    Draw::Buffers(draw) => {
                        all.extend(bound(&draw.bindings));
                        all.extend(draw.vertices.iter().map(|stream| (&stream.buffer, Usage::Vertex)));
                        all.extend(draw.indices.iter().map(|indices| (&indices.buffer, Usage::Index)));
                        if let DrawCounts::Indirect(counts) = &draw.counts {
                            all.push((counts, Usage::Indirect));
                        }
                    }
                    Draw::Scene(scene) => {
                        all.push((&scene.views, Usage::BlackboardRead));
                        all.extend(bound(&scene.bindings));
                    }
                }
                for color in &render.color {
                    all.push((&color.to, color.usage()));
                    all.extend(color.resolve.iter().map(|to| (to, Usage::ResolveTarget)));
                }
                all.extend(render.depth.iter().map(|depth| (&depth.to, depth.usage())));
                all.extend(render.stencil.iter().map(|stencil| (&stencil.to, stencil.usage())));
            }
            Work::Compute(compute) => {
                all.extend(bound(&compute.bindings));
                if let Dispatch::Indirect(counts) = &compute.dispatch {
                    all.push((counts, Usage::Indirect));
                }
            }
            Work::Transfer(transfer) => {
                all.extend(transfer.source.iter().map(|end| (end.subresource(), Usage::CopySource)));
                all.push((transfer.destination.subresource(), transfer.written));
            }
        }
        all
    }
}

fn bound(slots: &[BoundSlot]) -> impl Iterator<Item = (&Subresource, Usage)> {
    slots.iter().filter_map(|slot| match &slot.source {
        SlotSource::Texture(bound) => Some((&bound.texture, bound.usage)),
        SlotSource::Buffer { buffer, usage } => Some((buffer, *usage)),
        SlotSource::Data { data, .. } => Some((data, Usage::BlackboardRead)),
        SlotSource::Sampler(_) | SlotSource::View | SlotSource::Values(_) => None,
    })
}

/// A function from what the host says of a frame to named data and views. The node itself is part of the plan and does
/// not change; equal nodes compute the same.
pub trait CpuNode: PartialEq + Send + Sync + std::fmt::Debug + 'static {
    /// What is kept from frame to frame; `()` for nothing. Each executor has one for each pass.
    type State: Default + Send + 'static;

    /// Computes the data of one frame. `data` comes cleared; whatever the input is, it must end up finite.
    fn run(&self, state: &mut Self::State, context: &CpuContext<'_>, data: &mut BlackboardData);
}

/// A [`CpuNode`] without its type.
pub trait AnyCpuNode: Any + Send + Sync + std::fmt::Debug {
    /// The node with a new state.
    fn start(self: Arc<Self>) -> Box<dyn CpuRun>;
    /// Whether another node is of the same type and equal.
    fn is_same(&self, other: &dyn AnyCpuNode) -> bool;
}

/// A CPU node with its state.
pub trait CpuRun: Send {
    /// Computes the data of the next frame.
    fn run(&mut self, context: &CpuContext<'_>, data: &mut BlackboardData);
}

struct Started<N: CpuNode> {
    node: Arc<N>,
    state: N::State,
}

impl<N: CpuNode> AnyCpuNode for N {
    fn start(self: Arc<Self>) -> Box<dyn CpuRun> {
        Box::new(Started { node: self, state: N::State::default() })
    }

    fn is_same(&self, other: &dyn AnyCpuNode) -> bool {
        let other: &dyn Any = other;
        other.downcast_ref::<N>().is_some_and(|other| self == other)
    }
}

impl<N: CpuNode> CpuRun for Started<N> {
    fn run(&mut self, context: &CpuContext<'_>, data: &mut BlackboardData) {
        self.node.run(&mut self.state, context, data);
    }
}

/// The input of a CPU node for one frame.
#[derive(Debug)]
pub struct CpuContext<'a> {
    /// The host's input.
    pub frame: &'a FrameInput,
    /// The width and height of the picture.
    pub viewport: [u32; 2],
    /// The data that the pass declared to read, in the order of the declaration.
    pub inputs: &'a [&'a BlackboardData],
}

/// Work on the CPU.
#[derive(Clone, Debug)]
pub struct CpuWork {
    /// The function.
    pub node: Arc<dyn AnyCpuNode>,
    /// The data that it computes.
    pub output: Subresource,
    /// The data that it reads.
    pub inputs: Vec<Subresource>,
}

impl CpuWork {
    /// A node that computes data from a frame and from other data.
    pub fn new(node: impl CpuNode, output: Subresource, inputs: Vec<Subresource>) -> Self {
        Self { node: Arc::new(node), output, inputs }
    }
}

/// Drawing into attachments.
#[derive(Clone, Debug)]
pub struct RenderWork {
    /// The color attachments in the order of the fragment shader's locations.
    pub color: Vec<ColorAttachment>,
    /// The depth attachment.
    pub depth: Option<DepthAttachment>,
    /// The stencil attachment: of the same texture, mip and layer as the depth attachment.
    pub stencil: Option<StencilAttachment>,
    /// The draw.
    pub draw: Draw,
    /// The constant of the blend equations, if there is one.
    pub blend_constant: Option<[f64; 4]>,
}

/// The part of a texture that is attached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct AttachmentTarget {
    /// The texture.
    pub resource: ResourceHandle,
    /// The mip level.
    pub mip: u32,
    /// The layer: a fixed one, or `None` for the layer that each view names.
    pub layer: Option<u32>,
}

/// A color attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorAttachment {
    /// The target.
    pub to: Subresource,
    /// The load operation.
    pub load: LoadOperation<[f64; 4]>,
    /// The blend state.
    pub blend: Option<wgpu_types::BlendState>,
    /// The channels that are written.
    pub write_mask: wgpu_types::ColorWrites,
    /// The format in which it is written, if not the texture's own.
    pub format: Option<wgpu_types::TextureFormat>,
    /// The resolve target of its samples.
    pub resolve: Option<Subresource>,
    /// Whether its contents are discarded after the pass.
    pub discard: bool,
}

impl ColorAttachment {
    /// How the texture is used.
    pub fn usage(&self) -> Usage {
        match self.load {
            LoadOperation::Load => Usage::ColorAttachmentLoad,
            LoadOperation::Clear(_) | LoadOperation::Discard => Usage::ColorAttachment,
        }
    }
}

/// A depth attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthAttachment {
    /// The target.
    pub to: Subresource,
    /// The load operation.
    pub load: LoadOperation<f64>,
    /// Whether depth is written.
    pub write: bool,
    /// The depth comparison.
    pub compare: wgpu_types::CompareFunction,
    /// The bias of the rasteriser per unit of depth slope, away from the viewer where positive and depth grows away.
    pub slope_bias: f32,
    /// Whether its contents are discarded after the pass.
    pub discard: bool,
}

impl DepthAttachment {
    /// How the texture is used.
    pub fn usage(&self) -> Usage {
        match (self.load, self.write) {
            (LoadOperation::Load, false) => Usage::DepthAttachmentReadOnly,
            (LoadOperation::Load, true) => Usage::DepthAttachmentLoad,
            _ => Usage::DepthAttachment,
        }
    }
}

/// A stencil attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct StencilAttachment {
    /// The target.
    pub to: Subresource,
    /// The load operation.
    pub load: LoadOperation<u32>,
    /// Comparisons, operations and masks.
    pub state: wgpu_types::StencilState,
    /// The reference value for comparisons and writes.
    pub reference: u32,
    /// Whether its contents are discarded after the pass.
    pub discard: bool,
}

impl StencilAttachment {
    /// How the texture is used.
    pub fn usage(&self) -> Usage {
        match self.load {
            LoadOperation::Load if self.state.is_read_only(None) => Usage::StencilAttachmentReadOnly,
            LoadOperation::Load => Usage::StencilAttachmentLoad,
            _ => Usage::StencilAttachment,
        }
    }
}

/// The load operation of an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadOperation<T> {
    /// The contents from before.
    Load,
    /// One value.
    Clear(T),
    /// Whatever; the pass writes all of it.
    Discard,
}

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
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DrawCounts {
    /// So many.
    Direct {
        /// Vertices, or indices.
        count: u32,
        /// Instances.
        instances: u32,
    },
    /// As many as bytes of a buffer say: four `u32`, or five where there are indices, as WebGPU lays them out.
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
    /// Which faces are not drawn; meshes that are double-sided are drawn from both sides whatever this says.
    pub cull: Option<wgpu_types::Face>,
    /// In which order.
    pub order: DrawOrder,
    /// Where the depth attachment keeps what was drawn from frame to frame: when views are drawn again.
    pub redraw: Option<Redraw>,
}

/// When a view is drawn again whose texels are kept: where it is not as it was drawn, or where draws have changed that
/// its filter lets through.
#[derive(Clone, Debug, PartialEq)]
pub struct Redraw {
    /// The depth to which a view's texels are cleared before.
    pub clear: f64,
    /// In every how many frames changed draws are drawn, for each view in its turn; the last counts for all beyond.
    pub every: Vec<u32>,
}

/// The order of opaque draws. Blended ones are drawn after them, from back to front, whatever this says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrawOrder {
    /// As changes the least from draw to draw.
    #[default]
    State,
    /// By their distance along the view, the nearest first: for a light's view by their distance to the light.
    FrontToBack,
}

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
    Workgroups([Deferred; 3]),
    /// As many workgroups as three words of a buffer say.
    Indirect(Subresource),
    /// As many workgroups as cover the width, height and layers of a texture with one invocation for each texel.
    Over {
        /// The texture.
        resource: ResourceHandle,
        /// The mip level whose size counts.
        mip: u32,
    },
}

/// Copying texels or bytes, or clearing a buffer.
#[derive(Clone, Debug)]
pub struct TransferWork {
    /// From where; without it the destination, a buffer, is filled with zeros.
    pub source: Option<TransferEnd>,
    /// To where.
    pub destination: TransferEnd,
    /// How the destination is used: what stays of what was there.
    pub written: Usage,
    /// The width and height of the texels that are copied; all of a mip level without it.
    pub extent: Option<[Deferred; 2]>,
}

/// One end of a transfer.
#[derive(Clone, Debug)]
pub enum TransferEnd {
    /// Bytes of a buffer.
    Buffer(BufferRegion),
    /// Texels of a texture.
    Texture(TextureRegion),
}

impl TransferEnd {
    /// The part that is copied from or to.
    pub fn subresource(&self) -> &Subresource {
        match self {
            TransferEnd::Buffer(region) => &region.buffer,
            TransferEnd::Texture(region) => &region.texture,
        }
    }
}

/// Bytes of a buffer, or texels in it: row by row, layer by layer, mip level by mip level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BufferRegion {
    /// The bytes.
    pub buffer: Subresource,
    /// From one row of texels to the next, a multiple of 256 (unit: bytes); as few as possible without it.
    pub bytes_per_row: Option<u32>,
    /// From one layer to the next (unit: rows of texel blocks); as few as possible without it.
    pub rows_per_image: Option<u32>,
}

/// Texels of a texture.
#[derive(Clone, Debug)]
pub struct TextureRegion {
    /// The mip levels, the first without it; and the layers, or slices of a volume, all without it.
    pub texture: Subresource,
    /// The texel with which it begins, from the left and from the top; the first without it.
    pub origin: Option<[Deferred; 2]>,
}

impl TextureRegion {
    /// The mip levels.
    pub fn mip(&self) -> IndexRange<u32> {
        self.texture.range.mip.unwrap_or(IndexRange::one(0))
    }
}

/// An expression that is evaluated when sizes are known, and its place for diagnostics.
#[derive(Clone, Debug)]
pub struct Deferred {
    /// The expression.
    pub expression: Expression,
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

/// One binding of a program.
#[derive(Clone, Debug)]
pub struct BoundSlot {
    /// The bind group.
    pub group: u32,
    /// The binding in it.
    pub binding: u32,
    /// The shader's own name for it.
    pub name: String,
    /// The resource or values that it is bound to.
    pub source: SlotSource,
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

/// The resource or values that a binding is bound to.
#[derive(Clone, Debug)]
pub enum SlotSource {
    /// A view of a texture.
    Texture(BoundTexture),
    /// A buffer of the pipeline, or bytes of one.
    Buffer {
        /// The bytes.
        buffer: Subresource,
        /// How the shader uses it.
        usage: Usage,
    },
    /// A sampler.
    Sampler(Sampler),
    /// Blackboard data, laid out by the shader.
    Data {
        /// The data.
        data: Subresource,
        /// Members that take the values of expressions instead.
        values: Option<BlockValues>,
    },
    /// The view being drawn, laid out by the shader.
    View,
    /// Values of expressions, laid out by the shader.
    Values(BlockValues),
}

impl SlotSource {
    /// The members of a block that take the values of expressions.
    pub fn values(&self) -> Option<&BlockValues> {
        match self {
            SlotSource::Values(values) => Some(values),
            SlotSource::Data { values, .. } => values.as_ref(),
            _ => None,
        }
    }
}

/// Members of a block, each with an expression.
#[derive(Clone, Debug)]
pub struct BlockValues {
    /// The block as the shader declares it.
    pub layout: TypeLayout,
    /// The members' expressions by name.
    pub expressions: Vec<(String, Deferred)>,
}

/// A texture that a shader sees.
#[derive(Clone, Debug)]
pub struct BoundTexture {
    /// The part.
    pub texture: Subresource,
    /// How the shader uses it.
    pub usage: Usage,
    /// The dimension of the view.
    pub shape: TextureShape,
    /// The format in which it is seen, if not its own.
    pub format: Option<wgpu_types::TextureFormat>,
}

impl BoundTexture {
    /// What the shader sees; of depth and stencil the depth, where nothing is said.
    pub fn view(&self) -> TextureView {
        let Subresource { resource, range: SubresourceRange { mip, layer, aspect, .. }, .. } = self.texture;
        let aspect = if aspect == Aspect::All { Aspect::DepthOnly } else { aspect };
        TextureView { resource, shape: self.shape, mip, layer, aspect, format: self.format }
    }
}

/// A view of a texture that a shader sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct TextureView {
    /// The texture.
    pub resource: ResourceHandle,
    /// The dimension of the view.
    pub shape: TextureShape,
    /// Mip levels, or all.
    pub mip: Option<IndexRange<u32>>,
    /// Layers, or all.
    pub layer: Option<IndexRange<u32>>,
    /// The aspect; of a format with depth and stencil a shader sees one.
    pub aspect: Aspect,
    /// The format in which it is seen, if not its own.
    pub format: Option<wgpu_types::TextureFormat>,
}

/// The settings of a sampler.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Sampler {
    /// The filter within a level and between levels.
    pub filter: Filter,
    /// The address mode.
    pub address: Address,
    /// For comparison samplers: which reference values pass against a texel.
    pub compare: Option<Compare>,
    /// The maximum number of samples along the direction in which a texel is squeezed most; 1 for no such samples.
    pub max_anisotropy: u16,
    /// The minimum and the maximum level of detail, in thousandths of a mip level.
    pub lod_clamp: [u32; 2],
}

impl Sampler {
    /// The maximum level of detail without a clamp: more mip levels than any texture has.
    pub const MAX_LOD: u32 = 32;
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            filter: Filter::Linear,
            address: Address::ClampToEdge,
            compare: None,
            max_anisotropy: 1,
            lod_clamp: [0, Self::MAX_LOD * 1000],
        }
    }
}

crate::webgpu_words! {
    /// The filter.
    #[derive(Default)]
    Filter = wgpu_types::FilterMode {
        /// The nearest texel.
        Nearest,
        /// A mix of the nearest ones.
        #[default]
        Linear,
    }
}

crate::webgpu_words! {
    /// The address mode.
    #[derive(Default)]
    Address = wgpu_types::AddressMode {
        /// The edge's texels.
        #[default]
        ClampToEdge,
        /// The texture again.
        Repeat,
        /// The texture again, mirrored.
        MirrorRepeat,
    }
}

crate::webgpu_words! {
    /// A comparison, by WebGPU's names.
    Compare = wgpu_types::CompareFunction {
        /// Nothing passes.
        Never,
        /// `<`
        Less,
        /// `==`
        Equal,
        /// `<=`
        LessEqual,
        /// `>`
        Greater,
        /// `!=`
        NotEqual,
        /// `>=`
        GreaterEqual,
        /// Everything passes.
        Always,
    }
}

/// Where the values of blackboard data go in a block: one entry for each run of words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BlockLayout {
    /// The size of the block in bytes.
    pub size: u32,
    /// The words to copy, with their place in the block.
    pub runs: Vec<BlockRun>,
}

/// A run of words that is copied to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BlockRun {
    /// The index of the value in its data's shape.
    pub value: u32,
    /// The first word of the value.
    pub word: u32,
    /// The number of words.
    pub count: u32,
    /// The byte of the block.
    pub offset: u32,
}

impl BlockLayout {
    /// Packs blackboard data into the bytes of a block; what no value fills stays as it is.
    pub fn pack(&self, data: &BlackboardData, block: &mut [u8]) {
        for run in &self.runs {
            let words = data.words_at(run.value as usize).unwrap_or_default();
            let words = words.get(run.word as usize..(run.word + run.count) as usize).unwrap_or_default();
            let bytes: &[u8] = bytemuck::cast_slice(words);
            if let Some(target) = block.get_mut(run.offset as usize..run.offset as usize + bytes.len()) {
                target.copy_from_slice(bytes);
            }
        }
    }
}
