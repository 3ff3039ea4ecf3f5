//! Output of a command, for tests that run one.

use std::process::Output;

/// Standard output or standard error, as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The standard error of a command that has failed with a status and says all of these; none of them by a panic.
///
/// # Panics
/// If it has not.
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
