//! Limits on the scores of a picture.
//!
//! A limits file maps each scene to `{limit: number}`. A limit's name says its sense and its score: `min_iou`,
//! `max_leak_k2`, where `k2` is the band and no `k` means band 0. A name that is not known is an error: a limit that is
//! silently not checked is worse than none.

use std::fmt::Write;
use std::path::Path;

use super::error::TruthError;
use super::score::{BandScore, Scores, SoftScore};

/// The limits for the scores of one scene, sorted by name.
#[derive(Clone, Debug)]
pub struct Limits(Vec<Limit>);

#[derive(Clone, Debug)]
struct Limit {
    name: String,
    sense: Sense,
    score: Score,
    value: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    AtLeast,
    AtMost,
}

#[derive(Clone, Copy, Debug)]
enum Score {
    BothHit,
    ContactLeak,
    Band(fn(&BandScore) -> Option<f64>, u8),
    Soft(fn(&SoftScore) -> Option<f64>),
}

impl Limits {
    /// Reads the limits of a scene from a file.
    pub fn load(path: &Path, scene: &str) -> Result<Self, TruthError> {
        let failed = |reason: String| TruthError::Limits { path: path.to_owned(), reason };
        let text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
        Self::parse(&text, scene).map_err(failed)
    }

    fn parse(text: &str, scene: &str) -> Result<Self, String> {
        let value: serde_json::Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let entry = value.get(scene).ok_or_else(|| format!("there are no limits for scene `{scene}`"))?;
        let entry = entry.as_object().ok_or_else(|| format!("the limits of `{scene}` are no object"))?;
        let mut limits = Vec::new();
        for (name, value) in entry {
            let (sense, score) = meaning(name).ok_or_else(|| format!("the limit `{name}` is not known"))?;
            let value = value.as_f64().ok_or_else(|| format!("the limit `{name}` is no number"))?;
            limits.push(Limit { name: name.clone(), sense, score, value });
        }
        if limits.is_empty() {
            return Err(format!("the limits of `{scene}` are empty"));
        }
        limits.sort_by(|left, right| left.name.cmp(&right.name));
        Ok(Self(limits))
    }
}

fn meaning(name: &str) -> Option<(Sense, Score)> {
    let (sense, score) = match name.split_once('_')? {
        ("min", score) => (Sense::AtLeast, score),
        ("max", score) => (Sense::AtMost, score),
        _ => return None,
    };
    let (score, band) = match score.split_once("_k") {
        Some((score, band)) => (score, Some(band.parse().ok().filter(|band| [1, 2, 4].contains(band))?)),
        None => (score, None),
    };
    let score = match (sense, score, band) {
        (Sense::AtLeast, "both_hit", None) => Score::BothHit,
        (Sense::AtMost, "contact_leak", None) => Score::ContactLeak,
        (Sense::AtLeast, "iou", band) => Score::Band(BandScore::intersection_over_union, band.unwrap_or(0)),
        (Sense::AtLeast, "precision", Some(band)) => Score::Band(BandScore::precision, band),
        (Sense::AtLeast, "recall", Some(band)) => Score::Band(BandScore::recall, band),
        (Sense::AtMost, "leak", Some(band)) => Score::Band(BandScore::leak, band),
        (Sense::AtMost, "acne", Some(band)) => Score::Band(BandScore::acne, band),
        (Sense::AtMost, "mae", None) => Score::Soft(|soft| Some(soft.mean_error)),
        (Sense::AtMost, "mae_penumbra", None) => Score::Soft(|soft| soft.in_penumbra),
        (Sense::AtMost, "mae_outside_penumbra", None) => Score::Soft(|soft| soft.outside_penumbra),
        (Sense::AtMost, "abs_bias", None) => Score::Soft(|soft| Some(soft.bias.abs())),
        _ => return None,
    };
    Some((sense, score))
}

impl Limit {
    fn measured(&self, scores: &Scores) -> Option<f64> {
        match self.score {
            Score::BothHit => scores.both_hit,
            Score::ContactLeak => scores.contact_leak(),
            Score::Band(score, band) => scores.band(band).and_then(score),
            Score::Soft(score) => scores.soft.as_ref().and_then(score),
        }
    }

