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
    /// The pipeline constants of a variant in a pass that draws, by name.
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

/// The constants of a variant of a pass with some work, with formats of textures.
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

/// Whether the first color attachment encodes nothing; `None` without one, or where its format is not known.
fn is_linear(render: &RenderWork, format: &dyn Fn(ResourceHandle) -> Option<TextureFormat>) -> Option<bool> {
    let color = render.color.first()?;
    Some(!color.format.or_else(|| format(color.to.resource))?.is_srgb())
}
