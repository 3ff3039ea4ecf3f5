//! External validation of every distinct text, by a validator of the host: the command starts a program.

use umbragraph_text::diagnostic::Place;

/// Judges texts that naga accepts, on several threads.
pub trait Validator: Sync {
    /// The name under which diagnostics show it.
    fn name(&self) -> &str;

    /// The place of the request, for diagnostics about the validator.
    fn place(&self) -> Place;

    /// The verdict on a text.
    fn judge(&self, wgsl: &str) -> Opinion;
}

/// The verdict of a validator on a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Opinion {
    /// It is valid.
    Accepts,
    /// It is not.
    Rejects {
        /// Why.
        message: String,
        /// Line and column, both from 1, in bytes.
        place: Option<(usize, usize)>,
    },
    /// No answer within the time limit.
    TimedOut,
    /// The validator cannot run; with the reason.
    Unavailable(String),
}
