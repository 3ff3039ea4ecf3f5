//! Broken documents and exactly what is said of them.

use std::path::PathBuf;

use crate::common::{Outcome, With, check_with, root};
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::{document, edit};
use umbragraph_test_support::property;

struct Case {
    name: String,
    replacements: Vec<(String, String)>,
}

impl Case {
    fn text(&self) -> String {
        let mut text = base();
        for (old, new) in &self.replacements {
            assert!(text.contains(old.as_str()), "{}: the base does not contain {old}", self.name);
            text = text.replacen(old.as_str(), new, 1);
        }
        text
    }
}

fn folder() -> PathBuf {
    root().join("tests/broken")
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string(folder().join("cases.txt")).unwrap();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("== ") {
            cases.push(Case { name: name.to_owned(), replacements: Vec::new() });
        } else if let Some(old) = line.strip_prefix("- ") {
            cases.last_mut().unwrap().replacements.push((old.to_owned(), String::new()));
        } else if let Some(new) = line.strip_prefix("+ ") {
            cases.last_mut().unwrap().replacements.last_mut().unwrap().1 = new.to_owned();
        }
    }
    cases
}

/// The template that the base draws with, beside those of the project.
fn with() -> With<'static> {
    const TEMPLATES: &[(&str, &str)] = &[
        ("display.wgsl.jinja", include_str!("../broken/display.wgsl.jinja")),
        ("display.axes.json", include_str!("../broken/display.axes.json")),
    ];
    With { templates: TEMPLATES, ..With::default() }
}

fn base() -> String {
    std::fs::read_to_string(folder().join("chain.json")).unwrap()
}

#[test]
fn the_base_has_no_diagnostics() {
    let outcome = check_with("chain.json", &base(), &with());
    assert_eq!(outcome.text(), "");
    assert!(outcome.checked.plan.is_some());
}

#[test]
fn every_broken_document_has_exactly_the_expected_diagnostics() {
    let bless = std::env::var_os("UMBRAGRAPH_BLESS").is_some();
    let mut failures = Vec::new();
    let cases = cases();
    assert!(cases.len() >= 100, "only {} cases were read", cases.len());
    for case in &cases {
        let text = case.text();
        let outcome = check_with("chain.json", &text, &with());
        assert!(outcome.diagnostics.has_errors(), "{} is not broken", case.name);
        for diagnostic in &outcome.diagnostics {
            assert!(
                diagnostic.help.is_some(),
                "{}: a diagnostic without a way out: {}",
                case.name,
                diagnostic.message
            );
        }
        let actual = outcome.text();
        let path = folder().join("expected").join(format!("{}.txt", case.name));
        if bless {
            std::fs::write(&path, &actual).unwrap();
            continue;
        }
        let expected = std::fs::read_to_string(&path).unwrap_or_default();
        if expected != actual {
            failures.push(format!("{}:\nexpected\n{expected}\nfound\n{actual}", case.name));
        }
    }
    assert!(
        failures.is_empty(),
        "{}\n(UMBRAGRAPH_BLESS=1 cargo test --test text broken accepts them)",
        failures.join("\n")
    );
}

#[test]
fn fixes_never_make_a_document_worse_and_come_to_an_end() {
    let mut whole = 0;
    let cases = property::part(cases(), 4);
    for case in &cases {
        let mut text = case.text();
        let mut outcome = check_with("chain.json", &text, &with());
        for round in 0.. {
            let Some(fixed) = mended(&outcome.diagnostics, &outcome, &text) else { break };
            assert!(round < 8, "{}: fixes lead in a cycle: {fixed}", case.name);
            let after = check_with("chain.json", &fixed, &with());
            assert!(!after.codes().contains(&"UG0101"), "{}: {}", case.name, after.text());
            let (errors, left) = (outcome.diagnostics.error_count(), after.diagnostics.error_count());
            // A document that does not parse shows the rest of its diagnostics only when it does.
            let is_read = !outcome.codes().contains(&"UG0103");
            assert!(!is_read || left < errors, "{}: {}", case.name, after.text());
            (text, outcome) = (fixed, after);
        }
        whole += usize::from(!outcome.diagnostics.has_errors());
    }
    assert!(whole * 20 >= cases.len(), "only {whole} of {} documents were mended in full", cases.len());
}

