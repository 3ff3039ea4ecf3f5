//! Actions carried out, and the state of the window for tests.

use std::path::Path;

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use serde_json::{Map, Value, json};
use umbragraph::diagnostic::{codes, list_of};
use umbragraph::low_level::camera_path::{CameraPath, Key};
use umbragraph::low_level::files::replace;
use umbragraph::low_level::import::ImportArgument;

use crate::actions::{Action, KEYED};
use crate::app::Viewer;
use crate::camera::{Mode, View};
use crate::clock::STEP;
use crate::dock::{Dock, Pane};
use crate::files;
use crate::graph::Selected;
use crate::output::{Clip, Picture, command_line};
use crate::parameters;
use crate::save;
use crate::values::Values;

impl Viewer {
    /// Executes an action. `state` is needed by actions that read back the frame.
    pub(crate) fn act(&mut self, action: Action, context: &egui::Context, state: Option<&RenderState>) {
        match action {
            Action::Play => self.clock.is_playing = !self.clock.is_playing,
            Action::Step => {
                self.clock.is_playing = false;
                self.clock.time += STEP;
                self.stage.touch();
            }
            Action::Restart => {
                self.clock.time = 0.0;
                self.stage.touch();
            }
            Action::Mode => {
                if let Some(view) = &mut self.view {
                    view.mode = if view.mode == Mode::Orbit { Mode::Fly } else { Mode::Orbit };
                }
            }
            Action::Home => self.go_home(),
            Action::Bookmark => {
                self.bookmarks.extend(self.view.clone());
                let number = self.bookmarks.len();
                self.say(Ok(if number > KEYED {
                    format!("bookmark {number} has no key: it is only saved with the camera path (Ctrl+B)")
                } else {
                    format!("bookmark {number}")
                }));
            }
            Action::Visit(at) => {
                if let (Some(view), Some(bookmark)) = (&mut self.view, self.bookmarks.get(at)) {
                    view.visit(bookmark);
                    self.path = CameraPath::Scene;
                    self.stage.touch();
                }
            }
            Action::Panel(pane) => match self.dock.is_shown(pane) {
                true => self.close_panel(pane),
                false => self.dock.open(pane, true),
            },
            Action::NextPanel(by) => self.dock.focus(context, by),
            Action::ResetPanels => {
                self.dock = Dock::default();
                // egui's own key for it is this one.
                context.set_zoom_factor(1.0);
                self.dock.open(Pane::Inspector, self.inspector.selected.is_some());
            }
            Action::Turn(turn, by) => self.turn(turn, by),
            Action::Help => self.has_help = !self.has_help,
            Action::Screenshot => {
                let said = self.screenshot(state);
                self.say(said);
            }
            Action::Clip => match self.clip.take() {
                None => {
                    self.clip = Some(Clip::new());
                    self.stage.touch();
                }
                clip => {
                    self.clip = clip;
                    self.end_clip();
                }
            },
            Action::CopyCommand => {
                let said = self.copy_command(context);
                self.say(said);
            }
            Action::SaveParameters => {
                let said = self.save_parameters();
                self.say(said);
            }
            Action::SaveDocument => {
                let said = self.save_document();
                self.say(said);
            }
            Action::SaveCamera => {
                let name = format!("{}.camera.json", self.stem());
                let path = self.out().map(|folder| folder.join(name));
                let said = path.and_then(|path| {
                    self.save_camera(&path)?;
                    Ok(format!("saved {}", path.display()))
                });
                self.say(said);
            }
            Action::ResetAll => self.values = Values::default(),
            Action::Search => {
                self.dock.open(Pane::Values, true);
                self.wants_search = true;
            }
            Action::SearchGraph => {
                self.dock.open(Pane::Graph, true);
                self.wants_graph_search = true;
            }
            Action::Previous => self.select_beside(-1),
            Action::Next => self.select_beside(1),
            Action::Close => (self.inspector.selected, self.has_help) = (None, false),
            Action::Coarser => self.resolution.step(1),
            Action::Finer => self.resolution.step(-1),
            Action::Reload => self.stage.refresh(),
        }
        context.request_repaint();
    }

    /// Ends the recording of a clip, if there is one, and writes its file.
    pub(crate) fn end_clip(&mut self) {
        if let Some(clip) = self.clip.take() {
            let path = self.out().map(|folder| files::free(folder, "clip", "png"));
            self.say(path.and_then(|path| clip.write(&path)));
        }
    }

    fn go_home(&mut self) {
        if let Some(mut home) = self.stage.scene().map(View::home) {
            home.mode = self.view.as_ref().map_or(Mode::Orbit, |view| view.mode);
            self.view = Some(home);
            self.path = CameraPath::Scene;
            self.stage.touch();
        }
    }

