//! Whether passes run in the frames in which something else happens, as toggles decide.
//!
//! Seen from a reader in a frame in which it runs, another pass runs always, never, or [sometimes](Runs).

use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::pipeline::{Access, Condition, Located as _, Pass, TypedPipeline};
use umbragraph_pipeline::source::Span;
use umbragraph_pipeline::work::PassHandle;

/// The frames in which a pass runs, among the frames in which given toggle conditions hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Runs {
    Always,
    Never,
    Sometimes(Condition),
}

/// Returns the toggle conditions that hold in every frame in which an access happens, sorted. `None` if they contradict
/// each other, so that the access never happens.
pub(crate) fn known(pass: &Pass, one: &Access) -> Option<Vec<Condition>> {
    let mut known: Vec<Condition> = pass.condition.iter().chain(&one.when).copied().collect();
    known.sort_unstable();
    known.dedup();
    let possible = known.windows(2).all(|pair| pair[0].toggle != pair[1].toggle);
    possible.then_some(known)
}

/// Returns whether a pass runs always, never or sometimes in frames in which all conditions in `known` hold.
pub(crate) fn runs(pass: &Pass, known: &[Condition]) -> Runs {
    match pass.condition {
        None => Runs::Always,
        Some(condition) if known.contains(&condition) => Runs::Always,
        Some(condition) if known.contains(&condition.opposite()) => Runs::Never,
        Some(condition) => Runs::Sometimes(condition),
    }
}

/// Returns the error for a read that finds unwritten contents in frames in which `condition` does not hold and `writer`
/// is off. `pieces` names the unwritten subresources; an empty string stands for all that are read.
pub(crate) fn taken_away(
    pipeline: &TypedPipeline,
    reader: PassHandle,
    one: &Access,
    writer: PassHandle,
    place: Span,
    condition: Condition,
    pieces: &str,
) -> Diagnostic {
    let resource = &pipeline.resource(one.resource).name;
    let (reads, writes) = (pipeline.pass(reader), pipeline.pass(writer));
    let is_earlier = pipeline.resource(one.resource).is_earlier_frame();
    let written_name = resource.split('@').next().unwrap_or(resource);
    let of = if pieces.is_empty() { String::new() } else { format!("{pieces} of ") };
    let toggle = &pipeline.toggles[condition.toggle];
    let verb = if one.usage.writes() { "loads" } else { "reads" };
    let message = format!(
        "\"{}\" {verb} {of}\"{resource}\", which nothing writes while \"{}\" is {}",
        reads.name,
        toggle.name,
        if condition.on { "off" } else { "on" }
    );
    let written = pipeline.condition_name(condition);
    let help = if one.usage.writes() || is_earlier {
        format!(
            "let a pass without a toggle write \"{written_name}\" before, or give \"{}\" \"toggle\": \"{written}\" too",
            reads.name
        )
    } else {
        format!(
            "give \"{}\" \"passthrough\": {{ \"{resource}\": … }}, or \"{}\" \"toggle\": \"{written}\" too",
            writes.name, reads.name
        )
    };
    one.error(codes::TOGGLED_AWAY, message)
        .related(place, format!("\"{}\" writes it here, with the toggle \"{written}\"", writes.name))
        .help(help)
}
