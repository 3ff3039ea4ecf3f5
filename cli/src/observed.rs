//! Observations that `graph --format html` shows beside the plan: captures from a folder, and times from a trace.
//!
//! The file `NAME.png` shows the resource NAME at the end of the frame. `NAME@PASS.png` shows it after the pass PASS.
//! Captured buffers are `NAME.json` and `NAME.csv`; their first rows are shown. Other JSON files are ignored.
//!
//! A trace is read for complete events with the name of a pass. The events of a pass are added up in each frame, since a
//! pass over many layers has several. Shown is the mean of all frames; the first is left out if there are others.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::compose;
use umbragraph::low_level::report::Observed;

use crate::read::read_file;

/// The number of rows of a buffer that a page shows.
pub(crate) const ROWS: usize = 8;

const HELP: &str = "write it with `umbragraph render --capture-all FOLDER`, or `--trace FILE.json`";

/// Reads the captured pictures from a folder and the pass times from a trace; both are optional.
///
/// # Errors
/// A folder or a trace that cannot be read.
pub(crate) fn observed(captures: Option<&Path>, trace: Option<&Path>) -> Result<Observed, Diagnostic> {
    let mut observed = Observed::default();
    if let Some(folder) = captures {
        read_captures(folder, &mut observed)?;
    }
    observed.times = trace.map(times).transpose()?.unwrap_or_default();
    Ok(observed)
}

/// Adds the captured pictures and buffers in a folder.
fn read_captures(folder: &Path, observed: &mut Observed) -> Result<(), Diagnostic> {
    let unreadable = |error: std::io::Error| unreadable(folder, &error.to_string());
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_name().and_then(|name| name.to_str()?.rsplit_once('.'));
        let Some((name, extension @ ("png" | "json" | "csv"))) = name else { continue };
        let (name, bytes) = (name.to_owned(), read(&path)?);
        if extension == "png" {
            observed.pictures.insert(name, format!("data:image/png;base64,{}", STANDARD.encode(&bytes)));
        } else if let Some(rows) = rows(extension, &bytes) {
            observed.buffers.insert(name, rows);
        }
    }
    Ok(())
}

/// Returns the first rows of a captured buffer as text; `None` for JSON of another kind.
fn rows(extension: &str, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?;
    if extension == "csv" {
        return Some(text.lines().take(ROWS + 1).collect::<Vec<_>>().join("\n"));
    }
    let json: serde_json::Value = serde_json::from_str(text).ok()?;
    let first = format!("{} bytes, {}", json.get("bytes")?, json.get("type")?.as_str()?);
    let contents = json.get("contents")?;
    let rows: Vec<String> = match contents.as_array() {
        Some(rows) => rows.iter().take(ROWS).map(ToString::to_string).collect(),
        None => format!("{contents:#}").lines().take(2 * ROWS).map(str::to_owned).collect(),
    };
    Some(format!("{first}\n{}", rows.join("\n")))
}

fn times(trace: &Path) -> Result<BTreeMap<String, [f64; 2]>, Diagnostic> {
    let json: serde_json::Value =
        serde_json::from_slice(&read(trace)?).map_err(|error| unreadable(trace, &error.to_string()))?;
    let Some(events) = json["traceEvents"].as_array() else {
        return Err(unreadable(trace, "it has no \"traceEvents\""));
    };
    let mut frames: Vec<BTreeMap<&str, [f64; 2]>> = Vec::new();
    for event in events.iter().filter(|event| event["ph"] == "X") {
        let (Some(name), Some(time), Some(row @ 1..=2)) =
            (event["name"].as_str(), event["dur"].as_f64(), event["tid"].as_u64())
        else {
            continue;
        };
        if frames.is_empty() || name.starts_with("frame ") {
            frames.push(BTreeMap::new());
        }
        if let Some(frame) = frames.last_mut() {
            frame.entry(name).or_default()[row as usize - 1] += time / 1000.0;
        }
    }
    let counted = &frames[usize::from(frames.len() > 1)..];
    let mut means: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (name, times) in counted.iter().flatten() {
        let mean = means.entry((*name).to_owned()).or_default();
        for (mean, time) in mean.iter_mut().zip(times) {
            *mean += time / counted.len() as f64;
        }
    }
    Ok(means)
}

fn read(path: &Path) -> Result<Vec<u8>, Diagnostic> {
    read_file(path).map_err(|error| error.help(HELP))
}

fn unreadable(path: &Path, reason: &str) -> Diagnostic {
    compose::unreadable(&path.display().to_string(), &std::io::Error::other(reason)).help(HELP)
}