    /// Selects the pass `by` positions after the selected one (before it if negative); the first pass if no pass is
    /// selected.
    fn select_beside(&mut self, by: isize) {
        let Some(report) = &self.report else { return };
        let at = match &self.inspector.selected {
            Some(Selected::Pass(name)) => report.passes.iter().position(|pass| pass.name == *name),
            _ => None,
        };
        let at = at.map_or(0, |at| at.saturating_add_signed(by).min(report.passes.len().saturating_sub(1)));
        if let Some(pass) = report.passes.get(at) {
            self.inspector.select(Selected::Pass(pass.name.clone()), report);
        }
    }

    fn screenshot(&self, state: Option<&RenderState>) -> Result<String, String> {
        let (Some(state), Some(texture)) = (state, self.stage.targets.picture()) else {
            return Err("there is no frame yet".to_owned());
        };
        let path = files::free(self.out()?, "frame", "png");
        Picture::read(&state.device, &state.queue, texture)?.write(&path)
    }

    /// The file name of the pipeline without its extension.
    fn stem(&self) -> String {
        let name = self.arguments.pipeline.to_string_lossy().replace("umbragraph:", "");
        let stem = Path::new(&name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
        stem.unwrap_or_else(|| "pipeline".to_owned())
    }

    /// Saves the values into the parameter file in use, which is the last one, or else as a new file.
    fn save_parameters(&mut self) -> Result<String, String> {
        if let Some(path) = self.arguments.params.last() {
            return save::into_parameter_file(&self.values, path);
        }
        let name = format!("{}.params.json", self.stem());
        let place = [self.out()?, Path::new(&name)];
        let (written, said) = save::new_parameter_file(&self.values, place, self.written.as_ref())?;
        self.written = Some(written);
        Ok(said)
    }

    fn save_document(&mut self) -> Result<String, String> {
        let (Some(pipeline), Some(plan)) = (self.stage.pipeline(), &self.stage.plan) else {
            return Err("there is no pipeline yet".to_owned());
        };
        let said = save::into_document(&self.values, &self.arguments.pipeline, pipeline.document(), plan)?;
        // A parameter file counts more than the document.
        self.saved = self.arguments.params.is_empty().then(|| self.values.clone());
        Ok(said)
    }

    /// Lets go of values that were saved into the document, once it is drawn, and of values whose names the edited
    /// files do not declare any more.
    pub(crate) fn follow_files(&mut self) {
        if let (Some(saved), Some(pipeline), Some(plan)) =
            (&self.saved, self.stage.pipeline(), self.stage.plan.clone())
            && self.values.drop_defaults(saved, pipeline.document(), &plan)
        {
            self.saved = None;
        }
        let found = self.stage.error().into_iter().flat_map(|error| error.iter());
        let unknown =
            found.filter(|one| one.code == codes::UNKNOWN_SETTING).map(|one| one.message.clone()).next();
        if self.unknown == unknown {
            return;
        }
        self.unknown = unknown;
        // Before the first plan an unknown name is a mistake of the command line, which its error explains.
        let asked = self.unknown.as_ref().filter(|_| self.stage.plan.is_some());
        let loaded = asked.and_then(|_| self.stage.library.load(self.stage.wanted()).ok());
        let gone = loaded.map(|pipeline| self.values.keep_known(pipeline.document())).unwrap_or_default();
        if !gone.is_empty() {
            let names = list_of(gone.iter().map(|name| format!("\"{name}\"")));
            self.say(Ok(format!("dropped the values of {names}: the files no longer declare them")));
        }
    }

    /// The folder for what the window writes; made if it is not there.
    fn out(&self) -> Result<&Path, String> {
        let folder = self.arguments.out.as_path();
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("the folder {} of --out cannot be made: {error}", folder.display()))?;
        Ok(folder)
    }

    /// Writes the camera and the bookmarks as the keys of a camera path, one second apart.
    fn save_camera(&self, path: &Path) -> Result<(), String> {
        let view = self.view.as_ref().ok_or("there is no camera yet")?;
        let views = std::iter::once(view).chain(&self.bookmarks);
        let keys: Vec<Key> = (0u32..).zip(views).map(|(at, view)| view.key(at.into())).collect();
        replace(path, camera_file(&keys)).map_err(|found| found.message)
    }

    /// Writes the camera of the frame to a camera path file, and returns its path. `None` if the camera is that of the
    /// scene and has roll, which a path cannot store.
    fn camera_of_frame(&self) -> Result<Option<std::path::PathBuf>, String> {
        let view = self.view.as_ref().ok_or("there is no camera yet")?;
        let mut home = self.stage.scene().map(View::home);
        if let Some(home) = &mut home {
            home.mode = view.mode;
        }
        // A key of a camera path has no roll.
        if !view.is_upright() && home.as_ref() == Some(view) {
            return Ok(None);
        }
        let text = camera_file(&[view.key(0.0)]);
        let path = files::free_or_same(self.out()?, "view", "camera.json", &text);
        replace(&path, text).map_err(|found| found.message)?;
        Ok(Some(path))
    }

