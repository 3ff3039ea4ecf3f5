//! Makes a JavaScript module of a library that was built for browsers: `umbragraph-bindgen LIBRARY.wasm FOLDER`.
//!
//! It is wasm-bindgen's own command as a library, of the version in Cargo.lock, so that nothing has to be installed.

use anyhow::Context as _;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [library, folder] = arguments.as_slice() else {
        anyhow::bail!("usage: umbragraph-bindgen LIBRARY.wasm FOLDER");
    };
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    bindgen.input_path(library).typescript(false).remove_name_section(true).remove_producers_section(true);
    bindgen
        .omit_default_module_path(false)
        .web(true)?
        .generate(folder)
        .with_context(|| format!("{library} cannot be made a module"))
}
