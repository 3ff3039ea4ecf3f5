//! Targets: inputs of one kind, and the files that they are about.

use crate::mutation::Choices;

/// Inputs of one kind, tried by a function or by tests.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    /// The inputs, and what is asserted of them.
    pub(crate) about: &'static str,
    pub(crate) kind: Kind,
    /// Folders and files of the workspace: once something in them changes, the count starts again.
    pub(crate) files: &'static [&'static str],
    /// The number of inputs that are to be tried.
    pub(crate) aim: u64,
}

#[derive(Clone, Copy)]
pub(crate) enum Kind {
    /// A function that makes an input of choices and tries it. A panic is a failure.
    Function(fn(&mut Choices<'_>)),
    /// Tests of a package that take more cases with `UMBRAGRAPH_TIMES`, and others with `UMBRAGRAPH_SEED`.
    Tests {
        package: &'static str,
        /// As `cargo nextest -E` takes it.
        filter: &'static str,
        /// The cases of one run.
        cases: u64,
        /// The maximum of `UMBRAGRAPH_TIMES` that makes more of them.
        most: u64,
    },
}
