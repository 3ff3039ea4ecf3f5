//! Names: what can be one, what a name means where loops and subgraphs are around it, and what to say of one that is
//! not known.

pub(crate) mod environment;
pub(crate) mod expression_diagnostic;
pub(crate) mod identifiers;
pub(crate) mod instance;

pub(crate) use environment::{Environment, Given, Input, reference_in};
pub(crate) use expression_diagnostic::expression_diagnostic;
pub(crate) use identifiers::{VIEWPORT, is_of, name_diagnostic, twin_diagnostic};
pub(crate) use instance::Instance;
