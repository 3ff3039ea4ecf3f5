//! [`Error`]: what is wrong, with the texts in which it stands.

use std::fmt;
use std::ops::Deref;

use crate::diagnostic::{Diagnostic, Diagnostics, render};
use crate::source::Sources;

/// The error of a failed operation: its diagnostics, with the source texts that they point into. `Display` prints each
/// diagnostic with its code, source lines and help; [`Error::diagnostics`] returns them as data.
#[derive(Clone)]
pub struct Error(Box<Found>);

#[derive(Clone)]
struct Found {
    diagnostics: Diagnostics,
    sources: Sources,
}

impl Error {
    /// Creates an error from diagnostics and the source texts that they point into.
    pub fn new(diagnostics: Diagnostics, sources: &Sources) -> Self {
        Self(Box::new(Found { diagnostics, sources: sources.clone() }))
    }

    /// The diagnostics that describe the failure.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.0.diagnostics
    }

    /// The source texts that the diagnostics point into.
    pub fn sources(&self) -> &Sources {
        &self.0.sources
    }

    /// Returns `diagnostic` as a JSON object, with its file name, line and column.
    pub fn json(&self, diagnostic: &Diagnostic) -> serde_json::Value {
        render::json(diagnostic, &self.0.sources)
    }
}

/// Dereferences to the diagnostics, so that their methods can be called on the error.
impl Deref for Error {
    type Target = Diagnostics;

    fn deref(&self) -> &Diagnostics {
        &self.0.diagnostics
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&render::human_all(self.diagnostics(), &self.0.sources))
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#?}", self.diagnostics())
    }
}

impl std::error::Error for Error {}

/// Prints the diagnostic's code, message and help text without a source position, such as for device errors, which have
/// none.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.code, self.message)?;
        self.help.iter().try_for_each(|help| write!(f, "; {help}"))
    }
}

impl std::error::Error for Diagnostic {}

impl From<Error> for Diagnostics {
    fn from(error: Error) -> Self {
        error.0.diagnostics
    }
}
