//! Settings of attachments, shared by the node kinds that draw.
//!
//! What an attachment holds before a pass follows from what is said: `clear` clears, `contents` loads or discards;
//! otherwise a pass that is known to cover everything (full screen, the module's own triangle or one like it, no `discard`,
//! no `sample_mask`, no blending, depth or stencil) discards, and every other pass loads.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Word};
use umbragraph_pipeline::pipeline::{
    Contents, Face as CubeFace, IndexRange, PassBuilder, Produced, SubresourceRange, SubresourceRangeSettings,
};
use umbragraph_pipeline::wgpu_types::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, StencilFaceState, StencilOperation, StencilState,
};
use umbragraph_pipeline::work::{
    ColorAttachment, Compare, DepthAttachment, Draw, LoadOperation, RenderWork, StencilAttachment,
    Subresource, Work,
};

/// A color attachment.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColorSettings {
    /// The texture: a reference.
    pub to: String,
    /// The mip level.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer, without it the one that the view names; beside "face" the cube.
    #[serde(default)]
    pub layer: Option<Expr>,
    /// One face of a cube.
    #[serde(default)]
    pub face: Option<Word<CubeFace>>,
    /// Red, green, blue and alpha that it holds before.
    #[serde(default)]
    pub clear: Option<Expr>,
    /// Instead of "clear" whether what was there is needed: "load", or "discard" where all of it is drawn over;
    /// without it a full-screen pass that is known to draw over all of it without blending discards, and any other loads.
    #[serde(default)]
    pub contents: Option<Word<Contents>>,
    /// What happens to it after the pass: "automatic" without it, which stores it where something reads it later or it
    /// outlives the frame; "discard" where nobody reads it, not even the host.
    #[serde(default)]
    pub store: Option<Word<Store>>,
    /// How colors are combined with what is there; without it they replace it.
    #[serde(default)]
    pub blend: Option<Word<Blend>>,
    /// Where its samples are resolved to, one for each texel, for a texture of several samples.
    #[serde(default)]
    pub resolve: Option<ResolveSettings>,
    /// The format in which it is written, where it is not the texture's own: the same with or without "-srgb".
    #[serde(default)]
    pub format: Option<String>,
}

/// Where the samples of a color attachment are resolved to.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolveSettings {
    /// The texture: a reference. It has one sample, and the format and size of the attachment.
    pub to: String,
    /// The mip level.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer; without it that of the attachment.
    #[serde(default)]
    pub layer: Option<Expr>,
}

/// The store operation of an attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Store {
    /// It is stored where it is needed.
    Automatic,
    /// It is discarded.
    Discard,
}

/// How colors are combined with what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Blend {
    /// They replace it.
    Replace,
    /// By their alpha.
    Alpha,
    /// By their alpha, which is multiplied into the color already.
    PremultipliedAlpha,
    /// They are added.
    Add,
}

/// The depth attachment.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DepthSettings {
    /// The texture: a reference.
    pub to: String,
    /// The mip level.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer, without it the one that the view names; beside "face" the cube.
    #[serde(default)]
    pub layer: Option<Expr>,
    /// One face of a cube.
    #[serde(default)]
    pub face: Option<Word<CubeFace>>,
    /// The depth that it holds before; without it what was there.
    #[serde(default)]
    pub clear: Option<Expr>,
    /// Instead of "clear" whether what was there is needed: "load", or "discard" where all of it is drawn over.
    #[serde(default)]
    pub contents: Option<Word<Contents>>,
    /// What happens to it after the pass: "automatic" without it, which stores it where something reads it later or it
    /// outlives the frame; "discard" where nobody reads it, not even the host.
    #[serde(default)]
    pub store: Option<Word<Store>>,
    /// Whether depth is written; true without it.
    #[serde(default)]
    pub write: Option<Expr>,
    /// Which depths pass against what is there, such as "less-equal".
    pub compare: Word<Compare>,
    /// The rasteriser's bias for each unit of slope of depth (unit: hardware). It moves surfaces away from the viewer
    /// in whichever direction depth grows, as "compare" tells.
    #[serde(default)]
    pub slope_bias: Option<Expr>,
}

