//! `cargo xtask cameras`: the worst shadows of each pipeline with its defaults, over random cameras, as a table.
//!
//! Each pipeline is scored from 20 cameras of a seed (`umbragraph score --camera random:SEED --frames 20`), on each
//! scene whose lights it shadows. Rows are scenes. Cells hold the largest mean error of a frame against lights with
//! their extent (lower is better), and the smallest intersection over union with hard masks (higher is better), over
//! frames with at least a hundredth of the pixels in shadow. The status is 1 unless the flagship has the smallest error
//! on every scene. A soft shadow cannot match a hard mask, so the second number does not count.

use crate::{adapter, process};

/// The pipelines to score: five systems, and last the flagship `umbra`.
const PIPELINES: [&str; 6] = ["mantis", "awsm", "nebula", "caracal", "lore", "umbra"];

/// The column of the flagship `umbra` with ray-traced shadows where its shadow maps are coarse.
const HYBRID: &str = "umbra, hybrid";

/// The size of the pictures in pixels.
const SIZE: &str = "512x288";
const FRAMES: &str = "20";

/// Prints the table. Returns `true` if `umbra` has the smallest worst error on every scene.
pub(crate) fn run(seed: u64) -> Result<bool, String> {
    adapter::ensure_if_possible();
    let mut fine = true;
    println!("| scene | {} | {HYBRID} |\n|---|{}", PIPELINES.join(" | "), "---|".repeat(PIPELINES.len() + 1));
    for (name, scene) in scenes() {
        let mut all = Vec::new();
        for pipeline in PIPELINES {
            all.push(score(pipeline, &scene, seed, &[])?);
        }
        let hybrid = score("umbra", &scene, seed, &["--feature", "light_filter=hybrid"])?;
        let cell = |worst: Worst| format!("{:.4} ({:.3})", worst.error, worst.iou);
        let cells: Vec<String> =
            all.iter().chain([&hybrid]).map(|worst| worst.map_or_else(String::new, cell)).collect();
        println!("| {name} | {} |", cells.join(" | "));
        let (flagship, others) = all.split_last().ok_or("there are no pipelines")?;
        let is_better = |other: &Worst| flagship.is_some_and(|flagship| flagship.error < other.error);
        fine &= others.iter().flatten().all(is_better);
    }
    Ok(fine)
}

/// The worst scores among the frames of a pipeline on a scene: the largest mean error, and the smallest intersection
/// over union.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Worst {
    error: f64,
    iou: f64,
}

/// Returns the names and paths of the project's own scenes and of the available scenes with ray-traced masks.
fn scenes() -> Vec<(String, String)> {
    let root = process::workspace_root();
    let truth = std::env::var_os("UMBRAGRAPH_TRUTH").map_or_else(|| root.join("../shared/truth"), Into::into);
    let mut found = Vec::new();
    for folder in [root.join("examples/scenes"), truth] {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if let (Some("glb"), Some(name)) =
                (path.extension().and_then(|one| one.to_str()), path.file_stem().and_then(|one| one.to_str()))
            {
                found.push((name.to_owned(), path.display().to_string()));
            }
        }
    }
    found.sort();
    found
}

/// Returns the worst scores of a pipeline on a scene; `None` if it draws no shadows for some light.
fn score(pipeline: &str, scene: &str, seed: u64, more: &[&str]) -> Result<Option<Worst>, String> {
    let (pipeline, camera) = (format!("pipelines/{pipeline}.json"), format!("random:{seed}"));
    let arguments = ["run", "--quiet", "--package", "umbragraph-cli", "--", "score", &pipeline];
    let asked =
        ["--scene", scene, "--camera", &camera, "--frames", FRAMES, "--size", SIZE, "--format", "json"];
    let output = process::program("cargo").args(arguments).args(asked).args(more).output();
    let output = output.map_err(|error| format!("cargo could not be started: {error}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{pipeline} on {scene}: {errors}"));
    }
    if errors.contains("no shadows at all") {
        return Ok(None);
    }
    Ok(worst(&String::from_utf8_lossy(&output.stdout)))
}

/// Parses the worst scores from the JSON output of `score`.
fn worst(json: &str) -> Option<Worst> {
    let (_, frames) = json.split_once("\"frames\":")?;
    let (frames, worst) = frames.split_once("\"worst\":")?;
    let number = |text: &str| text.split(['}', ',']).next()?.trim().parse::<f64>().ok();
    let errors = frames.split("\"mean_error\":").skip(1).filter_map(number);
    let (_, iou) = worst.trim_start().strip_prefix('{')?.split_once("\"iou\":")?;
    Some(Worst { error: errors.reduce(f64::max)?, iou: number(iou)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_is_read_from_the_answer() {
        let frames = r#""frames": [{ "frame": 0, "iou": 0.9, "mean_error": 0.01 }, { "frame": 3, "iou": 0.875,
            "mean_error": 0.02 }, { "frame": 4, "iou": null, "mean_error": null }]"#;
        let answer = format!(
            r#"{{ "lights": [{{ "mean_error": 0.5 }}], {frames}, "worst": {{ "frame": 3, "iou": 0.875
            }}, "together": {{ "iou": 0.99, "mean_error": 0.3 }} }}"#
        );
        assert_eq!(worst(&answer), Some(Worst { error: 0.02, iou: 0.875 }));
        assert_eq!(worst(&format!(r#"{{ {frames}, "worst": null, "together": {{ "iou": 0.5 }} }}"#)), None);
    }

    #[test]
    fn the_projects_own_scenes_are_among_them() {
        assert!(scenes().iter().any(|(name, path)| name == "courtyard" && path.ends_with("courtyard.glb")));
    }
}
