//! The words of why the compiler keeps or culls a pass.

use umbragraph_compiler::{CullReason, KeepReason, Plan, PlannedPass};
use umbragraph_pipeline::diagnostic::list_of;
use umbragraph_pipeline::work::PassHandle;

/// The reason why a live pass is kept, one message for each step from the pass through its readers to an output. Empty
/// for a culled pass.
pub fn why_kept(plan: &Plan, pass: PassHandle) -> impl Iterator<Item = String> {
    plan.why_kept(pass).map(|planned| kept(plan, planned))
}

/// The reason why a pass is culled, one message for each step from the pass to a reader whose own results nothing
/// reads. Empty for a live pass.
pub fn why_culled(plan: &Plan, pass: &str) -> impl Iterator<Item = String> {
    plan.why_culled(pass).map(|(pass, reason)| culled(pass, reason))
}

/// Returns the reason why the compiler keeps one pass in words: an output, a side effect or a pass that reads from it.
pub(super) fn kept(plan: &Plan, planned: &PlannedPass) -> String {
    const MANY: &str =
        "more writers of different subresource ranges, or with different toggles, than are told apart";
    let resource = |handle| &plan.pipeline.resource(handle).name;
    let reads = |(reader, handle)| format!("{} reads {}", plan.pipeline.pass(reader).name, resource(handle));
    match planned.reason {
        KeepReason::SideEffect => "it has a side effect".to_owned(),
        KeepReason::Output(handle) => format!("writes the output {}", resource(handle)),
        KeepReason::ReadBy(read) => reads(read),
        KeepReason::MayBeReadBy(read) => format!("{}, perhaps nothing of it: it has {MANY}", reads(read)),
        KeepReason::MayBeLeft(handle) => {
            format!("something of {} may be left in {}, which has {MANY}", planned.name, resource(handle))
        }
        KeepReason::ReadLater(read) => {
            match plan.pipeline.resource(read.1).history.map_or(1, |history| history.back) {
                1 => format!("{} in the next frame", reads(read)),
                back => format!("{} {back} frames later", reads(read)),
            }
        }
    }
}

/// Returns the reason why one pass is culled in words.
fn culled(pass: &str, reason: &CullReason) -> String {
    let names = |names: &[String]| list_of(names.iter().map(String::as_str));
    match reason {
        CullReason::WritesNothing => format!("{pass} writes nothing and has no side effect"),
        CullReason::NothingReads(resources) => {
            format!("nothing reads what {pass} writes: {}", names(resources))
        }
        CullReason::OnlyCulledRead(readers) => {
            format!("only culled passes read what {pass} writes: {}", names(readers))
        }
    }
}
