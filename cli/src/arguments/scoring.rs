//! The command lines of `score` and `tune`, which draw a film and hold it against rays.

use std::path::PathBuf;

use clap::Args;
use umbragraph::diagnostic::{Diagnostic, Place};
use umbragraph_score::color::{Ambient, PixelArea, Settings};

use super::drawing::{Drawn, Film, Shot};
use super::{AnswerFormat, CacheArguments, Choices};
use crate::codes;
use crate::tune::space::Over;

/// The part of a picture that is scored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Of {
    /// The shadows of each light, against rays to it.
    #[default]
    Shadows,
    /// The colors of the whole picture, against traced paths.
    Color,
}

/// The ambient light of traced paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum AmbientArgument {
    /// Other surfaces stand in the way of the sky's light.
    Occluded,
    /// The sky's light arrives everywhere, times the occlusion map.
    Open,
}

/// The part of a pixel that traced paths begin at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PixelArgument {
    /// The middle alone.
    Middle,
    /// The whole pixel.
    Whole,
}

/// The options of scores of colors.
#[derive(Args)]
pub(crate) struct ColorArguments {
    /// The part of the picture that is scored: shadows or color.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) of: Of,
    /// The number of paths for each pixel. The default is 64. Only with --of color, as the next five.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) samples: Option<u32>,
    /// The number of surfaces that pass light on to the one that the camera sees. The default is 0: the lights and the
    /// sky alone.
    #[arg(long, value_name = "B", value_parser = clap::value_parser!(u32).range(..=64))]
    pub(crate) bounces: Option<u32>,
    /// The light of the sky: occluded by other surfaces (the default), or open, as a pipeline without ambient occlusion
    /// computes it.
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) ambient: Option<AmbientArgument>,
    /// The part of a pixel that is traced: its middle (the default), or the whole, as with several samples.
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) pixel: Option<PixelArgument>,
    /// An equirectangular picture (.hdr or .exr) as light and background. Switches the pipeline's feature "environment"
    /// on.
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Compares a texture of linear colors instead of the picture, such as the one before effects and tone mapping.
    /// @PASS selects the version that the pass wrote.
    #[arg(long, value_name = "NAME[@PASS]")]
    pub(crate) resource: Option<String>,
}

impl ColorArguments {
    /// The settings of the tracer.
    ///
    /// # Errors
    /// Bounces of light in a scene whose surfaces occlude none.
    pub(crate) fn settings(&self, seed: u64) -> Result<Settings, Diagnostic> {
        let bounces = self.bounces.unwrap_or(0);
        let ambient = match self.ambient {
            Some(AmbientArgument::Open) => Ambient::Open,
            _ => Ambient::Occluded,
        };
        if bounces > 0 && ambient == Ambient::Open {
            let message =
                format!("--bounces {bounces} needs surfaces in the way of light, --ambient open has none");
            return Err(Diagnostic::error(codes::SCORE, Place::Nowhere, message)
                .help("leave out --ambient open, or --bounces"));
        }
        let area = match self.pixel {
            Some(PixelArgument::Whole) => PixelArea::Whole,
            _ => PixelArea::Middle,
        };
        Ok(Settings { samples: self.samples.unwrap_or(64), bounces, seed, ambient, area })
    }

    /// Checks that no option of colors is given for scores of shadows.
    ///
    /// # Errors
    /// The first such option.
    pub(crate) fn unused(&self, has_seed: bool) -> Result<(), Diagnostic> {
        let given = [
            (self.samples.is_some(), "--samples"),
            (self.bounces.is_some(), "--bounces"),
            (self.ambient.is_some(), "--ambient"),
            (self.pixel.is_some(), "--pixel"),
            (self.environment.is_some(), "--environment"),
            (self.resource.is_some(), "--resource"),
            (has_seed, "--seed"),
        ];
        match given.iter().find(|(is_given, _)| *is_given) {
            None => Ok(()),
            Some((_, name)) => {
                let message = format!("{name} is an option of colors, and shadows are scored");
                Err(Diagnostic::error(codes::SCORE, Place::Nowhere, message)
                    .help(format!("add --of color, or leave out {name}")))
            }
        }
    }
}

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
    /// The score to improve. Of shadows: iou, the intersection over union of hard masks (the default), or mean-error,
    /// against area lights. Of color: mean-error (the default) or flip.
    #[arg(long = "score", value_enum, value_name = "NAME")]
    pub(crate) measure: Option<Measure>,
    #[command(flatten)]
    pub(crate) colors: ColorArguments,
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

impl TuneArguments {
    /// The score that the search improves.
    ///
    /// # Errors
    /// A score that what is scored does not have, and options of colors for shadows.
    pub(crate) fn measure(&self) -> Result<Measure, Diagnostic> {
        let wrong = |message: &str, help: &str| {
            Err(Diagnostic::error(codes::TUNE, Place::Nowhere, message).help(help))
        };
        match (self.colors.of, self.measure) {
            (Of::Shadows, measure) => {
                self.colors.unused(false)?;
                match measure.unwrap_or(Measure::Iou) {
                    Measure::Flip => {
                        wrong("shadows have no score \"flip\"", "choose iou or mean-error, or --of color")
                    }
                    measure => Ok(measure),
                }
            }
            (Of::Color, Some(Measure::Iou)) => {
                wrong("colors have no score \"iou\"", "choose mean-error or flip, or leave out --of color")
            }
            (Of::Color, measure) => Ok(measure.unwrap_or(Measure::MeanError)),
        }
    }
}

/// The score that a search improves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Measure {
    /// Intersection over union of shadowed pixels, to be maximized.
    Iou,
    /// The mean absolute error, to be minimized: of the shadow term against the visible part of lights, or of colors.
    MeanError,
    /// The mean of FLIP over the picture, to be minimized.
    Flip,
}

#[derive(Args)]
pub(crate) struct ScoreArguments {
    /// The pipeline file. Its shadow term is the output with the parameter "debug_view" set to "shadow_term"; its colors
    /// are the picture.
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) colors: ColorArguments,
    /// The seed of traced paths (1 by default): the same seed gives the same reference. Only with --of color.
    #[arg(long, value_name = "S")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) shots: Shots,
    /// Writes a picture of the errors in the last frame. Of shadows, one light below the other: red is light leaking,
    /// blue is shadow acne. Of color, side by side: rendered, traced, and FLIP.
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
