//! The node kind `draw`: the host's meshes, once for each view.

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Ref, Word};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, IndexRange, PassBuilder, Produced, SubresourceRange};
use umbragraph_pipeline::wgpu_types::Face;
use umbragraph_pipeline::work::{
    ColorAttachment, Depth, DepthAttachment, Draw as DrawWork, DrawOrder, LoadOperation, Redraw, SceneDraw,
};

use crate::attachment::Attachments;
use crate::if_said::if_said;
use crate::shader::ShaderSettings;

/// The greatest value of `every`: the frames after which a view with changed meshes is drawn again.
const MAX_EVERY: f64 = 65536.0;

/// The coarsest level of detail that a pass can set.
const MAX_DETAIL: f64 = 255.0;

/// Draws the host's meshes, once for each view. A template without a fragment stage draws only depth.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Draw {
    /// The name of the geometry contract (under "geometry") that the meshes follow, or an expression with an equals
    /// sign that yields it.
    pub geometry: Word<String>,
    /// The filter that chooses the meshes: a word that the host knows. The built-in pipelines use "opaque",
    /// "transparent" (blended meshes), "casters" and "moving" (for motion vectors). Pipelines that keep shadow maps
    /// from frame to frame use "static_casters" and "dynamic_casters".
    pub mesh_filter: String,
    /// The blackboard data with the views to draw, such as the data that a camera or a cascade fit publishes.
    pub views: Ref,
    /// The shader template with its axes, bindings and entry points.
    #[serde(flatten)]
    pub shader: ShaderSettings,
    /// The color, depth and stencil attachments.
    #[serde(flatten)]
    pub attachments: Attachments,
    /// The faces that are culled; "back" by default. Double-sided meshes are drawn from both sides.
    pub cull: Option<Word<Cull>>,
    /// The order of opaque meshes; "state" by default.
    pub order: Option<Word<DrawOrder>>,
    /// The level of detail that the host draws; 0, the finest, by default. It is a number, or a list with one for each
    /// view, whose last number counts for all further views. The host draws a mesh with fewer levels at its coarsest
    /// level.
    pub detail: Option<Expr>,
    /// The views that are drawn in a frame; "always" by default.
    pub redraw: Option<Word<RedrawWhen>>,
    /// With "changed", the number of frames after which a view with changed meshes is drawn again; 1 by default. It is
    /// a number, or a list with one for each view, whose last number counts for all further views. A view that has
    /// itself changed is drawn at once.
    pub every: Option<Expr>,
    /// With "changed", whether a view that moved in its own plane by whole texels is scrolled; false by default. Its
    /// old depth is then moved, and only the strips that came into view are drawn. The depth range of the views has to
    /// stay the same ("near_pull": "scene").
    pub scroll: Option<Expr>,
    /// With "changed", a depth texture of the same size that each view starts from, instead of "clear" of the
    /// attachment. A view is drawn again where this texture has changed, if a pass with "changed" draws it, or else
    /// always.
    pub base: Option<Ref>,
}

/// The choice of the views that are drawn in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RedrawWhen {
    /// All views are drawn in every frame.
    Always,
    /// Only views that have changed, or whose meshes have changed according to the host, are cleared and drawn again.
    /// The texels of other views stay unchanged, in a persistent depth texture.
    Changed,
}

/// The faces that are culled. Front faces are counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Cull {
    /// No faces are culled.
    None,
    /// Front faces are culled.
    Front,
    /// Back faces are culled.
    Back,
}

impl Cull {
    /// The face that is culled; `None` if both are drawn.
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
        let geometry = pass.word(&self.geometry, "/geometry")?;
        pass.geometry(&geometry, "/geometry")?;
        let draw = self.scene(pass, geometry);
        self.attachments.render(pass, false, draw)
    }
}

impl Draw {
    fn scene(&self, pass: &mut PassBuilder<'_>, geometry: String) -> Option<DrawWork> {
        let views = pass.data(&self.views, "/views");
        pass.filter(&geometry, &self.mesh_filter, "/mesh_filter");
        let (program, bindings) = self.shader.declare(pass, Some(&geometry));
        let cull = pass.word_or(&self.cull, "/cull", Cull::Back)?;
        let order = pass.word_or(&self.order, "/order", DrawOrder::default())?;
        Some(DrawWork::Scene(SceneDraw {
            geometry,
            filter: self.mesh_filter.clone(),
            views: views?,
            program: program?,
            bindings: bindings?,
            cull: cull.face(),
            order,
            detail: self.detail(pass)?,
            redraw: self.redraw(pass)?,
        }))
    }

