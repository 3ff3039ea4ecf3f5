//! An independent verifier of plans.
//!
//! [`verify`] checks a finished [`Plan`] against its pipeline by other means than the planner's. It shares no code with
//! the planner: it reads the pipeline's declarations and the plan's values, and none of the planner's graphs, lifetimes
//! or classes.
//!
//! - `passes`: the plan has the pipeline's passes, each once, in an order that the document allows, and culls only what
//!   nothing needs;
//! - `contents`: the frame is played through, texel region by texel region: every read finds what it has to find, and
//!   nothing is dropped that something later needs; `back` goes the other way where there are too many states;
//! - `uninitialised`: every read finds each piece of what it reads written in some state;
//! - `toggles`: fallbacks are used where they have to be, and fit; toggles and passthroughs are stated right;
//! - `transfers`: copies touch the mips, layers, aspects and bytes that their passes use, and are what they describe;
//! - `attachments`: load and store operations, marks and render pass groups say what the passes declare;
//! - `memory`: resources that share memory are never alive together, fit what stands for them, and are as few as
//!   possible; imports stay within what the host allows; the sums of bytes are right;
//! - `histories`: as many frames are kept as can be read, apart from one another and from everything else.
//!
//! Limits: shaders and sizes are not computed again, so a plan for another viewport is not detected. A writer counts as
//! writing all of the subresource range that it declares.
//!
//! Cost: about linear; more for writers that only a long dependency path orders.

mod attachments;
mod back;
mod contents;
mod histories;
mod memory;
mod passes;
mod regions;
mod schedule;
#[cfg(test)]
mod tests;
mod toggles;
mod transfers;
mod uninitialised;
mod violation;

pub use violation::{Violation, ViolationKind};

use umbragraph_compiler::{Plan, PlanOptions};
use violation::Violations;

/// Checks a plan against its pipeline and returns all violations found; an empty list means a valid plan. `options`
/// must be those that the plan was made with.
pub fn verify(plan: &Plan, options: &PlanOptions) -> Vec<Violation> {
    let mut violations = Violations(Vec::new());
    // The rest relies on every planned pass being one of the pipeline's.
    let Some(schedule) = passes::check(plan, &mut violations) else { return violations.0 };
    let flow = contents::check(plan, &schedule, &mut violations);
    passes::check_reasons(plan, &schedule, &flow, &mut violations);
    attachments::check(plan, &mut violations);
    let spare = histories::check(plan, &mut violations);
    memory::check(plan, options, &spare, &mut violations);
    toggles::check(plan, &mut violations);
    transfers::check(plan, &mut violations);
    violations.0
}
