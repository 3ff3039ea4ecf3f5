//! The thread of a [`Watcher`](super::Watcher): it reads, plans and compiles beside the frames.
//!
//! Two messages reach it: files changed, and the inputs of frames are others. Both lead to one attempt: read everything
//! again, load, plan for the last inputs, make the pipelines. The outcome goes back as one [`Outcome`].

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::executor::{PlanPreparer, PreparedPlan};
use crate::front::Options;
use crate::front::files::{Stamp, stamp};
use crate::front::library::Library;
use crate::low_level::session::Target;
use crate::low_level::source::Sources;
use crate::{Error, Plan};

use super::files::FileEvents;
use super::{Read, Reload, Wake};

/// The time in which further messages are handled together with the first one.
const SETTLE: Duration = Duration::from_millis(10);

/// Messages to the worker thread.
pub(super) enum Order {
    /// A file changed, or the watcher begins.
    Changed(Instant),
    /// The inputs of the next frames.
    Inputs(Box<Inputs>),
    /// The path of another pipeline.
    Pipeline(PathBuf),
    /// The paths of the parameter files, which replace the previous list.
    Parameters(Vec<PathBuf>),
    /// The path of the scene file to load and watch.
    #[cfg(feature = "gltf")]
    Scene(PathBuf),
    /// The paths of further files, which the host reads itself.
    Files(Vec<PathBuf>),
    /// Ends the thread.
    Stop,
}

/// The inputs that a plan is made for.
#[derive(Clone)]
pub(super) struct Inputs {
    /// The options, with the imports of the frames.
    pub(super) options: Options,
    /// Creates pipelines in the cache of the executor; `None` before the first frame.
    pub(super) preparer: Option<PlanPreparer>,
}

/// Messages from the worker thread.
pub(super) enum Outcome {
    /// A new plan, whose GPU pipelines may have been created already.
    Ready(Box<Ready>),
    /// The error that prevents a plan.
    Broken(Error),
    /// The files are again those of the running plan.
    Same,
    /// A file that the host reads itself has changed.
    Files,
    /// The loaded scene, or the error that prevented its load.
    #[cfg(feature = "gltf")]
    Scene(Result<Box<crate::scene::Scene>, Error>),
}

/// A new plan, with the files and options that it was made from.
pub(super) struct Ready {
    pub(super) read: Read,
    pub(super) options: Options,
    pub(super) plan: Arc<Plan>,
    pub(super) warnings: Diagnostics,
    /// The prepared plan; `None` before the first frame, and for geometries that the draw source has not declared
    /// yet.
    pub(super) prepared: Option<PreparedPlan>,
    /// Whether the plan was made from the current files; `false` if the current files cannot be loaded.
    pub(super) is_current: bool,
    /// The durations of the reload that led to the plan; `None` if only inputs of frames changed.
    pub(super) reload: Option<Reload>,
}

/// The state of the worker thread.
pub(super) struct Worker {
    pub(super) library: Library,
    pub(super) target: Target,
    pub(super) orders: Receiver<Order>,
    pub(super) outcomes: Sender<Outcome>,
    pub(super) wake: Arc<Mutex<Wake>>,
    pub(super) events: FileEvents,
    pub(super) parameters: Vec<PathBuf>,
    /// The files that the host reads itself, as they were when they were last looked at.
    pub(super) files: BTreeMap<PathBuf, Stamp>,
    pub(super) inputs: Option<Box<Inputs>>,
    /// The files of the last plan that was sent.
    pub(super) running: Option<Read>,
    /// Whether the files as they are now cannot be loaded.
    pub(super) is_broken: bool,
    /// The newest files, if they could not be planned or no inputs have arrived yet.
    pub(super) last: Option<Read>,
    #[cfg(feature = "gltf")]
    pub(super) scene: Option<super::scene::WatchedScene>,
}

