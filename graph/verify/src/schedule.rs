//! The order of passes in a plan.

use umbragraph_pipeline::work::PassHandle;

/// When each pass of the pipeline runs; `None` for a culled one.
pub(crate) struct Schedule {
    pub(crate) at: Vec<Option<usize>>,
}

impl Schedule {
    pub(crate) fn of(&self, pass: PassHandle) -> Option<usize> {
        self.at.get(pass.index()).copied().flatten()
    }
}
