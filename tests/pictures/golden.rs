//! Pictures of every pipeline on the project's own scenes, held to references from Mesa's software driver.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::pictures::{self, Case, PIPELINES, SCENES};
use crate::common::root;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::GoldenFolder;

/// Renders pictures and holds each to its reference.
#[track_caller]
fn match_their_references(cases: &[Case]) {
    let Some(gpu) = gpu::device() else { return };
    let folder = GoldenFolder::new(pictures::folder());
    let mut failures = Vec::new();
    for case in cases {
        let picture = case.render(&gpu, &case.check(&[]));
        let verdict = folder.check(&case.name, &picture, &pictures::tolerance(&gpu));
        if !verdict.is_success() {
            failures.push(format!("{verdict:?}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

macro_rules! pictures_of {
    ($($pipeline:ident),*) => {
        const TESTED: &[&str] = &[$(stringify!($pipeline)),*];
        $(mod $pipeline {
            use super::match_their_references;
            use crate::common::pictures::{of_scene, of_variants};

            const PIPELINE: &str = stringify!($pipeline);

            #[test]
            fn courtyard() {
                match_their_references(&of_scene(PIPELINE, "courtyard"));
            }

            #[test]
            fn figure() {
                match_their_references(&of_scene(PIPELINE, "figure"));
            }

            #[test]
            fn foliage() {
                match_their_references(&of_scene(PIPELINE, "foliage"));
            }

            #[test]
            fn interior() {
                match_their_references(&of_scene(PIPELINE, "interior"));
            }

            #[test]
            fn variants() {
                match_their_references(&of_variants(PIPELINE));
            }
        })*
    };
}

pictures_of!(nebula, mantis, caracal, awsm, lore, umbra);

#[test]
fn lessons() {
    match_their_references(&pictures::of_lessons());
}

#[test]
fn extended_systems() {
    match_their_references(&pictures::of_extended());
}

#[test]
fn maps() {
    match_their_references(&pictures::of_maps());
}

#[test]
fn no_pipeline_no_scene_and_no_reference_is_left_out() {
    let names = |folder: &Path, extension: &str| -> BTreeSet<String> {
        let files = std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
        let those = files.filter(|path| path.extension().is_some_and(|found| found == extension));
        those.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect()
    };
    let table =
        |names: &[&str]| -> BTreeSet<String> { names.iter().map(|name| (*name).to_owned()).collect() };
    let pipelines: Vec<&str> = PIPELINES.iter().map(|row| row.0).collect();
    let scenes: Vec<&str> = SCENES.iter().map(|row| row.0).collect();
    assert_eq!(table(&pipelines), names(&root().join("pipelines"), "json"));
    assert_eq!(table(TESTED), table(&pipelines));
    let extended =
        pictures::of_extended().into_iter().map(|case| case.name.replacen("extended_", "", 1)).collect();
    assert_eq!(names(&root().join("pipelines/extended"), "json"), extended);
    assert_eq!(table(&scenes), names(&root().join("examples/scenes"), "glb"));
    assert_eq!(table(&["courtyard", "figure", "foliage", "interior"]), table(&scenes));
    let kept = names(&pictures::folder(), "png");
    let drawn = pictures::all().into_iter().map(|case| case.name).collect();
    assert_eq!(kept, drawn, "the references, and the pictures of the table");
}