/// The stencil attachment: the eight bits of each texel that decide what is drawn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StencilSettings {
    /// The texture: a reference. Beside "depth" it is the same.
    pub to: String,
    /// The mip level.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer, without it the one that the view names; beside "face" the cube.
    #[serde(default)]
    pub layer: Option<Expr>,
    /// One face of a cube.
    #[serde(default)]
    pub face: Option<Word<CubeFace>>,
    /// The value that it holds before (0 to 255); without it what was there.
    #[serde(default)]
    pub clear: Option<Expr>,
    /// Instead of "clear" whether what was there is needed: "load", or "discard" where all of it is drawn over.
    #[serde(default)]
    pub contents: Option<Word<Contents>>,
    /// What happens to it after the pass: "automatic" without it, which stores it where something reads it later or it
    /// outlives the frame; "discard" where nobody reads it, not even the host.
    #[serde(default)]
    pub store: Option<Word<Store>>,
    /// What is compared with what is there, and what "replace" writes (0 to 255); 0 without it.
    #[serde(default)]
    pub reference: Option<Expr>,
    /// Which bits are compared (0 to 255); all without it.
    #[serde(default)]
    pub read_mask: Option<Expr>,
    /// Which bits are written (0 to 255); all without it.
    #[serde(default)]
    pub write_mask: Option<Expr>,
    /// What is compared and done for front faces; without it everything passes and nothing changes.
    #[serde(default)]
    pub front: Option<StencilFace>,
    /// The same for back faces; as for front faces without it.
    #[serde(default)]
    pub back: Option<StencilFace>,
}

/// What is compared, and what happens to the stencil.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StencilFace {
    /// Which references pass against what is there; "always" without it.
    #[serde(default)]
    pub compare: Option<Word<Compare>>,
    /// What happens where the stencil fails; "keep" without it.
    #[serde(default)]
    pub fail: Option<Word<StencilOperationName>>,
    /// What happens where the stencil passes and depth fails; "keep" without it.
    #[serde(default)]
    pub depth_fail: Option<Word<StencilOperationName>>,
    /// What happens where both pass; "keep" without it.
    #[serde(default)]
    pub pass: Option<Word<StencilOperationName>>,
}

/// What happens to the stencil, by WebGPU's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StencilOperationName {
    /// Nothing.
    Keep,
    /// It becomes 0.
    Zero,
    /// It becomes the reference.
    Replace,
    /// All bits are turned round.
    Invert,
    /// One more, 255 at most.
    IncrementClamp,
    /// One less, 0 at least.
    DecrementClamp,
    /// One more, 0 after 255.
    IncrementWrap,
    /// One less, 255 after 0.
    DecrementWrap,
}

impl From<StencilOperationName> for StencilOperation {
    fn from(name: StencilOperationName) -> Self {
        match name {
            StencilOperationName::Keep => Self::Keep,
            StencilOperationName::Zero => Self::Zero,
            StencilOperationName::Replace => Self::Replace,
            StencilOperationName::Invert => Self::Invert,
            StencilOperationName::IncrementClamp => Self::IncrementClamp,
            StencilOperationName::DecrementClamp => Self::DecrementClamp,
            StencilOperationName::IncrementWrap => Self::IncrementWrap,
            StencilOperationName::DecrementWrap => Self::DecrementWrap,
        }
    }
}

/// The settings of all attachments of a pass.
pub(crate) struct Attachments<'a> {
    pub(crate) color: &'a [ColorSettings],
    pub(crate) depth: Option<&'a DepthSettings>,
    pub(crate) stencil: Option<&'a StencilSettings>,
}

impl Attachments<'_> {
    /// Finds a pass that attaches nothing.
    pub(crate) fn check(&self, pass: &mut PassBuilder<'_>) -> Option<()> {
        if self.color.is_empty() && self.depth.is_none() && self.stencil.is_none() {
            let help = "add \"color\", \"depth\" or \"stencil\"";
            pass.report(codes::MISSING_KEY, "", "a pass without attachments draws nothing", help);
            return None;
        }
        Some(())
    }

    /// Declares them and what is drawn. `covers` says that the pass writes every texel.
    pub(crate) fn render(
        self,
        pass: &mut PassBuilder<'_>,
        covers: bool,
        draw: Option<Draw>,
    ) -> Option<Produced> {
        let color: Vec<_> = (self.color.iter().enumerate())
            .map(|(at, settings)| color(pass, settings, &format!("/color/{at}"), covers))
            .collect();
        let depth = self.depth.map(|settings| depth(pass, settings, "/depth"));
        let stencil = self.stencil.map(|settings| stencil(pass, settings, "/stencil"));
        let color = color.into_iter().collect::<Option<_>>()?;
        let (depth, stencil) = (all(depth)?, all(stencil)?);
        same_target(pass, depth.as_ref(), stencil.as_ref())?;
        pass.produce(Work::Render(Box::new(RenderWork { color, depth, stencil, draw: draw? })))
    }
}

/// `None` after at least one diagnostic.
fn all<T>(declared: Option<Option<T>>) -> Option<Option<T>> {
    declared.map_or(Some(None), |declared| declared.map(Some))
}

