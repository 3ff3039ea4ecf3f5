//! One live pass after the other, in their order: attachments, shader variants, and what its sizes
//! come to.

use crate::plan::planned::{PlannedAttachment, PlannedPass};
use crate::plan::target_constants;
use crate::resources::format;
use crate::resources::resolved::ResolvedResources;
use crate::schedule::cull::KeepReason;
use umbragraph_pipeline::diagnostic::Diagnostic;
use umbragraph_pipeline::pipeline::{Access, Aspect, Condition, TypedPipeline};
use umbragraph_pipeline::work::{PassHandle, Work};

/// The planner of the live passes in one execution order.
pub(crate) struct Planner<'a> {
    pub(crate) pipeline: &'a TypedPipeline,
    pub(crate) resolved: &'a ResolvedResources<'a>,
    /// For each resource, indexed by handle: the accesses by live passes with their position in execution order,
    /// ascending.
    pub(crate) users: Vec<Vec<(usize, &'a Access)>>,
    /// For each position in execution order: the toggle condition under which the pass runs; `None` if it always runs.
    pub(crate) conditions: Vec<Option<Condition>>,
}

impl<'a> Planner<'a> {
    /// Creates a planner for the live passes in execution order.
    pub(crate) fn new(resolved: &'a ResolvedResources<'a>, order: &[PassHandle]) -> Self {
        let pipeline = resolved.pipeline;
        let mut users = vec![Vec::new(); pipeline.resources.len()];
        for (at, pass) in order.iter().enumerate() {
            for one in pipeline.pass(*pass).accesses() {
                users[one.resource.index()].push((at, one));
            }
        }
        let conditions = order.iter().map(|pass| pipeline.pass(*pass).condition).collect();
        Self { pipeline, resolved, users, conditions }
    }

    /// Returns the positions of the first and last access of each resource, indexed by handle; `None` if unused.
    pub(crate) fn spans(&self) -> Vec<Option<(usize, usize)>> {
        self.users.iter().map(|accesses| Some((accesses.first()?.0, accesses.last()?.0))).collect()
    }

    /// Plans the pass at position `at` in execution order.
    pub(crate) fn pass(
        &self,
        at: usize,
        handle: PassHandle,
        reason: KeepReason,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> PlannedPass {
        let pass = self.pipeline.pass(handle);
        let mut own = Vec::new();
        let mut planned = PlannedPass {
            name: pass.name.clone(),
            kind: pass.kind.clone(),
            toggle: pass.condition.map(|condition| self.pipeline.condition_name(condition)),
            passthrough: crate::contents::toggles::passthrough_names(self.pipeline, pass),
            kept: reason.named(self.pipeline),
            color: Vec::new(),
            depth: None,
            stencil: None,
            group: 0,
            workgroups: None,
            copies: Vec::new(),
            variants: Vec::new(),
            blocks: Vec::new(),
            live: Vec::new(),
            handle,
            reason,
        };
        if let Some((program, _)) = format::slots(self.pipeline, handle) {
            planned.variants = program
                .variants
                .iter()
                .map(|variant| {
                    let module = &variant.module;
                    let hash: String = module.hash[..4].iter().map(|byte| format!("{byte:02x}")).collect();
                    let format = |resource| Some(self.resolved.texture(resource)?.format);
                    let constants = target_constants::of_work(program, variant, pass.work(), &format);
                    let constants: String =
                        constants.map(|(name, value)| format!(" {name}={value}")).collect();
                    let axes = umbragraph_pipeline::shader::describe(&module.axes);
                    format!("{} [{axes}] {hash}{constants}", program.template)
                })
                .collect();
        }
        if let Work::Render(render) = pass.work() {
            for one in render.attachments() {
                let attachment = self.attachment(at, one);
                match one.usage.aspect() {
                    Aspect::DepthOnly => planned.depth = Some(attachment),
                    Aspect::StencilOnly => planned.stencil = Some(attachment),
                    Aspect::All => planned.color.push(attachment),
                }
            }
        }
        self.resolved.size_pass(&mut planned, &mut own);
        let known =
            |attachment: &PlannedAttachment| self.resolved.texture(attachment.target.resource).is_some();
        if let Work::Render(render) = pass.work()
            && planned.attachments().all(known)
        {
            own.extend(self.check_outputs(handle, &planned, render));
        }
        diagnostics.extend(own.into_iter().map(|one| pass.environment.told(one)));
        planned
    }
}
