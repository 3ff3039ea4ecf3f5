//! `umbragraph check`

use crate::arguments::CheckArguments;
use crate::session::Session;
use crate::streams::print;

/// Checks pipelines; whether there were no errors.
pub(crate) fn run(arguments: &CheckArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref());
    for path in &arguments.pipelines {
        let before = session.findings.error_count();
        let (checked, profiles) = session.check_all(path, &arguments.choices);
        if session.findings.error_count() == before
            && let Some(plan) = &checked.plan
        {
            let variants: usize = plan.pipeline.programs.iter().map(|program| program.variants.len()).sum();
            print(&format!(
                "{}: {} passes ({} culled), {} resources, {variants} shader variants, valid for {}\n",
                path.display(),
                plan.passes.len() + plan.culled.len(),
                plan.culled.len(),
                plan.resources.len(),
                profiles.join(", ")
            ));
        }
    }
    session.report()
}
