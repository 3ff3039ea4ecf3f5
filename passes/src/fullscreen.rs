//! The node kind `fullscreen`: a fragment shader over every texel of its attachments.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Bind, PassBuilder, Produced};
use umbragraph_pipeline::work::Draw;

use crate::attachment::{Attachments, ColorSettings, DepthSettings, StencilSettings};

/// Runs a fragment shader for every texel of its attachments.
///
/// The template's vertex stage makes one triangle that covers clip space from `vertex_index` 0 to 2. Where that is not
/// known (another vertex stage, `discard`, `sample_mask`), what was there before stays where nothing is drawn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fullscreen {
    /// The template.
    pub shader: String,
    /// Values for axes of the template; an axis that is not named takes the feature or parameter of its name.
    #[serde(default)]
    pub axes: BTreeMap<String, Expr>,
    /// What stands behind the shader's bindings.
    #[serde(default)]
    pub bind: BTreeMap<String, Bind>,
    /// The color attachments, in the order of the shader's locations.
    #[serde(default)]
    pub color: Vec<ColorSettings>,
    /// The depth attachment: the triangle is tested, and written, at the depth of its vertices.
    #[serde(default)]
    pub depth: Option<DepthSettings>,
    /// The stencil attachment: only where the stencil passes is something drawn.
    #[serde(default)]
    pub stencil: Option<StencilSettings>,
}

impl Node for Fullscreen {
    const NAME: &'static str = "fullscreen";
    const SUMMARY: &'static str = "Runs a fragment shader for every texel of its attachments.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let program = pass.program(&self.shader, &self.axes, None, "");
        let bindings = program.and_then(|program| pass.bind(program, &self.bind, None, ""));
        if let Some(program) = program {
            pass.check_vertex_inputs(program, &[], "/shader")?;
        }
        // What depth, stencil or the shader keeps from being drawn stays as it was.
        let is_tested = self.depth.is_some() || self.stencil.is_some();
        let covers = !is_tested && program.is_some_and(|program| pass.covers(program));
        let attachments =
            Attachments { color: &self.color, depth: self.depth.as_ref(), stencil: self.stencil.as_ref() };
        attachments.check(pass)?;
        let draw = program.zip(bindings).map(|(program, bindings)| Draw::Fullscreen { program, bindings });
        attachments.render(pass, covers, draw)
    }
}
