//! The command line of the viewer.

use std::path::{Path, PathBuf};

use clap::Parser;
use serde_json::Value;
use umbragraph::low_level::camera_path::CameraArgument;
use umbragraph::low_level::import::ImportArgument;

/// Shows the live frame of a pipeline on a scene, and updates it when the files change.
#[derive(Parser, Clone, Debug)]
#[command(name = "umbragraph-view", version)]
pub(crate) struct Arguments {
    /// The pipeline: a file, or a bundled pipeline such as umbragraph:umbra.json.
    pub(crate) pipeline: PathBuf,
    /// The scene: a .glb or .gltf file.
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// An equirectangular picture (.hdr or .exr) as light and background. Switches the pipeline's feature "environment"
    /// on.
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,
    /// Fills an imported texture that passes only read, such as a table of colors, with a PNG or JPEG, or a float
    /// format with an .exr or .hdr. The file is read again when it changes.
    #[arg(long = "import", value_name = "NAME=FILE", value_parser = ImportArgument::parse)]
    pub(crate) imports: Vec<ImportArgument>,
    /// Uses the adapter whose name or backend contains this text; `umbragraph adapters` lists them. By default,
    /// WGPU_ADAPTER_NAME, WGPU_BACKEND and WGPU_POWER_PREF select the adapter, or else the best one is taken.
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// A folder with shader templates that replace or extend the bundled ones.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) templates: Option<PathBuf>,
    /// A further folder whose files the pipeline may reference.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) root: Vec<PathBuf>,
    /// Sets a parameter to a value: JSON, a word of an enumeration, or on or off for a boolean.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    pub(crate) set: Vec<(String, Value)>,
    /// Sets a feature to a value; without a value, the feature is switched on.
    #[arg(long = "feature", value_name = "NAME[=VALUE]", value_parser = feature)]
    pub(crate) feature: Vec<(String, Value)>,
    /// Switches a toggle on or off; without a value, it is switched on.
    #[arg(long = "toggle", value_name = "NAME[=on|off]", value_parser = toggle)]
    pub(crate) toggle: Vec<(String, bool)>,
    /// Applies the values of one of the pipeline's presets.
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<String>,
    /// Applies a parameter file on top of the preset, and again when the file changes. Later files take priority.
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Vec<PathBuf>,
    /// Moves the camera along a path, once in 10 s, until it is moved by hand. FILE is a camera path as for `umbragraph
    /// render --camera FILE`: the view begins at its first key, and all keys become bookmarks.
    #[arg(long, value_name = "orbit|walk|random|FILE", value_parser = CameraArgument::parse)]
    pub(crate) camera: Option<CameraArgument>,
    /// The texels of the frame per pixel of the window along each side, from 0.1 to 1. By default, the resolution
    /// adapts to the speed of the device.
    #[arg(long, value_name = "NUMBER", value_parser = scale)]
    pub(crate) scale: Option<f32>,
    /// The command that opens a source location in an editor, such as 'code -g {file}:{line}'.
    #[arg(long, value_name = "COMMAND", default_value = "code -g {file}:{line}")]
    pub(crate) editor: String,
    /// The width and height of the window, in points.
    #[arg(long, value_name = "WxH", default_value = "1440x860", value_parser = size)]
    pub(crate) window: [u32; 2],
    /// The folder for screenshots, clips, parameter files and camera paths.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    pub(crate) out: PathBuf,
    /// Writes the state of the window to a new file as a line of JSON whenever the state changes, for tests.
    #[arg(long, value_name = "FILE")]
    pub(crate) log_state: Option<PathBuf>,
}

/// Returns `true` if a path names a bundled pipeline (`umbragraph:…`).
pub(crate) fn is_bundled(path: &Path) -> bool {
    path.to_string_lossy().starts_with("umbragraph:")
}

/// Parses a value of the command line as JSON, or else as a string.
pub(crate) fn value(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))
}

fn setting(text: &str) -> Result<(String, Value), String> {
    let (name, text) = text.split_once('=').ok_or("write NAME=VALUE, such as exposure=1.5")?;
    Ok((name.to_owned(), value(text)))
}

fn feature(text: &str) -> Result<(String, Value), String> {
    let (name, text) = text.split_once('=').unwrap_or((text, "true"));
    let value = match text {
        "on" => Value::Bool(true),
        "off" => Value::Bool(false),
        text => value(text),
    };
    Ok((name.to_owned(), value))
}

fn toggle(text: &str) -> Result<(String, bool), String> {
    let (name, on) = feature(text)?;
    let on = on.as_bool().ok_or("a toggle is on or off")?;
    Ok((name, on))
}

fn scale(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number| (0.1..=1.0).contains(number));
    number.ok_or_else(|| "a number from 0.1 to 1".to_owned())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let sides = sides.filter(|sides| sides.iter().all(|side| (200..=16384).contains(side)));
    sides.ok_or_else(|| "two numbers from 200 to 16384 with x between, such as 1440x860".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_json_or_words() {
        assert_eq!(setting("far=[1, 2]"), Ok(("far".to_owned(), serde_json::json!([1, 2]))));
        assert_eq!(setting("filter=pcss"), Ok(("filter".to_owned(), Value::from("pcss"))));
        assert_eq!(setting("debug_view=off"), Ok(("debug_view".to_owned(), Value::from("off"))));
        assert_eq!(feature("msaa"), Ok(("msaa".to_owned(), Value::Bool(true))));
        assert_eq!(feature("msaa=off"), Ok(("msaa".to_owned(), Value::Bool(false))));
        assert!(setting("far").is_err() && scale("2").is_err() && size("3x").is_err());
    }
}
