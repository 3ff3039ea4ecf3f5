//! The shadows of every system on every scene of the project, held against rays.
//!
//! Rays are traced here, on the CPU, so that every machine guards the accuracy. Each light that casts shadows is drawn
//! alone with the system's defaults; one that the system gives no shadows has no row. The recorded scores stand in
//! `tests/scores/`; a test fails where a system has become worse than its record. `UMBRAGRAPH_BLESS=1` writes the
//! records again.

use std::fmt::Write as _;

use umbragraph::frame::{Light, LightKind};
use umbragraph::passes::words::CAST_SHADOW;
use umbragraph_score::{Rays, Rendered, Scores, Truth};
use umbragraph_test_support::environment::{BLESS, is_set, process};
use umbragraph_test_support::gpu;

use crate::common::gpu::{Host, scene};
use crate::common::pictures::SCENES;
use crate::common::{With, check_file, root};

const SIZE: [u32; 2] = [256, 144];

/// The greatest loss of intersection over union, and gain of the mean error, that another driver may bring.
const SLACK: f64 = 0.004;

/// The systems that shadow spot and point lights by default.
const LOCAL: [&str; 2] = ["umbra", "awsm"];

/// The scores of one light, in the order of their columns.
const COLUMNS: [&str; 4] = ["IoU", "IoU off edges", "contact leak", "mean error"];

/// Draws each light of each scene alone, and gives a line of scores for each.
fn scores(system: &str) -> Option<Vec<(String, [Option<f64>; 4])>> {
    let gpu = gpu::device()?;
    let with = With { parameters: &[("debug_view", "\"shadow_term\"")], size: Some(SIZE), ..With::default() };
    let outcome = check_file(&format!("pipelines/{system}.json"), &with);
    let mut lines = Vec::new();
    for (name, _) in SCENES {
        let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
        let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
        let casts = |light: &&Light| {
            light.has(CAST_SHADOW) && (LOCAL.contains(&system) || light.kind == LightKind::Directional)
        };
        if !input.lights.iter().any(|light| casts(&light)) {
            continue;
        }
        let rays = Rays::new(&scene, &scene.pose(0.0));
        let truth = Truth::new(&rays, &input.camera, SIZE);
        let mut host = Host::new(&gpu, &outcome, &scene);
        for light in input.lights.iter().filter(casts) {
            let Some(traced) = truth.light(light) else { continue };
            let picture = host.picture(&input.clone().lights(vec![light.clone()]));
            let rendered = Rendered::new(picture.bytes());
            if rendered.is_lit_everywhere() {
                continue;
            }
            let scores = Scores::of(&truth, &traced, rendered);
            let of = [scores.iou(), scores.band(2).iou(), scores.contact.leak(), scores.mean_error.mean()];
            lines.push((format!("{name}, {}", light.name), of));
        }
    }
    Some(lines)
}

/// A table as Markdown, a row for each light.
fn table(lines: &[(String, [Option<f64>; 4])]) -> String {
    let mut text = format!("| scene, light | {} |\n|---|---|---|---|---|\n", COLUMNS.join(" | "));
    for (name, scores) in lines {
        let columns = scores.map(|score| score.map_or("–".to_owned(), |score| format!("{score:.4}")));
        let _ = writeln!(text, "| {name} | {} |", columns.join(" | "));
    }
    text
}

/// The scores of a table by the names of its rows.
fn read(text: &str) -> Vec<(String, [Option<f64>; 4])> {
    let rows = text.lines().skip(2).map(|line| line.trim_matches('|').split('|').map(str::trim));
    rows.map(|mut columns| {
        let name = columns.next().unwrap_or_default().to_owned();
        (name, std::array::from_fn(|_| columns.next().and_then(|score| score.parse().ok())))
    })
    .collect()
}

#[track_caller]
fn is_no_worse_than_its_record(system: &str) {
    let Some(found) = scores(system) else { return };
    let path = root().join(format!("tests/scores/{system}.md"));
    let table = table(&found);
    println!("{system}\n{table}");
    if is_set(&process, BLESS) {
        std::fs::write(&path, &table).expect("the record");
        return;
    }
    let recorded = read(&std::fs::read_to_string(&path).expect("a record"));
    let names =
        |lines: &[(String, [Option<f64>; 4])]| lines.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&found), names(&recorded), "the lights of the scenes have a row each");
    for ((name, found), (_, recorded)) in found.iter().zip(&recorded) {
        for (at, column) in COLUMNS.iter().enumerate() {
            let (Some(found), Some(recorded)) = (found[at], recorded[at]) else {
                assert_eq!(found[at].is_some(), recorded[at].is_some(), "{system}, {name}: {column}");
                continue;
            };
            // Contact shadows cover few pixels: one of them is a part in a hundred.
            let (worse, slack) = match at {
                0 | 1 => (recorded - found, SLACK),
                2 => (found - recorded, 0.05),
                _ => (found - recorded, SLACK),
            };
            assert!(worse <= slack, "{system}, {name}: {column} was {recorded} and is {found:.4}");
        }
    }
}

#[test]
fn umbra_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("umbra");
}

#[test]
fn awsm_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("awsm");
}

#[test]
fn nebula_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("nebula");
}

#[test]
fn lore_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("lore");
}

#[test]
fn mantis_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("mantis");
}

#[test]
fn caracal_is_no_worse_than_its_record() {
    is_no_worse_than_its_record("caracal");
}
