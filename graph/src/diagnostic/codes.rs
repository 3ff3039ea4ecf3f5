//! The codes of the engine's own findings.
//!
//! Ranges: 00 files and the command line, 01 documents, 02 the pipeline language, 03 resources and expressions,
//! 04 the graph and its plan, 05 templates and shaders, 06 the node kinds that come with the project, 07 scenes,
//! 08 devices and execution. A code is never reused for another meaning.

crate::codes! {
    /// A file that is named but cannot be read.
    FILE_UNREADABLE = "UG0001", "file cannot be read",
        "A file that the command line, a pipeline or a template names does not exist or cannot be read.\n\nPaths inside a file are relative to the folder of that file.";
    /// A file that is not UTF-8.
    FILE_NOT_UTF8 = "UG0002", "file is not UTF-8",
        "Pipelines, parameter files and templates are UTF-8 text. The finding points to the first byte that is not.";
    /// A file over the size limit.
    FILE_TOO_LARGE = "UG0003", "file too large", "Text files are limited to 64 MiB.";
    /// A file that cannot be written.
    FILE_UNWRITABLE = "UG0004", "file cannot be written",
        "The output could not be written. Nothing is left half: output goes to a temporary file first, which is renamed when it is whole.";
    /// A key that no rule of the schema knows at its place.
    UNKNOWN_KEY = "UG0102", "unknown key",
        "An object has a key that means nothing at its place. Nothing is ignored silently: a misspelt key would otherwise change nothing and say nothing.";
}
