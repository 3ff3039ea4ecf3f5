//! Skipped tests, counted.
//!
//! Rust's test harness knows no verdict between passed and failed, and both it and nextest hide the output of
//! tests that pass. A skip therefore writes to the process's own standard error, past the harness's capture, and,
//! since nextest gives each test its own process, also appends a line to the file named by
//! [`SKIP_LOG`](crate::environment::SKIP_LOG), from which the runner takes the count over all processes.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::environment;

static SKIPPED: AtomicUsize = AtomicUsize::new(0);

/// Counts and announces a skipped test. Returns the number of skipped tests in this process so far.
pub fn skipped(reason: &str) -> usize {
    let count = SKIPPED.fetch_add(1, Ordering::Relaxed) + 1;
    let reason = reason.lines().collect::<Vec<_>>().join(" ");
    announce(&format!("SKIPPED ({count}): {reason}"));
    if let Some(log) = environment::process(environment::SKIP_LOG) {
        let test = test_name().unwrap_or_else(|| "(unnamed test)".to_owned());
        if let Err(error) = append(Path::new(&log), &reason, &test) {
            announce(&format!("cannot write the skip to {}: {error}", log.display()));
        }
    }
    count
}

/// Returns the number of skipped tests in this process so far.
pub fn count() -> usize {
    SKIPPED.load(Ordering::Relaxed)
}

/// Appends a line to the log in a single write, so that lines of several processes do not mix.
fn append(log: &Path, reason: &str, test: &str) -> io::Result<()> {
    let mut file = OpenOptions::new().create(true).append(true).open(log)?;
    file.write_all(format!("{reason}\t{test}\n").as_bytes())
}

/// Writes a line to standard error, also from within a test whose output is captured.
pub(crate) fn announce(line: &str) {
    // A test whose standard error is closed has no one to tell.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Returns the name of the running test; `None` if the test harness does not provide it.
pub(crate) fn test_name() -> Option<String> {
    if let Some(name) = environment::process("NEXTEST_TEST_NAME") {
        return name.into_string().ok();
    }
    std::thread::current().name().filter(|name| *name != "main").map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scratch::ScratchFolder;

    #[test]
    fn the_log_keeps_one_line_for_each_skip() {
        let folder = ScratchFolder::new("the_log_keeps_one_line_for_each_skip");
        let log = folder.join("skips.log");
        append(&log, "no adapter", "first").unwrap();
        append(&log, "no truth", "second").unwrap();
        let text = std::fs::read_to_string(&log).unwrap();
        assert_eq!(text, "no adapter\tfirst\nno truth\tsecond\n");
    }

    #[test]
    fn a_log_that_cannot_be_written_is_an_error_value() {
        assert!(append(Path::new("/nonexistent-folder/skips.log"), "no adapter", "a test").is_err());
    }

    #[test]
    fn the_running_test_knows_its_name() {
        let name = test_name().unwrap();
        assert!(name.ends_with("the_running_test_knows_its_name"), "{name}");
    }
}
