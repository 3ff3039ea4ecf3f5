//! The node kind `fullscreen`: a fragment shader over every texel of its attachments.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};
use umbragraph_pipeline::work::Draw;

use crate::attachment::Attachments;
use crate::shader::ShaderSettings;

/// Runs a fragment shader for every texel of its attachments.
///
/// The template's vertex stage makes one triangle from `vertex_index` 0 to 2 that covers clip space. If full coverage
/// is not certain (another vertex stage, `discard`, `sample_mask`), old contents stay where nothing is drawn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fullscreen {
    /// The shader template with its axes, bindings and entry points.
    #[serde(flatten)]
    pub shader: ShaderSettings,
    /// The color, depth and stencil attachments.
    #[serde(flatten)]
    pub attachments: Attachments,
}

impl Node for Fullscreen {
    const NAME: &'static str = "fullscreen";
    const SUMMARY: &'static str = "Runs a fragment shader for every texel of its attachments.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let (program, bindings) = self.shader.declare(pass, None);
        if let Some(program) = program {
            pass.check_vertex_inputs(program, &[], "/shader")?;
        }
        // What depth, stencil or the shader keeps from being drawn stays as it was.
        let is_tested = self.attachments.depth.is_some() || self.attachments.stencil.is_some();
        let covers = !is_tested && program.is_some_and(|program| pass.covers(program));
        self.attachments.check(pass)?;
        let draw = program.zip(bindings).map(|(program, bindings)| Draw::Fullscreen { program, bindings });
        self.attachments.render(pass, covers, draw)
    }
}
