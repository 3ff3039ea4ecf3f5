//! Standard output and standard error: readers that close early, terminals, and the exit status.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).current_dir(root());
    command
}

/// Every command that prints, with its exit status, which does not depend on the reader of its output.
const PRINTING: &[(&[&str], i32)] = &[
    (&["check", "pipelines/nebula.json"], 0),
    (&["permutations", "pipelines/learn/10-features.json"], 0),
    (&["permutations", "pipelines/learn/10-features.json", "--format", "json"], 0),
    (&["permutations", "pipelines/learn/10-features.json", "--format", "github"], 0),
    (&["permutations", "--axes"], 0),
    (&["permutations", "--axes", "--format", "json"], 0),
    (&["permutations", "nowhere.json"], 1),
    (&["permutations", "nowhere.json", "--format", "github"], 1),
    (&["plan", "pipelines/nebula.json", "--verify"], 0),
    (&["plan", "pipelines/nebula.json", "--format", "json"], 0),
    (&["show"], 0),
    (&["show", "umbragraph:nebula.json"], 0),
    (&["show", "umbragraph:nebular.json"], 1),
    (&["graph", "pipelines/nebula.json"], 0),
    (&["diff", "pipelines/nebula.json", "pipelines/caracal.json"], 0),
    (&["wgsl", "pipelines/nebula.json"], 0),
    (&["wgsl", "pipelines/nebula.json", "--pass", "casters", "--target", "spirv"], 0),
    (&["why", "pipelines/nebula.json", "shade"], 0),
    (&["why", "pipelines/nebula.json", "shade", "--format", "json"], 0),
    (&["why", "pipelines/nebula.json", "no such name"], 1),
    (&["reference"], 0),
    (&["reference", "UG0502"], 0),
    (&["reference", "UG9999"], 1),
    (&["schema"], 0),
    (&["check", "nowhere.json"], 1),
    (&["check", "pipelines/nebula.json", "--no-such-option"], 2),
];

