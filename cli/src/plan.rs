//! `umbragraph plan`: prints the plan of a pipeline, as tables or as JSON.

use umbragraph::low_level::report::{Report, table};
use umbragraph_verify::verify;

use crate::arguments::{AnswerFormat, PlanArguments};
use crate::session::Session;
use crate::streams::{complain, print, print_json};

/// Prints a plan. Returns `true` if there were no errors and, with `--verify`, no violations.
pub(crate) fn run(arguments: &PlanArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let checked = session.check(&arguments.pipeline, &arguments.choices);
    let fine = session.report();
    // Of a pipeline with errors, the plan is that of the passes that are sound.
    let Some(plan) = checked.plan else { return false };
    if arguments.verify && fine {
        let violations = verify(&plan, &Session::options(&arguments.choices));
        for violation in &violations {
            complain(&format!("violation: {violation}\n"));
        }
        if !violations.is_empty() {
            complain("the plan is wrong: this is a defect of the compiler\n");
            return false;
        }
        let (passes, resources) = (plan.passes.len(), plan.resources.len());
        complain(&format!("verified: {passes} passes, {resources} resources, no violations\n"));
    }
    match arguments.format {
        AnswerFormat::Human => {
            let Some(graph) = &checked.graph else { return false };
            print(&table(&Report::new(&plan, graph, session.sources())));
        }
        AnswerFormat::Json => {
            let Ok(text) = serde_json::to_string_pretty(&*plan) else { return false };
            print_json(&(text + "\n"));
        }
    }
    fine
}
