//! The CPU passes of a plan: what they keep from frame to frame, and what they published last.
//!
//! A plan is immutable and can be shared; whatever changes from frame to frame is here. An executor owns one of these.
//! It needs no device, so what CPU passes publish can be computed, tested and looked at without one:
//!
//! ```
//! # use umbragraph_compiler::{CpuPasses, Plan};
//! # use umbragraph_pipeline::{diagnostic::Diagnostics, frame::FrameInput};
//! # fn published(plan: std::sync::Arc<Plan>, frame: &FrameInput) -> Result<(), Diagnostics> {
//! let mut passes = CpuPasses::new(plan);
//! passes.run(frame, &[])?;
//! if let Some(data) = passes.data("camera") {
//!     println!("{:?}", data.words("position"));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A pass goes on in the plan that replaces another, with its state, its data and its notices, if there a pass of the
//! same name has an equal node (of one type, with equal settings) and publishes data of the same shape. Any other pass
//! begins again, and gives its notices again.
//!
//! In a frame without diagnostics nothing is allocated but by the nodes.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::frame::switches::Switches;
use crate::plan::planned::Plan;
use umbragraph_pipeline::data::{BlackboardData, DataShape};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::frame::FrameInput;
use umbragraph_pipeline::pipeline::{LiveSettings, Located as _, ResourceKind};
use umbragraph_pipeline::work::{CpuContext, CpuRun, CpuWork, PassHandle, ResourceHandle, Subresource, Work};

/// The maximum number of inputs that a pass receives without a heap allocation.
const FEW_INPUTS: usize = 8;

/// The CPU passes of a plan, with their state and data.
pub struct CpuPasses {
    plan: Arc<Plan>,
    /// For each pass of the plan, by position: the CPU node with its state; `None` for other passes.
    runs: Vec<Option<Box<dyn CpuRun>>>,
    /// For each pass of the plan, by position: whether it has run, in this plan or as the same pass of one before.
    has_run: Vec<bool>,
    /// For each resource, indexed by handle: the last published data; `None` for textures and buffers.
    data: Vec<Option<BlackboardData>>,
    switches: Switches,
}

impl CpuPasses {
    /// Creates the state of a plan's CPU passes, before their first frame.
    pub fn new(plan: Arc<Plan>) -> Self {
        let run = |pass| cpu_work(&plan, pass).map(|cpu| cpu.node.start());
        let runs: Vec<_> = plan.passes.iter().map(|planned| run(planned.handle)).collect();
        let has_run = vec![false; runs.len()];
        let data = plan.pipeline.resource_handles().map(|resource| {
            let ResourceKind::Data(Some(shape)) = &plan.pipeline.resource(resource).kind else { return None };
            let mut data = BlackboardData::new(shape.clone());
            plan_sizes(&plan, resource, &mut data);
            Some(data)
        });
        let data = data.collect();
        Self { runs, has_run, data, switches: Switches::new(&plan), plan }
    }

    /// Replaces the plan. CPU passes that are equal in both plans keep their state and data.
    pub fn set_plan(&mut self, plan: Arc<Plan>) {
        let before = std::mem::replace(self, Self::new(plan));
        self.go_on_from(before);
    }

    /// Moves in the state and data of CPU passes that have the same name, node and data shape in another plan.
    pub fn go_on_from(&mut self, mut before: Self) {
        let (plan, old) = (&self.plan, &before.plan);
        for ((run, has_run), planned) in self.runs.iter_mut().zip(&mut self.has_run).zip(&plan.passes) {
            let Some(cpu) = cpu_work(plan, planned.handle) else { continue };
            let Some(at) = old.passes.iter().position(|old| old.name == planned.name) else { continue };
            let Some(known) = cpu_work(old, old.passes[at].handle) else { continue };
            let data = self.data.get_mut(cpu.output.resource.index()).and_then(Option::as_mut);
            let kept = before.data.get_mut(known.output.resource.index()).and_then(Option::as_mut);
            if let (Some(data), Some(kept)) = (data, kept)
                && run
                    .as_ref()
                    .zip(before.runs[at].as_ref())
                    .is_some_and(|(run, known)| run.node().is_same(known.node()))
                && data.shape() == kept.shape()
            {
                *run = before.runs[at].take();
                *has_run = before.has_run[at];
                std::mem::swap(data, kept);
                plan_sizes(plan, cpu.output.resource, data);
            }
        }
    }

    /// Runs the CPU passes for a frame. `toggles` are the names and states of toggles; others have their default state.
    ///
    /// # Errors
    /// Fails if the pipeline does not have a toggle, or if a pass publishes data that it did not declare.
    pub fn run(&mut self, frame: &FrameInput, toggles: &[(&str, bool)]) -> Result<(), Diagnostics> {
        let mut diagnostics = Switches::check(&self.plan, toggles);
        if diagnostics.has_errors() {
            return Err(diagnostics);
        }
        self.switches.set(&self.plan, toggles);
        for at in 0..self.plan.passes.len() {
            diagnostics.extend(self.run_pass(at, frame).and_then(Result::err));
        }
        if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
    }

