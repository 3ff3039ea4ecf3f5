//! One template of a set.

use std::sync::Arc;

use super::scan::Scan;
use super::tree;
use umbragraph_text::diagnostic::Diagnostic;
use umbragraph_text::source::FileId;

/// One template: its source, its tags, and the copy with size checks that is rendered.
#[derive(Debug)]
pub(crate) struct Template {
    pub(crate) file: FileId,
    pub(crate) text: Arc<str>,
    pub(crate) scan: Scan,
    pub(crate) prepared: tree::Prepared,
    /// The error that makes the template unusable; `None` if it is usable.
    pub(crate) broken: Option<Diagnostic>,
}
