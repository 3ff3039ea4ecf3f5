//! Tests that were skipped for want of something, counted over all test processes.
//!
//! Each skipped test appends `reason`, a tab and its name to the file that [`VARIABLE`] names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The environment variable with the path of the file in which tests record skips.
pub(crate) const VARIABLE: &str = "UMBRAGRAPH_SKIP_LOG";

/// Returns the path of the log of skipped tests, after removing an old log.
pub(crate) fn new_log(target: &Path) -> PathBuf {
    let log = target.join("skipped-tests.log");
    // Where there is none there is nothing to remove; where it cannot be, the counts are too high and are looked at.
    let _ = std::fs::remove_file(&log);
    log
}

/// Returns a line for each reason for skipping, with the number of tests.
pub(crate) fn report(log: &Path) -> Vec<String> {
    count(&std::fs::read_to_string(log).unwrap_or_default())
        .into_iter()
        .map(|(reason, count)| format!("SKIPPED {count}: {reason}"))
        .collect()
}

fn count(text: &str) -> BTreeMap<&str, usize> {
    let mut reasons = BTreeMap::new();
    for line in text.lines() {
        let reason = line.split('\t').next().unwrap_or(line);
        *reasons.entry(reason).or_insert(0) += 1;
    }
    reasons
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_are_counted_by_their_reason() {
        let counted = count("no truth\tfirst\nno adapter\tsecond\nno truth\tthird\n");
        assert_eq!(counted, BTreeMap::from([("no adapter", 1), ("no truth", 2)]));
    }

    #[test]
    fn without_a_log_nothing_was_skipped() {
        assert!(report(Path::new("/nonexistent-folder/skips.log")).is_empty());
    }
}
