//! Settings of attachments, shared by the node kinds that draw.
//!
//! What an attachment holds before a pass follows from what is said: `clear` clears; otherwise a pass that covers
//! everything (full screen, without blending) discards, and every other pass loads.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_graph::diagnostic::codes;
use umbragraph_graph::language::{Expr, Word};
use umbragraph_graph::pipeline::{Part, PassBuilder, Usage};
use umbragraph_graph::wgpu_types::{BlendComponent, BlendFactor, BlendOperation, BlendState};
use umbragraph_graph::work::{AttachmentTarget, ColorAttachment, Compare, DepthAttachment, LoadOperation};

/// A color attachment.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColorSettings {
    /// The texture: a reference.
    pub to: String,
    /// The mip level.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer; without it the one that the view names.
    #[serde(default)]
    pub layer: Option<Expr>,
    /// Red, green, blue and alpha that it holds before.
    #[serde(default)]
    pub clear: Option<Expr>,
    /// How colors are combined with what is there; without it they replace it.
    #[serde(default)]
    pub blend: Option<Word<Blend>>,
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
    /// The layer; without it the one that the view names.
    #[serde(default)]
    pub layer: Option<Expr>,
    /// The depth that it holds before; without it what was there.
    #[serde(default)]
    pub clear: Option<Expr>,
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

/// Declares a color attachment. `covers` says that the pass writes every texel.
pub(crate) fn color(
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
        None if covers && blend.is_none() => LoadOperation::Discard,
        None => LoadOperation::Load,
    };
    let usage = if load == LoadOperation::Load { Usage::ColorAttachmentLoad } else { Usage::ColorAttachment };
    let target = target(pass, &settings.to, &settings.mip, &settings.layer, usage, at)?;
    Some(ColorAttachment { target, load, blend })
}

/// Declares the depth attachment.
pub(crate) fn depth(
    pass: &mut PassBuilder<'_>,
    settings: &DepthSettings,
    at: &str,
) -> Option<DepthAttachment> {
    let write = match &settings.write {
        Some(expr) => pass.boolean(expr, &format!("{at}/write"))?,
        None => true,
    };
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
        None => LoadOperation::Load,
    };
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
    let usage = match (load, write) {
        (LoadOperation::Load, false) => Usage::DepthAttachmentReadOnly,
        (LoadOperation::Load, true) => Usage::DepthAttachmentLoad,
        _ => Usage::DepthAttachment,
    };
    let target = target(pass, &settings.to, &settings.mip, &settings.layer, usage, at)?;
    Some(DepthAttachment {
        target,
        load,
        write,
        compare: compare.into(),
        slope_bias: if grows_toward_viewer { -bias } else { bias },
    })
}

fn target(
    pass: &mut PassBuilder<'_>,
    to: &str,
    mip: &Option<Expr>,
    layer: &Option<Expr>,
    usage: Usage,
    at: &str,
) -> Option<AttachmentTarget> {
    let mip = match mip {
        Some(expr) => pass.count(expr, &format!("{at}/mip"))?,
        None => 0,
    };
    let layer = match layer {
        Some(expr) => Some(pass.count(expr, &format!("{at}/layer"))?),
        None => None,
    };
    let resource = pass.texture(to, Part { mip: Some(mip), layer }, usage, &format!("{at}/to"))?;
    Some(AttachmentTarget { resource, mip, layer })
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
