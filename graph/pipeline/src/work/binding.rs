//! Bindings of a shader with their sources, and the layout of blocks.

use serde::{Deserialize, Serialize};

use crate::access::{Aspect, IndexRange, SubresourceRange, Usage};
use crate::data::BlackboardData;
use crate::work::Subresource;
use crate::work::handle::ResourceHandle;
use crate::work::live::Live;
use umbragraph_shaders::TypeLayout;
use umbragraph_text::expression::Expression;
use umbragraph_text::language::TextureShape;
use umbragraph_text::source::Span;

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
        /// The usage by the shader.
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
    pub expressions: Vec<(String, Live<Deferred>)>,
}

/// A texture that a shader sees.
#[derive(Clone, Debug)]
pub struct BoundTexture {
    /// The part.
    pub texture: Subresource,
    /// The usage by the shader.
    pub usage: Usage,
    /// The dimension of the view.
    pub shape: TextureShape,
    /// The format in which it is seen, if not its own.
    pub format: Option<wgpu_types::TextureFormat>,
}

impl BoundTexture {
    /// The view that the shader samples; of depth and stencil the depth, unless an aspect is given.
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

    /// Whether it reads single texels, for which a format need not be filterable.
    pub fn is_nearest(&self) -> bool {
        self.filter == Filter::Nearest && self.max_anisotropy == 1 && self.compare.is_none()
    }
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

umbragraph_text::webgpu_words! {
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

umbragraph_text::webgpu_words! {
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

umbragraph_text::webgpu_words! {
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

/// The layout of blackboard data in a block: one entry for each run of words.
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