/// Declares a color attachment. `covers` says that the pass writes every texel.
fn color(
    pass: &mut PassBuilder<'_>,
    settings: &ColorSettings,
    at: &str,
    covers: bool,
) -> Option<ColorAttachment> {
    let blend = match &settings.blend {
        Some(word) => blend_state(pass.word(word, &format!("{at}/blend"))?),
        None => None,
    };
    let load = match &settings.clear {
        Some(expr) => {
            let pointer = format!("{at}/clear");
            let numbers = pass.numbers(expr, &pointer)?;
            let Ok(value) = <[f64; 4]>::try_from(numbers.as_slice()) else {
                let message = format!("a color has four numbers, not {}", numbers.len());
                pass.report(
                    codes::OUT_OF_BOUNDS,
                    &pointer,
                    message,
                    "write red, green, blue and alpha: [0, 0, 0, 1]",
                );
                return None;
            };
            LoadOperation::Clear(value)
        }
        None => {
            let without =
                if covers && blend.is_none() { LoadOperation::Discard } else { LoadOperation::Load };
            contents(pass, settings.contents.as_ref(), without, at)?
        }
    };
    one_beginning(pass, settings.clear.as_ref(), settings.contents.as_ref(), at)?;
    let format = match &settings.format {
        Some(name) => Some(pass.format(name, &format!("{at}/format"))?),
        None => None,
    };
    let to = target(pass, &settings.to, (&settings.mip, &settings.layer, &settings.face), at)?;
    let resolve = match &settings.resolve {
        Some(to) => {
            let at = format!("{at}/resolve");
            Some(target(pass, &to.to, (&to.mip, &to.layer, &None), &at)?)
        }
        None => None,
    };
    let discard = discards(pass, settings.store.as_ref(), at)?;
    Some(ColorAttachment { to, load, blend, format, resolve, discard })
}

/// Declares the depth attachment.
fn depth(pass: &mut PassBuilder<'_>, settings: &DepthSettings, at: &str) -> Option<DepthAttachment> {
    let write = pass.boolean_or(&settings.write, &format!("{at}/write"), true)?;
    let compare = pass.word(&settings.compare, &format!("{at}/compare"))?;
    let load = match &settings.clear {
        Some(expr) => {
            let pointer = format!("{at}/clear");
            let value = pass.number(expr, &pointer)?;
            if !(0.0..=1.0).contains(&value) {
                let message = format!("depth is cleared to {value}");
                pass.report(codes::OUT_OF_BOUNDS, &pointer, message, "depth lies between 0 and 1");
                return None;
            }
            LoadOperation::Clear(value)
        }
        None => contents(pass, settings.contents.as_ref(), LoadOperation::Load, at)?,
    };
    one_beginning(pass, settings.clear.as_ref(), settings.contents.as_ref(), at)?;
    let bias = match &settings.slope_bias {
        Some(expr) => {
            let pointer = format!("{at}/slope_bias");
            let value = pass.number(expr, &pointer)? as f32;
            if !value.is_finite() {
                pass.report(
                    codes::OUT_OF_BOUNDS,
                    &pointer,
                    "the bias is beyond 32-bit floating point",
                    "a few units are plenty",
                );
                return None;
            }
            value
        }
        None => 0.0,
    };
    let grows_toward_viewer = matches!(compare, Compare::Greater | Compare::GreaterEqual);
    let to = target(pass, &settings.to, (&settings.mip, &settings.layer, &settings.face), at)?;
    let discard = discards(pass, settings.store.as_ref(), at)?;
    Some(DepthAttachment {
        discard,
        to,
        load,
        write,
        compare: compare.into(),
        slope_bias: if grows_toward_viewer { -bias } else { bias },
    })
}

/// Declares the stencil attachment beside a depth attachment, which has to be of the same texture.
fn stencil(pass: &mut PassBuilder<'_>, settings: &StencilSettings, at: &str) -> Option<StencilAttachment> {
    let byte = |pass: &mut PassBuilder<'_>, expr: &Option<Expr>, key: &str, without: u32| match expr {
        Some(expr) => {
            let pointer = format!("{at}/{key}");
            let value = pass.count(expr, &pointer)?;
            if value > 255 {
                let message = format!("stencil has eight bits, not {value}");
                pass.report(codes::OUT_OF_BOUNDS, &pointer, message, "0 to 255 are possible");
                return None;
            }
            Some(value)
        }
        None => Some(without),
    };
    let load = match &settings.clear {
        Some(_) => LoadOperation::Clear(byte(pass, &settings.clear, "clear", 0)?),
        None => contents(pass, settings.contents.as_ref(), LoadOperation::Load, at)?,
    };
    one_beginning(pass, settings.clear.as_ref(), settings.contents.as_ref(), at)?;
    let front = match &settings.front {
        Some(face) => stencil_face(pass, face, &format!("{at}/front"))?,
        None => StencilFaceState::IGNORE,
    };
    let back = match &settings.back {
        Some(face) => stencil_face(pass, face, &format!("{at}/back"))?,
        None => front,
    };
    let state = StencilState {
        front,
        back,
        read_mask: byte(pass, &settings.read_mask, "read_mask", 255)?,
        write_mask: byte(pass, &settings.write_mask, "write_mask", 255)?,
    };
    let reference = byte(pass, &settings.reference, "reference", 0)?;
    let to = target(pass, &settings.to, (&settings.mip, &settings.layer, &settings.face), at)?;
    let discard = discards(pass, settings.store.as_ref(), at)?;
    Some(StencilAttachment { to, load, state, reference, discard })
}

