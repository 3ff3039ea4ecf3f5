//! Output of a command, for tests that run one.

use std::process::Output;

/// Converts standard output or standard error to text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the standard error of a command that failed with the given status, mentions all of the texts, and did not
/// panic.
///
/// # Panics
/// If the command ended otherwise.
#[track_caller]
pub fn rejected(output: &Output, status: i32, says: &[&str]) -> String {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{errors}");
    for word in says {
        assert!(errors.contains(word), "{word} is missing in\n{errors}");
    }
    assert!(!errors.contains("panicked"), "{errors}");
    errors
}
