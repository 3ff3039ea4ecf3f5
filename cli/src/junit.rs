//! Diagnostics as JUnit XML, which GitLab, Jenkins and most other CI show as tests.
//!
//! A test suite has a case for each pipeline without errors, and one of its own for each of its passes whose shaders
//! are proven. Each further suite is a file with diagnostics: an error is a
//! case that failed, a warning or note one that passed with an output. There is no time in it, so equal runs are equal.

use std::collections::{BTreeMap, BTreeSet};

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, render};
use umbragraph::low_level::source::Sources;

/// A pipeline without errors, and its passes whose shaders are proven valid.
#[derive(Clone, Debug)]
pub(crate) struct Fine {
    pub(crate) pipeline: String,
    pub(crate) passes: BTreeSet<String>,
}

/// Returns the JUnit report of a command, including the pipelines without errors.
pub(crate) fn report(diagnostics: &Diagnostics, sources: &Sources, fine: &[Fine]) -> String {
    let mut report = Report::new("umbragraph");
    let success = |name: &String| TestCase::new(name.as_str(), TestCaseStatus::success());
    let mut pipelines = TestSuite::new("pipelines");
    pipelines.add_test_cases(fine.iter().map(|one| success(&one.pipeline)));
    report.add_test_suite(pipelines);
    for Fine { pipeline, passes } in fine.iter().filter(|one| !one.passes.is_empty()) {
        let mut suite = TestSuite::new(pipeline.as_str());
        suite.add_test_cases(passes.iter().map(|pass| {
            let mut case = success(pass);
            case.set_classname(pipeline.as_str());
            case
        }));
        report.add_test_suite(suite);
    }
    report.add_test_suites(suites(diagnostics, sources));
    // Writing to memory cannot fail.
    report.to_string().unwrap_or_default()
}

/// Returns a test suite for each file with diagnostics, with a test case for each diagnostic.
pub(crate) fn suites<'a>(
    diagnostics: impl IntoIterator<Item = &'a Diagnostic>,
    sources: &Sources,
) -> Vec<TestSuite> {
    let mut files: BTreeMap<String, TestSuite> = BTreeMap::new();
    for diagnostic in diagnostics {
        let (file, line) = place(diagnostic, sources);
        let suite = files.entry(file.clone()).or_insert_with(|| TestSuite::new(file.as_str()));
        suite.add_test_case(case(diagnostic, &file, &line, sources));
    }
    files.into_values().collect()
}

fn case(diagnostic: &Diagnostic, file: &str, line: &str, sources: &Sources) -> TestCase {
    let text = render::human(diagnostic, sources);
    let name = format!("{}{line}: {}", diagnostic.code.id, diagnostic.message);
    let mut case = if diagnostic.severity == Severity::Error {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message(diagnostic.message.as_str()).set_type(diagnostic.code.id).set_description(text);
        TestCase::new(name, status)
    } else {
        let mut case = TestCase::new(name, TestCaseStatus::success());
        case.set_system_out(text);
        case
    };
    case.set_classname(file);
    case
}

/// Returns the file of a diagnostic, and its line and column as ` LINE:COLUMN`. The latter is empty if they are
/// unknown.
fn place(diagnostic: &Diagnostic, sources: &Sources) -> (String, String) {
    match &diagnostic.place {
        Place::Span(span) => {
            let Some(file) = sources.get(span.file) else { return ("umbragraph".to_owned(), String::new()) };
            let at = file.line_column(span.start);
            (file.name().to_owned(), format!(" {}:{}", at.line, at.column))
        }
        Place::File { path, .. } => (path.clone(), String::new()),
        Place::Nowhere => ("umbragraph".to_owned(), String::new()),
    }
}
