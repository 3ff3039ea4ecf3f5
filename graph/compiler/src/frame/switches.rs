//! The toggles of a frame: which passes are recorded, and which resource is the fallback of which.
//!
//! A frame names the toggles that it wants otherwise than the pipeline's defaults. The fallback of a resource depends
//! on nothing else, so one table serves all passes: a reader that has the toggle of the writers runs only where the
//! resource stands for itself. In a frame without diagnostics nothing is allocated.

use crate::plan::planned::Plan;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// The states of the toggles in a frame, and the resource or fallback that readers of each resource get.
pub struct Switches {
    states: Vec<bool>,
    /// For each resource, indexed by handle: the resource that its readers get, which is itself or a fallback.
    seen: Vec<ResourceHandle>,
}

impl Switches {
    /// Creates the state in which all toggles have their defaults.
    pub fn new(plan: &Plan) -> Self {
        let pipeline = &plan.pipeline;
        let seen = pipeline.resource_handles().collect();
        let mut switches = Self { states: pipeline.default_states(), seen };
        switches.resolve(plan);
        switches
    }

    /// Returns errors for toggles that the pipeline does not have.
    pub fn check(plan: &Plan, given: &[(&str, bool)]) -> Diagnostics {
        let mut diagnostics = Diagnostics::new();
        let toggles = &plan.pipeline.toggles;
        for (name, _) in given.iter().filter(|(name, _)| plan.pipeline.find_toggle(name).is_none()) {
            let names = toggles.iter().map(|toggle| toggle.name.as_str());
            let message = format!("the pipeline \"{}\" has no toggle \"{name}\"", plan.name);
            let diagnostic = Diagnostic::error(codes::UNKNOWN_TOGGLE, Place::Nowhere, message);
            // A plan decides on its features and parameters; a frame switches toggles alone.
            let of_plan = [
                (plan.pipeline.features.contains_key(*name), "feature", "--feature"),
                (plan.pipeline.parameters.contains_key(*name), "parameter", "--set"),
            ];
            if let Some((_, what, option)) = of_plan.iter().find(|(is_one, ..)| *is_one) {
                let value = if *what == "feature" { "" } else { "=VALUE" };
                let help =
                    format!("\"{name}\" is a {what}; set it with {option} {name}{value}, not --toggle");
                diagnostics.push(diagnostic.help(help));
                continue;
            }
            diagnostics.push(diagnostic.suggest(name, names, None, |names| match names {
                [] => "the pipeline has no toggles".to_owned(),
                names => format!("the toggles are {}", list_of(names.iter().copied())),
            }));
        }
        diagnostics
    }

    /// Sets the toggles of a frame; toggles that are not listed have their default state.
    pub fn set(&mut self, plan: &Plan, given: &[(&str, bool)]) {
        if self.states.is_empty() {
            return;
        }
        for (state, toggle) in self.states.iter_mut().zip(&plan.pipeline.toggles) {
            let told = given.iter().rev().find(|(name, _)| *name == toggle.name);
            *state = told.map_or(toggle.default, |(_, on)| *on);
        }
        self.resolve(plan);
    }

    /// Computes the resource or fallback that readers of each resource get.
    fn resolve(&mut self, plan: &Plan) {
        for resource in plan.pipeline.passthroughs.keys() {
            let is_there = |handle: &ResourceHandle| {
                let passthrough = plan.pipeline.passthroughs.get(handle);
                passthrough.is_none_or(|passthrough| passthrough.condition.holds(&self.states))
            };
            let seen = plan.pipeline.fallbacks(*resource).find(is_there);
            if let (Some(seen), Some(slot)) = (seen, self.seen.get_mut(resource.index())) {
                *slot = seen;
            }
        }
    }

    /// Returns `true` if the toggles let a pass run in this frame.
    pub fn runs(&self, plan: &Plan, pass: PassHandle) -> bool {
        plan.pipeline.pass(pass).condition.is_none_or(|condition| condition.holds(&self.states))
    }

    /// Returns the resource that readers of a resource get: the resource itself, or a fallback.
    pub fn seen(&self, resource: ResourceHandle) -> ResourceHandle {
        self.seen.get(resource.index()).copied().unwrap_or(resource)
    }
}