    /// Runs the pass at a position of the plan. Returns `None` if it is not a CPU pass, or is switched off by a toggle.
    ///
    /// # Errors
    /// Fails if the pass publishes data that it did not declare.
    pub fn run_pass(&mut self, at: usize, frame: &FrameInput) -> Option<Result<(), Diagnostic>> {
        let pass = self.plan.passes.get(at)?.handle;
        let cpu = cpu_work(&self.plan, pass)?;
        let run = self.runs.get_mut(at)?.as_mut()?;
        let mut data = self.data.get_mut(cpu.output.resource.index()).and_then(Option::take)?;
        data.clear();
        let runs = self.switches.runs(&self.plan, pass);
        if runs {
            let filler = BlackboardData::new(DataShape::new());
            let mut few = [&filler; FEW_INPUTS];
            let many: Vec<&BlackboardData>;
            let seen =
                |input: &Subresource| self.data.get(self.switches.seen(input.resource).index())?.as_ref();
            let given = cpu.inputs.iter().filter_map(seen);
            let inputs = if cpu.inputs.len() <= FEW_INPUTS {
                let mut count = 0;
                for (slot, input) in few.iter_mut().zip(given) {
                    *slot = input;
                    count += 1;
                }
                &few[..count]
            } else {
                many = given.collect();
                &many
            };
            run.run(&CpuContext { frame, viewport: self.plan.viewport, inputs }, &mut data);
        }
        let outcome = data.rejected().map_or(Ok(()), |reason| {
            let pass = self.plan.pipeline.pass(pass);
            let message = format!("\"{}\" publishes {reason}", pass.name);
            let help = "a CPU pass publishes what it declared; this is a defect of its node kind";
            Err(pass.error(codes::BLACKBOARD, message).help(help))
        });
        self.data[cpu.output.resource.index()] = Some(data);
        self.has_run[at] = outcome.is_ok();
        runs.then_some(outcome)
    }

    /// The plan whose CPU passes run.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Returns the data that a pass last published, by the name of the resource; `None` if no blackboard data has this
    /// name.
    pub fn data(&self, name: &str) -> Option<&BlackboardData> {
        self.data.get(self.plan.pipeline.find_resource(name)?.index())?.as_ref()
    }

    /// The notices of the last run of the passes: limits that were reached, parts that were left out and why.
    pub fn notices(&self) -> impl Iterator<Item = &Diagnostic> {
        self.data.iter().flatten().flat_map(|data| data.notices().iter())
    }

    /// Returns the names of the frame's valid lights that no pass has read, so that they do not affect the image.
    pub fn unread_lights<'f>(&self, frame: &'f FrameInput) -> Vec<&'f str> {
        let is_read =
            |at: usize| self.data.iter().flatten().any(|data| data.read_lights().contains(&(at as u32)));
        let lights = frame.lights.iter().enumerate().filter(|(_, light)| light.check().is_none());
        lights.filter(|(at, _)| !is_read(*at)).map(|(_, light)| &*light.name).collect()
    }

    /// Returns the sizes that passes request, for [`crate::PlanOptions::data_sizes`]; `None` if the planned sizes
    /// suffice.
    pub fn wanted_sizes(&self) -> Option<BTreeMap<String, u32>> {
        let wants = |data: &BlackboardData| data.sizes().any(|(_, planned, wanted)| planned != wanted);
        if !self.data.iter().flatten().any(wants) {
            return None;
        }
        let mut all = BTreeMap::new();
        for (resource, data) in self.plan.pipeline.resources.iter().zip(&self.data) {
            let sizes = data.iter().flat_map(BlackboardData::sizes);
            all.extend(sizes.map(|(name, _, wanted)| (format!("{}.{name}", resource.name), wanted)));
        }
        Some(all)
    }
}

/// Methods that only an executor needs.
impl CpuPasses {
    /// Updates the CPU node at a position of the plan with live settings; other passes are ignored. Returns `None`
    /// after a diagnostic.
    pub fn update(&mut self, at: usize, settings: &mut LiveSettings<'_>) -> Option<()> {
        self.runs.get_mut(at).and_then(Option::as_mut).map_or(Some(()), |run| run.update(settings))
    }

    /// Returns `true` if the pass at a position of the plan has published the data of a frame.
    pub fn has_run(&self, at: usize) -> bool {
        self.has_run.get(at).copied().unwrap_or_default()
    }

    /// Sets the toggles of a frame; toggles that are not listed have their default state.
    pub fn switch(&mut self, toggles: &[(&str, bool)]) {
        self.switches.set(&self.plan, toggles);
    }

    /// Returns the data that readers of a resource get: the fallback's data if toggles select the fallback. `None` for
    /// textures and buffers.
    pub fn seen(&self, resource: ResourceHandle) -> Option<&BlackboardData> {
        self.data.get(self.switches.seen(resource).index())?.as_ref()
    }

    /// The states of the toggles in the current frame.
    pub fn switches(&self) -> &Switches {
        &self.switches
    }
}

fn cpu_work(plan: &Plan, pass: PassHandle) -> Option<&CpuWork> {
    match plan.pipeline.pass(pass).work() {
        Work::Cpu(cpu) => Some(cpu),
        _ => None,
    }
}

fn plan_sizes(plan: &Plan, resource: ResourceHandle, data: &mut BlackboardData) {
    let resource = &plan.pipeline.resource(resource).name;
    data.plan_sizes(|name, initial| {
        plan.data_sizes.get(&format!("{resource}.{name}")).copied().unwrap_or(initial)
    });
}
