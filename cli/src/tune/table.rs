//! The result of a search: scores before and after, and which values are worth their cost.
//!
//! A set of values is *worth its cost* (Pareto) where no other one that was tried scores as well for fewer texels and
//! taps.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;
use umbragraph::low_level::expression::Value;

use super::trial::{Cost, loss};
use super::{Tried, best};
use crate::answer::Answer;
use crate::arguments::{Measure, TuneArguments};

/// The maximum number of rows in the table for people.
const ROWS: usize = 12;

/// The result of a search.
pub(super) struct Found {
    pub(super) adapter: String,
    /// The names of the scene files.
    pub(super) scenes: Vec<String>,
    pub(super) measure: Measure,
    /// The number of value sets tried.
    pub(super) trials: usize,
    pub(super) rejected: usize,
    budget: u32,
    pub(super) names: Vec<String>,
    pub(super) before: Tried,
    pub(super) after: Tried,
    /// The trials on the Pareto front of loss and cost, from the cheapest to the most expensive.
    pareto: Vec<Tried>,
}

impl Found {
    /// Creates the result of a search. `tried` begins with the start values; `None` if it is empty.
    pub(super) fn new(
        (arguments, measure): (&TuneArguments, Measure),
        adapter: &str,
        names: Vec<String>,
        tried: Vec<Tried>,
        rejected: u32,
    ) -> Option<Self> {
        let (before, after) = (tried.first()?.clone(), best(&tried)?.clone());
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Some(Self {
            adapter: adapter.to_owned(),
            scenes: arguments.scene.iter().map(name).collect(),
            measure,
            trials: tried.len() + rejected as usize,
            rejected: rejected as usize,
            budget: arguments.budget,
            names,
            before,
            after,
            pareto: pareto(tried),
        })
    }

    /// Returns the display name of the score that was tuned.
    pub(super) fn score_name(&self) -> &'static str {
        match self.measure {
            Measure::Iou => "IoU",
            Measure::MeanError => "mean error",
            Measure::Flip => "FLIP",
        }
    }

    /// Converts a loss to the score that it was computed from.
    pub(super) fn score(&self, loss: f64) -> f64 {
        match self.measure {
            Measure::Iou => 1.0 - loss,
            Measure::MeanError | Measure::Flip => loss,
        }
    }
}

