//! The node kind `view`: one view of other data, for a target of its own.
//!
//! A fit publishes a set of views, and a pass that draws them draws all, each into its layer or tile of one texture. If
//! each needs its own texture, put a `view` between: it publishes the view of one index, which draws into the texture's
//! only layer. No values are published with it.
//!
//! Limits: the texels within the texture are those of the set. A frame in which the set has no such view has none here.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, DataShape};
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

/// Publishes one view of a set of views, to be drawn into a texture of its own.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// The blackboard data with the views, such as what a cascade fit publishes.
    pub from: Ref,
    /// The index of the view in the set, from 0.
    pub index: Expr,
}

impl Node for View {
    const NAME: &'static str = "view";
    const SUMMARY: &'static str = "Publishes one view of other data, to be drawn into a texture of its own.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let index = pass.live(|pass| pass.count(&self.index, "/index"));
        let input = pass.data(&self.from, "/from");
        let output = pass.publish(&self.to, "/to", DataShape::new().views(1))?;
        pass.produce(Work::Cpu(CpuWork::new(
            OneView { setting: self.index.clone(), index: index? },
            output,
            vec![input?],
        )))
    }
}

#[derive(Clone, Debug, PartialEq)]
struct OneView {
    setting: Expr,
    index: u32,
}

impl CpuNode for OneView {
    type State = ();

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        self.index = settings.count(&self.setting, "/index")?;
        Some(())
    }

    fn run(&self, (): &mut (), context: &CpuContext<'_>, data: &mut BlackboardData) {
        let Some(input) = context.inputs.first() else { return };
        let at = self.index as usize;
        if let Some((view, cadence)) = input.views().get(at).zip(input.cadences().get(at)) {
            data.push_view_every(view.layer(0), *cadence);
        }
    }
}
