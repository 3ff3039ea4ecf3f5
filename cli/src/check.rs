//! `umbragraph check`

use umbragraph::diagnostic::render;

use crate::arguments::{CheckArguments, FindingsFormat};
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
            && arguments.format != FindingsFormat::Json
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
    match arguments.format {
        FindingsFormat::Human => return session.report(),
        FindingsFormat::Json => {
            session.arrange();
            let findings: Vec<_> =
                session.findings.iter().map(|finding| render::json(finding, &session.sources)).collect();
            print(&format!("{:#}\n", serde_json::json!({ "findings": findings })));
        }
        FindingsFormat::Github => {
            session.arrange();
            for finding in &session.findings {
                print(&render::github(finding, &session.sources));
            }
        }
    }
    !session.findings.has_errors()
}