impl Answer for Found {
    fn json(&self) -> serde_json::Value {
        let tried = |tried: &Tried| {
            let scenes: Vec<_> = self
                .scenes
                .iter()
                .zip(&tried.outcome.scenes)
                .map(|(name, scores)| json!({ "scene": name, "scores": scores }))
                .collect();
            let values: serde_json::Map<_, _> =
                tried.values.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
            let Cost { texels, taps } = tried.outcome.cost;
            json!({ "score": self.score(tried.outcome.loss), "texels": texels, "taps": taps, "values": values, "scenes": scenes })
        };
        json!({
            "adapter": self.adapter, "trials": self.trials, "rejected": self.rejected, "score": self.score_name(),
            "before": tried(&self.before), "after": tried(&self.after),
            "pareto": self.pareto.iter().map(tried).collect::<Vec<_>>(),
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{} of {} sets of values tried", self.trials, self.budget);
        if self.rejected > 0 {
            let _ = write!(text, ", {} of them rejected by the pipeline", self.rejected);
        }
        let _ =
            writeln!(text, ", on {}\n{:<28}{:>10}{:>10}", self.adapter, self.score_name(), "before", "after");
        let mut row = |name: &str, [before, after]: [Option<f64>; 2]| {
            let [before, after] = [before, after]
                .map(|loss| loss.map_or_else(|| "-".to_owned(), |loss| format!("{:.4}", self.score(loss))));
            let _ = writeln!(text, "  {name:<26}{before:>10}{after:>10}");
        };
        let both = [&self.before.outcome, &self.after.outcome];
        for (at, name) in self.scenes.iter().enumerate() {
            row(name, both.map(|outcome| loss(outcome.scenes.get(at)?, self.measure)));
        }
        if self.scenes.len() > 1 {
            row("all", both.map(|outcome| Some(outcome.loss)));
        }
        for name in &self.names {
            let of = |tried: &Tried| value(tried, name);
            let _ = writeln!(text, "  {name}: {} → {}", of(&self.before), of(&self.after));
        }
        let _ = writeln!(
            text,
            "worth their cost:\n{:>12}{:>8}{:>12}  values",
            "texels",
            "taps",
            self.score_name()
        );
        for tried in shown(&self.pareto) {
            let Cost { texels, taps } = tried.outcome.cost;
            let score = self.score(tried.outcome.loss);
            let values: Vec<String> =
                self.names.iter().map(|name| format!("{name}={}", value(tried, name))).collect();
            let _ = writeln!(text, "{texels:>12}{taps:>8}{score:>12.4}  {}", values.join(" "));
        }
        text
    }
}

/// Returns the text of a parameter's value; empty if the trial does not set it.
pub(super) fn value(tried: &Tried, name: &str) -> String {
    let found = tried.values.iter().find(|(known, _)| known == name);
    found.map_or_else(String::new, |(_, value): &(String, Value)| value.to_string())
}

/// Returns the trials on the Pareto front of loss and cost, from the cheapest to the most expensive.
fn pareto(mut tried: Vec<Tried>) -> Vec<Tried> {
    tried.sort_by(|one, other| {
        let key = |tried: &Tried| (tried.outcome.cost.texels, tried.outcome.cost.taps);
        key(one).cmp(&key(other)).then_with(|| one.outcome.loss.total_cmp(&other.outcome.loss))
    });
    let mut kept: Vec<Tried> = Vec::new();
    for one in tried {
        // Those before have at most as many texels.
        let is_beaten = kept.iter().any(|other| {
            other.outcome.loss <= one.outcome.loss && other.outcome.cost.taps <= one.outcome.cost.taps
        });
        if !is_beaten {
            kept.push(one);
        }
    }
    kept
}

/// Returns up to `ROWS` evenly spaced trials, including the first and the last.
fn shown(all: &[Tried]) -> impl Iterator<Item = &Tried> {
    let last = all.len().saturating_sub(1);
    let rows = ROWS.min(all.len());
    (0..rows).filter_map(move |row| all.get(if rows > 1 { row * last / (rows - 1) } else { 0 }))
}

#[cfg(test)]
mod tests {
    use super::super::trial::Outcome;
    use super::*;

    fn tried(texels: u64, taps: u64, loss: f64) -> Tried {
        let outcome = Outcome { loss, scenes: Vec::new(), cost: Cost { texels, taps }, pictures: 0 };
        Tried { values: Vec::new(), outcome }
    }

    #[test]
    fn what_another_beats_in_everything_is_not_worth_its_cost() {
        let all = vec![
            tried(9, 1, 0.1),
            tried(4, 1, 0.2),
            tried(4, 1, 0.3),
            tried(9, 4, 0.2),
            tried(9, 4, 0.05),
            tried(16, 1, 0.1),
        ];
        let kept = pareto(all);
        let kept: Vec<_> = kept
            .iter()
            .map(|one| (one.outcome.cost.texels, one.outcome.cost.taps, one.outcome.loss))
            .collect();
        assert_eq!(kept, [(4, 1, 0.2), (9, 1, 0.1), (9, 4, 0.05)]);
    }

    #[test]
    fn of_many_rows_the_ends_are_shown() {
        let all: Vec<Tried> = (0..100).map(|at| tried(at, 0, 0.0)).collect();
        let rows: Vec<u64> = shown(&all).map(|one| one.outcome.cost.texels).collect();
        assert_eq!((rows.len(), rows[0], rows[11]), (12, 0, 99));
        assert_eq!(shown(&all[..1]).count(), 1);
        assert_eq!(shown(&[]).count(), 0);
    }
}
