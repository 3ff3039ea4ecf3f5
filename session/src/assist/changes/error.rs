//! [`ChangeError`]: the reasons for which a graph cannot be changed.

use std::collections::BTreeMap;

use crate::graph::diagnostic::list_of;
use crate::graph::edit::{EditError, Edits};

/// The reason why a change of a pass graph cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ChangeError {
    /// An edit of a file that is not possible, such as a rename to a name that is taken.
    Edit(EditError),
    /// The name of a pass or resource that does not exist.
    Unknown(String),
    /// A name that is neither a node kind nor a subgraph.
    UnknownKind(String),
    /// The name of a file with a syntax error.
    Broken(String),
    /// The name of a file that is bundled with the engine and cannot be changed.
    Bundled(String),
    /// An expression that selects the reference, which can only be changed by hand.
    Chosen(String),
    /// The label of a slot in a list that the pass inherits from shared settings or another file.
    Inherited(String),
    /// The condition under the key `when` that keeps the pass switched off with the chosen values.
    Conditional(String),
    /// The name of a resource that the passes of a group use in several versions, written by different passes outside.
    Versions(String),
    /// The name of the resource to be removed, and the names of the declarations that use it.
    Used(String, Vec<String>),
    /// Passes that are declared in several files, or in a file other than the pipeline's own.
    Scattered,
    /// A value that is no longer in the file, since the file has changed.
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
