//! Texts of which nothing can be made, and random mutations of those of which something can: diagnostics that stand
//! inside the text, never a panic.

#[path = "../../benches/hopeless.rs"]
mod texts;

use std::path::Path;

use crate::common::{Outcome, With, check, check_with, root};
use umbragraph::diagnostic::{Diagnostics, Place, codes};
use umbragraph::low_level::compose::{self, Memory};
use umbragraph::low_level::source::Sources;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// Asserts that every diagnostic, and all that is related to it, stands inside its text.
#[track_caller]
fn assert_placed(outcome: &Outcome, what: &str) {
    for diagnostic in &outcome.diagnostics {
        let related = diagnostic.related.iter().map(|related| &related.place);
        for place in related.chain([&diagnostic.place]) {
            let Place::Span(span) = place else { continue };
            let length = outcome.sources.get(span.file).map_or(0, |file| file.text().len());
            assert!(
                span.start <= span.end && span.end as usize <= length,
                "{what}: {} at {span:?} of {length} bytes",
                diagnostic.message
            );
        }
    }
}

#[test]
fn hopeless_texts_are_diagnostics_inside_the_text() {
    for (name, text) in texts::texts() {
        let outcome = check_with("hopeless.json", &text, &With::default());
        assert!(outcome.diagnostics.has_errors(), "{name}");
        assert!(outcome.diagnostics.len() <= 2_000, "{name}: {} diagnostics", outcome.diagnostics.len());
        assert_placed(&outcome, name);
    }
}

#[test]
fn every_truncated_pipeline_is_a_diagnostic_in_the_text() {
    let text = std::fs::read_to_string(root().join("pipelines/nebula.json")).unwrap();
    let end = text.trim_end().len();
    for at in (0..end).step_by(37).filter(|at| text.is_char_boundary(*at)) {
        let outcome = check_with("pipelines/cut.json", &text[..at], &With::default());
        assert!(outcome.diagnostics.has_errors(), "cut at byte {at}");
        assert_placed(&outcome, &format!("cut at byte {at}"));
    }
}

#[test]
fn bytes_that_are_no_text_are_a_diagnostic_at_the_first_of_them() {
    let path = std::env::temp_dir().join(format!("umbragraph-not-utf8-{}.json", std::process::id()));
    for (bytes, at) in [(&b"{ \"a\": \"\xff\" }"[..], 8), (b"\xff\xfe{\0}\0", 0), (b"{}\xe2\x82", 2)] {
        std::fs::write(&path, bytes).unwrap();
        let diagnostic = umbragraph::low_level::read_source(&path, &mut Sources::new()).unwrap_err();
        assert_eq!(diagnostic.code.id, "UG0002");
        let Place::Span(span) = diagnostic.place else { panic!("{diagnostic:?}") };
        assert_eq!(span.start, at);
    }
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn files_that_lead_back_to_themselves_are_one_diagnostic() {
    for key in ["extends", "include"] {
        for length in [1, 2, 30] {
            let files = (0..length).map(|at| {
                let next = (at + 1) % length;
                (format!("f{at}.json"), format!("{{ \"{key}\": \"f{next}.json\" }}"))
            });
            let mut memory = Memory(files.collect());
            let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
            let file = sources.add("f0.json", memory.0["f0.json"].as_str());
            let path = Path::new("f0.json");
            assert!(compose::compose(file, path, &mut memory, &mut sources, &mut diagnostics).is_none());
            let codes: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
            assert_eq!(codes, [codes::FILE_CYCLE], "{key} of {length} files");
        }
    }
}

#[test]
fn subgraph_files_without_end_are_a_diagnostic() {
    // Each file uses the next, which either is there or is not.
    for there in [true, false] {
        let uses = |from: usize, to: usize| {
            let passes: Vec<String> =
                (from..to).map(|at| format!("\"p{at}\": {{ \"use\": \"f{at}.json\" }}")).collect();
            format!("{{ \"passes\": {{ {} }} }}", passes.join(", "))
        };
        let text = if there { uses(1, 2) } else { uses(1, 100_000) };
        let files = (1..500).filter(|_| there).map(|at| (format!("f{at}.json"), uses(at + 1, at + 2)));
        let mut memory = Memory(files.collect());
        let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
        let file = sources.add("f0.json", text);
        let path = Path::new("f0.json");
        assert!(compose::compose(file, path, &mut memory, &mut sources, &mut diagnostics).is_none());
        assert!(diagnostics.len() <= 65, "{}", diagnostics.len());
        assert!(diagnostics.iter().any(|diagnostic| diagnostic.code == codes::FILE_CYCLE), "{there}");
    }
}

/// The pieces of a text: strings, words and numbers, and single other characters.
fn tokens(text: &str) -> Vec<&str> {
    let (mut tokens, mut rest) = (Vec::new(), text);
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            _ if first.is_alphanumeric() => {
                rest.find(|c: char| !c.is_alphanumeric() && c != '.' && c != '_').unwrap_or(rest.len())
            }
            _ => first.len_utf8(),
        };
        tokens.push(&rest[..length]);
        rest = &rest[length..];
    }
    tokens
}

