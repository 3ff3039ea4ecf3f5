//! [`Done`]: the work that answers took.

/// Counts of the work that answers took. Cached results do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Done {
    /// Files that were read, unsaved texts included.
    pub read: usize,
    /// Texts that were parsed as documents.
    pub parsed: usize,
    /// Texts that were compared with the one before, token by token, and are the same document.
    pub compared: usize,
    /// Documents that were composed of their files.
    pub composed: usize,
    /// Templates that were read into a set.
    pub templates: usize,
    /// Configurations that were loaded.
    pub loaded: usize,
    /// Plans that were made.
    pub planned: usize,
    /// Shader variants that were rendered.
    pub rendered: usize,
    /// Sets of shader variants that were validated.
    pub proven: usize,
}
