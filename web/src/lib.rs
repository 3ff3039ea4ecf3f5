//! umbragraph in a browser, through wasm-bindgen.
//!
//! Two libraries are made of this crate. Without features there are `Project`, which checks, plans and explains in a
//! worker, and `Language`, the language server of editors; the feature `gpu` leaves out the latter and adds `Painter`,
//! which draws on WebGPU. Both are classes of JavaScript whose methods take and give texts, most of them JSON.
//! `cargo xtask web` builds them and the page around them.
//!
//! A panic ends a library, since nothing unwinds in a browser: it is printed to the console, and whoever started the
//! worker starts another.

// The macros of wasm-bindgen write unsafe code; there is none in this crate.
#![cfg_attr(target_family = "wasm", allow(unsafe_code))]

#[cfg(all(target_family = "wasm", feature = "gpu"))]
mod contents;
#[cfg(target_family = "wasm")]
mod graph;
#[cfg(all(target_family = "wasm", not(feature = "gpu")))]
mod language;
#[cfg(all(target_family = "wasm", feature = "gpu"))]
mod painter;
#[cfg(all(target_family = "wasm", feature = "gpu"))]
mod picture;
#[cfg(target_family = "wasm")]
mod project;
#[cfg(target_family = "wasm")]
mod settings;

#[cfg(all(target_family = "wasm", feature = "gpu"))]
pub use contents::Contents;
#[cfg(all(target_family = "wasm", not(feature = "gpu")))]
pub use language::Language;
#[cfg(all(target_family = "wasm", feature = "gpu"))]
pub use painter::Painter;
#[cfg(target_family = "wasm")]
pub use project::Project;

#[cfg(target_family = "wasm")]
mod start {
    use wasm_bindgen::prelude::wasm_bindgen;

    #[wasm_bindgen]
    extern "C" {
        #[wasm_bindgen(js_namespace = console)]
        fn error(text: &str);
    }

    /// Installs a panic hook that prints panics to the browser's console.
    #[wasm_bindgen(start)]
    fn start() {
        std::panic::set_hook(Box::new(|panic| error(&panic.to_string())));
    }
}
