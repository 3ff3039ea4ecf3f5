//! WebGPU's blend equations: the combination of drawn colors with the attachment's.
//!
//! An attachment names one of a few common blends, or an equation. For color and for alpha an equation applies an
//! operation to the drawn value (source) and the attachment's (destination), each times a factor.
//!
//! ```jsonc
//! "blend": { "color": { "operation": "subtract", "src_factor": "constant", "dst_factor": "one" }, "constant": [0.5, 0.5, 0.5, 1] }
//! ```
//!
//! Factors of a second source (`src1`) take the fragment stage's second output, `@location(0) @blend_src(1)`. That
//! needs the feature `dual-source-blending` of WebGPU, and a pass with one attachment.
//!
//! Limits: one constant for all attachments of a pass.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Word};
use umbragraph_pipeline::pipeline::{Evaluate, PassBuilder};
use umbragraph_pipeline::wgpu_types::{BlendComponent, BlendFactor, BlendOperation, BlendState};
use umbragraph_pipeline::work::{Color, Live};

use crate::attachment::ColorSettings;

/// A common way to blend drawn colors (source) with those in the attachment (destination).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Blend {
    /// Drawn colors replace those in the attachment.
    Replace,
    /// Blends by the alpha of the drawn color.
    Alpha,
    /// Blends by the alpha of the drawn color, whose red, green and blue are already multiplied by alpha.
    PremultipliedAlpha,
    /// Drawn colors are added to those in the attachment.
    Add,
    /// Drawn colors are multiplied by those in the attachment.
    Multiply,
    /// The lesser of the drawn and the attachment's value, in each channel.
    Min,
    /// The greater of the drawn and the attachment's value, in each channel.
    Max,
}

/// The blend of drawn colors with those in the attachment: a word, or an equation.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum BlendSettings {
    /// One of the common blends, by name.
    Named(Word<Blend>),
    /// A blend equation with factors and operations.
    Equation(BlendEquation),
}

/// The blend equation of an attachment, for color and for alpha.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlendEquation {
    /// The equation for red, green and blue.
    pub color: BlendComponentSettings,
    /// The equation for alpha; by default the equation for color.
    pub alpha: Option<BlendComponentSettings>,
    /// The red, green, blue and alpha of the factor "constant".
    pub constant: Option<Expr>,
}

/// The blend equation of color or alpha: source · source factor, combined by an operation with destination ·
/// destination factor.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlendComponentSettings {
    /// The operation; "add" by default.
    pub operation: Option<Word<Operation>>,
    /// The factor of the drawn color; "one" by default.
    pub src_factor: Option<Word<Factor>>,
    /// The factor of the color in the attachment; "zero" by default. "min" and "max" take no factors.
    pub dst_factor: Option<Word<Factor>>,
}

umbragraph_pipeline::webgpu_words! {
    /// The operation of a blend equation, by WebGPU's names.
    Operation = BlendOperation {
        /// Source plus destination.
        Add,
        /// Source minus destination.
        Subtract,
        /// Destination minus source.
        ReverseSubtract,
        /// The lesser of source and destination, without factors.
        Min,
        /// The greater of source and destination, without factors.
        Max,
    }
}

umbragraph_pipeline::webgpu_words! {
    /// A factor of a blend equation, by WebGPU's names.
    Factor = BlendFactor {
        /// The factor 0.
        Zero,
        /// The factor 1.
        One,
        /// The color that the shader outputs (source); in the equation for alpha, its alpha.
        Src,
        /// 1 minus the source.
        OneMinusSrc,
        /// The alpha of the source.
        SrcAlpha,
        /// 1 minus the alpha of the source.
        OneMinusSrcAlpha,
        /// The color in the attachment (destination); in the equation for alpha, its alpha.
        Dst,
        /// 1 minus the destination.
        OneMinusDst,
        /// The alpha of the destination.
        DstAlpha,
        /// 1 minus the alpha of the destination.
        OneMinusDstAlpha,
        /// The lesser of the alpha of the source and 1 minus the alpha of the destination. In the equation for alpha,
        /// 1.
        SrcAlphaSaturated,
        /// The blend constant of the pass.
        Constant,
        /// 1 minus the blend constant.
        OneMinusConstant,
        /// The second output of the fragment stage (second source), for which a device needs "dual-source-blending".
        Src1,
        /// 1 minus the second source.
        OneMinusSrc1,
        /// The alpha of the second source.
        Src1Alpha,
        /// 1 minus the alpha of the second source.
        OneMinusSrc1Alpha,
    }
}

