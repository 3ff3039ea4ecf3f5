//! [`ChangeError`]: the reasons for which a graph cannot be changed.

use std::collections::BTreeMap;

use crate::graph::diagnostic::list_of;
use crate::graph::edit::{EditError, Edits};

/// A change that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ChangeError {
    /// An edit of a text that cannot be made.
    Edit(EditError),
    /// An unknown pass, resource or slot.
    Unknown(String),
    /// An unknown node kind or subgraph.
    UnknownKind(String),
    /// A file with a syntax error.
    Broken(String),
    /// A file that is bundled with the engine and cannot be changed.
    Bundled(String),
    /// A reference that an expression selects.
    Chosen(String),
    /// A list that a pass takes over as a whole from shared settings or another file.
    Inherited(String),
    /// A condition that is false with the chosen values.
    Conditional(String),
    /// A resource that passes of a group use in several versions.
    Versions(String),
    /// The resource to be removed, and the names of its users.
    Used(String, Vec<String>),
    /// Passes that stand in several files, or in one that is not the pipeline's own.
    Scattered,
    /// A text that has changed since.
    Gone,
}

impl std::fmt::Display for ChangeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Edit(error) => write!(f, "{error}"),
            Self::Unknown(name) => write!(f, "the pipeline's text has no \"{name}\""),
            Self::UnknownKind(name) => write!(f, "\"{name}\" is neither a node kind nor a subgraph"),
            Self::Broken(file) => write!(f, "{file} has a syntax error; mend it first"),
            Self::Bundled(file) => write!(f, "{file} comes with the module and cannot be changed here"),
            Self::Chosen(text) => write!(f, "the expression \"{text}\" chooses here; change it in the text"),
            Self::Inherited(what) => {
                write!(f, "\"{what}\" is part of a list that the pass takes over; change it in the text")
            }
            Self::Conditional(text) => {
                write!(f, "\"when\": \"{text}\" is false with these settings; change a setting or the text")
            }
            Self::Versions(name) => {
                write!(f, "the passes use \"{name}\" in several versions of passes outside")
            }
            Self::Used(name, users) => {
                write!(
                    f,
                    "\"{name}\" is used by {}; connect something else there first",
                    list_of(users.iter().map(String::as_str))
                )
            }
            Self::Scattered => f.write_str("these passes do not stand in one file of the pipeline"),
            Self::Gone => f.write_str("the text is no longer what the graph shows"),
        }
    }
}

impl std::error::Error for ChangeError {}

impl From<EditError> for ChangeError {
    fn from(error: EditError) -> Self {
        Self::Edit(error)
    }
}

pub(super) type Changed = Result<(), ChangeError>;

/// The edits of a change, by file name, or the error that prevents the change.
pub type Changes = Result<BTreeMap<String, Edits>, ChangeError>;
