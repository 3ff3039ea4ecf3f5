//! Names: what can be one, what a name means where loops and subgraphs are around it, and what to say of one that is not
//! known.

pub(crate) mod environment;
pub(crate) mod expression_diagnostic;
pub(crate) mod identifiers;
pub(crate) mod instance;