impl BlendSettings {
    /// The blend state of an attachment. `Some(None)` is no blending: drawn colors replace the old ones. `None` follows
    /// a diagnostic.
    pub(crate) fn declare(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<Option<BlendState>> {
        let equation = match self {
            Self::Named(word) => return Some(named(pass.word(word, at)?)),
            Self::Equation(equation) => equation,
        };
        let color = equation.color.declare(pass, &format!("{at}/color"))?;
        let alpha = match &equation.alpha {
            Some(settings) => settings.declare(pass, &format!("{at}/alpha"))?,
            None => color,
        };
        if [color, alpha].iter().any(BlendComponent::uses_constant) && equation.constant.is_none() {
            let message = "a factor is \"constant\", but the blend has no key \"constant\"";
            let help = "add \"constant\": red, green, blue and alpha";
            return pass.reject(codes::MISSING_KEY, at, message, help);
        }
        Some(Some(BlendState { color, alpha }))
    }
}

/// The blend constant of a pass, which all its attachments share. `Some(None)` is no constant; `None` follows a
/// diagnostic.
pub(crate) fn blend_constant(
    pass: &mut PassBuilder<'_>,
    attachments: &[ColorSettings],
) -> Option<Option<Live<Color>>> {
    let mut found = None;
    for (at, attachment) in attachments.iter().enumerate() {
        let Some(BlendSettings::Equation(BlendEquation { constant: Some(expr), .. })) = &attachment.blend
        else {
            continue;
        };
        let pointer = format!("/color/{at}/blend/constant");
        let constant: Live<Color> = pass.live_value(expr, &pointer)?;
        if found.is_some_and(|known: Live<Color>| known.value != constant.value) {
            let message = "two attachments of a pass blend with different constants";
            let help = "a pass has one constant for all of them";
            return pass.reject(codes::ATTACHMENTS, &pointer, message, help);
        }
        found = Some(constant);
    }
    Some(found)
}

impl BlendComponentSettings {
    fn declare(&self, pass: &mut PassBuilder<'_>, at: &str) -> Option<BlendComponent> {
        let operation = pass.word_or(&self.operation, format_args!("{at}/operation"), Operation::Add)?;
        if matches!(operation, Operation::Min | Operation::Max) {
            for (factor, key) in [(&self.src_factor, "src_factor"), (&self.dst_factor, "dst_factor")] {
                if factor.is_some() {
                    let message = "\"min\" and \"max\" compare what is drawn with what is there as they are";
                    let pointer = format!("{at}/{key}");
                    let help = "remove \"src_factor\" and \"dst_factor\"";
                    return pass.reject(codes::ATTACHMENTS, &pointer, message, help);
                }
            }
            let one = BlendFactor::One;
            return Some(BlendComponent { src_factor: one, dst_factor: one, operation: operation.into() });
        }
        let src_factor = pass.word_or(&self.src_factor, format_args!("{at}/src_factor"), Factor::One)?;
        let dst_factor = pass.word_or(&self.dst_factor, format_args!("{at}/dst_factor"), Factor::Zero)?;
        Some(BlendComponent {
            src_factor: src_factor.into(),
            dst_factor: dst_factor.into(),
            operation: operation.into(),
        })
    }
}

fn named(blend: Blend) -> Option<BlendState> {
    let both = |src_factor, dst_factor, operation| {
        let component = BlendComponent { src_factor, dst_factor, operation };
        Some(BlendState { color: component, alpha: component })
    };
    let one = BlendFactor::One;
    match blend {
        Blend::Replace => None,
        Blend::Alpha => Some(BlendState::ALPHA_BLENDING),
        Blend::PremultipliedAlpha => Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        Blend::Add => both(one, one, BlendOperation::Add),
        Blend::Multiply => both(BlendFactor::Dst, BlendFactor::Zero, BlendOperation::Add),
        Blend::Min => both(one, one, BlendOperation::Min),
        Blend::Max => both(one, one, BlendOperation::Max),
    }
}
