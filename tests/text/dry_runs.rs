//! Plans that `check` passes are accepted by wgpu: the tree's pipelines and mutations of the teaching ones, run dry.
//!
//! A mutation replaces one number or word of a document by another of its kind. Most are rejected; what is not has to
//! run on wgpu's backend without a driver, on a device with just what the profile promises.

use std::sync::Arc;

use crate::common::{With, check_with, read, root};
use umbragraph::executor::DryRun;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::scene::interface;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

const NUMBERS: &[&str] =
    &["0", "1", "2", "3", "4", "5", "6", "8", "16", "63", "64", "100", "256", "1000", "4096"];
const FORMATS: &[&str] = &[
    "r8unorm",
    "rgba8unorm",
    "rgba8unorm-srgb",
    "rgba8snorm",
    "rgba8uint",
    "bgra8unorm",
    "r16float",
    "rgba16float",
    "r32float",
    "r32uint",
    "rg32float",
    "rgba32float",
    "rgba16unorm",
    "rgb10a2unorm",
    "rg11b10ufloat",
    "depth16unorm",
    "depth32float",
    "depth24plus-stencil8",
];
const WORDS: &[&str] = &[
    "nearest",
    "linear",
    "repeat",
    "less",
    "always",
    "greater",
    "add",
    "alpha",
    "multiply",
    "back",
    "none",
    "2d-array",
    "cube",
    "3d",
    "triangle-strip",
    "line-list",
    "point-list",
    "persistent",
    "transient",
    "imported",
    "viewport",
    "replace",
    "zero",
];

/// The teaching pipelines, by their paths in the workspace.
fn lessons() -> Vec<String> {
    let folder = std::fs::read_dir(root().join("pipelines/learn")).expect("lessons");
    let names = folder.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut paths: Vec<String> =
        names.filter(|name| name.ends_with(".json")).map(|name| format!("pipelines/learn/{name}")).collect();
    paths.sort();
    paths
}

/// The diagnostics of wgpu for a document that `check` passes; `None` for other documents.
fn said(dry_run: &mut DryRun, path: &str, text: &str) -> Option<String> {
    let outcome = check_with(path, text, &With::default());
    if outcome.diagnostics.has_errors() {
        return None;
    }
    let mut plan = Arc::unwrap_or_clone(outcome.checked.plan?);
    Arc::make_mut(&mut plan.pipeline)
        .hosts
        .insert(interface::GEOMETRY.into(), interface::any_scene().any_filter());
    let said = pollster::block_on(dry_run.run(&Arc::new(plan)));
    let messages: Vec<&str> = said.iter().map(|one| one.message.as_str()).collect();
    Some(messages.join("; "))
}

fn dry_run() -> DryRun {
    pollster::block_on(DryRun::new(&TargetProfile::webgpu())).expect("a device")
}

#[test]
fn the_pipelines_of_the_tree_run_dry() {
    let mut dry_run = dry_run();
    let shipped =
        ["awsm", "caracal", "lore", "mantis", "nebula"].map(|name| format!("pipelines/{name}.json"));
    for path in lessons().into_iter().chain(shipped) {
        assert_eq!(said(&mut dry_run, &path, &read(&path)).as_deref(), Some(""), "{path}");
    }
}

/// The ranges of a document's numbers and of the words that are values.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = text.find("\"resources\"").unwrap_or(0);
    while at < bytes.len() {
        match bytes[at] {
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                while at < bytes.len() && bytes[at] != b'\n' {
                    at += 1;
                }
            }
            b'"' => {
                let end = at + 1 + text[at + 1..].find('"').unwrap_or(0);
                if !text[end + 1..].trim_start().starts_with(':') {
                    found.push((at + 1, end));
                }
                at = end + 1;
            }
            b'0'..=b'9' => {
                let end = at + text[at..].find(|c: char| !c.is_ascii_digit()).unwrap_or(1);
                found.push((at, end));
                at = end;
            }
            _ => at += 1,
        }
    }
    found
}

fn mutation(text: &str, random: &mut Random) -> String {
    let tokens = tokens(text);
    let (start, end) = tokens[random.below(tokens.len())];
    let old = &text[start..end];
    let new = if old.starts_with(|c: char| c.is_ascii_digit()) {
        random.one_of(NUMBERS)
    } else if FORMATS.contains(&old) || old.contains("float") || old.contains("norm") {
        random.one_of(FORMATS)
    } else if WORDS.contains(&old) {
        random.one_of(WORDS)
    } else {
        let (start, end) = tokens[random.below(tokens.len())];
        &text[start..end]
    };
    [&text[..start], new, &text[end..]].concat()
}

#[test]
fn mutations_of_lessons_that_check_passes_run_dry() {
    let (mut dry_run, mut random) = (dry_run(), Random(property::seed()));
    let lessons: Vec<(String, String)> =
        lessons().into_iter().map(|path| (path.clone(), read(&path))).collect();
    let (mut passed, mut wrong) = (0, Vec::new());
    for _ in 0..150 * property::times() {
        let (path, text) = &lessons[random.below(lessons.len())];
        let mut mutant = mutation(text, &mut random);
        if random.below(2) == 0 {
            mutant = mutation(&mutant, &mut random);
        }
        let Some(said) = said(&mut dry_run, path, &mutant) else { continue };
        passed += 1;
        if !said.is_empty() {
            let changed: Vec<String> = text
                .lines()
                .zip(mutant.lines())
                .filter(|(old, new)| old != new)
                .map(|(old, new)| format!("- {old}\n+ {new}"))
                .collect();
            wrong.push(format!("{path}\n{}\n  {said}", changed.join("\n")));
        }
    }
    println!("{passed} mutations pass check");
    assert!(passed > 10, "only {passed} mutations pass check");
    assert!(wrong.is_empty(), "{} of {passed}:\n{}", wrong.len(), wrong.join("\n"));
}
