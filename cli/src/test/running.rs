//! A run of shader tests: its parts, and the counts of tests and rows.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use umbragraph::low_level::shader::TemplateSet;

use crate::device::Graphics;

/// The stack size in bytes for naga, which recurses into nested code.
pub(super) const STACK_BYTES: usize = 32 << 20;

/// The settings that all variants of a test run share.
pub(super) struct Run<'a> {
    pub(super) templates: &'a TemplateSet,
    pub(super) graphics: &'a Graphics,
    /// A part of the names of the tests to run; `None` runs all tests.
    pub(super) filter: Option<&'a str>,
    /// The time limit of one compute pass.
    pub(super) limit: Duration,
    /// Set once a pass did not end in time: the device can run nothing further.
    pub(super) has_timed_out: Cell<bool>,
}

/// The counts of one shader test.
#[derive(Debug, Default)]
pub(super) struct TestCount {
    pub(super) rows: usize,
    /// The number of variants, counted once for each set of `override` values.
    pub(super) variants: usize,
    /// The messages of the test's failures; empty if it passed.
    pub(super) messages: BTreeSet<String>,
}

/// The test counts of one file.
#[derive(Debug)]
pub(super) struct FileCount {
    pub(super) name: String,
    pub(super) tests: BTreeMap<String, TestCount>,
}
