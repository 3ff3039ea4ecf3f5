//! The order of passes in a plan.

use umbragraph_pipeline::work::PassHandle;

/// The position of each pass in execution order, indexed by pass handle; `None` for a culled pass.
pub(crate) struct Schedule {
    pub(crate) at: Vec<Option<usize>>,
}

impl Schedule {
    pub(crate) fn of(&self, pass: PassHandle) -> Option<usize> {
        self.at.get(pass.index()).copied().flatten()
    }
}
