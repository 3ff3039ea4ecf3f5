//! The tests that ran and those that failed, in the form that is asked for.

use std::collections::BTreeSet;

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use umbragraph::diagnostic::{Diagnostic, render};

use super::running::FileCount;
use crate::arguments::DiagnosticsFormat;
use crate::junit;
use crate::session::Session;
use crate::streams::print;

/// Prints the report of a test run. Returns `true` if no test failed.
pub(super) fn report(
    format: DiagnosticsFormat,
    session: &mut Session,
    counts: &[FileCount],
    adapter: &str,
) -> bool {
    if format == DiagnosticsFormat::Junit {
        session.arrange();
        print(&xml(session, counts));
        return !session.diagnostics.has_errors();
    }
    let json = |diagnostics: Vec<serde_json::Value>| {
        let report = serde_json::json!({
            "adapter": adapter,
            "files": counts.iter().map(file_as_json).collect::<Vec<_>>(),
            "diagnostics": diagnostics,
        });
        format!("{report:#}")
    };
    let text =
        || counts.iter().filter(|file| !file.tests.is_empty()).map(|file| line(file, adapter)).collect();
    session.report_as(format, text, json, &[])
}

/// Returns one line about the tests of a file.
fn line(file: &FileCount, adapter: &str) -> String {
    let tests = file.tests.len();
    let noun = |count: usize, noun: &str| format!("{count} {noun}{}", if count == 1 { "" } else { "s" });
    let failed = file.tests.values().filter(|test| !test.messages.is_empty()).count();
    if failed > 0 {
        let verb = if failed == 1 { "fails" } else { "fail" };
        return format!("{}: {failed} of {} {verb} on {adapter}\n", file.name, noun(tests, "test"));
    }
    let rows = file.tests.values().map(|test| test.rows).sum();
    let variants = file.tests.values().map(|test| test.variants).max().unwrap_or_default();
    let (tests, rows, variants) = (noun(tests, "test"), noun(rows, "row"), noun(variants, "variant"));
    format!("{}: {tests} with {rows} pass in {variants} on {adapter}\n", file.name)
}

fn file_as_json(file: &FileCount) -> serde_json::Value {
    let tests = file.tests.iter().map(|(name, test)| {
        serde_json::json!({
            "name": name,
            "rows": test.rows,
            "variants": test.variants,
            "passed": test.messages.is_empty(),
        })
    });
    serde_json::json!({ "file": file.name, "tests": tests.collect::<Vec<_>>() })
}

/// Returns JUnit XML: a suite for each file with a case for each test. Diagnostics that belong to no test become
/// separate cases.
fn xml(session: &Session, counts: &[FileCount]) -> String {
    let (diagnostics, sources) = (&session.diagnostics, session.sources());
    let mut report = Report::new("umbragraph");
    let mut of_tests = BTreeSet::new();
    for file in counts {
        let mut suite = TestSuite::new(file.name.as_str());
        for (name, test) in &file.tests {
            let own = diagnostics.iter().filter(|diagnostic| test.messages.contains(&diagnostic.message));
            let own: Vec<&Diagnostic> = own.collect();
            let mut case = TestCase::new(name.as_str(), TestCaseStatus::success());
            if let Some(first) = own.first() {
                let text: String = own.iter().map(|one| render::human(one, sources)).collect();
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_message(first.message.as_str()).set_type(first.code.id).set_description(text);
                case = TestCase::new(name.as_str(), status);
            }
            case.set_classname(file.name.as_str());
            suite.add_test_case(case);
            of_tests.extend(&test.messages);
        }
        report.add_test_suite(suite);
    }
    let others = diagnostics.iter().filter(|diagnostic| !of_tests.contains(&diagnostic.message));
    report.add_test_suites(junit::suites(others, sources));
    // Writing to memory cannot fail.
    report.to_string().unwrap_or_default()
}