    /// The level of detail of each view, 0 the finest; the last entry counts for all further views. `None` follows a
    /// diagnostic.
    fn detail(&self, pass: &mut PassBuilder<'_>) -> Option<Vec<u32>> {
        let Some(expr) = &self.detail else { return Some(vec![0]) };
        let help = format!("write numbers from 0, the finest, to {MAX_DETAIL}");
        counts(pass, expr, "/detail", 0.0..=MAX_DETAIL, "levels of detail are whole numbers", help)
    }

    /// The settings for drawing changed views only; `Some(None)` if all views are drawn in every frame. [`keep`] sets
    /// the depth to which views are cleared.
    fn redraw(&self, pass: &mut PassBuilder<'_>) -> Option<Option<Redraw>> {
        if pass.word_or(&self.redraw, "/redraw", RedrawWhen::Always)? == RedrawWhen::Always {
            let settings = [
                ("every", self.every.is_some()),
                ("scroll", self.scroll.is_some()),
                ("base", self.base.is_some()),
            ];
            let Some((name, _)) = settings.into_iter().find(|(_, is_said)| *is_said && self.redraw.is_none())
            else {
                return Some(None);
            };
            let message = format!("\"{name}\" is set, but \"redraw\" is \"always\"");
            let help = format!("add \"redraw\": \"changed\", or remove \"{name}\"");
            return pass.reject(codes::OUT_OF_BOUNDS, &format!("/{name}"), message, help);
        }
        let every = if_said(&self.every, |expr| {
            let message = "changed meshes are drawn in every so many frames, a whole number";
            let help = format!("write numbers from 1 to {MAX_EVERY}");
            counts(pass, expr, "/every", 1.0..=MAX_EVERY, message, help)
        })?;
        let every = every.unwrap_or_else(|| vec![1]);
        let scroll = pass.boolean_or(&self.scroll, "/scroll", false)?;
        let mip = Some(IndexRange::one(0));
        let range = SubresourceRange { mip, ..SubresourceRange::default() };
        let base = if_said(&self.base, |name| pass.texture(name, range, "/base"))?;
        if scroll && base.is_some() {
            let message = "what is drawn over another texture does not scroll";
            return pass.reject(codes::ATTACHMENTS, "/scroll", message, "remove \"scroll\", or \"base\"");
        }
        Some(Some(Redraw { clear: Depth(0.0).into(), base, every, scroll }))
    }
}

/// Evaluates one or more whole numbers, all within `range`; `None` follows a diagnostic.
fn counts(
    pass: &mut PassBuilder<'_>,
    expr: &Expr,
    pointer: &str,
    range: RangeInclusive<f64>,
    message: &str,
    help: String,
) -> Option<Vec<u32>> {
    let numbers = pass.numbers(expr, pointer)?;
    if numbers.is_empty() || !numbers.iter().all(|number| number.fract() == 0.0 && range.contains(number)) {
        return pass.reject(codes::OUT_OF_BOUNDS, pointer, message, help);
    }
    Some(numbers.into_iter().map(|number| number as u32).collect())
}

/// Makes the depth attachment of a pass with "redraw": "changed" load its old contents, since each view is cleared by
/// itself. Rejects other attachments of such a pass.
pub(crate) fn keep(
    pass: &mut PassBuilder<'_>,
    color: &[ColorAttachment],
    depth: Option<&mut DepthAttachment>,
    has_stencil: bool,
    draw: Option<&mut DrawWork>,
) -> Option<()> {
    let Some(DrawWork::Scene(SceneDraw { redraw: Some(redraw), .. })) = draw else { return Some(()) };
    if let (Some(DepthAttachment { load, write: true, .. }), [], false) = (depth, color, has_stencil) {
        match (std::mem::replace(load, LoadOperation::Load), &redraw.base) {
            (LoadOperation::Clear(clear), None) => {
                redraw.clear = clear;
                return Some(());
            }
            (LoadOperation::Load, Some(_)) => return Some(()),
            (LoadOperation::Clear(_), Some(_)) => {
                let message = "\"base\" and \"clear\" of the depth attachment both say what views begin with";
                let help = "remove one of the two; a \"clear\" of shared settings goes with \"clear\": null";
                return pass.reject(codes::ATTACHMENTS, "/base", message, help);
            }
            _ => {}
        }
    }
    let message =
        "what a pass that draws changed views keeps is depth that it clears and writes, and nothing else";
    let help = "attach \"depth\" alone, with \"clear\" or \"base\"; or remove \"redraw\"";
    pass.reject(codes::ATTACHMENTS, "/redraw", message, help)
}
