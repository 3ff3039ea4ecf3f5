//! The codes of diagnostics that the command and the viewer share.

#![allow(unreachable_pub)] // The macro serves libraries.

umbragraph_graph::codes! {
    /// A file that cannot be written.
    FILE_UNWRITABLE = "UG0004", "file cannot be written",
        "The output could not be written. Nothing is left half: output goes to a temporary file first, which is renamed when it is whole.";
    /// A camera path that no camera can follow.
    CAMERA_PATH = "UG0810", "unusable camera path",
        "The file of `--camera` has keys with a time, a position and a target, in strictly increasing order of their times; all numbers are finite, and no key looks straight up or down.";
}
