//! Helpers of the programs that write the example scenes: tested here, since examples are not run as tests.

#[path = "../../examples/glb/functions.rs"]
#[allow(dead_code, reason = "some of it only the examples use")]
mod functions;

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The last bits of the platform's elementary functions differ, and with them could the scenes' bytes.
#[test]
fn no_writer_computes_with_functions_of_the_platform() {
    const PLATFORM: [&str; 13] = [
        "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "powf", "exp", "ln", "hypot", "cbrt",
    ];
    let mut paths = Vec::new();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for folder in std::fs::read_dir(examples).unwrap().flatten() {
        let name = folder.file_name();
        let is_writer = name == "glb" || name.to_string_lossy().starts_with("write_");
        if is_writer && folder.path().is_dir() {
            sources(&folder.path(), &mut paths);
        }
    }
    assert!(paths.len() > 10);
    for path in paths.iter().filter(|path| !path.ends_with("functions.rs")) {
        let text = std::fs::read_to_string(path).unwrap();
        let used: Vec<&str> =
            PLATFORM.into_iter().filter(|name| text.contains(&format!(".{name}("))).collect();
        assert!(used.is_empty(), "{} uses {used:?}", path.display());
    }
}