#[test]
fn a_reader_that_closes_early_is_no_error() {
    for (arguments, status) in PRINTING {
        let mut child = command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(*status), "{arguments:?}: {errors}");
        assert!(!errors.contains("panicked"), "{arguments:?}: {errors}");

        let mut child = command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(*status), "{arguments:?} without standard error");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_is_lost_is_an_error_of_every_command() {
    let folder = ScratchFolder::new("streams-full");
    let scene = folder.join("empty.gltf");
    std::fs::write(&scene, r#"{ "asset": { "version": "2.0" } }"#).unwrap();
    let (scene, out) = (scene.display().to_string(), folder.join("out.png").display().to_string());
    let mended = folder.join("mended.json");
    let min = std::fs::read_to_string(root().join("pipelines/learn/01-smallest.json")).unwrap();
    std::fs::write(&mended, min.replace("viewport", "viewprot")).unwrap();
    let mended = mended.display().to_string();
    let render =
        ["render", "pipelines/learn/01-smallest.json", "--scene", &scene, "--out", &out, "--size", "8x8"];
    let score = ["score", "pipelines/nebula.json", "--scene", "examples/scenes/figure.glb", "--size", "8x8"];
    let further: &[&[&str]] = &[
        &["--help"],
        &["--version"],
        &["check", "--help"],
        &["fmt", "--strict", "pipelines/nebula.json"],
        &["check", "pipelines/nebula.json", "--format", "json"],
        &["check", "pipelines/nebula.json", "--format", "sarif"],
        &["check", &mended, "--fix", "--dry-run"],
        &["graph", "pipelines/nebula.json", "--format", "json"],
        &["graph", "pipelines/nebula.json", "--format", "html"],
        &["graph", "pipelines/nebula.json", "--format", "dot"],
        &["graph", "pipelines/nebula.json", "--format", "mermaid"],
        &["diff", "pipelines/nebula.json", "--after-feature", "cached=on"],
        &["why", "pipelines/nebula.json", "color", "maps"],
        &["wgsl", "pipelines/nebula.json", "--map"],
        &["schema", "--of", "extension"],
        &["reference", "draw"],
        &["reference", "--help"],
        &render,
        &[&render[..], &["--timings"]].concat(),
        &score,
    ];
    let printing = PRINTING.iter().filter(|(_, status)| *status == 0).map(|(arguments, _)| *arguments);
    let mut lost = 0;
    for arguments in printing.chain(further.iter().copied()) {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = command(arguments).stdout(full).stderr(Stdio::piped()).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        if arguments[0] == "render" && errors.contains("no graphics")
            || errors.contains("unrecognized subcommand")
        {
            continue;
        }
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
        assert!(errors.contains("standard output cannot be written"), "{arguments:?}: {errors}");
        lost += 1;
    }
    assert!(lost >= 24, "only {lost}");
}

/// Runs the command with standard error on a terminal and returns the terminal's output; `None` if no terminal is
/// available.
#[cfg(target_os = "linux")]
fn on_a_terminal(arguments: &str) -> Option<String> {
    let folder = ScratchFolder::new("streams-terminal");
    let log = folder.join("log");
    let line = format!("'{}' {arguments} > /dev/null", env!("CARGO_BIN_EXE_umbragraph"));
    let status = Command::new("script")
        .args(["--quiet", "--return", "--command", &line])
        .arg(&log)
        .current_dir(root())
        .env("TERM", "xterm")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .ok()?;
    assert!(status.code() <= Some(1), "{status}");
    Some(String::from_utf8_lossy(&std::fs::read(&log).ok()?).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn progress_is_shown_on_terminals_only() {
    let arguments = ["permutations", "pipelines/mantis.json", "--no-cache"];
    let output = command(&arguments).output().unwrap();
    let piped = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!piped.contains("texts") && !piped.contains('\u{1b}') && !piped.contains('\r'), "{piped}");
    let Some(seen) = on_a_terminal(&arguments.join(" ")) else {
        eprintln!("`script` is not installed: the terminal's half of this test is left out");
        return;
    };
    let shown = |each: &str| -> Option<(usize, usize)> {
        let (done, all) = each.trim_start_matches(['█', '░', ' ']).trim_end().split_once(" of ")?;
        Some((done.parse().ok()?, all.split_once(" texts")?.0.parse().ok()?))
    };
    let bars: Vec<(usize, usize)> =
        seen.split(['\r', '\n']).map(|line| line.trim_start_matches("\u{1b}[2K")).filter_map(shown).collect();
    assert!(bars.len() > 1 && bars.is_sorted() && bars.iter().all(|(done, all)| done <= all), "{bars:?}");
    let after = seen.rfind(" texts").map(|at| &seen[at..]).unwrap_or_default();
    assert!(after.contains("\u{1b}[2K") || after.contains("\u{1b}[K"), "the bar is removed: {after:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn diagnostics_have_colors_on_terminals_only() {
    let folder = ScratchFolder::new("streams-colors");
    let path = folder.join("slip.json");
    let text = std::fs::read_to_string(root().join("pipelines/learn/01-smallest.json")).unwrap();
    std::fs::write(&path, text.replace("\"color\"", "\"colour\"")).unwrap();
    let path = path.to_str().unwrap();
    let piped = String::from_utf8_lossy(&command(&["check", path]).output().unwrap().stderr).into_owned();
    assert!(piped.contains("error[UG0102]") && !piped.contains('\u{1b}'), "{piped}");
    let Some(seen) = on_a_terminal(&format!("check {path}")) else {
        eprintln!("`script` is not installed: the terminal's half of this test is left out");
        return;
    };
    assert!(seen.contains("\u{1b}[1;31merror[UG0102]\u{1b}[0m: "), "{seen:?}");
    assert!(seen.contains("^\u{1b}[0m"), "the caret: {seen:?}");
}

#[test]
fn the_exit_status_says_how_it_went() {
    let folder = ScratchFolder::new("streams-status");
    let status = |template: &str, further: &[&str]| {
        std::fs::write(folder.join("gradient.wgsl.jinja"), template).unwrap();
        let pipeline = "pipelines/learn/01-smallest.json";
        let templates = folder.to_str().unwrap();
        let arguments = [&["permutations", pipeline, "--templates", templates], further].concat();
        command(&arguments).output().unwrap().status.code()
    };
    let sound = std::fs::read_to_string(root().join("shaders-templates/gradient.wgsl.jinja")).unwrap();
    let broken = sound.replace("@fragment", "@fragmnt");
    assert_ne!(sound, broken);
    for format in ["human", "json", "github"] {
        assert_eq!(status(&sound, &["--format", format]), Some(0), "all is well");
        assert_eq!(status(&broken, &["--format", format]), Some(1), "an error");
        // Text that no variant contains is a warning: a diagnostic, but no error.
        let unused = format!("{sound}{{% if false %}}\n// never\n{{% endif %}}\n");
        assert_eq!(status(&unused, &["--format", format, "--all"]), Some(0), "a warning");
    }
    assert_eq!(status(&sound, &["--threads", "none"]), Some(2), "a command line that cannot be understood");
    assert_eq!(status(&sound, &["--profile", "nowhere"]), Some(1), "a profile that does not exist");
}
