//! The guide, typed into an empty folder: files are written, commands are run, chapter after chapter.
//!
//! A block with `file=NAME` behind its language is a file; in a block of `sh` each line is a command, which succeeds,
//! or fails where `!` stands in front. Rust is compiled by the tests of documentation of `lib.rs`.

use std::path::{Path, PathBuf};
use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// Returns the paths of the guide's chapters, sorted.
fn chapters() -> Vec<PathBuf> {
    let mut chapters: Vec<PathBuf> = std::fs::read_dir(root().join("docs/guide"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.file_name().is_some_and(|name| name != "README.md"))
        .collect();
    chapters.sort();
    chapters
}

/// Returns the fenced blocks of a Markdown text: the language after the fence, and the content.
fn blocks(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split("```").skip(1).step_by(2).filter_map(|block| block.split_once('\n'))
}

/// Runs a shell command line with this build's command, in a folder laid out as the guide says.
fn typed(line: &str, folder: &Path) {
    let built = Path::new(env!("CARGO_BIN_EXE_umbragraph")).parent().unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("bash")
        .args(["-c", line])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", built.display()))
        .env("UMBRAGRAPH", root())
        .output()
        .expect("a shell");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !errors.contains("panicked"), "{line}\n{errors}");
}

#[test]
fn what_the_guide_says_can_be_typed_into_an_empty_folder() {
    let folder = ScratchFolder::new("guide");
    let is_drawn = umbragraph_test_support::gpu::device().is_some();
    let (mut files, mut commands) = (0, 0);
    for chapter in chapters() {
        let text = std::fs::read_to_string(chapter).unwrap();
        for (kind, block) in blocks(&text) {
            if let Some((_, name)) = kind.split_once(" file=") {
                let path = folder.join(name);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, block).unwrap();
                files += 1;
            }
            for line in block.lines().filter(|_| kind == "sh") {
                let needs_adapter = ["umbragraph render", "umbragraph test"];
                if needs_adapter.iter().any(|command| line.contains(command)) && !is_drawn {
                    skip::skipped("no adapter to render the guide with");
                    continue;
                }
                typed(line, &folder.join(""));
                commands += 1;
            }
        }
    }
    assert!(files >= 7 && commands >= 25, "{files} files, {commands} commands");
    if is_drawn {
        for picture in ["first.png", "visibility.png", "maps.png", "soft.png", "looks.png", "sharp.png"] {
            assert!(folder.join(picture).metadata().unwrap().len() > 100, "{picture}");
        }
    }
}

#[test]
fn files_of_the_guide_have_the_layout_of_the_command() {
    let folder = ScratchFolder::new("guide-layout");
    for chapter in chapters() {
        let text = std::fs::read_to_string(chapter).unwrap();
        for (kind, block) in blocks(&text) {
            let Some((_, name)) = kind.split_once(" file=").filter(|(_, name)| name.ends_with(".json"))
            else {
                continue;
            };
            let path = folder.join(name.rsplit('/').next().unwrap());
            std::fs::write(&path, block).unwrap();
            typed(&format!("umbragraph fmt --check {}", path.display()), &folder.join(""));
        }
    }
}

#[test]
fn links_of_the_guide_lead_somewhere() {
    for chapter in chapters() {
        let text = std::fs::read_to_string(&chapter).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let there = chapter.parent().unwrap().join(link.split('#').next().unwrap());
            assert!(there.exists(), "{}: {link}", chapter.display());
        }
    }
}