    fn is_met(&self, measured: Option<f64>) -> bool {
        measured.is_some_and(|measured| match self.sense {
            Sense::AtLeast => measured >= self.value,
            Sense::AtMost => measured <= self.value,
        })
    }
}

/// Compares scores with limits. On failure, returns a message with every broken limit and its measured value.
pub fn check(scores: &Scores, limits: &Limits) -> Result<(), String> {
    let mut broken = String::new();
    for limit in &limits.0 {
        let measured = limit.measured(scores);
        if !limit.is_met(measured) {
            let measured = measured.map_or_else(|| "nothing".to_owned(), |value| format!("{value:.6}"));
            let _ = write!(broken, "\n  {} {} measured {measured}", limit.name, limit.value);
        }
    }
    if broken.is_empty() {
        return Ok(());
    }
    let hint =
        scores.alignment_hint.map(|hint| format!("\n  hint: the picture looks {hint}")).unwrap_or_default();
    Err(format!("limits that are not met:{broken}{hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channels, Picture};
    use crate::truth::evaluate;
    use crate::truth::scene::half_shadowed;

    fn scores(grey: u8) -> Scores {
        evaluate(&half_shadowed(), &Picture::filled(8, 8, Channels::Grey, &[grey])).unwrap()
    }

    fn limits(entries: &str) -> Result<Limits, String> {
        Limits::parse(&format!(r#"{{"half": {{{entries}}}}}"#), "half")
    }

    #[test]
    fn every_broken_limit_is_listed_with_its_measure() {
        let limits =
            limits(r#""min_iou": 0.5, "max_leak_k2": 0.004, "max_acne_k1": 0.001, "min_both_hit": 0.9"#);
        let message = check(&scores(255), &limits.unwrap()).unwrap_err();
        assert!(message.contains("min_iou 0.5 measured 0.000000"), "{message}");
        assert!(message.contains("max_leak_k2 0.004 measured 1.000000"), "{message}");
        assert!(!message.contains("acne") && !message.contains("both_hit"), "{message}");
    }

    #[test]
    fn a_limit_is_met_by_exactly_its_value() {
        assert!(check(&scores(0), &limits(r#""min_iou": 0.5"#).unwrap()).is_ok());
        assert!(check(&scores(0), &limits(r#""min_iou": 0.500001"#).unwrap()).is_err());
        assert!(check(&scores(255), &limits(r#""max_leak_k1": 1"#).unwrap()).is_ok());
    }

    #[test]
    fn a_score_that_does_not_exist_meets_no_limit() {
        let limits = limits(r#""min_precision_k2": 0"#).unwrap();
        let message = check(&scores(255), &limits).unwrap_err();
        assert!(message.contains("measured nothing"), "{message}");
    }

    #[test]
    fn each_name_means_its_own_score() {
        for (name, grey, met) in [
            ("min_recall_k1\": 0.9", 0, true),
            ("min_recall_k1\": 0.9", 255, false),
            ("min_precision_k2\": 0.6", 0, false),
            ("max_acne_k4\": 0.5", 0, false),
            ("max_acne_k4\": 0.5", 255, true),
            ("max_contact_leak\": 0.5", 0, true),
            ("max_contact_leak\": 0.5", 255, false),
            // Of eight rows three are 1 off, one 0.8, one 0.2, and three right: (3 + 0.8 + 0.2) / 8 = 0.5.
            ("max_mae\": 0.501", 255, true),
            ("max_mae\": 0.499", 255, false),
            ("max_mae_penumbra\": 0.49", 0, false),
            ("max_mae_outside_penumbra\": 0.5", 0, true),
            ("max_abs_bias\": 0.4", 0, false),
        ] {
            let limits = limits(&format!("\"{name}")).unwrap();
            assert_eq!(check(&scores(grey), &limits).is_ok(), met, "{name} at {grey}");
        }
    }

    #[test]
    fn limits_that_are_not_understood_are_errors() {
        for wrong in [
            r#""min_beauty": 1"#,
            r#""max_iou": 1"#,
            r#""min_iou_k3": 1"#,
            r#""max_leak": 1"#,
            r#""min_iou": "high""#,
            "",
        ] {
            assert!(limits(wrong).is_err(), "{wrong}");
        }
        assert!(Limits::parse("{}", "half").unwrap_err().contains("`half`"));
        assert!(Limits::parse("{", "half").is_err());
    }
}
