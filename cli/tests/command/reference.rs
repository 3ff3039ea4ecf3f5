//! The reference says what there is, and the pages of `docs/reference/` are those of this version.

use std::path::{Path, PathBuf};
use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs `reference`. Returns the exit status, standard output and standard error.
fn reference(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    let output = command.arg("reference").args(arguments).current_dir(root()).output().expect("the command");
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn contents(folder: &Path) -> Vec<(String, String)> {
    let mut files: Vec<(String, String)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn the_pages_are_those_of_this_version() {
    let committed = root().join("docs/reference");
    if std::env::var_os("UMBRAGRAPH_BLESS").is_some() {
        assert_eq!(reference(&["--write", committed.to_str().unwrap()]).0, Some(0));
    }
    let folder = ScratchFolder::new("reference-pages");
    assert_eq!(reference(&["--write", folder.join("").to_str().unwrap()]).0, Some(0));
    let (made, committed) = (contents(&folder.join("")), contents(&committed));
    let names = |files: &[(String, String)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&made), names(&committed));
    for ((name, made), (_, committed)) in made.iter().zip(&committed) {
        assert!(
            made == committed,
            "docs/reference/{name} is of another version: umbragraph reference --write docs/reference"
        );
    }
}

#[test]
fn a_folder_that_is_not_there_is_a_diagnostic() {
    let folder = ScratchFolder::new("reference-missing");
    let (status, _, errors) = reference(&["--write", folder.join("nowhere").to_str().unwrap()]);
    assert!(status == Some(1) && errors.contains("error[UG0004]"), "{errors}");
}

#[test]
fn links_between_pages_lead_to_headings() {
    let files = contents(&root().join("docs/reference"));
    let anchor = |heading: &str| {
        let letters =
            heading.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-'));
        letters.collect::<String>().to_lowercase()
    };
    let mut count = 0;
    for (name, text) in &files {
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let file = if file.is_empty() { name } else { file };
            let (_, there) =
                files.iter().find(|(other, _)| other == file).unwrap_or_else(|| panic!("{link}"));
            let mut headings = there.lines().filter_map(|line| line.strip_prefix("## "));
            assert!(heading.is_empty() || headings.any(|one| anchor(one) == heading), "{name}: {link}");
            count += 1;
        }
    }
    assert!(count > 100, "{count} links");
}

#[test]
fn each_name_of_the_list_has_an_entry_and_a_slip_is_told() {
    let (_, list, _) = reference(&[]);
    let names: Vec<&str> = list
        .lines()
        .filter_map(|line| line.strip_prefix("  "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for name in ["camera", "pass", "BindObject", "mip_count", "lib/light_shadows.wgsl.jinja", "UG0402"] {
        assert!(names.contains(&name), "{name} is missing in\n{list}");
    }
    assert!(names.len() > 150, "{list}");
    // One of each page, and of each ten.
    for name in names.iter().step_by(10) {
        let (status, text, _) = reference(&[name]);
        assert!(status == Some(0) && text.len() > 40, "{name}: {text}");
    }
    let (status, _, errors) = reference(&["cascade"]);
    assert_eq!((status, errors.contains("did you mean cascades?")), (Some(1), true), "{errors}");
}

#[test]
fn a_node_kind_tells_its_settings_and_what_it_publishes() {
    let (_, text, _) = reference(&["camera"]);
    for said in ["`to` (required)", "`clip_from_world` | `mat4x4<f32>`", "besides views"] {
        assert!(text.contains(said), "{said} is missing in\n{text}");
    }
    let (_, text, _) = reference(&["shadow_atlas"]);
    assert!(text.contains("and the sizes `atlas_side`, `cube_count`, `layer_count`"), "{text}");
    assert!(!text.contains("]("), "a link in a terminal: {text}");
}
