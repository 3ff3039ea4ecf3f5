//! `--log-state`: the state of the window as lines of JSON, with the places of its controls.
//!
//! A test finds a control by its name, moves the pointer of the window system there, and reads back what became of it.
//! Nothing is gathered without the option.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use eframe::egui::{Rect, Response};
use serde_json::{Map, Value, json};

/// The positions of controls in the window, in points, and the log file for them.
pub(crate) struct Places {
    file: Option<File>,
    rects: BTreeMap<String, Rect>,
    /// The name of the control that has the keyboard.
    focus: Option<String>,
    last: String,
}

impl Places {
    /// Creates the log file, if a path is given.
    ///
    /// # Errors
    /// The file cannot be created, or holds something already: a log cannot take the place of a file as a whole, as
    /// other outputs do.
    pub(crate) fn new(path: Option<&Path>) -> std::io::Result<Self> {
        let is_full = |path: &Path| path.metadata().is_ok_and(|known| known.is_file() && known.len() > 0);
        if let Some(path) = path.filter(|path| is_full(path)) {
            let message = format!("\"{}\" is not empty; name a new file, or remove it", path.display());
            return Err(std::io::Error::new(std::io::ErrorKind::AlreadyExists, message));
        }
        let file = path.map(File::create).transpose()?;
        Ok(Self { file, rects: BTreeMap::new(), focus: None, last: String::new() })
    }

    /// Returns `true` if the log is written.
    pub(crate) fn is_on(&self) -> bool {
        self.file.is_some()
    }

    /// Scrolls to a control that gets the keyboard, and stores its visible rectangle in this frame, if the log is
    /// written.
    pub(crate) fn note(&mut self, name: &str, response: &Response) {
        if response.gained_focus() {
            response.scroll_to_me(None);
        }
        if self.is_on() {
            if response.has_focus() {
                self.focus = Some(name.to_owned());
            }
            // A control that is scrolled out of view cannot be clicked.
            let rect = response.interact_rect;
            if rect.is_positive() {
                self.rects.insert(name.to_owned(), rect);
            }
        }
    }

    /// Writes the state with the control rectangles, if it has changed since the last line, and clears the rectangles.
    pub(crate) fn write(&mut self, mut state: Map<String, Value>) {
        let Some(file) = &mut self.file else { return };
        let rects = std::mem::take(&mut self.rects);
        let corner = |rect: Rect| json!([rect.left(), rect.top(), rect.width(), rect.height()]);
        let rects: Map<String, Value> = rects.into_iter().map(|(name, rect)| (name, corner(rect))).collect();
        state.insert("keyboard".to_owned(), json!(self.focus.take()));
        state.insert("controls".to_owned(), Value::Object(rects));
        let line = Value::Object(state).to_string() + "\n";
        if line != self.last {
            // A disk that is full ends the log, not the window.
            if file.write_all(line.as_bytes()).is_err() {
                self.file = None;
            }
            self.last = line;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_never_replaces_a_file_that_holds_something() {
        let path = std::env::temp_dir().join(format!("umbragraph-places-{}", std::process::id()));
        std::fs::write(&path, "{}").unwrap();
        let refused = Places::new(Some(&path)).err().expect("the file holds something").to_string();
        assert!(refused.contains("is not empty; name a new file"), "{refused}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "{}");
        std::fs::write(&path, "").unwrap();
        assert!(Places::new(Some(&path)).is_ok_and(|places| places.is_on()));
        std::fs::remove_file(&path).unwrap();
    }
}
