//! The values of axes that the tests of a file run with.
//!
//! A file that was named runs with all that its templates can express. For a pipeline, the axes that it shares with a
//! pass have the values that the pipeline reaches there, on the first profile that it claims.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::pipeline::{self, Configurations, Overrides, Surveyed};
use umbragraph::low_level::shader::permutations::Request;
use umbragraph::low_level::shader::{ShaderCache, TargetProfile};

use super::find::{self, TestFile};
use crate::session::{Session, profiles};

/// Adds requests for the variants of test files that a pipeline can reach, by file name. Returns the number of test
/// files with such requests, or `None` if the pipeline cannot be loaded.
pub(super) fn of_pipeline(
    session: &mut Session,
    path: &Path,
    files: &[TestFile],
    requests: &mut BTreeMap<String, Vec<Request>>,
) -> Option<usize> {
    let loaded = session.open(path, &[])?;
    let understood = loaded.document().zip(loaded.model())?;
    let profile = profiles(understood.0, Vec::new()).into_iter().next().unwrap_or_else(TargetProfile::webgpu);
    let (values, plan) = (Overrides::default(), PlanOptions::new(1280, 720));
    let options = session.check_options(&profile, &values, &plan);
    let configurations = Configurations::all(understood, &session.templates, &profile);
    let mut diagnostics = Diagnostics::new();
    let mut accept = |_: &Arc<Plan>| Diagnostics::new();
    let shaders = Arc::new(ShaderCache::of_survey(&session.templates, &profile));
    let reached = pipeline::reach(
        understood,
        &options,
        Surveyed { configurations: &configurations, shaders: &shaders, judge: &mut accept },
        session.sources(),
        &mut diagnostics,
    );
    let text = |name: &str| {
        let file = session.templates.file(name).and_then(|file| session.sources().get(file));
        file.map(|file| file.text().clone()).unwrap_or_default()
    };
    let mut used = 0;
    for file in files {
        let Some(axes) = session.templates.axes(&file.name) else { continue };
        let mut own = Vec::new();
        for program in &reached.programs {
            let templates = find::reached([program.template.clone()], text);
            if !file.includes().any(|name| templates.contains(name)) {
                continue;
            }
            for product in &program.products {
                let shared = product.iter().filter(|(name, _)| axes.get(name).is_some());
                let allowed: BTreeMap<_, _> =
                    shared.map(|(name, values)| (name.clone(), values.clone())).collect();
                let request = Request { allowed, ..Request::all(&file.name, std::slice::from_ref(&profile)) };
                own.push(request);
            }
        }
        own.dedup_by(|one, other| one.allowed == other.allowed);
        if !own.is_empty() {
            used += 1;
            requests.entry(file.name.clone()).or_default().extend(own);
        }
    }
    session.add_new(diagnostics);
    Some(used)
}
