//! What `graph --format html` shows beside the plan: captures from a folder, and times from a trace.
//!
//! A file `NAME.png` is the picture of the resource NAME. Of a trace count the complete events whose names are those of
//! passes; the mean of all frames but the first is shown, unless there is only one.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use umbragraph::diagnostic::{Diagnostic, codes};
use umbragraph::report::Observed;

/// Reads what was observed.
///
/// # Errors
/// A folder or a trace that cannot be read.
pub(crate) fn observed(captures: Option<&Path>, trace: Option<&Path>) -> Result<Observed, Diagnostic> {
    Ok(Observed {
        pictures: captures.map(pictures).transpose()?.unwrap_or_default(),
        times: trace.map(times).transpose()?.unwrap_or_default(),
    })
}

fn pictures(folder: &Path) -> Result<BTreeMap<String, String>, Diagnostic> {
    let unreadable = |error: std::io::Error| unreadable(folder, &error.to_string());
    let mut pictures = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()?.strip_suffix(".png")) else {
            continue;
        };
        let bytes = std::fs::read(&path).map_err(unreadable)?;
        pictures.insert(name.to_owned(), format!("data:image/png;base64,{}", STANDARD.encode(&bytes)));
    }
    Ok(pictures)
}

fn times(trace: &Path) -> Result<BTreeMap<String, [f64; 2]>, Diagnostic> {
    let text = std::fs::read_to_string(trace).map_err(|error| unreadable(trace, &error.to_string()))?;
    let json: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| unreadable(trace, &error.to_string()))?;
    let Some(events) = json["traceEvents"].as_array() else {
        return Err(unreadable(trace, "it has no \"traceEvents\""));
    };
    let mut all: BTreeMap<String, [Vec<f64>; 2]> = BTreeMap::new();
    for event in events.iter().filter(|event| event["ph"] == "X") {
        let (Some(name), Some(time), Some(row @ 1..=2)) =
            (event["name"].as_str(), event["dur"].as_f64(), event["tid"].as_u64())
        else {
            continue;
        };
        all.entry(name.to_owned()).or_default()[row as usize - 1].push(time / 1000.0);
    }
    let mean = |times: &Vec<f64>| {
        let counted = &times[usize::from(times.len() > 1)..];
        if counted.is_empty() { 0.0 } else { counted.iter().sum::<f64>() / counted.len() as f64 }
    };
    Ok(all.iter().map(|(name, times)| (name.clone(), [mean(&times[0]), mean(&times[1])])).collect())
}

fn unreadable(path: &Path, reason: &str) -> Diagnostic {
    let name = path.display().to_string();
    Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", format!("\"{name}\" cannot be read: {reason}"))
        .help("write it with `umbragraph render --capture-all FOLDER`, or `--trace FILE.json`")
}
