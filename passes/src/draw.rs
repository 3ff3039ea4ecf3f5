//! The node kind `draw`: the host's meshes, once for each view.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::language::Word;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};
use umbragraph_pipeline::wgpu_types::Face;
use umbragraph_pipeline::work::{Draw as DrawWork, DrawOrder, SceneDraw};

use crate::attachment::Attachments;
use crate::shader::ShaderSettings;

/// Draws the host's meshes, once for each view. Without a fragment stage in the template only depth is drawn.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// The contract under "geometry" that the meshes follow.
    pub geometry: String,
    /// Which of the host's meshes: a word that the host knows, such as "opaque" or "casters".
    pub filter: String,
    /// The blackboard data whose views are drawn, such as what a camera or a cascade fit publishes.
    pub views: String,
    /// The shader.
    #[serde(flatten)]
    pub shader: ShaderSettings,
    /// The attachments.
    #[serde(flatten)]
    pub attachments: Attachments,
    /// Which faces are not drawn: "back" without it. Meshes that are double-sided are drawn from both sides.
    pub cull: Option<Word<Cull>>,
    /// In which order opaque meshes are drawn: "state" without it.
    pub order: Option<Word<DrawOrder>>,
}

/// Which faces are not drawn. Front faces are counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Cull {
    /// Both sides are drawn.
    None,
    /// Front faces are not drawn.
    Front,
    /// Back faces are not drawn.
    Back,
}

impl Cull {
    /// The face that is not drawn.
    pub(crate) fn face(self) -> Option<Face> {
        match self {
            Cull::None => None,
            Cull::Front => Some(Face::Front),
            Cull::Back => Some(Face::Back),
        }
    }
}

impl Node for Draw {
    const NAME: &'static str = "draw";
    const SUMMARY: &'static str = "Draws the host's meshes, once for each view.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        pass.geometry(&self.geometry, "/geometry")?;
        let draw = self.scene(pass);
        self.attachments.render(pass, false, draw)
    }
}

impl Draw {
    fn scene(&self, pass: &mut PassBuilder<'_>) -> Option<DrawWork> {
        let views = pass.data(&self.views, "/views");
        let (program, bindings) = self.shader.declare(pass, Some(&self.geometry));
        let cull = pass.word_or(&self.cull, "/cull", Cull::Back)?;
        let order = pass.word_or(&self.order, "/order", DrawOrder::default())?;
        Some(DrawWork::Scene(SceneDraw {
            geometry: self.geometry.clone(),
            filter: self.filter.clone(),
            views: views?,
            program: program?,
            bindings: bindings?,
            cull: cull.face(),
            order,
        }))
    }
}
