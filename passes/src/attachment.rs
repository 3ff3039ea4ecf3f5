//! Settings of attachments, shared by the node kinds that draw.
//!
//! `clear` clears an attachment before a pass, `contents` loads or discards it. Without either, a pass that certainly
//! covers everything discards, and every other pass loads. A pass covers everything if it is full screen with the
//! module's own triangle or one like it, and has no `discard`, no `sample_mask`, no blending, depth or stencil.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Ref, Word};
use umbragraph_pipeline::pipeline::{
    Contents, Evaluate, Face as CubeFace, IndexRange, PassBuilder, Produced, SubresourceRange,
    SubresourceRangeSettings,
};
use umbragraph_pipeline::wgpu_types::{ColorWrites, StencilFaceState, StencilOperation, StencilState};
use umbragraph_pipeline::work::{
    AttachmentTarget, Byte, ColorAttachment, Compare, DepthAttachment, Draw, Live, LiveValue, LoadOperation,
    RenderWork, StencilAttachment, Subresource, Work,
};

use crate::blend::{BlendSettings, blend_constant};
use crate::if_said::if_said;

/// The common settings of attachments: the texture, and its contents before and after the pass.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Attached {
    /// The texture: a reference.
    pub to: Ref,
    /// The mip level of the texture; 0 by default.
    pub mip: Option<Expr>,
    /// The index of the layer; with "face", the index of the cube. By default the layer that a draw's view names.
    pub layer: Option<Expr>,
    /// The face of a cube texture to draw into.
    pub face: Option<Word<CubeFace>>,
    /// The treatment of the old contents, instead of "clear": "load" keeps them, "discard" leaves them undefined. The
    /// default is "load"; a full-screen pass that surely overwrites a whole color attachment without blending discards.
    pub contents: Option<Word<Contents>>,
    /// The store operation after the pass; "automatic" by default. "automatic" stores contents that a later pass reads
    /// or that outlive the frame. "discard" is for contents that nobody reads, not even the host.
    pub store: Option<Word<Store>>,
}

/// A color attachment.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColorSettings {
    /// The texture and its contents.
    #[serde(flatten)]
    pub attached: Attached,
    /// The red, green, blue and alpha to which the attachment is cleared before the pass.
    pub clear: Option<Expr>,
    /// The blending of drawn colors with those in the attachment: a word, or an equation. By default drawn colors
    /// replace them.
    pub blend: Option<BlendSettings>,
    /// The channels that are written, such as ["red", "green"]; all by default. Other channels stay unchanged.
    pub write_mask: Option<Vec<ColorChannel>>,
    /// The target to which a multisampled attachment is resolved: the samples of each texel become one texel.
    pub resolve: Option<ResolveSettings>,
    /// The format of the attachment's view, if it is not the texture's own. It may only add or remove "-srgb".
    pub format: Option<String>,
}

/// The target to which the samples of a color attachment are resolved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveSettings {
    /// The texture: a reference. It must be single-sampled, with the format and size of the attachment.
    pub to: Ref,
    /// The mip level of the texture; 0 by default.
    pub mip: Option<Expr>,
    /// The index of the layer; by default the layer of the attachment.
    pub layer: Option<Expr>,
}

/// The store operation of an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Store {
    /// Contents are stored if a later pass needs them or they outlive the frame.
    Automatic,
    /// Contents are discarded after the pass.
    Discard,
}

/// A channel of a color.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColorChannel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha.
    Alpha,
}

impl From<ColorChannel> for ColorWrites {
    fn from(channel: ColorChannel) -> Self {
        match channel {
            ColorChannel::Red => Self::RED,
            ColorChannel::Green => Self::GREEN,
            ColorChannel::Blue => Self::BLUE,
            ColorChannel::Alpha => Self::ALPHA,
        }
    }
}

