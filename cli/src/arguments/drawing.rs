//! The command line of `render`, and the frames of a scene ([`Film`]) for what else draws.

use std::path::PathBuf;

use clap::Args;

use super::{AnswerFormat, Choices};
use crate::render::capture::CaptureArgument;
use umbragraph::low_level::camera_path::CameraArgument;

/// The adapter that draws.
#[derive(Args)]
pub(crate) struct Drawn {
    /// Draws with the adapter whose name or backend contains this; `umbragraph adapters` lists them. Without it
    /// WGPU_ADAPTER_NAME, WGPU_BACKEND and WGPU_POWER_PREF choose, or else the best is taken.
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

#[derive(Args)]
pub(crate) struct AdaptersArguments {
    /// The form of the list: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
}

#[derive(Args)]
pub(crate) struct RenderArguments {
    /// The pipeline.
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// An equirectangular picture, .hdr or .exr, as light and background: switches the pipeline's feature "environment"
    /// on.
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// The picture to write: a .png, or an .exr with the numbers of the target; for several frames a .png with # in
    /// place of the number, an .apng or a .gif.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Renders so many frames, in which what earlier ones left lives on; the scene's animations play.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,
    #[command(flatten)]
    pub(crate) film: Film,
    /// Writes what a texture holds after the last frame (with @PASS the version that the pass wrote, with a mip level,
    /// a layer and a face those alone) to a .png, or as numbers to an .exr.
    #[arg(long, value_name = "RESOURCE[@PASS][:MIP,LAYER,FACE]=FILE", value_parser = CaptureArgument::parse)]
    pub(crate) capture: Vec<CaptureArgument>,
    /// Writes what every texture holds after the last frame to a folder.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) capture_all: Option<PathBuf>,
    /// Writes a page of the run into a folder, to be attached to a bug report: frame, graph, what every pass reads and
    /// writes, times, memory, diagnostics, parameters.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) report: Option<PathBuf>,
    /// Prints how long the processor and the GPU work on each pass: the mean of all frames but the first.
    #[arg(long)]
    pub(crate) timings: bool,
    /// Writes when the processor and the GPU work on each pass of each frame, as a trace for ui.perfetto.dev.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) trace: Option<PathBuf>,
    /// Compresses PNG files less, in a fraction of the time.
    #[arg(long)]
    pub(crate) fast: bool,
    /// Switches a toggle; without a value it is switched on. With @FRAME from that frame on, counted from 0. Toggles
    /// change nothing about the plan.
    #[arg(long = "toggle", value_name = "NAME[=on|off][@FRAME]", value_parser = ToggleArgument::parse)]
    pub(crate) toggles: Vec<ToggleArgument>,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

/// When the frames of a scene are, and from where they are seen.
#[derive(Args)]
pub(crate) struct Film {
    /// Frames a second.
    #[arg(long, value_name = "F", default_value_t = 30.0, value_parser = parse_rate)]
    pub(crate) fps: f64,
    /// Seconds since the start of the scene's animations, of the first frame.
    #[arg(long, alias = "time", value_name = "SECONDS", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_seconds)]
    pub(crate) at: f64,
    /// The path of the camera: orbit, walk, random (elsewhere in every frame; random:SEED), or a file with its keys.
    /// Without it the scene's own camera.
    #[arg(long, value_name = "orbit|walk|random|FILE", value_parser = CameraArgument::parse)]
    pub(crate) camera: Option<CameraArgument>,
}

/// A frame of several.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    pub(crate) index: u32,
    /// Seconds.
    pub(crate) time: f64,
    /// The fraction of the whole path that lies behind it.
    pub(crate) part: f64,
}

impl Film {
    /// The first frames.
    pub(crate) fn shots(&self, frames: u32) -> impl Iterator<Item = Shot> + use<> {
        let (at, fps) = (self.at, self.fps);
        (0..frames).map(move |index| {
            let part = f64::from(index) / f64::from(frames);
            Shot { index, time: at + f64::from(index) / fps, part }
        })
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() => Ok(seconds),
        _ => Err(format!("\"{text}\" is no number of seconds")),
    }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (0.001..=1000.0).contains(&rate) => Ok(rate),
        _ => Err(format!("\"{text}\" is no number of frames a second between 0.001 and 1000")),
    }
}

/// The state of a toggle from a frame on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ToggleArgument {
    pub(crate) name: String,
    pub(crate) on: bool,
    pub(crate) since: u32,
}

impl ToggleArgument {
    fn parse(text: &str) -> Result<Self, String> {
        let (state, since) = match text.rsplit_once('@') {
            Some((state, frame)) => {
                (state, frame.parse().map_err(|_| format!("\"{frame}\" is no number of a frame"))?)
            }
            None => (text, 0),
        };
        let (name, state) = state.split_once('=').unwrap_or((state, "on"));
        let on = match state {
            "on" | "true" => true,
            "off" | "false" => false,
            _ => return Err(format!("a toggle is on or off, not \"{state}\"")),
        };
        Ok(Self { name: name.to_owned(), on, since })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toggles_have_a_state_from_a_frame_on() {
        let parse = |text: &str| ToggleArgument::parse(text);
        let toggle = |on, since| Ok(ToggleArgument { name: "rain".to_owned(), on, since });
        assert_eq!(parse("rain"), toggle(true, 0));
        assert_eq!(parse("rain=off"), toggle(false, 0));
        assert_eq!(parse("rain=off@3"), toggle(false, 3));
        assert_eq!(parse("rain@2"), toggle(true, 2));
        assert!(parse("rain=wet").is_err() && parse("rain=on@soon").is_err());
    }
}
