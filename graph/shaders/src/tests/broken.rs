//! Invalid templates, each with its exact diagnostics.
//!
//! Each case is a file of `broken/`: the files of a template set under `=== NAME` lines. The check runs on
//! `main.wgsl.jinja`; `--- profiles` names the profiles if not `webgpu`; the expected diagnostics follow `---
//! diagnostics`. If they differ, the case fails with the text that the file should contain.

use std::fmt::Write as _;

use super::Fixture;
use crate::TargetProfile;
use crate::permutations::{Options, Request, check};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, Place};

struct Case<'a> {
    files: Vec<(&'a str, String)>,
    profiles: Vec<TargetProfile>,
    expected: String,
}

fn read(text: &str) -> Case<'_> {
    let mut case =
        Case { files: Vec::new(), profiles: vec![TargetProfile::webgpu()], expected: String::new() };
    let mut diagnostics = false;
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("=== ") {
            case.files.push((name, String::new()));
        } else if let Some(names) = line.strip_prefix("--- profiles ") {
            case.profiles = names.split(' ').map(|name| TargetProfile::from_name(name).unwrap()).collect();
        } else if line == "--- diagnostics" {
            diagnostics = true;
        } else if diagnostics {
            case.expected.push_str(line);
            case.expected.push('\n');
        } else {
            let (_, file) = case.files.last_mut().expect("a file begins with its name");
            file.push_str(line);
            file.push('\n');
        }
    }
    case
}

fn describe(fixture: &Fixture, diagnostics: &Diagnostics) -> String {
    let mut text = String::new();
    for diagnostic in diagnostics {
        writeln!(text, "{} {} {}", diagnostic.code, fixture.place(&diagnostic.place), diagnostic.message)
            .unwrap();
        for related in &diagnostic.related {
            match related.place {
                Place::Nowhere => writeln!(text, "    {}", related.message).unwrap(),
                _ => writeln!(text, "    {} {}", fixture.place(&related.place), related.message).unwrap(),
            }
        }
        if let Some(help) = &diagnostic.help {
            writeln!(text, "    help: {help}").unwrap();
        }
    }
    text
}

fn check_case(files: &[(&str, String)], profiles: &[TargetProfile]) -> (Fixture, Diagnostics) {
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let fixture = Fixture::new(&files);
    let mut diagnostics = fixture.diagnostics.clone();
    let options = Options { report_dead: true, ..Options::default() };
    let request = Request::all("main.wgsl.jinja", profiles);
    diagnostics.extend(check(&fixture.set, &[request], &options).diagnostics);
    diagnostics.sort();
    (fixture, diagnostics)
}

fn found(case: &Case<'_>) -> String {
    let (fixture, diagnostics) = check_case(&case.files, &case.profiles);
    describe(&fixture, &diagnostics)
}

#[test]
fn a_name_that_was_meant_is_written_by_the_fix() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/tests/broken");
    let mut without = Vec::new();
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let text = std::fs::read_to_string(&path).unwrap();
        let case = read(&text);
        let (fixture, diagnostics) = check_case(&case.files, &case.profiles);
        for diagnostic in &diagnostics {
            let fixed = umbragraph_text::edit::mend([diagnostic], &fixture.sources, |_| true);
            if diagnostic.help.as_deref().is_some_and(|help| help.starts_with("did you mean"))
                && fixed.is_empty()
            {
                without.push(path.file_stem().unwrap().to_string_lossy().into_owned());
            }
            if fixed.is_empty() {
                continue;
            }
            let mut files = case.files.clone();
            for (name, edits) in fixed {
                let text = &mut files.iter_mut().find(|(known, _)| *known == name).unwrap().1;
                *text = edits.apply(text).unwrap();
            }
            let is_it =
                |other: &Diagnostic| (other.code, &other.message) == (diagnostic.code, &diagnostic.message);
            let (_, after) = check_case(&files, &case.profiles);
            assert!(!after.iter().any(is_it), "{}: {}", path.display(), diagnostic.message);
        }
    }
    without.sort();
    // The calls of a misspelt import would have to be renamed, too.
    assert_eq!(without, ["block_that_no_base_has"]);
}

#[test]
fn every_broken_template_gets_exactly_its_diagnostics() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/tests/broken");
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    assert!(names.len() >= 40, "only {} cases", names.len());
    let mut wrong = String::new();
    for path in names {
        let text = std::fs::read_to_string(&path).unwrap();
        let case = read(&text);
        let found = found(&case);
        assert!(!found.is_empty(), "{} is not broken", path.display());
        if found != case.expected {
            let name = path.file_name().unwrap().to_string_lossy();
            write!(wrong, "=====#{name}\n{found}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}