/// The depth attachment.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DepthSettings {
    /// The texture and its contents.
    #[serde(flatten)]
    pub attached: Attached,
    /// The depth to which the attachment is cleared before the pass; without this key the old depth is loaded.
    pub clear: Option<Expr>,
    /// Whether depth is written; true by default.
    pub write: Option<Expr>,
    /// The comparison of a drawn depth with the one in the attachment, such as "less-equal".
    pub compare: Word<Compare>,
    /// The rasteriser's bias for each unit of slope of depth (unit: hardware); 0 by default. A positive bias moves
    /// surfaces away from the viewer, in the direction of depth that "compare" implies.
    pub slope_bias: Option<Expr>,
}

/// The stencil attachment: eight bits for each texel that decide whether fragments are drawn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StencilSettings {
    /// The texture and its contents.
    #[serde(flatten)]
    pub attached: Attached,
    /// The value to which the stencil is cleared before the pass (0 to 255); without this key the old values are
    /// loaded.
    pub clear: Option<Expr>,
    /// The reference value that is compared with the stencil, and that "replace" writes (0 to 255); 0 by default.
    pub reference: Option<Expr>,
    /// The mask of the bits that are compared (0 to 255); all bits by default.
    pub read_mask: Option<Expr>,
    /// The mask of the bits that are written (0 to 255); all bits by default.
    pub write_mask: Option<Expr>,
    /// The test and the operations for front faces; by default every fragment passes and the stencil stays unchanged.
    pub front: Option<StencilFace>,
    /// The test and the operations for back faces; by default those of front faces.
    pub back: Option<StencilFace>,
}

/// The stencil test of one side of triangles, and the operations on the stencil that follow the test.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StencilFace {
    /// The comparison of the reference value with the stencil; "always" by default.
    pub compare: Option<Word<Compare>>,
    /// The operation if the stencil test fails; "keep" by default.
    pub fail: Option<Word<StencilOperationName>>,
    /// The operation if the stencil test passes and the depth test fails; "keep" by default.
    pub depth_fail: Option<Word<StencilOperationName>>,
    /// The operation if the stencil test and the depth test pass; "keep" by default.
    pub pass: Option<Word<StencilOperationName>>,
}

umbragraph_pipeline::webgpu_words! {
    /// The operation on the stencil value, by WebGPU's names.
    StencilOperationName = StencilOperation {
        /// Keeps the value.
        Keep,
        /// Sets the value to 0.
        Zero,
        /// Sets the value to the reference value.
        Replace,
        /// Inverts all bits of the value.
        Invert,
        /// Adds 1; 255 stays 255.
        IncrementClamp,
        /// Subtracts 1; 0 stays 0.
        DecrementClamp,
        /// Adds 1; 255 becomes 0.
        IncrementWrap,
        /// Subtracts 1; 0 becomes 255.
        DecrementWrap,
    }
}

/// The attachments of a pass.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Attachments {
    /// The color attachments, in the order of the shader's locations.
    #[serde(default)]
    pub color: Vec<ColorSettings>,
    /// The depth attachment. The triangle of a full-screen pass is tested, and written, at the depth of its vertices.
    pub depth: Option<DepthSettings>,
    /// The stencil attachment: fragments are drawn only where the stencil test passes. With "depth", both name the same
    /// texture, mip level and layer.
    pub stencil: Option<StencilSettings>,
}

impl Attachments {
    /// Reports a pass without any attachment, and then returns `None`.
    pub(crate) fn check(&self, pass: &mut PassBuilder<'_>) -> Option<()> {
        if self.color.is_empty() && self.depth.is_none() && self.stencil.is_none() {
            let help = "add \"color\", \"depth\" or \"stencil\"";
            return pass.reject(codes::MISSING_KEY, "", "a pass without attachments draws nothing", help);
        }
        Some(())
    }

