//! Components of the Rust toolchain that a step needs and that a machine may lack.

use crate::process;

/// A tool that is installed separately from cargo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    Rustfmt,
    Clippy,
    Rustdoc,
}

impl Component {
    /// Returns advice on a missing component with the command that installs it; `None` if it is installed.
    pub(crate) fn missing(self) -> Option<String> {
        let present = match self {
            Self::Rustfmt => process::succeeds("cargo", &["fmt", "--version"]),
            Self::Clippy => process::succeeds("cargo", &["clippy", "--version"]),
            Self::Rustdoc => process::succeeds("rustdoc", &["--version"]),
        };
        (!present).then(|| self.advice(process::succeeds("rustup", &["--version"])))
    }

    fn advice(self, rustup: bool) -> String {
        let name = match self {
            Self::Rustfmt => "rustfmt",
            Self::Clippy => "clippy",
            // Comes with the compiler; there is no component of this name to add.
            Self::Rustdoc => return "rustdoc is not installed; reinstall the Rust toolchain".to_owned(),
        };
        if rustup {
            format!("{name} is not installed; to install it: rustup component add {name}")
        } else {
            format!(
                "{name} is not installed; install the package `{name}` that belongs to this Rust toolchain"
            )
        }
    }
}

/// Returns `true` if the standard library for WebAssembly is installed.
pub(crate) fn has_wasm() -> bool {
    let folder =
        process::output("rustc", &["--print", "target-libdir", "--target", "wasm32-unknown-unknown"]);
    folder.is_some_and(|folder| std::path::Path::new(folder.trim()).is_dir())
}

/// Returns `true` if cargo-nextest is installed.
pub(crate) fn has_nextest() -> bool {
    process::succeeds("cargo", &["nextest", "--version"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_advice_depends_on_whether_rustup_is_there() {
        assert!(Component::Rustfmt.advice(true).ends_with("rustup component add rustfmt"));
        assert!(Component::Clippy.advice(true).ends_with("rustup component add clippy"));
        let without = Component::Clippy.advice(false);
        assert!(without.contains("package `clippy`") && !without.contains("rustup"), "{without}");
    }
}
