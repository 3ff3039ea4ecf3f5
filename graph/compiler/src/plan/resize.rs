//! Planning again where only sizes change: another viewport, other sizes of the host's textures or data.
//!
//! The new plan takes over decisions that sizes do not change: kept passes and their reasons, order, formats, usages,
//! shader variants, load and store operations, and merged render passes. Sizes, workgroups, blocks, classes and memory
//! are made again, with the diagnostics about them. The result is equal to a plan from scratch.
//!
//! Planned from scratch is what changes more: the `memory` order, which weighs bytes; other formats or usages of the
//! host's textures; a number of samples, which formats depend on; layers where there were none, which render passes
//! depend on. So is what has diagnostics, since there they come in their order.
//!
//! Cost: linear in passes and resources; without graph, order and names sorted again.

use crate::contents::LiveResources;
use crate::graph::Graph;
use crate::plan::allocate;
use crate::plan::device_rules;
use crate::plan::planned::Plan;
use crate::plan::{check, plan};
use crate::request::objective::Objective;
use crate::request::options::PlanOptions;
use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Severity};
use umbragraph_pipeline::source::Sources;

impl Plan {
    /// Plans the same pipeline with other options, and reuses the rest of this plan if only sizes change. `graph` is
    /// the graph from which this plan was made.
    ///
    /// # Errors
    /// Returns the diagnostics of the new plan.
    pub fn resized(
        &self,
        graph: &Graph,
        options: &PlanOptions,
        sources: &Sources,
    ) -> Result<Self, Diagnostics> {
        if let Some(plan) = self.sizes_only(graph, options, sources) {
            return Ok(plan);
        }
        let mut diagnostics = Diagnostics::new();
        plan(&self.pipeline, graph, options, sources, &mut diagnostics).ok_or(diagnostics)
    }

    /// Returns the plan for other sizes; `None` if more than sizes changes, or if the sizes cause an error.
    fn sizes_only(&self, graph: &Graph, options: &PlanOptions, sources: &Sources) -> Option<Self> {
        let fixed = &self.fixed;
        let alike = options.objective == self.order.objective
            && options.objective != Objective::Memory
            && options.aliasing == fixed.aliasing
            && options.copyable_state == fixed.copyable_state
            && options.import_kinds() == fixed.import_kinds;
        if !alike {
            return None;
        }
        let mut diagnostics: Vec<Diagnostic> = Vec::new();
        let resolved = ResolvedResources::resized(
            &self.pipeline,
            options,
            sources,
            &fixed.resolved,
            &fixed.conditional,
        )?;
        let is_live = |pass| self.position(pass).is_some();
        check(LiveResources { resolved: &resolved, graph, is_live: &is_live }, &mut diagnostics);
        let mut plan = self.clone();
        (plan.viewport, plan.data_sizes) = (options.viewport, options.data_sizes.clone());
        for pass in &mut plan.passes {
            resolved.size_pass(pass, &mut diagnostics);
        }
        resolved.check_all_sizes();
        let is_error = |one: &Diagnostic| one.severity == Severity::Error;
        if diagnostics.iter().any(is_error) || !resolved.sizes.take_diagnostics().is_empty() {
            return None;
        }
        allocate::allocate(&mut plan, &resolved);
        device_rules::check(&plan).is_empty().then_some(plan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::{Assembly, build};
    use umbragraph_pipeline::diagnostic::codes;
    use umbragraph_pipeline::language::{Expr, Lifetime};
    use umbragraph_pipeline::pipeline::SubresourceRange;

    #[test]
    fn a_viewport_changes_sizes_only_other_options_more() {
        let mut assembly = Assembly::new("resized");
        let layered = assembly.texture_with("layered", |texture| {
            texture.lifetime = Lifetime::Persistent;
            texture.layers = Some(Expr::from("=max(1, floor(viewport.width / 100))"));
        });
        let _ = assembly.pass("fill").writes(layered);
        let (pipeline, sources) = assembly.finish();
        let mut diagnostics = Diagnostics::new();
        let graph = build(&pipeline, &mut diagnostics).expect("a graph");
        let options = PlanOptions::new(64, 64);
        let first = plan(&pipeline, &graph, &options, &sources, &mut diagnostics).expect("a plan");
        let taken_over = |options: &PlanOptions| {
            let again = first.resized(&graph, options, &sources).expect("a plan");
            Arc::ptr_eq(&first.fixed, &again.fixed)
        };
        assert!(taken_over(&PlanOptions { viewport: [65, 1], ..options.clone() }));
        // What is drawn for each layer shares no render pass.
        assert!(!taken_over(&PlanOptions { viewport: [200, 1], ..options.clone() }));
        for objective in [Objective::Memory, Objective::FewPasses] {
            assert!(!taken_over(&PlanOptions { objective, ..options.clone() }));
        }
        assert!(!taken_over(&PlanOptions { aliasing: false, ..options.clone() }));
        assert!(!taken_over(&PlanOptions { copyable_state: true, ..options }));
    }

    #[test]
    fn a_new_layer_that_only_a_toggled_pass_writes_is_found() {
        let mut assembly = Assembly::new("growing");
        let picture = assembly.texture_with("picture", |texture| {
            texture.lifetime = Lifetime::Imported;
            texture.layers = Some(Expr::from("=viewport.width"));
        });
        let toggle = assembly.toggle("on");
        let layer = |layer| SubresourceRange::of(Some(0), Some(layer));
        let always = assembly.pass("always").writes_range(picture, layer(0)).writes_range(picture, layer(1));
        let always = always.handle();
        let _ = assembly.pass("sometimes").writes(picture).toggle(toggle, true).after(always);
        let (pipeline, sources) = assembly.finish();
        let mut diagnostics = Diagnostics::new();
        let graph = build(&pipeline, &mut diagnostics).expect("a graph");
        let options = PlanOptions::new(2, 2);
        let two = plan(&pipeline, &graph, &options, &sources, &mut diagnostics).expect("a plan");
        let options = PlanOptions::new(3, 2);
        assert!(plan(&pipeline, &graph, &options, &sources, &mut diagnostics).is_none());
        let rejected = two.resized(&graph, &options, &sources).expect_err("a diagnostic");
        assert!(rejected.iter().any(|one| one.code == codes::TOGGLED_AWAY));
    }
}