    /// Declares the attachments and the draw of a pass. `covers` is `true` if the pass surely writes every texel.
    pub(crate) fn render(
        &self,
        pass: &mut PassBuilder<'_>,
        covers: bool,
        mut draw: Option<Draw>,
    ) -> Option<Produced> {
        let color: Vec<_> = (self.color.iter().enumerate())
            .map(|(at, settings)| settings.declare(pass, at, covers))
            .collect();
        let depth = if_said(&self.depth, |settings| settings.declare(pass, "/depth"));
        let stencil = if_said(&self.stencil, |settings| settings.declare(pass, "/stencil"));
        let color = color.into_iter().collect::<Option<Vec<_>>>()?;
        let (mut depth, stencil) = (depth?, stencil?);
        if let (Some(depth), Some(stencil), Some(own), Some(other)) =
            (&depth, &stencil, &self.depth, &self.stencil)
            && depth.to.target() != stencil.to.target()
        {
            let place = |texture: &Ref, at: AttachmentTarget| {
                let layer = at.layer.map(|layer| format!(" of layer {layer}")).unwrap_or_default();
                format!("mip {}{layer} of \"{texture}\"", at.mip)
            };
            let (own, other) =
                (place(&own.attached.to, depth.to.target()), place(&other.attached.to, stencil.to.target()));
            let message = format!("depth is attached to {own}, stencil to {other}");
            let help = "give \"depth\" and \"stencil\" one texture, mip and layer";
            return pass.reject(codes::ATTACHMENTS, "/stencil/to", message, help);
        }
        crate::draw::keep(pass, &color, depth.as_mut(), stencil.is_some(), draw.as_mut())?;
        let blend_constant = blend_constant(pass, &self.color)?;
        pass.produce(Work::Render(Box::new(RenderWork {
            color,
            depth,
            stencil,
            draw: draw?,
            blend_constant,
        })))
    }
}

impl Attached {
    /// The load operation: clear to the value of `clear`, or the word of `contents`. `without` is used if neither is
    /// set.
    fn load<T: LiveValue>(
        &self,
        pass: &mut PassBuilder<'_>,
        clear: &Option<Expr>,
        at: &str,
        without: LoadOperation<Live<T>>,
    ) -> Option<LoadOperation<Live<T>>> {
        let load = match (clear, &self.contents) {
            (Some(expr), _) => LoadOperation::Clear(pass.live_value(expr, &format!("{at}/clear"))?),
            (None, None) => return Some(without),
            (None, Some(word)) => match pass.word(word, &format!("{at}/contents"))? {
                Contents::Load => LoadOperation::Load,
                Contents::Discard => LoadOperation::Discard,
            },
        };
        if clear.is_some() && self.contents.is_some() {
            let help = "remove one of the two: \"clear\" says what it holds before";
            let message = "\"clear\" and \"contents\" exclude one another";
            return pass.reject(codes::ATTACHMENTS, &format!("{at}/contents"), message, help);
        }
        Some(load)
    }

