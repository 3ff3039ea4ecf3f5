//! `umbragraph show`: the bundled files, read from an installed command.

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::scratch::ScratchFolder;

fn run(arguments: &[&str]) -> Output {
    let folder = ScratchFolder::new("show");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).current_dir(folder.join("")).output().expect("the command")
}

fn bundled(name: &str) -> String {
    std::fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(name)).unwrap()
}

#[test]
fn show_prints_a_bundled_file_as_it_is() {
    let nebula = bundled("pipelines/nebula.json");
    for name in ["umbragraph:nebula.json", "nebula.json"] {
        let output = run(&["show", name]);
        assert!(output.status.success() && text(&output.stdout) == nebula, "{name}");
    }
    let output = run(&["show", "lib/fullscreen.wgsl.jinja"]);
    assert_eq!(text(&output.stdout), bundled("shaders-templates/lib/fullscreen.wgsl.jinja"));
}

#[test]
fn show_lists_every_name_and_suggests_near_ones() {
    let list = text(&run(&["show"]).stdout);
    let wanted = [
        "umbragraph:nebula.json",
        "umbragraph:umbra/fog.json",
        "lib/fullscreen.wgsl.jinja",
        "tonemap.axes.json",
        "Cascaded shadow maps of one directional light",
    ];
    for name in wanted {
        assert!(list.contains(name), "{name}\n{list}");
    }
    let near = ["UG0001", "did you mean \"umbragraph:nebula.json\"?"];
    rejected(&run(&["show", "umbragraph:nebular.json"]), 1, &near);
    rejected(&run(&["show", "nebular.json"]), 1, &near);
    rejected(&run(&["show", "fullscreen.wgsl"]), 1, &["lib/fullscreen.wgsl.jinja"]);
    rejected(&run(&["show", "zzzzzzzz"]), 1, &["`umbragraph show` lists"]);
    rejected(
        &run(&["fmt", "--strict", "umbragraph:nebula.json"]),
        1,
        &["UG0001", "`umbragraph show umbragraph:nebula.json > FILE`"],
    );
}
