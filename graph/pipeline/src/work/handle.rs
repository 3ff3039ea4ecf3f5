//! Names of what a pipeline has, as positions that cannot be mixed up.

use serde::Serialize;

/// Names a resource of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ResourceHandle(pub(crate) u32);

/// Names a pass of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct PassHandle(pub(crate) u32);

/// Names a program (a shader with all its variants) of one pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct ProgramHandle(pub(crate) u32);

impl ResourceHandle {
    /// The handle of the resource at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::resources`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl PassHandle {
    /// The handle of the pass at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::passes`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl ProgramHandle {
    /// The handle of the program at a position of a pipeline.
    pub fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// The position in [`crate::pipeline::Pipeline::programs`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
