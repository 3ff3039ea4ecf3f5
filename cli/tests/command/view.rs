//! `umbragraph view`: the viewer is found beside the command or on PATH, gets the arguments, and is missed with a way
//! out.

use std::path::Path;
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::scratch::ScratchFolder;

fn view(program: &Path, path: &Path, arguments: &[&str]) -> Output {
    Command::new(program).arg("view").args(arguments).env("PATH", path).output().expect("the command")
}

/// Writes a program that prints its name and its arguments.
fn write_program(folder: &Path, name: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    let path = folder.join("umbragraph-view");
    std::fs::write(&path, format!("#!/bin/sh\necho {name} \"$@\"\nexit 2\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn the_viewer_is_found_beside_the_command_and_on_path() {
    let folder = ScratchFolder::new("the_viewer_is_found");
    for name in ["beside", "path"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    let command = folder.join("beside/umbragraph");
    std::fs::copy(env!("CARGO_BIN_EXE_umbragraph"), &command).unwrap();
    let arguments = ["p.json", "--scene", "s.glb", "--help"];
    rejected(&view(&command, &folder.join("path"), &arguments), 1, &["UG0816", "cargo install --path view"]);
    write_program(&folder.join("path"), "path");
    let output = view(&command, &folder.join("path"), &arguments);
    assert_eq!(text(&output.stdout), "path p.json --scene s.glb --help\n");
    assert_eq!(output.status.code(), Some(2), "the status of the viewer");
    write_program(&folder.join("beside"), "beside");
    let output = view(&command, &folder.join("path"), &arguments);
    assert_eq!(text(&output.stdout), "beside p.json --scene s.glb --help\n");
}
