//! Random edits of every document of `pipelines/`, half of them broken: a session that lives through all of them
//! answers each as a fresh start does.
//!
//! The fresh side shares nothing with the session but the crates below it: files are composed, loaded and planned anew,
//! with shader modules of its own that no document can change.

use std::path::Path;
use std::sync::Arc;

use umbragraph::diagnostic::{Diagnostic, Diagnostics};
use umbragraph::low_level::CheckOptions;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{self, Disk, Files, Roots};
use umbragraph::low_level::pipeline::Overrides;
use umbragraph::low_level::session::{Session, Survey, Target};
use umbragraph::low_level::shader::{ShaderCache, TargetProfile, TemplateSet};
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::node::Registry;
use umbragraph::{Bundled, DiskStorage, with_templates};
use umbragraph_test_support::edits::{documents, edited};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::session::{choice, shown};

/// Edits of each document; the tenth part of them in ordinary tests.
const EDITS: usize = 300;
/// Edits of each document after which all its configurations are checked.
const CHECKS: usize = 10;
/// The size from which a document is edited less often in ordinary tests.
const LARGE: usize = 2_000;

/// The files of the workspace, with one text over them.
struct Edited<'t> {
    disk: Bundled<Disk>,
    path: &'t Path,
    text: &'t str,
}

impl Files for Edited<'_> {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        if path == self.path {
            return Ok(sources.add(path.display().to_string(), self.text));
        }
        self.disk.read(path, sources)
    }

    fn has_scheme(&self, scheme: &str) -> bool {
        self.disk.has_scheme(scheme)
    }
}

/// The inputs of a session that starts fresh.
struct Fresh {
    sources: Sources,
    templates: Arc<TemplateSet>,
    registry: Registry,
    shaders: Arc<ShaderCache>,
}

impl Fresh {
    fn new() -> Self {
        let mut sources = Sources::new();
        let templates = umbragraph::templates(&mut sources, &mut Diagnostics::new());
        let shaders = Arc::new(ShaderCache::new(&templates, &TargetProfile::webgpu()));
        Self { sources, templates, registry: umbragraph::registry(), shaders }
    }

    /// The diagnostics and the plan.
    fn plan(&mut self, path: &Path, text: &str) -> (String, Option<String>) {
        let mut sources = self.sources.clone();
        let mut diagnostics = Diagnostics::new();
        let file = sources.add(path.display().to_string(), text);
        let mut files = Edited { disk: Bundled(Disk(Roots::of(path))), path, text };
        let composed = compose::compose(file, path, &mut files, &mut sources, &mut diagnostics);
        let plan = composed.and_then(|composed| {
            let (profile, plan) = (TargetProfile::webgpu(), PlanOptions::new(640, 480));
            let options = CheckOptions {
                registry: &self.registry,
                templates: &self.templates,
                profile: &profile,
                overrides: &Overrides::default(),
                plan: &plan,
            };
            let (document, kept) = (&composed.document, (&self.shaders, None));
            umbragraph::low_level::check_sharing(document, &options, &sources, &mut diagnostics, kept).plan
        });
        diagnostics.sort();
        (shown(&diagnostics, &sources), plan.map(|plan| printed(&plan)))
    }
}

fn printed(plan: &umbragraph::Plan) -> String {
    serde_json::to_string(plan).expect("JSON")
}

/// Edits the documents whose number has this remainder, so that threads share the work.
fn edits_are_answered_as_by_a_fresh_start(remainder: usize, of: usize) {
    let mut fresh = Fresh::new();
    let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
    let mut planned = 0;
    for (number, path) in documents("pipelines").iter().enumerate().filter(|(at, _)| at % of == remainder) {
        let text = std::fs::read_to_string(path).expect("a text");
        let target = Target::new(path);
        let mut random = Random(property::seed().wrapping_mul(1_000).wrapping_add(number as u64));
        let edits: Vec<String> = (0..EDITS).map(|_| edited(&text, &mut random)).collect();
        let out_of = 10 * (1 + text.len() / LARGE) as u64;
        for now in property::part(edits, out_of) {
            session.overlay(path, now.as_bytes());
            let (answer, diagnostics) = session.plan(&target, &choice()).expect("nothing cancels");
            let answer =
                (shown(&diagnostics, session.sources()), answer.report.plan.map(|plan| printed(&plan)));
            let expected = fresh.plan(path, &now);
            planned += usize::from(expected.1.is_some());
            assert_eq!(answer, expected, "{}:\n{now}", path.display());
        }
        session.close(path);
        let (_, diagnostics) = session.plan(&target, &choice()).expect("nothing cancels");
        assert_eq!(shown(&diagnostics, session.sources()), fresh.plan(path, &text).0, "{}", path.display());
    }
    assert!(planned > 0, "no edit left a plan");
}

#[test]
fn random_edits_are_answered_as_by_a_fresh_start_in_part_1() {
    edits_are_answered_as_by_a_fresh_start(0, 3);
}

#[test]
fn random_edits_are_answered_as_by_a_fresh_start_in_part_2() {
    edits_are_answered_as_by_a_fresh_start(1, 3);
}

#[test]
fn random_edits_are_answered_as_by_a_fresh_start_in_part_3() {
    edits_are_answered_as_by_a_fresh_start(2, 3);
}

#[test]
fn random_edits_are_checked_as_by_a_fresh_session() {
    let begin = || Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
    let mut session = begin();
    // The large ones take a minute each.
    let folder = if property::times() > 1 { "pipelines" } else { "pipelines/learn" };
    let documents = documents(folder).into_iter().enumerate();
    for (number, path) in property::part(documents, 5) {
        let text = std::fs::read_to_string(&path).expect("a text");
        let mut random = Random(property::seed().wrapping_mul(2_000).wrapping_add(number as u64));
        let edits: Vec<String> = (0..CHECKS).map(|_| edited(&text, &mut random)).collect();
        for now in property::part(edits, 10) {
            let check = |session: &mut Session| {
                session.overlay(&path, now.as_bytes());
                let survey = Survey::new(vec![TargetProfile::webgpu()], PlanOptions::new(640, 480));
                let mut judges = |_: &TargetProfile| -> Box<dyn FnMut(&Arc<_>) -> Diagnostics> {
                    Box::new(|_| Diagnostics::new())
                };
                let checked = session.check(&Target::new(&path), &survey, &mut judges);
                let (checked, diagnostics) = checked.expect("nothing cancels");
                let numbers = checked.map(|one| (one.coverage.variants.len(), one.configurations.list.len()));
                (shown(&diagnostics, session.sources()), numbers)
            };
            assert_eq!(check(&mut session), check(&mut begin()), "{}:\n{now}", path.display());
        }
    }
}
