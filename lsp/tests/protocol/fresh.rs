//! Random edits of every document of `pipelines/`, half of them broken: the answers are those of a fresh session.

use std::path::Path;

use serde_json::{Value as Json, json};
use umbragraph::diagnostic::{Diagnostics, Place, Severity};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::pipeline::claimed_profiles;
use umbragraph::low_level::session::{Choice, Target};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::Sources;
use umbragraph_test_support::edits::{documents, edited};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::editor::*;

/// Edits of each document; a hundredth of them, of a third of the documents, in ordinary tests.
const EDITS: usize = 300;

/// The diagnostics of a file by a fresh session, as lines; and whether there are errors, in whichever file.
fn fresh(path: &Path, text: &str) -> (Vec<String>, bool) {
    let mut session = session();
    session.set_roots(&[root().join("pipelines")]);
    session.overlay(path, text.as_bytes());
    let target = Target::new(path);
    let diagnostics = match session.check_part(path) {
        Some((_, diagnostics)) => diagnostics,
        None => {
            let loaded = session.load(&target).expect("nothing cancels");
            let profiles = loaded
                .understood()
                .map(|composed| claimed_profiles(&composed.document, &mut Diagnostics::new()));
            let profile =
                profiles.and_then(|all| all.into_iter().next()).unwrap_or_else(TargetProfile::webgpu);
            session
                .plan(&target, &Choice::new(profile, PlanOptions::new(1280, 720)))
                .expect("nothing cancels")
                .1
        }
    };
    (lines(&diagnostics, session.sources(), path), diagnostics.has_errors())
}

fn lines(diagnostics: &Diagnostics, sources: &Sources, path: &Path) -> Vec<String> {
    let mut lines = Vec::new();
    for one in diagnostics {
        let related = one.related.iter().map(|one| &one.place);
        let spans = std::iter::once(&one.place).chain(related).filter_map(|place| match place {
            Place::Span(span) => Some(*span),
            _ => None,
        });
        let mut spans = spans
            .filter(|span| sources.get(span.file).is_some_and(|file| Path::new(file.name()).is_absolute()));
        let severity = match one.severity {
            Severity::Error => 1,
            Severity::Warning => 2,
            Severity::Note => 3,
        };
        let (start, end) = match spans.next() {
            Some(span) => {
                let file = sources.get(span.file).expect("a file");
                if Path::new(file.name()) != path {
                    continue;
                }
                let at = |offset: u32| {
                    let position = position(file.text(), offset as usize);
                    format!("{}:{}", position["line"], position["character"])
                };
                (at(span.start), at(span.end))
            }
            None => continue,
        };
        lines.push(format!("{start} {end} \"{}\" {severity} {}", one.code.id, one.message));
    }
    lines.sort();
    lines.dedup();
    lines
}

/// Edits the documents whose number has this remainder, so that threads share the work.
fn answers_after_edits_are_those_of_a_fresh_session(remainder: usize, of: usize) {
    let folder = root().join("pipelines");
    let mut editor = Editor::start(&folder);
    let mut compared = 0;
    let documents = documents(&folder).into_iter().enumerate().filter(|(at, _)| at % of == remainder);
    for (number, path) in property::part(documents, 3) {
        let text = std::fs::read_to_string(&path).expect("a text");
        // A part that is not right alone is told of as part of a whole: see the test of parts.
        let is_part = session().check_part(&path).is_some();
        let stands_alone = is_part || !fresh(&path, &text).1 && text.contains("\"passes\"");
        let mut random = Random(property::seed().wrapping_mul(3_000).wrapping_add(number as u64));
        editor.open(&path, &text);
        let edits: Vec<String> = (0..EDITS).map(|_| edited(&text, &mut random)).collect();
        for now in property::part(edits, 100) {
            editor.change(&path, &now);
            let found = editor.diagnostics(&path);
            if stands_alone {
                let mut all = found.clone();
                all.retain(|line| !line.starts_with("0:0 0:0"));
                let (mut expected, _) = fresh(&path, &now);
                expected.retain(|line| !line.starts_with("0:0 0:0"));
                if is_part {
                    // A pipeline that is open says more of its parts.
                    all.retain(|line| expected.contains(line));
                }
                // Of a format that does not exist, a part alone says that the word is not known; as a part of a whole
                // it is no format.
                let alone = |line: &String| {
                    line.replace("\"UG0322\"", "\"UG0107\"")
                        .replace("is not a texture format", "is not known here")
                };
                let [all, expected] =
                    [&all, &expected].map(|lines| lines.iter().map(alone).collect::<Vec<_>>());
                assert_eq!(all, expected, "{}:\n{now}", path.display());
                compared += 1;
            }
            let mut at = random.below(now.len() + 1);
            while !now.is_char_boundary(at) {
                at -= 1;
            }
            for method in ["completion", "hover", "definition", "prepareRename"] {
                editor.at(&format!("textDocument/{method}"), &path, at, Json::Null);
            }
            editor.at(
                "textDocument/references",
                &path,
                at,
                json!({ "context": { "includeDeclaration": true } }),
            );
            let whole = json!({ "start": position(&now, 0), "end": position(&now, now.len()) });
            let document = json!({ "uri": uri(&path) });
            editor.ask("textDocument/semanticTokens/full", json!({ "textDocument": document }));
            editor.ask("textDocument/inlayHint", json!({ "textDocument": document, "range": whole }));
            let context = json!({ "diagnostics": [] });
            editor.ask(
                "textDocument/codeAction",
                json!({ "textDocument": document, "range": whole, "context": context }),
            );
        }
        editor.close(&path);
    }
    assert!(compared > 0, "no document stands alone");
}

#[test]
fn answers_after_edits_are_those_of_a_fresh_session_in_part_1() {
    answers_after_edits_are_those_of_a_fresh_session(0, 2);
}

#[test]
fn answers_after_edits_are_those_of_a_fresh_session_in_part_2() {
    answers_after_edits_are_those_of_a_fresh_session(1, 2);
}