    fn target(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<Subresource> {
        target(pass, &self.to, (&self.mip, &self.layer, &self.face), at)
    }

    fn discards(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<bool> {
        Some(pass.word_or(&self.store, format_args!("{at}/store"), Store::Automatic)? == Store::Discard)
    }
}

impl ColorSettings {
    /// Declares a color attachment. `covers` is `true` if the pass surely writes every texel.
    fn declare(&self, pass: &mut PassBuilder<'_>, index: usize, covers: bool) -> Option<ColorAttachment> {
        let at = &format!("/color/{index}");
        let blend =
            if_said(&self.blend, |settings| settings.declare(pass, &format!("{at}/blend")))?.flatten();
        let all = ColorWrites::ALL;
        let write_mask = self
            .write_mask
            .as_ref()
            .map_or(all, |channels| channels.iter().map(|channel| ColorWrites::from(*channel)).collect());
        let replaces = covers && blend.is_none() && write_mask == all;
        let without = if replaces { LoadOperation::Discard } else { LoadOperation::Load };
        let load = self.attached.load(pass, &self.clear, at, without)?;
        let format = if_said(&self.format, |name| pass.format(name, &format!("{at}/format")))?;
        let to = self.attached.target(pass, at)?;
        let resolve = if_said(&self.resolve, |resolve| {
            target(pass, &resolve.to, (&resolve.mip, &resolve.layer, &None), &format!("{at}/resolve"))
        })?;
        let discard = self.attached.discards(pass, at)?;
        Some(ColorAttachment { to, load, blend, write_mask, format, resolve, discard })
    }
}

impl DepthSettings {
    fn declare(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<DepthAttachment> {
        let write = pass.boolean_or(&self.write, format_args!("{at}/write"), true)?;
        let compare = pass.word(&self.compare, &format!("{at}/compare"))?;
        let load = self.attached.load(pass, &self.clear, at, LoadOperation::Load)?;
        let pointer = format!("{at}/slope_bias");
        let bias = pass.number_or(&self.slope_bias, &pointer, 0.0)? as f32;
        if !bias.is_finite() {
            let message = "the bias is beyond 32-bit floating point";
            return pass.reject(codes::OUT_OF_BOUNDS, &pointer, message, "a few units are plenty");
        }
        let grows_toward_viewer = matches!(compare, Compare::Greater | Compare::GreaterEqual);
        let to = self.attached.target(pass, at)?;
        let discard = self.attached.discards(pass, at)?;
        let slope_bias = if grows_toward_viewer { -bias } else { bias };
        Some(DepthAttachment { discard, to, load, write, compare: compare.into(), slope_bias })
    }
}

impl StencilSettings {
    /// Declares the stencil attachment of a pass, at the JSON pointer `at`.
    fn declare(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<StencilAttachment> {
        let load = self.attached.load(pass, &self.clear, at, LoadOperation::Load)?;
        let front = if_said(&self.front, |face| face.declare(pass, &format!("{at}/front")))?;
        let front = front.unwrap_or(StencilFaceState::IGNORE);
        let back = if_said(&self.back, |face| face.declare(pass, &format!("{at}/back")))?.unwrap_or(front);
        let mut mask = |expr: &Option<Expr>, key: &str| {
            let mask = if_said(expr, |expr| pass.read(expr, &format!("{at}/{key}")))?;
            Some(mask.map_or(255, |Byte(mask)| mask.into()))
        };
        let read_mask = mask(&self.read_mask, "read_mask")?;
        let write_mask = mask(&self.write_mask, "write_mask")?;
        let reference = if_said(&self.reference, |expr| pass.live_value(expr, &format!("{at}/reference")))?;
        let reference = reference.unwrap_or_else(|| Byte(0).into());
        let to = self.attached.target(pass, at)?;
        let discard = self.attached.discards(pass, at)?;
        let state = StencilState { front, back, read_mask, write_mask };
        Some(StencilAttachment { to, load, state, reference, discard })
    }
}

impl StencilFace {
    fn declare(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<StencilFaceState> {
        let mut operation = |word: &Option<Word<StencilOperationName>>, key: &str| {
            pass.word_or(word, format_args!("{at}/{key}"), StencilOperationName::Keep).map(Into::into)
        };
        let fail_op = operation(&self.fail, "fail");
        let depth_fail_op = operation(&self.depth_fail, "depth_fail");
        let pass_op = operation(&self.pass, "pass");
        let compare = pass.word_or(&self.compare, format_args!("{at}/compare"), Compare::Always)?.into();
        let (fail_op, depth_fail_op, pass_op) = (fail_op?, depth_fail_op?, pass_op?);
        Some(StencilFaceState { compare, fail_op, depth_fail_op, pass_op })
    }
}

fn target(
    pass: &mut PassBuilder<'_>,
    to: &Ref,
    (mip, layer, face): (&Option<Expr>, &Option<Expr>, &Option<Word<CubeFace>>),
    at: &str,
) -> Option<Subresource> {
    let (mip, layer, face) = (mip.clone(), layer.clone(), face.clone());
    let settings = SubresourceRangeSettings { mip, layer, face, ..SubresourceRangeSettings::default() };
    let range = pass.subresource_range(&settings, at)?;
    let mip = range.mip.map_or(0, |run| run.first);
    pass.texture(to, SubresourceRange { mip: Some(IndexRange::one(mip)), ..range }, &format!("{at}/to"))
}
