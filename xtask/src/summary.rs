//! Outcomes of the steps, and their summary.

use std::time::Duration;

/// The outcome of one step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Outcome {
    pub(crate) name: &'static str,
    pub(crate) elapsed: Duration,
    /// The reason of the failure; `None` if the step succeeded.
    pub(crate) failure: Option<String>,
}

/// Returns `true` if every step succeeded.
pub(crate) fn all_passed(outcomes: &[Outcome]) -> bool {
    outcomes.iter().all(|outcome| outcome.failure.is_none())
}

/// Returns a text with the table of steps, the skipped tests and the verdict.
pub(crate) fn summary(outcomes: &[Outcome], skips: &[String]) -> String {
    let width = outcomes.iter().map(|outcome| outcome.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for outcome in outcomes {
        let verdict = if outcome.failure.is_none() { "ok  " } else { "FAIL" };
        let seconds = outcome.elapsed.as_secs_f64();
        text += &format!("  {verdict} {:<width$} {seconds:>8.1} s", outcome.name);
        if let Some(failure) = &outcome.failure {
            text += &format!("  {failure}");
        }
        text.push('\n');
    }
    for skip in skips {
        text += &format!("  {skip}\n");
    }
    let failed = outcomes.iter().filter(|outcome| outcome.failure.is_some()).count();
    text += &match failed {
        0 => format!("all {} steps passed\n", outcomes.len()),
        _ => format!("{failed} of {} steps failed\n", outcomes.len()),
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(name: &'static str, failure: Option<&str>) -> Outcome {
        Outcome { name, elapsed: Duration::from_millis(1250), failure: failure.map(str::to_owned) }
    }

    #[test]
    fn a_failed_step_is_named_with_its_reason() {
        let outcomes = [outcome("formatting", None), outcome("lints", Some("exit status: 101"))];
        let text = summary(&outcomes, &["SKIPPED 2: no adapter".to_owned()]);
        assert_eq!(
            text,
            "  ok   formatting      1.2 s\n  FAIL lints           1.2 s  exit status: 101\n  \
             SKIPPED 2: no adapter\n1 of 2 steps failed\n"
        );
        assert!(!all_passed(&outcomes));
    }

    #[test]
    fn success_says_how_many_steps_there_were() {
        let outcomes = [outcome("tests", None)];
        assert!(summary(&outcomes, &[]).ends_with("all 1 steps passed\n"));
        assert!(all_passed(&outcomes));
    }
}