    /// Copies a command line that renders this frame to the clipboard, and writes the camera path file that it uses.
    fn copy_command(&self, context: &egui::Context) -> Result<String, String> {
        let (_, [width, height]) = self.stage.targets.shown().ok_or("there is no frame yet")?;
        let camera = self.camera_of_frame()?;
        let path = |path: &Path| path.display().to_string();
        let mut words = vec!["umbragraph".to_owned(), "render".to_owned(), path(&self.arguments.pipeline)];
        let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
        option("--scene", path(&self.arguments.scene));
        option("--size", format!("{width}x{height}"));
        if let Some(camera) = &camera {
            option("--camera", path(camera));
        }
        if self.clock.time != 0.0 {
            option("--at", self.clock.time.to_string());
        }
        if let Some(file) = &self.arguments.environment {
            option("--environment", path(file));
        }
        for ImportArgument { name, path: file } in &self.arguments.imports {
            option("--import", format!("{name}={}", path(file)));
        }
        if let Some(folder) = &self.arguments.templates {
            option("--templates", path(folder));
        }
        for folder in &self.arguments.root {
            option("--root", path(folder));
        }
        for file in &self.arguments.params {
            option("--params", path(file));
        }
        option("--out", "frame.png".to_owned());
        words.extend(self.values.arguments());
        let line = command_line(words);
        context.copy_text(line.clone());
        Ok(format!("copied: {line}"))
    }

    /// Opens a source location, `file:line`, in the editor.
    pub(crate) fn open(&mut self, place: &str) {
        let said = crate::notices::open_editor(&self.arguments.editor, place);
        self.say(said);
    }

    /// The state of the window as JSON, for the log that tests read.
    pub(crate) fn state(&mut self, context: &egui::Context) -> Map<String, Value> {
        let errors: Vec<String> = self
            .stage
            .error()
            .map(|error| error.iter().map(|one| one.message.clone()).collect())
            .unwrap_or_default();
        let (at, is_down) = context.input(|input| (input.pointer.latest_pos(), input.pointer.any_down()));
        let plan = self.stage.plan.as_ref();
        let selected = self.inspector.selected.as_ref().map(|selected| match selected {
            Selected::Pass(name) => format!("pass {name}"),
            Selected::Resource(name) => format!("resource {name}"),
        });
        let shown: Vec<&str> = self.dock.shown().iter().map(|pane| pane.title()).collect();
        let below = [Pane::Graph, Pane::Times, Pane::Notices].into_iter();
        let below = below.map(|pane| pane.title()).find(|title| shown.contains(title));
        let values = &self.values;
        let Value::Object(state) = json!({
            "frames": self.stage.index,
            "plans": self.stage.plans,
            "bytes": plan.map(|plan| plan.bytes),
            "busy": self.stage.is_busy() || self.is_resizing(),
            "size": self.stage.targets.shown().map(|(_, size)| size),
            "scale": self.resolution.scale(),
            "camera": self.view.as_ref().map(View::rounded),
            "moving": self.path != CameraPath::Scene,
            "fly": self.view.as_ref().is_some_and(|view| view.mode == Mode::Fly),
            "bookmarks": self.bookmarks.len(),
            "playing": self.clock.is_playing,
            "time": (self.clock.time * 1e3).round() / 1e3,
            "errors": errors,
            "warnings": self.stage.warnings().0.iter().map(|one| one.message.clone()).collect::<Vec<_>>(),
            "passes": plan.map(|plan| plan.passes.iter().map(|pass| pass.name.clone()).collect::<Vec<_>>()),
            "kept_bytes": self.stage.kept.bytes(),
            "planned": plan.map(|plan| parameters::state(plan)),
            "features": plan.map(|plan| parameters::features(plan)),
            "given": {
                "preset": values.preset, "parameters": values.parameters,
                "features": values.features, "toggles": values.toggles,
            },
            "panel": {
                "search": self.panel.search, "only given": self.panel.only_given,
                "open": self.dock.is_shown(Pane::Values),
            },
            "panels": shown,
            "below": below,
            "help": self.has_help,
            "pointer": { "at": at.map(|at| [at.x.round(), at.y.round()]), "down": is_down },
            "focused": context.input(|input| input.focused),
            "typing": context.text_edit_focused(),
            "selected": selected,
            "contents": self.inspector.contents.state(),
            "not_captured": self.inspector.contents.error,
            "clip": self.clip.as_ref().map(Clip::len),
            "message": self.message.0,
            "times": self.timings.state(),
            "timed": self.timings.whole_frames().map(|_| true),
            "scene": self.arguments.scene.display().to_string(),
            "pipeline": self.arguments.pipeline.display().to_string(),
            "params": self.arguments.params,
        }) else {
            return Map::new();
        };
        state
    }
}

/// The JSON text of a camera path file.
fn camera_file(keys: &[Key]) -> String {
    format!("{:#}\n", json!({ "keys": keys }))
}
