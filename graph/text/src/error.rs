//! [`Error`]: what is wrong, with the texts in which it stands.

use std::fmt;
use std::ops::Deref;

use crate::diagnostic::{Diagnostic, Diagnostics, render};
use crate::source::Sources;

/// Why there is no result: every diagnostic, and the texts in which they stand. Shown, each has its code, its lines and
/// a way out; as data they are [`Error::diagnostics`].
#[derive(Clone)]
pub struct Error(Box<Found>);

#[derive(Clone)]
struct Found {
    diagnostics: Diagnostics,
    sources: Sources,
}

impl Error {
    /// Diagnostics, and the texts in which they stand.
    pub fn new(diagnostics: Diagnostics, sources: &Sources) -> Self {
        Self(Box::new(Found { diagnostics, sources: sources.clone() }))
    }

    /// The diagnostics.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.0.diagnostics
    }

    /// The texts in which it stands.
    pub fn sources(&self) -> &Sources {
        &self.0.sources
    }

    /// A diagnostic as JSON, with its file, line and column.
    pub fn json(&self, diagnostic: &Diagnostic) -> serde_json::Value {
        render::json(diagnostic, &self.0.sources)
    }
}

/// The diagnostics.
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

/// Prints code, message and help without the place, for an error of a device that has none.
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
