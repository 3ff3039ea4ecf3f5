//! Diagnostics as lines for a problem matcher; only files whose diagnostics have changed are printed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Instant;

use umbragraph::diagnostic::{counted, render};

use crate::session::Session;
use crate::streams::print;

/// The lines last printed for each file.
#[derive(Default)]
pub(super) struct Problems(BTreeMap<String, Vec<String>>);

/// The file name shown for diagnostics without a file.
const NO_FILE: &str = "(no file)";

impl Problems {
    /// Prints the files whose diagnostics have changed, and the number of problems.
    pub(super) fn print(&mut self, session: &Session, start: Instant, is_first: bool) {
        let mut now: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let (mut errors, mut warnings) = (0, 0);
        for diagnostic in &session.diagnostics {
            let json = render::json(diagnostic, session.sources());
            let (file, line) = line(&json);
            match json["severity"].as_str() {
                Some("error") => errors += 1,
                Some("warning") => warnings += 1,
                _ => {}
            }
            now.entry(file).or_default().push(line);
        }
        let mut text = String::new();
        // Writing to a string cannot fail.
        for file in self.0.keys().filter(|file| !now.contains_key(*file)) {
            let _ = writeln!(text, "watch: {file} is fine");
        }
        for (file, lines) in now.iter().filter(|(file, lines)| self.0.get(*file) != Some(*lines)) {
            let _ = writeln!(text, "watch: {file}");
            for line in lines {
                let _ = writeln!(text, "{line}");
            }
        }
        if is_first || !text.is_empty() {
            let counts = [counted(errors, "error"), counted(warnings, "warning")].join(", ");
            let _ = writeln!(text, "checked: {counts} in {:.2} s", start.elapsed().as_secs_f64());
            print(&text);
        }
        self.0 = now;
    }
}

/// Returns the file name of a diagnostic, given as JSON, and the line that is printed for it.
fn line(json: &serde_json::Value) -> (String, String) {
    let place = &json["place"];
    let file = place["file"].as_str().unwrap_or(NO_FILE).to_owned();
    let number = |key: &str| place[key].as_u64().unwrap_or(1);
    let text = |key: &str| json[key].as_str().unwrap_or_default();
    let mut line = format!(
        "{file}:{}:{}: {}[{}]: {}",
        number("line"),
        number("column"),
        text("severity"),
        text("code"),
        text("message")
    );
    if let Some(help) = json["help"].as_str() {
        let _ = write!(line, "; {help}");
    }
    (file, line.replace('\n', " "))
}
