//! The steps of `cargo xtask test`, as data.

use crate::toolchain::Component;

/// A cargo command to run, and its name in the summary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    pub(crate) name: &'static str,
    pub(crate) arguments: Vec<&'static str>,
    pub(crate) environment: Vec<(&'static str, &'static str)>,
    pub(crate) needs: Option<Component>,
}

impl Step {
    fn cargo(name: &'static str, arguments: &'static str) -> Step {
        Step { name, arguments: arguments.split_whitespace().collect(), environment: Vec::new(), needs: None }
    }

    fn needs(mut self, component: Component) -> Step {
        self.needs = Some(component);
        self
    }

    fn with(mut self, variable: &'static str, value: &'static str) -> Step {
        self.environment.push((variable, value));
        self
    }

    /// Returns the step as a shell command line.
    pub(crate) fn command_line(&self) -> String {
        let variables = self.environment.iter().map(|(name, value)| format!("{name}=\"{value}\" "));
        format!("{}cargo {}", variables.collect::<String>(), self.arguments.join(" "))
    }
}

/// Filters for the tests that a second Vulkan driver runs: a misbehaving driver, limited devices, and reference
/// pictures of two systems.
const ON_SECOND_DRIVER: &str = "misbehaving narrowed::nebula golden::nebula golden::mantis::courtyard";

/// Returns all steps, the quickest first. `second` is the manifest of a second Vulkan driver; `None` leaves its step
/// out.
pub(crate) fn steps(nextest: bool, wasm: bool, second: Option<&'static str>) -> Vec<Step> {
    use Component::{Clippy, Rustdoc, Rustfmt};
    let tests = if nextest {
        "nextest run --workspace --features umbragraph/watch --no-fail-fast"
    } else {
        "test --workspace --features umbragraph/watch --lib --bins --tests --examples --no-fail-fast"
    };
    // The two libraries of the page.
    let browser = [
        Step::cargo(
            "browser",
            "clippy --target wasm32-unknown-unknown --package umbragraph-web --keep-going -- -D warnings",
        )
        .needs(Clippy),
        Step::cargo(
            "browser without a GPU",
            "clippy --target wasm32-unknown-unknown --package umbragraph-web --no-default-features --keep-going -- -D warnings",
        )
        .needs(Clippy),
    ];
    let second = second.map(|manifest| {
        let run = if nextest { "nextest run" } else { "test" };
        let mut step = Step::cargo("second driver", run).with("VK_DRIVER_FILES", manifest);
        // The packages and features of the step `tests`: others would build the dependencies a second time.
        step.arguments.extend(
            "--workspace --features umbragraph/watch --test device --test pictures --no-fail-fast --"
                .split(' '),
        );
        step.arguments.extend(ON_SECOND_DRIVER.split(' '));
        step
    });
    let steps = vec![
        Step::cargo("formatting", "fmt --all --check").needs(Rustfmt),
        // The packages of their own build with `--locked` only where their lock file knows the crates of this
        // workspace.
        Step::cargo("lock of egui", "update --workspace --locked --manifest-path examples/egui/Cargo.toml"),
        Step::cargo("lock of bevy", "update --workspace --locked --manifest-path examples/bevy/Cargo.toml"),
        Step::cargo("lock of peers", "update --workspace --locked --manifest-path benches/peers/Cargo.toml"),
        Step::cargo("lock of view", "update --workspace --locked --manifest-path view/Cargo.toml"),
        Step::cargo("lints", "clippy --workspace --features umbragraph/watch --all-targets --keep-going -- -D warnings").needs(Clippy),
        Step::cargo(
            "lints without a GPU",
            "clippy --package umbragraph --package umbragraph-cli --no-default-features --keep-going -- -D warnings",
        )
        .needs(Clippy),
        Step::cargo("tests", tests),
        Step::cargo("scenes", "run --quiet --package xtask -- scenes --check"),
        Step::cargo("doc tests", "test --workspace --features umbragraph/watch --doc --no-fail-fast").needs(Rustdoc),
        // The command and the front door are both called `umbragraph`, and would overwrite each other's pages.
        Step::cargo("documentation", "doc --workspace --features umbragraph/watch --lib --no-deps --keep-going")
            .with("RUSTDOCFLAGS", "-D warnings")
            .needs(Rustdoc),
    ];
    steps.into_iter().chain(second).chain(wasm.then_some(browser).into_iter().flatten()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(steps: &[Step], name: &str) -> String {
        steps.iter().find(|step| step.name == name).unwrap().command_line()
    }

    #[test]
    fn every_step_fails_on_a_warning_or_a_difference() {
        let steps = steps(true, true, None);
        assert!(line(&steps, "formatting").contains("--check"));
        assert!(line(&steps, "lints").ends_with("-- -D warnings"));
        assert!(line(&steps, "lints without a GPU").ends_with("-- -D warnings"));
        assert!(line(&steps, "documentation").starts_with("RUSTDOCFLAGS=\"-D warnings\" cargo doc"));
    }

    #[test]
    fn lock_files_of_packages_apart_are_checked_and_not_written() {
        for name in ["lock of egui", "lock of bevy", "lock of peers"] {
            assert!(line(&steps(true, true, None), name).contains("--locked"), "{name}");
        }
    }

    #[test]
    fn facade_and_command_are_linted_without_default_features() {
        let line = line(&steps(true, true, None), "lints without a GPU");
        for part in ["--package umbragraph ", "--package umbragraph-cli ", "--no-default-features"] {
            assert!(line.contains(part), "{part}");
        }
    }

    #[test]
    fn without_nextest_the_same_tests_run_with_cargo() {
        assert!(line(&steps(true, true, None), "tests").starts_with("cargo nextest run --workspace"));
        assert!(line(&steps(false, true, None), "tests").starts_with("cargo test --workspace"));
        for nextest in [true, false] {
            assert!(line(&steps(nextest, true, None), "tests").contains("--no-fail-fast"));
            assert!(line(&steps(nextest, true, None), "doc tests").contains("--doc"));
        }
    }

    #[test]
    fn what_browsers_run_is_checked_where_their_target_is_installed() {
        assert!(line(&steps(true, true, None), "browser").contains("--target wasm32-unknown-unknown"));
        assert!(steps(true, false, None).iter().all(|step| !step.name.starts_with("browser")));
        assert!(line(&steps(true, true, None), "browser without a GPU").contains("--no-default-features"));
    }

    #[test]
    fn a_second_driver_draws_where_it_is_installed() {
        let steps = steps(true, true, Some("/driver.json"));
        let line = line(&steps, "second driver");
        assert!(
            line.starts_with(
                "VK_DRIVER_FILES=\"/driver.json\" cargo nextest run --workspace --features umbragraph/watch "
            ),
            "{line}"
        );
        assert!(
            line.ends_with("-- misbehaving narrowed::nebula golden::nebula golden::mantis::courtyard"),
            "{line}"
        );
    }

    #[test]
    fn step_names_are_unique() {
        let mut names: Vec<_> = steps(true, true, None).iter().map(|step| step.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), steps(true, true, None).len());
    }
}
