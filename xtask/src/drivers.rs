//! `cargo xtask drivers` and `cargo xtask validate`: the command on every driver of the machine, and under the
//! validation layers of Vulkan.
//!
//! Drivers that are missing are installed by the names that Debian and Ubuntu give their packages, where that is
//! possible; one that cannot be installed is left out of the table. The table is written by the program `drivers` of
//! `tests/support`, which can compare pictures.

use std::path::{Path, PathBuf};

use crate::{adapter, process};

/// The possible manifests of SwiftShader, which comes with Chromium and Chrome.
const SWIFTSHADER: [&str; 3] = [
    "/usr/lib/chromium/vk_swiftshader_icd.json",
    "/usr/lib/chromium-browser/vk_swiftshader_icd.json",
    "/opt/google/chrome/vk_swiftshader_icd.json",
];

/// Packages to install, each with files of which one exists if they are installed: OpenGL without a display,
/// SwiftShader.
const PACKAGES: [(&[&str], &[&str]); 2] = [
    (
        &["libegl1", "libgl1-mesa-dri"],
        &["/usr/lib/x86_64-linux-gnu/libEGL.so.1", "/usr/lib/aarch64-linux-gnu/libEGL.so.1"],
    ),
    (&["chromium"], &SWIFTSHADER),
];

/// The path of the page with the table.
const TABLE: &str = "docs/drivers.md";

/// The pipelines that are rendered with validation layers: one with only CPU-fitted cascades, one with all techniques.
const VALIDATED: [&str; 2] = ["nebula", "umbra"];

/// The names of the project's scenes.
const SCENES: [&str; 4] = ["courtyard", "figure", "foliage", "interior"];

/// The options that select the part of the table to render.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// Renders one scene only, without presets and debug views.
    pub(crate) quick: bool,
    /// Renders one pipeline only, or the lessons; `None` renders all.
    pub(crate) only: Option<String>,
    /// The maximum rendering time in minutes; `None` for no limit.
    pub(crate) minutes: Option<u64>,
}

/// Writes the table. Returns `true` if the drivers agree.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    adapter::ensure_if_possible();
    for (packages, files) in PACKAGES {
        if !files.iter().any(|file| Path::new(file).exists())
            && let Err(reason) = adapter::install_packages(packages)
        {
            eprintln!("{} is left out: {reason}", packages.join(" and "));
        }
    }
    let program = build(!options.quick)?;
    let folder = process::target_folder().join("drivers");
    // The page in the tree is of whole runs.
    let table = if options.quick { folder.join("drivers.md") } else { process::workspace_root().join(TABLE) };
    let mut command = process::program("cargo");
    let program_of_table =
        "run --quiet --package umbragraph-test-support --no-default-features --bin drivers --";
    command.args(program_of_table.split_whitespace());
    command.arg(program).arg(&folder).arg(&table).args(options.quick.then_some("--quick"));
    command.args(options.only.iter().flat_map(|only| ["--only", only]));
    command.args(options.minutes.iter().flat_map(|minutes| ["--minutes".to_owned(), minutes.to_string()]));
    let fine = process::cargo(&mut command)?;
    println!("the table is {}", table.display());
    Ok(fine)
}

/// Renders two pipelines, or everything with `all`, with the validation layers on. Returns `true` if the layers
/// reported nothing.
pub(crate) fn validate(all: bool) -> Result<bool, String> {
    adapter::ensure_if_possible();
    let program = build(all)?;
    let out = process::target_folder().join("drivers-validated.png");
    let mut fine = true;
    let pictures = if all { everything(&program) } else { VALIDATED.map(Validated::of).to_vec() };
    for Validated { pipeline, scene, options } in pictures {
        let mut command = process::program(&program.display().to_string());
        command.args(["render", &format!("pipelines/{pipeline}.json"), "--size", "320x180", "--frames", "1"]);
        command.args(["--scene", &format!("examples/scenes/{scene}.glb"), "--out"]).arg(&out).args(&options);
        // With debug information naga names WGSL as the language of a shader, which layers of before 2023 do not know.
        command.env("WGPU_BACKEND", "vulkan").env("WGPU_VALIDATION", "1").env("WGPU_DEBUG", "0");
        let output = command.output().map_err(|error| format!("{}: {error}", program.display()))?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if said.contains("unable to find layer: VK_LAYER_KHRONOS_validation") {
            return Err("there is no validation layer; on Debian and Ubuntu as root: apt-get install --yes vulkan-validationlayers".to_owned());
        }
        let messages: Vec<&str> = said.lines().filter(|line| is_of_layer(line)).collect();
        for message in &messages {
            println!("{message}");
        }
        let picture = [&[pipeline], options.as_slice()].concat().join(" ");
        println!("{picture} on {scene}: {} messages of the validation layer", messages.len());
        if !output.status.success() {
            println!("{said}");
        }
        fine &= output.status.success() && messages.is_empty();
    }
    Ok(fine)
}

