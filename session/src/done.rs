//! [`Done`]: the work that answers took.

/// Counts of the work that a session did for its answers. Results taken from caches are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Done {
    /// Files that were read, including unsaved texts.
    pub read: usize,
    /// Files and other texts that were parsed as JSON documents.
    pub parsed: usize,
    /// Changed documents that were compared with their previous text, token by token.
    pub compared: usize,
    /// Pipelines that were composed from their files.
    pub composed: usize,
    /// Shader templates that were read into a template set.
    pub templates: usize,
    /// Configurations of pipelines that were loaded, as the step before planning.
    pub loaded: usize,
    /// Plans that were made, one per configuration.
    pub planned: usize,
    /// Shader variants that were generated from templates.
    pub rendered: usize,
    /// Sets of shader variants that were validated.
    pub proven: usize,
}
