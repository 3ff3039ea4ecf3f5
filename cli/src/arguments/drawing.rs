//! The command line of `render`, and the frames of a scene ([`Film`]) for what else draws.

use std::path::PathBuf;

use clap::Args;

use super::{AnswerFormat, Choices};
use crate::render::capture::CaptureArgument;
use umbragraph::low_level::camera_path::CameraArgument;
use umbragraph::low_level::import::ImportArgument;

/// The option that selects the graphics adapter.
#[derive(Args)]
pub(crate) struct Drawn {
    /// Uses the adapter whose name or backend contains this text; `umbragraph adapters` lists them. By default,
    /// WGPU_ADAPTER_NAME, WGPU_BACKEND and WGPU_POWER_PREF select the adapter, or else the best one is taken.
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

#[derive(Args)]
pub(crate) struct AdaptersArguments {
    /// The format of the list: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
}

#[derive(Args)]
pub(crate) struct RenderArguments {
    /// The pipeline file.
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// An equirectangular picture (.hdr or .exr) as light and background. Switches the pipeline's feature "environment"
    /// on.
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Fills an imported texture that passes only read, such as a table of colors, with a PNG or JPEG, or a float
    /// format with an .exr or .hdr.
    #[arg(long = "import", value_name = "NAME=FILE", value_parser = ImportArgument::parse)]
    pub(crate) imports: Vec<ImportArgument>,
    /// The picture to write: a .png, or an .exr with unconverted numbers. For several frames: a .png with # in place of
    /// the frame number, an .apng or a .gif.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Renders this number of frames; history resources keep their content between frames, and the scene's animations
    /// play.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,
    #[command(flatten)]
    pub(crate) film: Film,
    /// Writes the content of a texture after the last frame to a .png, or as numbers to an .exr; of a buffer, as its
    /// shader declares it, to a .json or .csv. @PASS selects the version that the pass wrote; a mip level, a layer and
    /// a face select a part.
    #[arg(long, value_name = "RESOURCE[@PASS][:MIP,LAYER,FACE]=FILE", value_parser = CaptureArgument::parse)]
    pub(crate) capture: Vec<CaptureArgument>,
    /// Writes the content of every texture and buffer after the last frame to a folder, which is made if it does not
    /// exist.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) capture_all: Option<PathBuf>,
    /// Writes an HTML page about the run into a folder, for a bug report, also if the run fails. It shows the frame,
    /// the graph, inputs and outputs of every pass, times, memory, diagnostics and parameters.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) report: Option<PathBuf>,
    /// Prints the CPU and GPU time of each pass: the mean of all frames but the first.
    #[arg(long)]
    pub(crate) timings: bool,
    /// Writes the CPU and GPU times of each pass in each frame as a trace for ui.perfetto.dev.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) trace: Option<PathBuf>,
    /// Compresses PNG files less, in a fraction of the time.
    #[arg(long)]
    pub(crate) fast: bool,
    /// Sets a toggle; without a value it is switched on. @FRAME delays the change to that frame, counted from 0.
    /// Toggles never change the plan.
    #[arg(long = "toggle", value_name = "NAME[=on|off][@FRAME]", value_parser = ToggleArgument::parse)]
    pub(crate) toggles: Vec<ToggleArgument>,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

impl RenderArguments {
    /// Says which toggle would first change behind the last frame; `None` if all change before.
    pub(crate) fn toggle_beyond(&self) -> Option<String> {
        let frames = self.frames.unwrap_or(1);
        let toggle = self.toggles.iter().find(|toggle| toggle.since >= frames)?;
        let ToggleArgument { name, since, .. } = toggle;
        let drawn = match frames {
            1 => "1 frame is drawn, frame 0".to_owned(),
            _ => format!("{frames} frames are drawn, 0 to {}", frames - 1),
        };
        let wanted = u64::from(*since) + 1;
        Some(format!(
            "--toggle {name}@{since} lies beyond the last frame: {drawn}; draw --frames {wanted} or more, or change it at once: @0"
        ))
    }
}

/// The times and the camera of the frames of a scene.
#[derive(Args)]
pub(crate) struct Film {
    /// The number of frames per second.
    #[arg(long, value_name = "F", default_value_t = 30.0, value_parser = parse_rate)]
    pub(crate) fps: f64,
    /// The animation time of the first frame, in seconds.
    #[arg(long, alias = "time", value_name = "SECONDS", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_seconds)]
    pub(crate) at: f64,
    /// The path of the camera: orbit, walk, random (a new place in every frame; random:SEED), or a JSON file with key
    /// frames: { "keys": [ { "time": 0, "position": [0, 2, 8], "target": [0, 1, 0] } ] }, in seconds and metres. The
    /// default is the scene's own camera.
    #[arg(long, value_name = "orbit|walk|random|FILE", value_parser = CameraArgument::parse)]
    pub(crate) camera: Option<CameraArgument>,
}

/// The time of one frame of a sequence.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    pub(crate) index: u32,
    /// The animation time in seconds.
    pub(crate) time: f64,
    /// The position on the camera path, as a fraction of its length from 0 to 1.
    pub(crate) part: f64,
}

impl Film {
    /// Returns the given number of frames, beginning with frame 0.
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

/// The state of a toggle, and the first frame at which it holds.
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