/// A picture to render with validation layers.
#[derive(Clone, Debug)]
struct Validated {
    /// The path of the pipeline below `pipelines/`, without extension.
    pipeline: String,
    scene: &'static str,
    /// The command-line options for a preset or a debug view.
    options: Vec<String>,
}

impl Validated {
    /// Creates the case of a pipeline with default settings on the first scene.
    fn of(pipeline: impl Into<String>) -> Self {
        Self { pipeline: pipeline.into(), scene: SCENES[0], options: Vec::new() }
    }
}

/// Returns all pictures: each pipeline and lesson; the systems on each scene, and on the first with each preset and
/// debug view.
fn everything(program: &Path) -> Vec<Validated> {
    let names = |folder: &str| {
        let path = process::workspace_root().join("pipelines").join(folder);
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        let name =
            |entry: std::fs::DirEntry| Some(entry.file_name().to_str()?.strip_suffix(".json")?.to_owned());
        let mut names: Vec<String> = entries.filter_map(name).collect();
        names.sort();
        names.into_iter().map(|name| format!("{folder}{name}")).collect::<Vec<_>>()
    };
    let mut all = Vec::new();
    for system in names("") {
        all.extend(SCENES.map(|scene| Validated { scene, ..Validated::of(&*system) }));
        for (option, prefix) in [("--preset", ""), ("--set", "debug_view=")] {
            let words = known(program, &system, [option, &format!("{prefix}?")]);
            all.extend(words.into_iter().map(|word| {
                let options = vec![option.to_owned(), format!("{prefix}{word}")];
                Validated { options, ..Validated::of(&*system) }
            }));
        }
    }
    all.extend(["learn/", "extended/"].into_iter().flat_map(names).map(Validated::of));
    all
}

/// Returns the valid presets or parameter values, which the command lists in its error about an unknown one.
fn known(program: &Path, pipeline: &str, unknown: [&str; 2]) -> Vec<String> {
    let mut command = process::program(&program.display().to_string());
    command.args(["plan", &format!("pipelines/{pipeline}.json")]).args(unknown);
    let said = command.output().map(|output| String::from_utf8_lossy(&output.stderr).into_owned());
    listed(&said.unwrap_or_default())
}

/// Parses the names after `help: the presets are` or `help: known are`.
fn listed(said: &str) -> Vec<String> {
    let list = said.lines().find_map(|line| {
        let help = line.split_once("help: ")?.1;
        help.strip_prefix("the presets are ").or_else(|| help.strip_prefix("known are "))
    });
    list.into_iter().flat_map(|list| list.split(", ")).map(str::to_owned).collect()
}

/// Returns `true` if a line is a message of the validation layer, about validation or synchronization.
fn is_of_layer(line: &str) -> bool {
    ["VUID-", "SYNC-HAZARD", "UNASSIGNED-"].iter().any(|mark| line.contains(mark))
}

/// Returns the path of SwiftShader's manifest; `None` if it is not installed.
pub(crate) fn swiftshader() -> Option<&'static str> {
    SWIFTSHADER.into_iter().find(|file| Path::new(file).exists())
}

/// Builds the command and returns its path. An optimized build pays off for many pictures, since each runs in a process
/// of its own.
fn build(is_optimised: bool) -> Result<PathBuf, String> {
    let mut command = process::program("cargo");
    command.args("build --package umbragraph-cli --bin umbragraph".split_whitespace());
    command.args(is_optimised.then_some("--release"));
    if !process::cargo(&mut command)? {
        return Err("the command cannot be built".to_owned());
    }
    let folder = process::target_folder().join(if is_optimised { "release" } else { "debug" });
    Ok(folder.join(format!("umbragraph{}", std::env::consts::EXE_SUFFIX)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_and_words_are_read_from_the_help() {
        assert_eq!(
            listed("error[UG0213]: no preset\n  = help: the presets are low, high\n"),
            ["low", "high"]
        );
        assert_eq!(listed("  = help: known are off, shadow_term\n"), ["off", "shadow_term"]);
        assert!(listed("  = help: this pipeline has no presets\n").is_empty());
    }

    #[test]
    fn messages_of_the_layer_are_told_from_others() {
        assert!(is_of_layer("wgpu_hal::vulkan::instance: VALIDATION [VUID-vkCmdDraw-None-02699 (0x1)] …"));
        assert!(is_of_layer("wgpu_hal::vulkan::instance: VALIDATION [SYNC-HAZARD-WRITE-AFTER-READ (0x2)] …"));
        assert!(!is_of_layer("wgpu_core::device: warning"));
    }
}
