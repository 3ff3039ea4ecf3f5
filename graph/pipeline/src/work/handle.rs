//! Names of what a pipeline has, as positions that cannot be mixed up.

use serde::Serialize;

macro_rules! handle {
    ($handle:ident, $what:literal, $list:literal) => {
        #[doc = concat!("Names a ", $what, " of one pipeline.")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        pub struct $handle(pub(crate) u32);

        impl $handle {
            #[doc = concat!("The handle of the ", $what, " at a position of a pipeline.")]
            pub fn at(position: usize) -> Self {
                Self(position as u32)
            }

            #[doc = concat!("The position in [`crate::pipeline::TypedPipeline::", $list, "`].")]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

handle!(ResourceHandle, "resource", "resources");
handle!(PassHandle, "pass", "passes");
handle!(ProgramHandle, "program (a shader with all its variants)", "programs");