/// The text with the fixes of these diagnostics made, if there are some.
fn mended<'a>(
    diagnostics: impl IntoIterator<Item = &'a Diagnostic>,
    outcome: &Outcome,
    text: &str,
) -> Option<String> {
    let edits = edit::mend(diagnostics, &outcome.sources, |name| name == "chain.json");
    edits.get("chain.json").map(|edits| edits.apply(text).unwrap())
}

#[test]
fn a_suggestion_is_gone_after_its_fix() {
    let mut without = Vec::new();
    let cases = property::part(cases(), 4);
    for case in &cases {
        let text = case.text();
        let outcome = check_with("chain.json", &text, &with());
        for diagnostic in &outcome.diagnostics {
            let is_named = diagnostic.help.as_deref().is_some_and(|help| help.starts_with("did you mean"));
            let Some(fixed) = mended([diagnostic], &outcome, &text) else {
                without.extend(is_named.then_some(case.name.as_str()));
                continue;
            };
            let after = check_with("chain.json", &fixed, &with());
            let is_it =
                |other: &Diagnostic| (other.code, &other.message) == (diagnostic.code, &diagnostic.message);
            assert!(
                !after.diagnostics.iter().any(is_it),
                "{}:\n{}\n{}",
                case.name,
                outcome.text(),
                after.text()
            );
        }
    }
    // Another name is as close, or the right one is there already, or a type may be what is missing; of a key of a
    // subgraph's `passthrough` the place is not kept.
    let mut known = vec![
        "face-that-does-not-exist",
        "subgraph-files-that-are-not-there",
        "as-close-to-two-names",
        "misspelt-parameter-beside-the-right-one-in-a-preset",
        "passthrough-of-a-subgraph-for-a-misspelt-resource",
        "value-of-a-parameter-that-is-misspelt",
    ];
    known.retain(|name| cases.iter().any(|case| case.name == *name));
    assert_eq!(without, known);
}

#[test]
fn pointers_lead_through_the_document_as_it_is_written() {
    let mut lost = Vec::new();
    for case in &property::part(cases(), 4) {
        let outcome = check_with("chain.json", &case.text(), &with());
        let file = outcome.sources.find("chain.json").unwrap();
        let Ok(document) = document::parse(&outcome.sources, file).valid() else { continue };
        let root = document.root.to_json();
        // Diagnostics in a subgraph's own file lead through the pipeline that it is part of.
        for diagnostic in
            outcome.diagnostics.iter().filter(|one| one.span().is_some_and(|span| span.file == file))
        {
            if root.pointer(&diagnostic.pointer).is_none() {
                lost.push(format!("{}: {} {}", case.name, diagnostic.code, diagnostic.pointer));
            }
        }
    }
    assert!(lost.is_empty(), "{}", lost.join("\n"));
}

#[test]
fn a_key_that_says_the_same_twice_is_removed_once() {
    let twice = base().replace("\"name\": \"chain\",", "\"name\": \"chain\",\n  \"name\": \"chain\",");
    let outcome = check_with("chain.json", &twice, &with());
    assert_eq!(mended(&outcome.diagnostics, &outcome, &twice), Some(base()));
    let differing = twice.replacen("\"name\": \"chain\"", "\"name\": \"train\"", 1);
    let outcome = check_with("chain.json", &differing, &with());
    assert_eq!(mended(&outcome.diagnostics, &outcome, &differing), None);
}

#[test]
fn hopeless_texts_are_diagnostics_and_never_a_panic() {
    for text in [
        "",
        " ",
        "{",
        "null",
        "[]",
        "{}",
        "\u{feff}{}",
        "\"\"",
        "// only a comment",
        &"[".repeat(100_000),
        &"{\"a\":".repeat(100_000),
    ] {
        let outcome = check_with("test.json", text, &with());
        assert!(outcome.diagnostics.has_errors(), "{:?}", text.chars().take(20).collect::<String>());
    }
}
