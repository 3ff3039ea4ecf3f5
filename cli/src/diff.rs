//! `umbragraph diff`

use umbragraph::report::diff;

use crate::arguments::DiffArguments;
use crate::graph::report;
use crate::session::Session;
use crate::streams::print;

/// Says what differs between two plans; whether there were no errors.
pub(crate) fn run(arguments: &DiffArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref());
    let before = report(&mut session, &arguments.before, &arguments.choices);
    let after = report(&mut session, &arguments.after, &arguments.choices);
    if !session.report() {
        return false;
    }
    let (Some(before), Some(after)) = (before, after) else { return false };
    let lines = diff(&before, &after);
    print(&if lines.is_empty() { "the plans are the same\n".to_owned() } else { lines.join("\n") + "\n" });
    true
}
