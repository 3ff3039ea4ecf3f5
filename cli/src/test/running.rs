//! A run of shader tests: its parts, and the counts of tests and rows.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use umbragraph::low_level::shader::TemplateSet;

use crate::device::Graphics;

/// Stack for naga, which recurses into nested text.
pub(super) const STACK_BYTES: usize = 32 << 20;

/// The parts that every variant of a run has in common.
pub(super) struct Run<'a> {
    pub(super) templates: &'a TemplateSet,
    pub(super) graphics: &'a Graphics,
    /// A part of the names of the tests to run.
    pub(super) filter: Option<&'a str>,
    /// The time limit of a pass.
    pub(super) limit: Duration,
    /// Whether a pass did not end in time: nothing further can run.
    pub(super) has_timed_out: Cell<bool>,
}

/// The counts of one test.
#[derive(Debug, Default)]
pub(super) struct TestCount {
    pub(super) rows: usize,
    /// The variants, with each set of values of overrides.
    pub(super) variants: usize,
    /// The messages of what is wrong with it.
    pub(super) messages: BTreeSet<String>,
}

/// The counts of one file.
#[derive(Debug)]
pub(super) struct FileCount {
    pub(super) name: String,
    pub(super) tests: BTreeMap<String, TestCount>,
}
