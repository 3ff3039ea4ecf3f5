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

/// Renders a scene with the adapter that the environment selects; `None` if there is no such adapter.
fn drawn(pipeline: &str, scene: &str, out: &Path, set: &[(&str, &str)]) -> Option<Picture> {
    let pipeline = format!("pipelines/{pipeline}.json");
    let scene = format!("examples/scenes/{scene}.glb");
    let scene = ["--scene", &scene, "--size", "160x90", "--out"];
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

/// Runs the command with only the Vulkan drivers of the given manifests. Returns the exit status and standard error.
#[cfg(target_os = "linux")]
fn with_drivers(files: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let output = run(arguments, &[("VK_DRIVER_FILES", files), ("WGPU_BACKEND", "vulkan")]);
    (output.status.code(), text(&output.stderr))
}

const RENDER: [&str; 6] = [
    "render",
    "pipelines/nebula.json",
    "--scene",
    "examples/scenes/figure.glb",
    "--out",
    concat!(env!("CARGO_TARGET_TMPDIR"), "/no-adapter.png"),
];

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_is_no_driver_leaves_no_adapter() {
    let folder = ScratchFolder::new("adapters-no-driver");
    let library = folder.join("driver.so");
    std::fs::write(&library, "no library").unwrap();
    let manifest = folder.join("driver.json");
    let path = library.to_str().unwrap();
    let text = format!(
        r#"{{ "file_format_version": "1.0.0", "ICD": {{ "api_version": "1.1.0", "library_path": "{path}" }} }}"#
    );
    std::fs::write(&manifest, text).unwrap();
    for file in ["/etc/hostname", "/no/such/file.json", manifest.to_str().unwrap()] {
        for arguments in [&["adapters"][..], &RENDER] {
            let (status, said) = with_drivers(file, arguments);
            let words = format!("VK_DRIVER_FILES limits Vulkan to \"{file}\"");
            assert!(status == Some(1) && said.contains(&words), "{status:?}: {said}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn no_adapters_at_all_are_a_sentence_without_noise() {
    let nowhere = "/no/such/file.json";
    let set = [("VK_DRIVER_FILES", nowhere), ("__EGL_VENDOR_LIBRARY_FILENAMES", nowhere)];
    for arguments in [&["adapters"][..], &RENDER] {
        let output = run(arguments, &set);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.starts_with("error[UG0801]: no graphics adapter was found"), "{said}");
        assert!(!said.to_lowercase().contains("egl:"), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn adapters_of_one_name_are_told_apart_by_a_number() {
    let Some(lavapipe) = lavapipe() else {
        skip::skipped("no lavapipe");
        return;
    };
    let folder = ScratchFolder::new("adapters-one-name");
    let copies = ["a.json", "b.json"].map(|name| folder.join(name));
    for copy in &copies {
        std::fs::copy(&lavapipe, copy).unwrap();
    }
    let files = copies.map(|copy| copy.to_str().unwrap().to_owned()).join(":");
    let with = |adapter: &str| {
        with_drivers(&files, &[&RENDER[..], &["--size", "16x9", "--adapter", adapter]].concat())
    };
    let (status, said) = with("llvmpipe");
    assert!(status == Some(1) && said.contains("2 graphics adapters are called \"llvmpipe\""), "{said}");
    assert!(said.contains("(vulkan) #1") && said.contains("(vulkan) #2"), "{said}");
    let (status, said) = with("#2");
    assert!(status == Some(0), "{said}");
    // One that has vanished since.
    let (status, said) = with("#3");
    assert!(status == Some(1) && said.contains("no graphics adapter is called \"#3\""), "{said}");
}

/// Limits the process's memory so that a shadow map of 8192 by 8192 texels in four layers cannot be allocated.
#[cfg(target_os = "linux")]
#[test]
fn memory_that_runs_out_names_the_resource() {
    let swiftshader = PathBuf::from("/usr/lib/chromium/vk_swiftshader_icd.json");
    let drivers = lavapipe().into_iter().chain(Some(swiftshader).filter(|file| file.exists()));
    let mut drawn = false;
    for driver in drivers {
        let render = [&RENDER[..], &["--size", "16x9", "--set", "resolution=8192"]].concat();
        let limited = r#"ulimit -v 1200000; exec "$0" "$@""#;
        let mut command = Command::new("sh");
        command.args(["-c", limited, env!("CARGO_BIN_EXE_umbragraph")]).args(render);
        command.env("VK_DRIVER_FILES", &driver).env("WGPU_BACKEND", "vulkan").env("WGPU_VALIDATION", "0");
        command.current_dir(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(".."));
        let output = command.output().expect("a shell");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{}: {said}", driver.display());
        let words = "error[UG0803]: the device has not enough memory for \"maps\"";
        assert!(said.contains(words), "{}: {said}", driver.display());
        drawn = true;
    }
    if !drawn {
        skip::skipped("no driver of Vulkan in software");
    }
}

/// Returns the path of lavapipe's manifest; `None` if it is not installed.
#[cfg(target_os = "linux")]
fn lavapipe() -> Option<PathBuf> {
    let files = std::fs::read_dir("/usr/share/vulkan/icd.d").ok()?.flatten().map(|entry| entry.path());
    let is_it =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("lvp_icd"));
    files.filter(is_it).min()
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
    let unknown = run(&[&RENDER[..], &["--adapter", "no such"]].concat(), &[]);
    let said = text(&unknown.stderr);
    assert!(unknown.status.code() == Some(1) && said.contains("\"no such\", as --adapter asks"), "{said}");
}

/// Environment variables that make Mesa offer an older version of OpenGL.
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
    // The interior has lights of every kind, with maps in cubes and in an atlas.
    for (pipeline, scene) in [("nebula", "courtyard"), ("umbra", "courtyard"), ("awsm", "interior")] {
        let vulkan = [("WGPU_BACKEND", "vulkan"), ("WGPU_ADAPTER_NAME", "llvmpipe")];
        let Some(reference) = drawn(pipeline, scene, &folder.join("vulkan.png"), &vulkan) else {
            skip::skipped("no lavapipe");
            return;
        };
        for (at, set) in [&ES31[..1], &ES31].into_iter().enumerate() {
            let Some(picture) = drawn(pipeline, scene, &folder.join(format!("{at}.png")), set) else {
                skip::skipped("no OpenGL");
                return;
            };
            // Half a percent of the pixels: edges of shadows, where rounding decides.
            let tolerance = Tolerance { per_channel: 8, failed_pixels: 72 };
            let comparison = compare(&reference, &picture, &tolerance);
            assert!(comparison.matches(), "{pipeline} on {scene}, {set:?}: {}", comparison.message());
        }
    }
}

#[test]
fn depth_is_captured_on_opengl_or_a_sentence_says_why_not() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("adapters-depth");
    let out = folder.join("picture.png");
    let depth = folder.join("depth.exr");
    let capture = format!("depth={}", depth.display());
    let scene = ["--scene", "examples/scenes/courtyard.glb", "--size", "64x36", "--out"];
    let render =
        [&["render", "pipelines/nebula.json"][..], &scene, &[out.to_str().unwrap(), "--capture", &capture]]
            .concat();
    let output = run(&render, &ES31[..1]);
    let said = text(&output.stderr);
    if said.contains("UG0801") {
        skip::skipped("no OpenGL");
        return;
    }
    assert!(output.status.success() && depth.exists(), "{said}");
    let output = run(&render, &ES30);
    let said = text(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("cannot be read back"), "{said}");
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

#[test]
fn opengl_without_compute_draws_without_the_denoiser() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("adapters-presets");
    let out = folder.join("picture.png");
    let scene = ["--scene", "examples/scenes/figure.glb", "--size", "64x36", "--out", out.to_str().unwrap()];
    for preset in ["console", "desktop"] {
        let output =
            run(&[&["render", "pipelines/umbra.json", "--preset", preset][..], &scene].concat(), &ES30);
        let said = text(&output.stderr);
        if said.contains("UG0801") {
            skip::skipped("no OpenGL");
            return;
        }
        assert!(output.status.success(), "{preset}: {said}");
        let is_off = |feature: &str| said.contains(&format!("\"{feature}\" is off: llvmpipe"));
        assert!(is_off("visible_range") && is_off("denoise") == (preset == "console"), "{preset}: {said}");
    }
}
