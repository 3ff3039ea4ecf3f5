//! Limits on scores, for CI.
//!
//! A JSON object with names and numbers, for all lights together. A name gives the direction (minimum or maximum) and
//! the score:
//!
//! | limit | score |
//! |---|---|
//! | `min_iou`, `min_iou_k1`, `_k2`, `_k4` | intersection over union, of all pixels or of a band |
//! | `max_leak`, `max_acne`, with `_k1`, `_k2`, `_k4` | leak, acne |
//! | `max_contact_leak` | leak where something very near casts the shadow |
//! | `max_mean_error`, `max_penumbra_error`, `max_bias` | errors against lights with an extent |
//! | `max_changed` | points whose shadow term changes from frame to frame, of those that are seen twice |
//! | `min_both_hit` | pixels that rays and picture hit, of those that rays hit |
//!
//! A score that does not exist meets no limit, and an unknown name is an error: a limit that is silently unchecked is
//! worse than none.

use std::collections::BTreeMap;
use std::marker::PhantomData;

use crate::scores::{BANDS, Counts, Scores, ratio};

/// Scores on which limits can be set.
pub trait Limited: Default {
    /// The names of all possible limits. One that begins with `min_` is a minimum, any other a maximum.
    fn limits() -> Vec<String>;

    /// The score to which a limit of this name applies: `None` for an unknown name, `Some(None)` for a score that does
    /// not exist.
    fn limited(&self, name: &str) -> Option<Option<f64>>;
}

/// Limits on scores of one kind, by name, such as `min_iou` or `max_leak_k2`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits<S = Scores>(BTreeMap<String, f64>, PhantomData<S>);

/// A limit that is not met.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The name of the limit, such as `min_iou`.
    pub name: String,
    /// The value of the limit.
    pub limit: f64,
    /// The measured score; `None` if the score does not exist.
    pub measured: Option<f64>,
}

impl<S: Limited> Limits<S> {
    /// Creates limits from names and values.
    ///
    /// # Errors
    /// Returns the first name that does not belong to a score.
    pub fn new(values: BTreeMap<String, f64>) -> Result<Self, String> {
        match values.keys().find(|name| S::default().limited(name).is_none()) {
            Some(unknown) => Err(unknown.clone()),
            None => Ok(Self(values, PhantomData)),
        }
    }

    /// The limits that scores do not meet.
    pub fn broken(&self, scores: &S) -> Vec<Broken> {
        let broken = self.0.iter().filter_map(|(name, limit)| {
            let measured = scores.limited(name)?;
            let met = measured.is_some_and(|measured| {
                if name.starts_with("min_") { measured >= *limit } else { measured <= *limit }
            });
            (!met).then(|| Broken { name: name.clone(), limit: *limit, measured })
        });
        broken.collect()
    }
}

impl Limited for Scores {
    fn limits() -> Vec<String> {
        let banded = ["min_iou", "max_leak", "max_acne"].iter().flat_map(|name| {
            BANDS.map(|band| if band == 0 { (*name).to_owned() } else { format!("{name}_k{band}") })
        });
        let errors = ["max_mean_error", "max_penumbra_error", "max_bias"];
        let others = ["min_both_hit", "max_changed", "max_contact_leak"].into_iter().chain(errors);
        banded.chain(others.map(str::to_owned)).collect()
    }

    fn limited(&self, name: &str) -> Option<Option<f64>> {
        let (plain, band) = match name.split_once("_k") {
            Some((plain, band)) => {
                (plain, band.parse().ok().filter(|band| *band != 0 && BANDS.contains(band))?)
            }
            None => (name, 0),
        };
        let banded: Option<fn(&Counts) -> Option<f64>> = match plain {
            "min_iou" => Some(Counts::iou),
            "max_leak" => Some(Counts::leak),
            "max_acne" => Some(Counts::acne),
            _ => None,
        };
        match (banded, name) {
            (Some(score), _) => Some(score(&self.band(band))),
            (None, "min_both_hit") => Some(ratio(self.hit_in_both, self.hit)),
            (None, "max_changed") => Some(self.changes.share()),
            (None, "max_contact_leak") => Some(self.contact.leak()),
            (None, "max_mean_error") => Some(self.mean_error.mean()),
            (None, "max_penumbra_error") => Some(self.penumbra_error.mean()),
            (None, "max_bias") => Some(self.bias.mean().map(f64::abs)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_says_a_score_and_others_are_rejected() {
        for name in Scores::limits() {
            assert!(Limits::<Scores>::new([(name.clone(), 0.5)].into()).is_ok(), "{name}");
        }
        for unknown in ["min_leak", "max_iou", "min_iou_k3", "min_iou_k0", "max_contact_leak_k2", "iou", ""] {
            assert_eq!(Limits::<Scores>::new([(unknown.to_owned(), 0.5)].into()), Err(unknown.to_owned()));
        }
    }

    #[test]
    fn limits_are_met_up_to_their_value_and_not_by_no_score() {
        let counts = Counts { shadowed_in_both: 3, leaking: 1, acne: 0, lit_in_both: 4 };
        let scores = Scores { bands: [(0, counts)].into(), ..Scores::default() };
        let limits = |name: &str, value| Limits::<Scores>::new([(name.to_owned(), value)].into()).unwrap();
        assert!(limits("min_iou", 0.75).broken(&scores).is_empty());
        let broken = limits("min_iou", 0.76).broken(&scores);
        assert_eq!((broken[0].limit, broken[0].measured), (0.76, Some(0.75)));
        assert!(limits("max_leak", 0.25).broken(&scores).is_empty());
        assert_eq!(limits("max_leak", 0.24).broken(&scores).len(), 1);
        assert_eq!(limits("max_contact_leak", 1.0).broken(&scores)[0].measured, None);
    }
}
