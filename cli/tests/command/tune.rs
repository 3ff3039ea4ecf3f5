//! `umbragraph tune` as a user meets it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use umbragraph_test_support::command::rejected;
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

const FOLIAGE: &str = "examples/scenes/foliage.glb";

fn command(name: &str, pipeline: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args([name, pipeline, "--scene", FOLIAGE, "--size", "96x54"]).args(arguments);
    command.current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."));
    command
}

fn tune(arguments: &[&str], out: &Path) -> Output {
    let mut command = command("tune", "pipelines/mantis.json", arguments);
    command.args(["--out", out.to_str().unwrap()]).output().expect("the command")
}

fn json(output: &Output) -> serde_json::Value {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn what_is_found_is_better_repeatable_and_written_down() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("what_is_found_is_better");
    let [first, second] = ["first.json", "second.json"].map(|name| folder.join(name));
    let over = "far,normal_bias=0..0.5,border,square_texels,exposure";
    let arguments =
        ["--over", over, "--budget", "40", "--seed", "7", "--format", "json", "--set", "filter_radius=0"];
    let output = tune(&arguments, &first);
    let found = json(&output);
    let [before, after] = ["before", "after"].map(|name| found[name]["score"].as_f64().unwrap());
    assert!(after > before + 0.005, "{before} {after}");
    assert_eq!(found["trials"], 40);
    let pareto = found["pareto"].as_array().unwrap();
    let of = |row: &serde_json::Value, name: &str| row[name].as_f64().unwrap();
    assert!(pareto.windows(2).all(|rows| of(&rows[0], "texels") <= of(&rows[1], "texels")));
    assert_eq!(pareto.iter().map(|row| of(row, "score")).fold(0.0, f64::max), after);
    assert!(pareto.iter().all(|row| of(row, "texels") > 1e4 && of(row, "taps") >= 2.0), "{pareto:?}");
    // The color of the picture is no part of its shadows.
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("UG0814") && errors.contains("\"exposure\" changes no pixel"), "{errors}");

    let text = std::fs::read_to_string(&first).unwrap();
    let values = &found["after"]["values"];
    assert!(values["border"].as_f64().is_some_and(|border| border.fract() == 0.0), "{values}");
    assert!(values["square_texels"].is_boolean(), "{values}");
    for part in [
        "// mantis.json, tuned by `umbragraph tune` over far, normal_bias, border, square_texels, exposure\n",
        "// on foliage.glb at 96 by 54; 40 sets of values, seed 7, on ",
        &format!("// IoU {before:.4} before, {after:.4} after.\n"),
        "\"filter_radius\": 0,",
    ] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
    assert!(!text.contains("exposure\":") && !text.contains("debug_view"), "{text}");
    assert_eq!(json(&tune(&arguments, &second)), found);
    assert_eq!(std::fs::read_to_string(&second).unwrap(), text);
    // The file gives that score again.
    let params = ["--params", first.to_str().unwrap(), "--format", "json"];
    let scored = command("score", "pipelines/mantis.json", &params).output().unwrap();
    assert_eq!(json(&scored)["together"]["bands"]["0"]["iou"], found["after"]["score"]);
}

#[test]
fn names_that_cannot_be_tuned_are_told_apart() {
    let folder = ScratchFolder::new("names_that_cannot_be_tuned");
    let out = folder.join("out.json");
    for (over, says) in [
        ("normal_bais", ["UG0814", "no parameter \"normal_bais\"", "did you mean \"normal_bias\""]),
        ("fit", ["UG0814", "\"fit\" is an enumeration", "tight, sphere"]),
        ("reverse_z", ["UG0814", "\"reverse_z\" is a feature", "--feature reverse_z"]),
        ("lambda=4..9", ["UG0814", "holds no value", "takes 0 to 1"]),
    ] {
        rejected(&tune(&["--over", over], &out), 1, &says);
    }
    assert_eq!(tune(&["--over", "far=9..1"], &out).status.code(), Some(2));
    assert_eq!(tune(&["--over", "far", "--budget", "0"], &out).status.code(), Some(2));
    rejected(&tune(&["--over", "far"], &folder.join("nowhere/out.json")), 1, &["UG0004", "does not exist"]);
    let plain = command("tune", "pipelines/learn/01-smallest.json", &["--over", "far", "--out", "x.json"]);
    rejected(&{ plain }.output().unwrap(), 1, &["UG0812", "shows no shadow term"]);
    if gpu::device().is_some() {
        rejected(
            &tune(&["--over", "exposure"], &out),
            1,
            &["UG0814", "changes no pixel", "no parameter is left"],
        );
    }
    assert!(!out.exists(), "nothing was found");
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_best_so_far() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("an_interrupt_keeps_the_best");
    let out = folder.join("out.json");
    let arguments = ["--over", "far,normal_bias", "--budget", "1000000", "--out", out.to_str().unwrap()];
    let mut command = command("tune", "pipelines/mantis.json", &arguments);
    let running = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_secs(4));
    let interrupt = Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap();
    assert!(interrupt.success());
    let output = running.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains(" of 1000000 sets of values tried"), "{text}");
    let file = std::fs::read_to_string(&out).unwrap();
    assert!(file.starts_with("// mantis.json, tuned") && file.ends_with("}\n"), "{file}");
    assert_eq!(std::fs::read_dir(folder.join("")).unwrap().count(), 1, "no half file");
}
