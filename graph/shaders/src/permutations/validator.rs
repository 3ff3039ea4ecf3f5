//! External validation of every distinct text, by a validator of the host: the command starts a program.

use umbragraph_text::diagnostic::Place;

/// An external validator, such as another WGSL compiler, for modules that naga accepts. Several threads may call it.
pub trait Validator: Sync {
    /// The name shown in diagnostics.
    fn name(&self) -> &str;

    /// The place to which diagnostics about the validator itself refer.
    fn place(&self) -> Place;

    /// Validates a WGSL module.
    fn judge(&self, wgsl: &str) -> Opinion;
}

/// The result of an external validator for a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Opinion {
    /// The module is valid.
    Accepts,
    /// The module is invalid.
    Rejects {
        /// The error message of the validator.
        message: String,
        /// The line and the column in bytes, each starting at 1; `None` if the validator names no place.
        place: Option<(usize, usize)>,
    },
    /// The validator did not finish within its time limit.
    TimedOut,
    /// The validator cannot run; contains the reason.
    Unavailable(String),
}
