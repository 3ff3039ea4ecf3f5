//! `cargo xtask web`: the module in a browser.
//!
//! The library is built twice for browsers, without and with what draws, and made a module of JavaScript each time;
//! then node puts the page around them. `--test` drives a browser, `--serve` opens the page to this machine.

use std::path::Path;

use crate::{process, toolchain};

/// Optional steps after building the web page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    pub(crate) test: bool,
    pub(crate) serve: bool,
}

const TARGET: &str = "wasm32-unknown-unknown";

/// The WebAssembly modules to build: the folder and the cargo options of each.
const LIBRARIES: [(&str, &[&str]); 2] = [("checker", &["--no-default-features"]), ("painter", &[])];

/// Builds the web page, and tests or serves it if requested.
pub(crate) fn run(options: Options) -> Result<bool, String> {
    if !toolchain::has_wasm() {
        return Err(format!(
            "the standard library for browsers is not installed: rustup target add {TARGET}"
        ));
    }
    if !process::succeeds("npm", &["--version"]) {
        return Err("node and npm are not installed; the page is put together with them".to_owned());
    }
    let out = process::target_folder().join("web");
    for (name, features) in LIBRARIES {
        build(&out.join(name), features)?;
    }
    let web = process::workspace_root().join("web");
    if !is_newer(&web.join("node_modules/.package-lock.json"), &web.join("package-lock.json")) {
        node("npm", &process::NPM_CI, &[])?;
    }
    node("node", &["scripts/build.mjs"], &[&out])?;
    let site = out.join("site");
    if options.test {
        process::run(process::program("cargo").args(["build", "--package", "umbragraph-cli"]), "cargo")?;
        let command = process::target_folder().join("debug/umbragraph");
        node("node", &["scripts/test.mjs"], &[&site, &command])?;
    }
    if options.serve {
        node("node", &["scripts/serve.mjs"], &[&site])?;
    }
    Ok(true)
}

/// Builds the library with the given cargo options as a WebAssembly module in a folder.
fn build(folder: &Path, features: &[&str]) -> Result<(), String> {
    let arguments = ["build", "--package", "umbragraph-web", "--target", TARGET, "--profile", "web"];
    process::run(process::program("cargo").args(arguments).args(features), "cargo")?;
    let library = process::target_folder().join(TARGET).join("web/umbragraph_web.wasm");
    let bindgen = ["run", "--quiet", "--package", "umbragraph-bindgen", "--"];
    process::run(process::program("cargo").args(bindgen).arg(library).arg(folder), "umbragraph-bindgen")
}

/// Runs node or npm in the folder `web`.
fn node(name: &str, arguments: &[&str], paths: &[&Path]) -> Result<(), String> {
    let mut command = process::program(name);
    command.current_dir(process::workspace_root().join("web"));
    let shown = [&[name], arguments].concat().join(" ");
    process::run(command.args(arguments).args(paths), &shown)
}

fn is_newer(file: &Path, than: &Path) -> bool {
    let written = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
    written(file).is_some_and(|time| written(than).is_some_and(|other| time >= other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_not_newer() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(is_newer(&here, &here));
        assert!(!is_newer(Path::new("nothing"), &here));
    }
}
