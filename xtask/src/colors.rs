//! `cargo xtask colors`: the colors of the flagship against traced paths, on each scene of the project, as a table.
//!
//! Two rows for each scene. In the first, light comes from lamps and sky alone: ambient occlusion is off, and in the
//! reference nothing occludes the sky. In the second, ambient occlusion is on, and the reference has three bounces; the
//! same without ambient occlusion stands in brackets. The status is 1 if a first row has an error above 0.01.

use crate::{adapter, process};

/// The size of the pictures in pixels.
const SIZE: &str = "160x90";

/// The error above which the status is 1: of 1, display-referred.
const MAX_ERROR: f64 = 0.01;

const SCENES: [&str; 4] = ["courtyard", "figure", "foliage", "interior"];

/// The scores of a picture: mean error, the same over surfaces, bias, and FLIP.
type Scores = [f64; 4];

/// Prints the table. Returns `true` if no error of direct light is too large.
pub(crate) fn run() -> Result<bool, String> {
    adapter::ensure_if_possible();
    println!("| scene | light | mean error | on surfaces | bias | FLIP |\n|---|---|---|---|---|---|");
    let mut fine = true;
    for scene in SCENES {
        let open =
            score(scene, &["--feature", "ambient_occlusion=off", "--ambient", "open", "--samples", "64"])?;
        fine &= open[0] <= MAX_ERROR;
        println!("| {scene} | lamps and sky | {} |", open.map(|score| format!("{score:.4}")).join(" | "));
        let bounced = |occlusion: &str| {
            let feature = format!("ambient_occlusion={occlusion}");
            score(scene, &["--feature", &feature, "--bounces", "3", "--samples", "64"])
        };
        let (with, without) = (bounced("on")?, bounced("off")?);
        let cells = with.iter().zip(without).map(|(with, without)| format!("{with:.4} ({without:.4})"));
        println!("| {scene} | three bounces | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    Ok(fine)
}

/// Returns the scores of the picture of `umbra` before its effects.
fn score(scene: &str, more: &[&str]) -> Result<Scores, String> {
    let scene = format!("examples/scenes/{scene}.glb");
    let arguments =
        ["run", "--quiet", "--package", "umbragraph-cli", "--", "score", "pipelines/umbra.json", "--scene"];
    let asked = ["--of", "color", "--resource", "color@sky", "--size", SIZE, "--format", "json"];
    let output = process::program("cargo").args(arguments).arg(&scene).args(asked).args(more).output();
    let output = output.map_err(|error| format!("cargo could not be started: {error}"))?;
    if !output.status.success() {
        return Err(format!("{scene}: {}", String::from_utf8_lossy(&output.stderr)));
    }
    together(&String::from_utf8_lossy(&output.stdout)).ok_or_else(|| format!("{scene}: no scores"))
}

/// Parses the scores of all frames together from the JSON output of `score`.
fn together(json: &str) -> Option<Scores> {
    let (_, together) = json.split_once("\"together\":")?;
    let number = |name: &str| {
        let (_, rest) = together.split_once(&format!("\"{name}\":"))?;
        rest.split(['}', ',']).next()?.trim().parse::<f64>().ok()
    };
    Some([number("mean_error")?, number("surface_error")?, number("bias")?, number("flip")?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_read_from_the_answer() {
        let scores =
            r#"{ "bias": -0.5, "flip": 0.25, "mean_error": 0.01, "noise": 0.1, "surface_error": 0.02 }"#;
        let answer = format!(r#"{{ "frames": [{{ "scores": {{ "flip": 9 }} }}], "together": {scores} }}"#);
        assert_eq!(together(&answer), Some([0.01, 0.02, -0.5, 0.25]));
        assert_eq!(together(r#"{ "together": { "flip": null } }"#), None);
    }
}
