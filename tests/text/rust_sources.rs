//! Rust sources: doc comments name the thing first, names of tests are short, and one file opens files.

use std::path::{Path, PathBuf};

use crate::common::root;

/// Words with which a doc comment explains before it names.
const BEGINNINGS: [&str; 6] = ["What", "Where", "How", "Which", "Who", "That"];
/// The maximum length of a test's name.
const MAX_NAME: usize = 60;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let is_hidden = name.to_string_lossy().starts_with('.');
        if path.is_dir() && name != "target" && !is_hidden {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The number of lines of documentation that begin with a word.
fn beginnings(text: &str, word: &str) -> usize {
    let documented = text.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("/// ").or_else(|| line.strip_prefix("//! "))
    });
    let begins = |line: &&str| {
        line.strip_prefix(word).is_some_and(|rest| !rest.starts_with(|next: char| next.is_alphanumeric()))
    };
    documented.filter(begins).count()
}

/// The names of the functions below `#[test]` that are longer than they should be.
fn long_names(text: &str) -> impl Iterator<Item = &str> {
    let mut lines = text.lines().map(str::trim_start);
    let tests = std::iter::from_fn(move || {
        lines.find(|line| *line == "#[test]")?;
        lines.find_map(|line| line.strip_prefix("fn ")?.split(['(', '<']).next())
    });
    tests.filter(|name| name.len() > MAX_NAME)
}

#[test]
fn doc_comments_name_the_thing_first_and_test_names_are_short() {
    let mut paths = Vec::new();
    sources(&root(), &mut paths);
    assert!(paths.len() > 500, "{}", paths.len());
    let texts: Vec<String> = paths.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    for (path, text) in paths.iter().zip(&texts) {
        for word in BEGINNINGS {
            assert_eq!(beginnings(text, word), 0, "a doc comment of {} begins with {word}", path.display());
        }
    }
    let names: Vec<&str> = texts.iter().flat_map(|text| long_names(text)).collect();
    assert!(names.is_empty(), "longer than {MAX_NAME} characters: {names:#?}");
}

#[test]
fn beginnings_and_long_names_are_found() {
    let long = "x".repeat(MAX_NAME + 1);
    let text = format!(
        "//! What\n    /// What a\n/// Whatever\n#[test]\n#[ignore]\nfn {long}() {{}}\nfn z{long}() {{}}"
    );
    assert_eq!((beginnings(&text, "What"), beginnings(&text, "How")), (2, 0));
    assert_eq!(long_names(&text).collect::<Vec<_>>(), [long.as_str()]);
}

/// Calls that open a file, whatever it is: a pipe is waited for, a device never ends.
const OPENERS: [&str; 4] = ["fs::read(", "fs::read_to_string(", "File::open(", "OpenOptions"];
/// Files with a reason to open one.
const MAY_OPEN: [&str; 3] = [
    // Asks what the file is before.
    "cli/src/annotations.rs",
    // Reads the output of a command that it started.
    "cli/src/validator.rs",
    // Asks what the file is before.
    "graph/text/src/compose/disk.rs",
];

#[test]
fn regular_files_alone_are_opened() {
    let mut paths = Vec::new();
    for folder in
        ["cli/src", "front", "graph", "lsp/src", "passes", "scene/src", "score/src", "session", "view/src"]
    {
        sources(&root().join(folder), &mut paths);
    }
    let mut opening = Vec::new();
    for path in &paths {
        let text = std::fs::read_to_string(path).unwrap();
        let name = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let is_test = code.contains("#[test]") || name.contains("/tests/") || name.ends_with("build.rs");
        if !is_test && OPENERS.iter().any(|call| code.contains(call)) {
            opening.push(name);
        }
    }
    opening.sort();
    assert_eq!(opening, MAY_OPEN, "read_bytes of graph/text/src/compose/disk.rs opens regular files alone");
}