fn stencil_face(pass: &mut PassBuilder<'_>, settings: &StencilFace, at: &str) -> Option<StencilFaceState> {
    let operation =
        |pass: &mut PassBuilder<'_>, word: &Option<Word<StencilOperationName>>, key: &str| match word {
            Some(word) => pass.word(word, &format!("{at}/{key}")).map(Into::into),
            None => Some(StencilOperation::Keep),
        };
    Some(StencilFaceState {
        compare: match &settings.compare {
            Some(word) => pass.word(word, &format!("{at}/compare"))?.into(),
            None => Compare::Always.into(),
        },
        fail_op: operation(pass, &settings.fail, "fail")?,
        depth_fail_op: operation(pass, &settings.depth_fail, "depth_fail")?,
        pass_op: operation(pass, &settings.pass, "pass")?,
    })
}

/// Finds a stencil attachment of another texture, mip or layer than the depth attachment.
fn same_target(
    pass: &mut PassBuilder<'_>,
    depth: Option<&DepthAttachment>,
    stencil: Option<&StencilAttachment>,
) -> Option<()> {
    if let (Some(depth), Some(stencil)) = (depth, stencil)
        && depth.to.target() != stencil.to.target()
    {
        let help = "give \"depth\" and \"stencil\" one texture, mip and layer";
        let message = "depth and stencil of one pass belong to one texture";
        pass.report(codes::ATTACHMENTS, "/stencil/to", message, help);
        return None;
    }
    Some(())
}

/// What an attachment that is not cleared holds before.
fn contents<T>(
    pass: &mut PassBuilder<'_>,
    said: Option<&Word<Contents>>,
    without: LoadOperation<T>,
    at: &str,
) -> Option<LoadOperation<T>> {
    let Some(word) = said else { return Some(without) };
    Some(match pass.word(word, &format!("{at}/contents"))? {
        Contents::Load => LoadOperation::Load,
        Contents::Discard => LoadOperation::Discard,
    })
}

/// Whether an attachment is discarded.
fn discards(pass: &mut PassBuilder<'_>, store: Option<&Word<Store>>, at: &str) -> Option<bool> {
    let Some(word) = store else { return Some(false) };
    Some(pass.word(word, &format!("{at}/store"))? == Store::Discard)
}

/// Finds "clear" and "contents" side by side.
fn one_beginning(
    pass: &mut PassBuilder<'_>,
    clear: Option<&Expr>,
    contents: Option<&Word<Contents>>,
    at: &str,
) -> Option<()> {
    if clear.is_some() && contents.is_some() {
        let help = "remove one of the two: \"clear\" says what it holds before";
        let message = "\"clear\" and \"contents\" exclude one another";
        pass.report(codes::ATTACHMENTS, &format!("{at}/contents"), message, help);
        return None;
    }
    Some(())
}

fn target(
    pass: &mut PassBuilder<'_>,
    to: &str,
    (mip, layer, face): (&Option<Expr>, &Option<Expr>, &Option<Word<CubeFace>>),
    at: &str,
) -> Option<Subresource> {
    let (mip, layer, face) = (mip.as_ref(), layer.as_ref(), face.as_ref());
    let range = pass.subresource_range(
        SubresourceRangeSettings { mip, layer, face, ..SubresourceRangeSettings::default() },
        at,
    )?;
    let mip = range.mip.map_or(0, |run| run.first);
    pass.texture(to, SubresourceRange { mip: Some(IndexRange::one(mip)), ..range }, &format!("{at}/to"))
}

fn blend_state(blend: Blend) -> Option<BlendState> {
    let component =
        |src_factor, dst_factor| BlendComponent { src_factor, dst_factor, operation: BlendOperation::Add };
    match blend {
        Blend::Replace => None,
        Blend::Alpha => Some(BlendState::ALPHA_BLENDING),
        Blend::PremultipliedAlpha => Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        Blend::Add => {
            let add = component(BlendFactor::One, BlendFactor::One);
            Some(BlendState { color: add, alpha: add })
        }
    }
}