impl Worker {
    /// Runs the thread's loop until the watcher is dropped.
    pub(super) fn run(mut self) {
        while let Ok(order) = self.orders.recv() {
            let mut changed = None;
            let mut is_new = false;
            let mut next = Some(order);
            // Orders within this time are done together. A window sends one with every frame, so each does not extend
            // it.
            let end = Instant::now() + SETTLE;
            loop {
                match next.take() {
                    Some(Order::Changed(at)) => changed = changed.or(Some(at)),
                    Some(Order::Inputs(inputs)) => {
                        self.inputs = Some(inputs);
                        is_new = true;
                    }
                    Some(Order::Pipeline(path)) => {
                        self.target = Target::new(path);
                        changed = changed.or_else(|| Some(Instant::now()));
                    }
                    Some(Order::Parameters(files)) => {
                        self.parameters = files;
                        changed = changed.or_else(|| Some(Instant::now()));
                    }
                    #[cfg(feature = "gltf")]
                    Some(Order::Scene(path)) => {
                        self.scene = Some(super::scene::WatchedScene::new(path));
                        changed = changed.or_else(|| Some(Instant::now()));
                    }
                    Some(Order::Files(files)) => {
                        self.files = files.into_iter().map(|path| (path, None)).collect();
                        changed = changed.or_else(|| Some(Instant::now()));
                    }
                    Some(Order::Stop) => return,
                    None => {}
                }
                match self.orders.recv_timeout(end.saturating_duration_since(Instant::now())) {
                    Ok(order) => next = Some(order),
                    Err(RecvTimeoutError::Timeout) => break,
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
            let mut is_planned = false;
            if let Some(at) = changed {
                #[cfg(feature = "gltf")]
                self.scene_again();
                self.look_at_files();
                is_planned = self.read_again(at);
                if self.watch() {
                    is_planned |= self.read_again(at);
                }
            }
            if is_new && !is_planned {
                self.plan_again();
            }
        }
    }

    /// Watches all files that were read so far. Returns `true` if a folder is newly watched, so that files must be read
    /// again: they may have changed before.
    fn watch(&mut self) -> bool {
        let mut files = self.parameters.clone();
        files.extend(self.files.keys().cloned());
        files.extend(self.library.paths_of(&self.target));
        #[cfg(feature = "gltf")]
        files.extend(self.scene.iter().flat_map(super::scene::WatchedScene::files));
        let (has_new, failed) = self.events.watch(files, self.library.folders());
        if failed.is_empty() {
            return has_new;
        }
        let unwatched = failed.into_iter().map(|(folder, reason)| {
            let name = folder.display().to_string();
            let message = format!("changes in the folder \"{name}\" cannot be watched: {reason}");
            let help =
                "raise the limit that it names; on Linux fs.inotify.max_user_watches and max_user_instances";
            Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help(help)
        });
        self.tell(Outcome::Broken(Error::new(unwatched.collect(), &Sources::new())));
        has_new
    }

    fn tell(&self, outcome: Outcome) {
        let is_sent = self.outcomes.send(outcome).is_ok();
        let wake = self.wake.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(wake) = wake.as_ref().filter(|_| is_sent) {
            wake();
        }
    }

    /// Reads the files again. Returns `true` if an attempt was made to plan them.
    fn read_again(&mut self, changed: Instant) -> bool {
        let begin = Instant::now();
        let read = self.library.read_again(&self.target, &self.parameters, self.running.as_ref());
        self.is_broken = read.is_err();
        match read {
            Ok(read) if self.running.as_ref() == Some(&read) => {
                self.last = None;
                self.tell(Outcome::Same);
            }
            // Tried before, and told then.
            Ok(read) if self.last.as_ref() == Some(&read) => {}
            Ok(read) => {
                self.plan(read, Some((changed, begin.elapsed())));
                return true;
            }
            Err(error) => {
                self.last = None;
                self.tell(Outcome::Broken(error));
            }
        }
        false
    }

    /// Plans the newest files with the current inputs.
    fn plan_again(&mut self) {
        if let Some(read) = self.last.clone().or_else(|| self.running.clone()) {
            self.plan(read, None);
        }
    }

    fn plan(&mut self, read: Read, changed: Option<(Instant, Duration)>) {
        self.last = Some(read.clone());
        let Some(Inputs { options, preparer }) = self.inputs.as_deref().cloned() else { return };
        let begin = Instant::now();
        let (plan, warnings) = match read.plan(&options) {
            Ok(planned) => planned,
            Err(error) => return self.tell(Outcome::Broken(error)),
        };
        let planned = begin.elapsed();
        let prepared = match preparer.map(|preparer| preparer.prepare(plan.clone(), None)).transpose() {
            Ok(prepared) => prepared,
            // A geometry that the draw source of the executor has not declared: it is asked with the next frame.
            Err(error) if error.iter().all(|one| one.code == codes::HOST_INTERFACE) => None,
            Err(error) => return self.tell(Outcome::Broken(error)),
        };
        let prepared_in = begin.elapsed().saturating_sub(planned);
        let reload =
            changed.map(|(changed, loaded)| Reload { changed, loaded, planned, prepared: prepared_in });
        self.last = None;
        self.running = Some(read.clone());
        let is_current = !self.is_broken;
        let ready = Ready { read, options, plan, warnings, prepared, is_current, reload };
        self.tell(Outcome::Ready(Box::new(ready)));
    }

    /// Tells the host if one of the files that it reads itself has changed.
    fn look_at_files(&mut self) {
        let mut has_changed = false;
        for (path, known) in &mut self.files {
            let now = stamp(path);
            has_changed |= now != *known;
            *known = now;
        }
        if has_changed {
            self.tell(Outcome::Files);
        }
    }

    #[cfg(feature = "gltf")]
    fn scene_again(&mut self) {
        let loaded = self.scene.as_mut().and_then(super::scene::WatchedScene::load_again);
        if let Some(loaded) = loaded {
            let loaded = loaded.map(Box::new).map_err(|found| Error::new(found, &Sources::new()));
            self.tell(Outcome::Scene(loaded));
        }
    }
}
