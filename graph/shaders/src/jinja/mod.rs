//! The template language: tokens, names, filters, and the limits that keep rendering short.

pub(crate) mod comparisons;
pub(crate) mod filters;
pub(crate) mod guard;
pub(crate) mod length;
pub(crate) mod scan;
pub(crate) mod structure;
pub(crate) mod syntax_help;
pub(crate) mod template;
pub(crate) mod tree;
