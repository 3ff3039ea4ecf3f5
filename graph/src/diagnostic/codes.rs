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
    /// A text that is not JSON.
    SYNTAX = "UG0101", "not JSON",
        "Pipelines are strict JSON (RFC 8259) with `//` and `/* */` comments. Trailing commas, single quotes, bare keys, hexadecimal numbers, NaN and nesting beyond 512 levels are refused. The parser stops at the first such place.";
    /// A key that no rule of the schema knows at its place.
    UNKNOWN_KEY = "UG0102", "unknown key",
        "An object has a key that means nothing at its place. Nothing is ignored silently: a misspelt key would otherwise change nothing and say nothing.";
    /// A key that stands twice in one object.
    DUPLICATE_KEY = "UG0103", "duplicate key",
        "A key stands twice in one object. Other readers of JSON take the first or the last of the two; here it is always a mistake.";
    /// A number that no 64-bit type holds.
    NUMBER_RANGE = "UG0104", "number out of range",
        "A number is beyond what a 64-bit floating-point number holds, or is not written as JSON wants it.";
    /// A value of another type than the schema wants.
    WRONG_TYPE = "UG0105", "wrong type",
        "A value has another type than its place wants: a string where a number belongs, an object where an array belongs. `umbragraph schema` prints what each place wants.";
    /// A key that has to be there and is not.
    MISSING_KEY = "UG0106", "missing key", "An object lacks a key that it must have.";
    /// A text that is none of the words that its place knows.
    UNKNOWN_WORD = "UG0107", "unknown word",
        "A place that takes one of a few words (a texture format, a comparison) has another one. The words are those of the WebGPU specification.";
    /// A value outside the limits of the schema.
    OUT_OF_BOUNDS = "UG0108", "value out of bounds",
        "A number, or the length of a list, is outside what its place allows.";
}
