//! The viewer where no window can be opened: one diagnostic, exit status 1, no panic.

use std::path::Path;
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph-view"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command.args(arguments).output().expect("the viewer")
}

fn rejected(arguments: &[&str], words: &[&str]) {
    let output = run(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(words.iter().all(|word| said.contains(word)) && !said.contains("panicked"), "{said}");
}

#[test]
fn missing_files_are_diagnostics() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/courtyard.glb");
    let scene = scene.to_string_lossy();
    rejected(&["missing.json", "--scene", &scene], &["\"missing.json\" is not there", "help"]);
    rejected(&["umbragraph:nebula.json", "--scene", "missing.glb"], &["\"missing.glb\" is not there"]);
}

#[test]
fn an_unusable_camera_path_has_the_code_of_one() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/courtyard.glb");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad.camera.json");
    std::fs::write(&path, "{ \"keys\": [] }").unwrap();
    let [scene, path] = [&scene, &path].map(|path| path.to_string_lossy());
    rejected(
        &["umbragraph:nebula.json", "--scene", &scene, "--camera", &path],
        &["UG0810", "a camera path has no keys", "help"],
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_missing_display_is_a_diagnostic() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/courtyard.glb");
    rejected(
        &["umbragraph:nebula.json", "--scene", &scene.to_string_lossy()],
        &["UG0817", "DISPLAY", "xvfb-run"],
    );
}

#[test]
fn an_unknown_option_has_the_status_2() {
    assert_eq!(run(&["umbragraph:nebula.json", "--scen", "x.glb"]).status.code(), Some(2));
}
