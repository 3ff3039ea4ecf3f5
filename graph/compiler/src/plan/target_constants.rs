//! Pipeline constants that follow from the format of a pass's target.
//!
//! A target in a format with `-srgb` encodes what is written; in any other a shader that shows colors has to. A
//! template asks which it is with an axis that says `"from": "linear_target"`: the constant is true where the first
//! color attachment, as the pass sees it, encodes nothing. What the pass or the pipeline says of the axis counts over
//! it.

use wgpu_types::TextureFormat;

use crate::plan::planned::Plan;
use umbragraph_pipeline::pipeline::{Program, ProgramVariant};
use umbragraph_pipeline::work::{RenderWork, ResourceHandle, Work};

impl Plan {
    /// Returns the names and values of the pipeline constants (WGSL overrides) of a shader variant in a render pass.
    pub fn constants(
        &self,
        program: &Program,
        variant: &ProgramVariant,
        render: &RenderWork,
    ) -> impl Iterator<Item = (String, f64)> {
        let format = |resource: ResourceHandle| self.resource(resource)?.format;
        of_variant(program, variant, is_linear(render, &format))
    }
}

/// Returns the names and values of the pipeline constants of a shader variant in a pass. `format` returns the format of
/// a texture; `None` if it is not known.
pub(crate) fn of_work(
    program: &Program,
    variant: &ProgramVariant,
    work: &Work,
    format: &dyn Fn(ResourceHandle) -> Option<TextureFormat>,
) -> impl Iterator<Item = (String, f64)> {
    let linear = match work {
        Work::Render(render) => is_linear(render, format),
        _ => None,
    };
    of_variant(program, variant, linear)
}

fn of_variant(
    program: &Program,
    variant: &ProgramVariant,
    linear: Option<bool>,
) -> impl Iterator<Item = (String, f64)> {
    variant.module.constants.iter().map(move |(name, value)| {
        let follows = linear.filter(|_| program.from_target.contains(name));
        (name.clone(), follows.map_or(*value, |linear| f64::from(u8::from(linear))))
    })
}

/// Returns `true` if the first color attachment has a format without sRGB encoding. Returns `None` without a color
/// attachment, or if the format is not known.
fn is_linear(render: &RenderWork, format: &dyn Fn(ResourceHandle) -> Option<TextureFormat>) -> Option<bool> {
    let color = render.color.first()?;
    Some(!color.format.or_else(|| format(color.to.resource))?.is_srgb())
}
