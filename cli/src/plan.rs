//! `umbragraph plan`

use crate::arguments::PlanArguments;
use crate::session::Session;

/// Prints a plan; whether there were no errors.
pub(crate) fn run(arguments: &PlanArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref());
    let checked = session.check(&arguments.pipeline, &arguments.choices);
    let fine = session.report();
    match checked.plan.map(|plan| serde_json::to_string_pretty(&plan)) {
        Some(Ok(text)) if fine => {
            println!("{text}");
            true
        }
        _ => false,
    }
}
