//! The command lines of `score` and `tune`, which draw a film and hold it against rays.

use std::path::PathBuf;

use clap::Args;

use super::drawing::{Drawn, Film, Shot};
use super::{AnswerFormat, CacheArguments, Choices};
use crate::tune::space::Over;

/// From where and when a scene is scored.
#[derive(Args)]
pub(crate) struct Shots {
    /// Scores so many frames, which are drawn one after the other; the scene's animations play. Of several, `score`
    /// says how many points that two in a row see have another shadow term, though rays say the same.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    #[command(flatten)]
    pub(crate) film: Film,
}

impl Shots {
    /// All of them.
    pub(crate) fn all(&self) -> impl Iterator<Item = Shot> + use<> {
        self.film.shots(self.frames)
    }
}

#[derive(Args)]
pub(crate) struct TuneArguments {
    /// The pipeline; its shadow term is what it makes where the parameter "debug_view" is "shadow_term".
    pub(crate) pipeline: PathBuf,
    /// The glTF scenes (.gltf or .glb); all count alike.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) scene: Vec<PathBuf>,
    /// The parameters whose values are searched, within their ranges or narrower ones: numbers, lists of them,
    /// booleans.
    #[arg(long, value_name = "NAME[=MIN..MAX]", required = true, value_delimiter = ',', value_parser = Over::parse)]
    pub(crate) over: Vec<Over>,
    /// The parameter file that is written: the values of the command line, and over them those that were found.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: PathBuf,
    /// The number of sets of values to try.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) budget: u32,
    /// The seed of the search: the same seed finds the same values.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// The score to improve: iou, the intersection over union of hard masks, or mean-error, against lights with an
    /// extent.
    #[arg(long = "score", value_enum, value_name = "NAME", default_value_t)]
    pub(crate) measure: Measure,
    #[command(flatten)]
    pub(crate) shots: Shots,
    /// The form of what is said of the search: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

/// A score that is made better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Measure {
    /// Intersection over union of shadowed pixels.
    #[default]
    Iou,
    /// The mean error of grey against the visible part of lights.
    MeanError,
}

#[derive(Args)]
pub(crate) struct ScoreArguments {
    /// The pipeline; its shadow term is what it makes where the parameter "debug_view" is "shadow_term".
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) shots: Shots,
    /// Writes where and how the last frame differs, one light below the other: red leaks, blue is acne.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: Option<PathBuf>,
    /// Limits on the scores of all lights together; exits with 1 if one is not met.
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// The form of the scores: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) cache: CacheArguments,
    #[command(flatten)]
    pub(crate) choices: Choices,
}
