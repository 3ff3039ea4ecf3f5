//! Files that are dropped on the window: a scene, a pipeline, a parameter file or a camera path.
//!
//! A scene is known by its ending. A JSON file is known by its contents: a camera path has `keys`, and a parameter file
//! has nothing but what parameter files have. A file that is no JSON is known by its name. What is running goes on until
//! the new file can be shown; a broken one only brings its diagnostics.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use eframe::egui;
use umbragraph::diagnostic::list_of;
use umbragraph::low_level::camera_path::{CameraArgument, CameraPath};
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::source::Sources;

use crate::app::Viewer;
use crate::camera::View;
use crate::files;

/// The members that a parameter file can have.
const PARAMETER_MEMBERS: [&str; 6] = ["$schema", "format", "description", "preset", "parameters", "features"];

/// The kind of a dropped file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Scene,
    Pipeline,
    Parameters,
    Camera,
}

impl Viewer {
    /// Opens the files that were dropped on the window.
    pub(crate) fn take_dropped(&mut self, context: &egui::Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        for path in dropped.iter().map(|file| file.path().to_owned()) {
            let said = self.open_dropped(path);
            self.say(said);
        }
    }

    fn open_dropped(&mut self, path: PathBuf) -> Result<String, String> {
        let name = path.display().to_string();
        match kind_of(&path) {
            Some(Kind::Scene) => {
                self.stage.open_scene(&path);
                // Cameras and times of the scene before mean nothing in another; they stay until it is loaded.
                self.has_dropped_scene = true;
                self.arguments.scene = path;
                Ok(format!("opened {name}"))
            }
            Some(Kind::Pipeline) => {
                // A value that the new pipeline does not have would be an error of every plan.
                let loaded = self.stage.library.load(&path).ok();
                let gone =
                    loaded.map(|pipeline| self.values.keep_known(pipeline.document())).unwrap_or_default();
                self.stage.open_pipeline(&path);
                let reset =
                    if gone.is_empty() { String::new() } else { format!("; it has no {}", list_of(gone)) };
                Ok(format!("opened {name}{reset}"))
            }
            Some(Kind::Parameters) => {
                // A broken file would be in the way of everything that is loaded after it.
                if files::read(&path).ok().and_then(|text| parsed(&text)).is_none() {
                    return Err(format!("{name} is not applied: it is no valid JSON"));
                }
                self.arguments.params.retain(|known| *known != path);
                self.arguments.params.push(path);
                self.stage.open_parameters(&self.arguments.params);
                Ok(format!("applied the parameter file {name}"))
            }
            Some(Kind::Camera) => {
                let read = CameraPath::of(Some(&CameraArgument::File(path)));
                self.path = read.map_err(|found| format!("{name} is not opened: {}", found.message))?;
                self.begin_path();
                Ok(format!("opened the camera path {name}: its keys are bookmarks"))
            }
            None => Err(format!(
                "\"{name}\" is no pipeline, parameter file or camera path (.json) and no scene (.glb, .gltf)"
            )),
        }
    }

    /// Begins a dropped scene, once it is loaded, at its own camera and at the time 0.
    pub(crate) fn begin_scene(&mut self) {
        if std::mem::take(&mut self.has_dropped_scene) {
            (self.view, self.path, self.clock.time) =
                (self.stage.scene().map(View::home), CameraPath::Scene, 0.0);
            self.bookmarks.clear();
        }
    }
}

/// The kind of a dropped file; `None` if the viewer opens no such files.
fn kind_of(path: &Path) -> Option<Kind> {
    let end = path.extension()?.to_ascii_lowercase();
    match end.to_str()? {
        "glb" | "gltf" => Some(Kind::Scene),
        "json" | "jsonc" => match files::read(path).ok().and_then(|text| parsed(&text)) {
            Some(document) => kind_of_document(&document),
            None => Some(kind_of_name(path)),
        },
        _ => None,
    }
}

/// The document of a text; `None` if it is no JSON.
fn parsed(text: &str) -> Option<Document> {
    let mut sources = Sources::new();
    let file = sources.add("dropped", text);
    document::parse(&sources, file).valid().ok()
}

/// The kind of a JSON file by the members that it has; `None` if the viewer opens no such file.
fn kind_of_document(document: &Document) -> Option<Kind> {
    let entries = document.root.entries()?;
    let has = |name: &str| entries.iter().any(|entry| entry.key == name);
    let is_parameters = entries.iter().all(|entry| PARAMETER_MEMBERS.contains(&entry.key.as_str()));
    if has("keys") && !has("passes") {
        return Some(Kind::Camera);
    }
    let has_values = ["preset", "parameters", "features"].into_iter().any(has);
    match is_parameters && has_values {
        true => Some(Kind::Parameters),
        false => ["passes", "extends", "resources"].into_iter().any(has).then_some(Kind::Pipeline),
    }
}

/// The kind of a JSON file by its name.
fn kind_of_name(path: &Path) -> Kind {
    let stem = path.file_stem().map(Path::new).and_then(Path::extension).and_then(OsStr::to_str);
    match stem {
        Some("params") => Kind::Parameters,
        Some("camera") => Kind::Camera,
        _ => Kind::Pipeline,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_files_are_known_by_their_members() {
        let kind = |text| parsed(text).map(|document| kind_of_document(&document));
        assert_eq!(kind("{ \"keys\": [] } // a path"), Some(Some(Kind::Camera)));
        assert_eq!(kind("{ \"format\": 1, \"parameters\": { \"far\": 3 } }"), Some(Some(Kind::Parameters)));
        let pipeline = "{ \"format\": 1, \"extends\": \"a.json\", \"parameters\": {} }";
        assert_eq!(
            [kind(pipeline), kind("{ \"private\": true }"), kind("{ \"parameters\": {")],
            [Some(Some(Kind::Pipeline)), Some(None), None]
        );
        assert_eq!(kind_of_name(Path::new("a/own.params.json")), Kind::Parameters);
        assert_eq!(kind_of_name(Path::new("own.camera.json")), Kind::Camera);
        assert_eq!(kind_of_name(Path::new("own.json")), Kind::Pipeline);
        assert_eq!(kind_of(Path::new("notes.txt")), None);
    }
}
