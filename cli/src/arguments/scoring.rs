//! The command lines of `score` and `tune`, which draw a film and hold it against rays.

use std::path::PathBuf;

use clap::Args;

use super::drawing::{Drawn, Film, Shot};
use super::{AnswerFormat, CacheArguments, Choices};
use crate::tune::space::Over;

/// The frames, times and cameras at which a scene is scored.
#[derive(Args)]
pub(crate) struct Shots {
    /// Scores this number of consecutive frames; the scene's animations play. With several, `score` also counts points
    /// whose shadow term changes between frames although ray tracing gives the same result.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    #[command(flatten)]
    pub(crate) film: Film,
}

impl Shots {
    /// Returns all frames to score.
    pub(crate) fn all(&self) -> impl Iterator<Item = Shot> + use<> {
        self.film.shots(self.frames)
    }
}

#[derive(Args)]
pub(crate) struct TuneArguments {
    /// The pipeline file. Its shadow term is the output with the parameter "debug_view" set to "shadow_term".
    pub(crate) pipeline: PathBuf,
    /// The glTF scenes (.gltf or .glb); all have the same weight.
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) scene: Vec<PathBuf>,
    /// The parameters to search, within their declared ranges or narrower ones: numbers, lists of numbers, booleans.
    #[arg(long, value_name = "NAME[=MIN..MAX]", required = true, value_delimiter = ',', value_parser = Over::parse)]
    pub(crate) over: Vec<Over>,
    /// The parameter file to write: the values of the command line, overridden by the values found.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) out: PathBuf,
    /// The number of sets of values to try.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) budget: u32,
    /// The seed of the search: the same seed finds the same values.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// The score to improve: iou, the intersection over union of hard shadow masks, or mean-error, against area lights.
    #[arg(long = "score", value_enum, value_name = "NAME", default_value_t)]
    pub(crate) measure: Measure,
    #[command(flatten)]
    pub(crate) shots: Shots,
    /// The format of the results: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

/// The score that a search improves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Measure {
    /// Intersection over union of shadowed pixels, to be maximized.
    #[default]
    Iou,
    /// The mean absolute error of the shadow term against the visible part of lights, to be minimized.
    MeanError,
}

#[derive(Args)]
pub(crate) struct ScoreArguments {
    /// The pipeline file. Its shadow term is the output with the parameter "debug_view" set to "shadow_term".
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) shots: Shots,
    /// Writes a picture of the errors in the last frame, one light below the other: red is light leaking, blue is
    /// shadow acne.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: Option<PathBuf>,
    /// A file of limits on the scores of all lights together; exits with 1 if a limit is not met.
    #[arg(long, value_name = "FILE")]
    pub(crate) limits: Option<PathBuf>,
    /// The format of the scores: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) cache: CacheArguments,
    #[command(flatten)]
    pub(crate) choices: Choices,
}