const ODD: [&str; 16] = [
    "null",
    "true",
    "0",
    "-1",
    "1e308",
    "4294967296",
    "0.5",
    "\"\"",
    "\"=1/0\"",
    "\"=viewport\"",
    "[]",
    "{}",
    "\"ä€😀\"",
    "\"a.b@c@-1\"",
    "\"{\"",
    "\"NaN\"",
];

fn mutate(text: &str, random: &mut Random) -> String {
    let mut pieces = tokens(text);
    for _ in 0..=random.below(3) {
        let solid: Vec<usize> = (0..pieces.len()).filter(|at| !pieces[*at].trim().is_empty()).collect();
        // Strings and words: changes of them mostly leave JSON.
        let words: Vec<usize> = solid.iter().copied().filter(|at| pieces[*at].len() > 1).collect();
        let (Some(at), Some(other)) =
            (words.get(random.below(words.len())), words.get(random.below(words.len())))
        else {
            continue;
        };
        match random.below(6) {
            0 => {
                pieces.remove(solid[random.below(solid.len())]);
            }
            1 => pieces.insert(*at, pieces[*other]),
            2 => pieces.swap(*at, *other),
            3 => pieces[*at] = pieces[*other],
            _ => pieces[*at] = ODD[random.below(ODD.len())],
        }
    }
    pieces.concat()
}

#[test]
fn mutated_pipelines_never_panic_and_have_places_in_the_text() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ property::seed());
    for (file, rounds) in
        [("tests/broken/chain.json", 200), ("pipelines/nebula.json", 20), ("pipelines/awsm.json", 4)]
    {
        let text = std::fs::read_to_string(root().join(file)).unwrap();
        for round in 0..rounds * property::times() {
            let mutated = mutate(&text, &mut random);
            let outcome = check_with(file, &mutated, &With::default());
            assert_placed(&outcome, &format!("{file}, mutation {round}"));
            // Nothing is rejected without a word.
            assert!(
                outcome.checked.plan.is_some() || outcome.diagnostics.has_errors(),
                "{file}, mutation {round} has no plan and no diagnostic:\n{mutated}"
            );
        }
    }
}

#[test]
fn more_errors_than_anybody_reads_are_cut_off() {
    let values = format!("[{}0]", "0,".repeat(1_500_001));
    assert_eq!(check(&values).codes(), ["UG0003"]);
    let keys: String = (0..5_000).map(|at| format!("\"k{at}\": 1, ")).collect();
    let outcome = check(&format!("{{ {keys} \"format\": 1 }}"));
    assert!(outcome.diagnostics.len() < 1_100, "{}", outcome.diagnostics.len());
    assert!(outcome.checked.pipeline.is_none());
}

#[test]
fn a_thousand_unknown_names_are_answered_with_short_lists() {
    let declared: Vec<String> =
        (0..1_000).map(|at| format!("\"light_{at}\": {{ \"type\": \"f32\", \"default\": 0 }}")).collect();
    let text = format!(
        r#"{{ "format": 1, "name": "n", "parameters": {{ {} }}, "passes": {{}} }}"#,
        declared.join(", ")
    );
    let unknown: Vec<String> = (0..1_000).map(|at| format!("x{at}")).collect();
    let parameters: Vec<(&str, &str)> = unknown.iter().map(|name| (name.as_str(), "1")).collect();
    let outcome = check_with("names.json", &text, &With { parameters: &parameters, ..With::default() });
    let helps = outcome.diagnostics.iter().filter_map(|diagnostic| diagnostic.help.as_deref());
    let helps: Vec<&str> = helps.filter(|help| help.starts_with("the parameters are")).collect();
    assert!(helps.len() >= 999, "{} of {}", helps.len(), outcome.diagnostics.len());
    assert!(helps.iter().all(|help| help.len() < 400 && help.ends_with(" and 976 more")), "{}", helps[0]);
}
