//! Choosing an adapter by the environment and the command line, and drawing on OpenGL as on Vulkan.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use umbragraph_test_support::command::text;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::{Picture, Tolerance, compare};
use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

const CHOOSING: [&str; 6] = [
    "UMBRAGRAPH_ADAPTER",
    "WGPU_ADAPTER_NAME",
    "WGPU_BACKEND",
    "WGPU_POWER_PREF",
    "WGPU_VALIDATION",
    "EGL_LOG_LEVEL",
];

fn run(arguments: &[&str], set: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    for name in CHOOSING {
        command.env_remove(name);
    }
    command.env("WGPU_VALIDATION", "0").envs(set.iter().copied()).args(arguments);
    command.current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")).output().expect("the command")
}

/// Renders the courtyard with the adapter of the environment; the picture, if there is such an adapter.
fn courtyard(pipeline: &str, out: &Path, set: &[(&str, &str)]) -> Option<Picture> {
    let pipeline = format!("pipelines/{pipeline}.json");
    let scene = ["--scene", "examples/scenes/courtyard.glb", "--size", "160x90", "--out"];
    let arguments = [&["render", &pipeline][..], &scene, &[out.to_str().unwrap()]].concat();
    let output = run(&arguments, set);
    let said = text(&output.stderr);
    if said.contains("UG0801") {
        return None;
    }
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains("libEGL"), "{said}");
    Some(Picture::load(out).expect("a picture"))
}

#[test]
fn nonsense_is_a_sentence_and_status_1() {
    let cases = [
        ("WGPU_BACKEND", "nonsense", "WGPU_BACKEND names \"nonsense\""),
        ("WGPU_POWER_PREF", "huge", "WGPU_POWER_PREF is \"huge\""),
        ("WGPU_BACKEND", "metal", "no graphics adapter of metal"),
    ];
    for (name, value, words) in cases {
        let output = run(&["adapters"], &[(name, value)]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words) && said.contains("UG0801"), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_is_no_driver_leaves_no_adapter() {
    let set = [("VK_DRIVER_FILES", "/etc/hostname"), ("WGPU_BACKEND", "vulkan")];
    let said = text(&run(&["adapters"], &set).stderr);
    assert!(said.contains("VK_DRIVER_FILES lets no driver through but \"/etc/hostname\""), "{said}");
}

#[test]
fn adapters_are_listed_with_what_they_draw() {
    let Some(gpu) = gpu::device() else { return };
    let output = run(&["adapters", "--format", "json"], &[]);
    let list: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let name = gpu.adapter.get_info().name;
    let mut adapters = list["adapters"].as_array().unwrap().iter();
    let own = adapters.find(|one| one["name"].as_str().unwrap().contains(&name)).expect("the adapter");
    let systems: Vec<_> = own["systems"].as_array().unwrap().iter().collect();
    assert_eq!(systems.len(), 6);
    assert!(systems.iter().all(|system| system["error"].is_null()), "{own}");
    let unknown = run(
        &[
            "render",
            "pipelines/nebula.json",
            "--scene",
            "examples/scenes/figure.glb",
            "--out",
            concat!(env!("CARGO_TARGET_TMPDIR"), "/no-adapter.png"),
            "--adapter",
            "no such",
        ],
        &[],
    );
    let said = text(&unknown.stderr);
    assert!(unknown.status.code() == Some(1) && said.contains("\"no such\", as --adapter asks"), "{said}");
}

/// Mesa gives an older OpenGL where its variables say so.
const ES31: [(&str, &str); 3] =
    [("WGPU_BACKEND", "gl"), ("MESA_GL_VERSION_OVERRIDE", "3.1"), ("MESA_GLES_VERSION_OVERRIDE", "3.1")];
const ES30: [(&str, &str); 3] =
    [("WGPU_BACKEND", "gl"), ("MESA_GL_VERSION_OVERRIDE", "2.1"), ("MESA_GLES_VERSION_OVERRIDE", "3.0")];

#[test]
fn opengl_draws_what_vulkan_draws() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("adapters-opengl");
    for pipeline in ["nebula", "umbra"] {
        let vulkan = [("WGPU_BACKEND", "vulkan"), ("WGPU_ADAPTER_NAME", "llvmpipe")];
        let Some(reference) = courtyard(pipeline, &folder.join("vulkan.png"), &vulkan) else {
            skip::skipped("no lavapipe");
            return;
        };
        for (at, set) in [&ES31[..1], &ES31].into_iter().enumerate() {
            let Some(picture) = courtyard(pipeline, &folder.join(format!("{at}.png")), set) else {
                skip::skipped("no OpenGL");
                return;
            };
            // Half a percent of the pixels: edges of shadows, where rounding decides.
            let tolerance = Tolerance { per_channel: 8, failed_pixels: 72 };
            let comparison = compare(&reference, &picture, &tolerance);
            assert!(comparison.matches(), "{pipeline}, {set:?}: {}", comparison.message());
        }
    }
}

#[test]
fn opengl_without_compute_draws_shadows_and_says_what_is_off() {
    if gpu::device().is_none() {
        return;
    }
    let pipeline =
        ["score", "pipelines/umbra.json", "--preset", "phone", "--size", "160x90", "--format", "json"];
    let scene = ["--scene", "examples/scenes/courtyard.glb"];
    let output = run(&[&pipeline[..], &scene].concat(), &ES30);
    let said = text(&output.stderr);
    if said.contains("UG0801") {
        skip::skipped("no OpenGL");
        return;
    }
    assert!(said.contains("\"visible_range\" is off: llvmpipe"), "{said}");
    let scores: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let iou = scores["lights"][0]["scores"]["bands"]["2"]["iou"].as_f64().expect("a score");
    assert!(iou > 0.9, "{scores}");
}
