//! `cargo xtask gallery`: the pictures of each scene by each pipeline, in the sheets of `examples/gallery/`.

use crate::{adapter, process};

/// Renders the pictures of the gallery.
pub(crate) fn run() -> Result<bool, String> {
    adapter::ensure_if_possible();
    let mut command = process::program("cargo");
    process::run(command.args(["run", "--quiet", "--example", "gallery"]), "cargo")?;
    Ok(true)
}
