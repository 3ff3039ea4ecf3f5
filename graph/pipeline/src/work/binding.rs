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

/// An expression that is evaluated once resource sizes are known, with its place in the document for diagnostics.
#[derive(Clone, Debug)]
pub struct Deferred {
    /// The parsed expression.
    pub expression: Expression,
    /// The place of the expression in the document.
    pub place: Span,
    /// The JSON pointer of the expression.
    pub pointer: String,
}

/// A shader binding of a pass, with the resource or values that are bound to it.
#[derive(Clone, Debug)]
pub struct BoundSlot {
    /// The index of the bind group.
    pub group: u32,
    /// The binding number in the group.
    pub binding: u32,
    /// The name of the binding in the shader.
    pub name: String,
    /// The resource or values that are bound.
    pub source: SlotSource,
    /// The place of the binding in the document.
    pub place: Span,
    /// The JSON pointer of the binding.
    pub pointer: String,
}

/// The resource or values that a binding is bound to.
#[derive(Clone, Debug)]
pub enum SlotSource {
    /// A view of a texture.
    Texture(BoundTexture),
    /// A buffer of the pipeline, or a range of its bytes.
    Buffer {
        /// The buffer and the bound range of its bytes.
        buffer: Subresource,
        /// The usage of the buffer by the shader.
        usage: Usage,
    },
    /// A sampler.
    Sampler(Sampler),
    /// Blackboard data, packed into the uniform or storage block that the shader declares.
    Data {
        /// The blackboard data that is bound.
        data: Subresource,
        /// Members whose values come from expressions instead of the data; `None` if there are none.
        values: Option<BlockValues>,
    },
    /// The view that is being drawn, packed into the uniform block that the shader declares.
    View,
    /// Values of expressions, packed into the uniform block that the shader declares.
    Values(BlockValues),
}

impl SlotSource {
    /// The block members whose values come from expressions; `None` if the source has no expressions.
    pub fn values(&self) -> Option<&BlockValues> {
        match self {
            SlotSource::Values(values) => Some(values),
            SlotSource::Data { values, .. } => values.as_ref(),
            _ => None,
        }
    }
}

/// The members of a uniform or storage block that have expressions as values.
#[derive(Clone, Debug)]
pub struct BlockValues {
    /// The layout of the block as the shader declares it.
    pub layout: TypeLayout,
    /// The expressions, each with the name of its block member.
    pub expressions: Vec<(String, Live<Deferred>)>,
}

/// A texture that is bound to a shader.
#[derive(Clone, Debug)]
pub struct BoundTexture {
    /// The texture and its subresource range.
    pub texture: Subresource,
    /// The usage of the texture by the shader.
    pub usage: Usage,
    /// The dimension of the texture view, such as 2D array.
    pub shape: TextureShape,
    /// The format of the texture view; `None` for the texture's own format.
    pub format: Option<wgpu_types::TextureFormat>,
}

impl BoundTexture {
    /// The texture view that the shader reads. If the range has all aspects, the view has the depth aspect, since a
    /// shader reads either depth or stencil.
    pub fn view(&self) -> TextureView {
        let Subresource { resource, range: SubresourceRange { mip, layer, aspect, .. }, .. } = self.texture;
        let aspect = if aspect == Aspect::All { Aspect::DepthOnly } else { aspect };
        TextureView { resource, shape: self.shape, mip, layer, aspect, format: self.format }
    }
}

/// A view of a texture that a shader reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct TextureView {
    /// The texture that is viewed.
    pub resource: ResourceHandle,
    /// The dimension of the texture view, such as 2D array.
    pub shape: TextureShape,
    /// The mip levels of the view; `None` for all.
    pub mip: Option<IndexRange<u32>>,
    /// The layers of the view; `None` for all.
    pub layer: Option<IndexRange<u32>>,
    /// The aspect of the view; a shader reads either the depth or the stencil of a format that has both.
    pub aspect: Aspect,
    /// The format of the texture view; `None` for the texture's own format.
    pub format: Option<wgpu_types::TextureFormat>,
}

/// The settings of a sampler.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, default)]
pub struct Sampler {
    /// The filter within a mip level and between mip levels.
    pub filter: Filter,
    /// The address mode for texture coordinates outside of the texture.
    pub address: Address,
    /// The comparison of reference values with texels, for comparison samplers; `None` for other samplers.
    pub compare: Option<Compare>,
    /// The maximum anisotropy: samples along the direction in which a texel is squeezed most; 1 switches it off.
    pub max_anisotropy: u16,
    /// The minimum and the maximum level of detail, in thousandths of a mip level.
    pub lod_clamp: [u32; 2],
}

impl Sampler {
    /// The maximum level of detail without a clamp, in mip levels: more than any texture has.
    pub const MAX_LOD: u32 = 32;

    /// Returns `true` if the sampler reads single texels, for which a format need not be filterable.
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
    /// The filter of a sampler.
    #[derive(Default)]
    Filter = wgpu_types::FilterMode {
        /// The nearest texel.
        Nearest,
        /// Linear interpolation of the nearest texels.
        #[default]
        Linear,
    }
}

umbragraph_text::webgpu_words! {
    /// The address mode for coordinates outside of the texture.
    #[derive(Default)]
    Address = wgpu_types::AddressMode {
        /// The nearest texel of the texture's edge.
        #[default]
        ClampToEdge,
        /// The texture, repeated.
        Repeat,
        /// The texture, repeated and mirrored each time.
        MirrorRepeat,
    }
}

umbragraph_text::webgpu_words! {
    /// A comparison function of a depth test, a stencil test or a comparison sampler.
    Compare = wgpu_types::CompareFunction {
        /// The comparison never passes.
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
        /// The comparison always passes.
        Always,
    }
}

/// The layout of blackboard data in a uniform or storage block, as runs of 32-bit words to copy.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BlockLayout {
    /// The size of the block in bytes.
    pub size: u32,
    /// The runs of words to copy, each with its byte offset in the block.
    pub runs: Vec<BlockRun>,
}

/// A run of successive 32-bit words that is copied from a blackboard value to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct BlockRun {
    /// The index of the value in [`DataShape::values`](crate::data::DataShape::values).
    pub value: u32,
    /// The index of the first copied word within the value.
    pub word: u32,
    /// The number of 32-bit words.
    pub count: u32,
    /// The byte offset in the block at which the run starts.
    pub offset: u32,
}

impl BlockLayout {
    /// Packs blackboard data into the bytes of a block; bytes that no value fills stay as they are.
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
