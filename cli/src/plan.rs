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
            let is_empty = plan.passes.is_empty() && plan.culled.is_empty();
            let Some(graph) = checked.graph.as_ref().filter(|_| fine || !is_empty) else {
                return false;
            };
            if !fine {
                print("The plan without the passes that have errors:\n\n");
            }
            print(&table(&Report::new(&plan, graph, session.sources())));
        }
        AnswerFormat::Json => {
            let Ok(text) = serde_json::to_string_pretty(&*plan) else { return false };
            print_json(&(text + "\n"));
        }
    }
    fine
}
