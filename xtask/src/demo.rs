//! `cargo xtask demo`: one picture, from a fresh clone.

use crate::{adapter, process};

/// The path of the picture, relative to the root of the workspace.
const PICTURE: &str = "target/demo/courtyard.png";

/// The arguments of cargo: the command without the features for `score` and `tune`, which a picture does not need.
const ARGUMENTS: &str = "run --release --package umbragraph-cli --no-default-features --features gpu --bin umbragraph \
                         -- render pipelines/umbra.json --scene examples/scenes/courtyard.glb --size 1280x720 --out";

/// Renders the demo picture. Returns `true`, or an error if there is no picture.
pub(crate) fn run() -> Result<bool, String> {
    adapter::ensure_if_possible();
    let picture = process::workspace_root().join(PICTURE);
    let made = prepare(&picture).and_then(|()| render()).and_then(|()| confirm(&picture));
    made.map_err(|reason| format!("there is no picture: {reason}"))?;
    println!("the picture is at {}", picture.display());
    Ok(true)
}

/// Creates the folder of the picture, and removes the picture of an earlier run.
fn prepare(picture: &std::path::Path) -> Result<(), String> {
    if let Some(folder) = picture.parent() {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    match std::fs::remove_file(picture) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(format!("{}: {error}", picture.display()))
        }
        _ => Ok(()),
    }
}

fn render() -> Result<(), String> {
    println!("==> cargo {ARGUMENTS} {PICTURE}");
    let mut command = process::program("cargo");
    process::run(command.args(ARGUMENTS.split_whitespace()).arg(PICTURE), "cargo")
}

fn confirm(picture: &std::path::Path) -> Result<(), String> {
    if picture.is_file() {
        Ok(())
    } else {
        Err(format!("the command succeeded but wrote no {}", picture.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_an_earlier_run_does_not_pass_for_the_new_one() {
        let folder = std::env::temp_dir().join(format!("xtask-demo-{}", std::process::id()));
        let picture = folder.join("nested/picture.png");
        prepare(&picture).unwrap();
        assert!(confirm(&picture).is_err());
        std::fs::write(&picture, b"old").unwrap();
        assert!(confirm(&picture).is_ok());
        prepare(&picture).unwrap();
        assert!(confirm(&picture).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn the_demo_is_built_optimised_and_writes_where_it_says() {
        assert!(ARGUMENTS.split_whitespace().any(|one| one == "--release"));
        assert!(ARGUMENTS.ends_with(" --out"));
    }
}
