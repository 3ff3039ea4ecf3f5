//! [`Watcher`]: a pipeline that follows its files while it is drawn.
//!
//! An author changes a file and wants to see it. A thread of the watcher reads the change, plans it and compiles its
//! shaders beside the running frames; [`Renderer::record_watched`](crate::Renderer::record_watched) takes the result
//! over between two frames, as [`Executor::set_prepared_plan`](crate::Executor::set_prepared_plan) does: histories,
//! kept maps and live values that still fit stay. A change that is broken, in whatever way, changes nothing: the last
//! good plan goes on, and [`Watcher::error`] says why.
//!
//! ```no_run
//! # use umbragraph::{Frame, Library, Options, Renderer, Watcher, wgpu};
//! # fn example(device: &wgpu::Device, queue: &wgpu::Queue, frames: &[Frame<'_>]) -> Result<(), umbragraph::Error> {
//! let mut watcher = Watcher::new(Library::new().templates("shaders"), "frame.json")?;
//! let mut renderer = Renderer::new(device, queue);
//! for frame in frames {
//!     let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
//!     renderer.record_watched(&mut watcher, &Options::new(1280, 720), &mut encoder, frame)?;
//!     queue.submit([encoder.finish()]);
//!     if let Some(error) = watcher.error() {
//!         eprintln!("{error}");
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Limits: the folders of all files that the pipeline reads are watched, with one inotify watch each on Linux. The
//! first plan is made into pipelines in the frame that begins with it.

mod files;
mod frames;
#[cfg(feature = "gltf")]
mod scene;
mod worker;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use umbragraph_session::Target;

use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::executor::PlanPreparer;
use crate::front::library::Library;
use crate::front::{Options, Pipeline};
use crate::low_level::pipeline::ParameterFile;
use crate::low_level::source::Sources;
use crate::{Error, Plan};

use files::FileEvents;
use worker::{Inputs, Order, Outcome, Ready, Worker};

/// Follows the files of a pipeline: documents, includes, subgraphs, templates, axes, parameter files, and a scene.
pub struct Watcher {
    orders: Sender<Order>,
    outcomes: Receiver<Outcome>,
    thread: Option<JoinHandle<()>>,
    wake: Arc<Mutex<Wake>>,
    /// The options that were last sent to the thread, and whether they were sent with a plan preparer.
    told: Option<(Options, bool)>,
    ready: Option<Box<Ready>>,
    error: Option<Error>,
    reload: Option<Reload>,
    running: Option<Read>,
    /// The warnings and notes of the files and plan that run.
    warnings: Diagnostics,
    /// The options of the last plan that was installed, or whose planning failed.
    planned_for: Option<Options>,
    /// Whether imports are planned as the documents declare them, whatever textures the frames bring.
    has_declared_imports: bool,
    #[cfg(feature = "gltf")]
    scene: SceneNews,
}

/// A loaded scene that was not taken yet, and the error of the last load; `None` if that load succeeded.
#[cfg(feature = "gltf")]
#[derive(Default)]
struct SceneNews {
    new: Option<Box<crate::scene::Scene>>,
    error: Option<Error>,
}

/// The function that is called when a frame could show something new.
type Wake = Option<Box<dyn Fn() + Send>>;

/// The durations of the steps that applied a change of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Reload {
    /// The moment at which the file system events of the change had paused.
    pub changed: Instant,
    /// The time for reading and composing files.
    pub loaded: Duration,
    /// The time for planning, including the validation of new shader variants.
    pub planned: Duration,
    /// The time for creating shader modules, layouts and pipelines, nearly all of it within wgpu.
    pub prepared: Duration,
}

/// The contents of a pipeline's files as read at one time.
#[derive(Clone)]
pub(super) struct Read {
    path: PathBuf,
    pipeline: Pipeline,
    parameters: Arc<[ParameterFile]>,
    sources: Sources,
}

impl PartialEq for Read {
    fn eq(&self, other: &Self) -> bool {
        self.pipeline == other.pipeline && self.is_with(&other.parameters)
    }
}

impl Read {
    pub(super) fn new(
        path: &Path,
        pipeline: Pipeline,
        parameters: Vec<ParameterFile>,
        sources: Sources,
    ) -> Self {
        Self { path: path.to_owned(), pipeline, parameters: parameters.into(), sources }
    }

    /// Returns `true` if the stored parameter files equal `parameters`.
    fn is_with(&self, parameters: &[ParameterFile]) -> bool {
        format!("{:?}", self.parameters) == format!("{parameters:?}")
    }

    /// Returns `true` if the pipeline was created from `loaded` and the stored parameter files equal `parameters`.
    pub(super) fn is_of(&self, loaded: &umbragraph_session::Loaded, parameters: &[ParameterFile]) -> bool {
        self.pipeline.is_of(loaded) && self.is_with(parameters)
    }

    /// Plans with the values of the parameter files, which the options override. Returns the plan and its warnings.
    pub(super) fn plan(&self, options: &Options) -> Result<(Arc<Plan>, Diagnostics), Error> {
        let planned = self.pipeline.plan_over(options, &self.parameters);
        planned.map_err(|found| Error::new(found, &self.sources))
    }
}

impl Watcher {
    /// Begins to watch a pipeline. A thread reads the files, so errors in files are reported by [`Watcher::error`], not
    /// here.
    ///
    /// # Errors
    /// An operating system that cannot report file changes or start a thread.
    pub fn new(library: Library, path: impl AsRef<Path>) -> Result<Self, Error> {
        let (orders, ordered) = channel();
        let (done, outcomes) = channel();
        let wake: Arc<Mutex<Wake>> = Arc::default();
        let changed = orders.clone();
        let path = path.as_ref().to_path_buf();
        let refused = |reason: String| {
            let name = path.display().to_string();
            let message = format!("changes of \"{name}\" cannot be watched: {reason}");
            let help = "raise the limit that it names; on Linux fs.inotify.max_user_instances";
            let diagnostic = Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help(help);
            Error::new(diagnostic.into(), &Sources::new())
        };
        let events = FileEvents::new(move || {
            // The thread is gone where nobody receives it.
            let _ = changed.send(Order::Changed(Instant::now()));
        });
        let events = events.map_err(refused)?;
        let worker = Worker {
            library,
            target: Target::new(&path),
            orders: ordered,
            outcomes: done,
            wake: wake.clone(),
            events,
            parameters: Vec::new(),
            files: BTreeMap::new(),
            inputs: None,
            running: None,
            is_broken: false,
            last: None,
            #[cfg(feature = "gltf")]
            scene: None,
        };
        let thread = std::thread::Builder::new().name("umbragraph watcher".to_owned());
        let thread = thread.spawn(move || worker.run()).map_err(|error| refused(error.to_string()))?;
        let watcher = Self {
            orders,
            outcomes,
            thread: Some(thread),
            wake,
            told: None,
            ready: None,
            error: None,
            reload: None,
            running: None,
            warnings: Diagnostics::new(),
            planned_for: None,
            has_declared_imports: false,
            #[cfg(feature = "gltf")]
            scene: SceneNews::default(),
        };
        watcher.order(Order::Changed(Instant::now()));
        Ok(watcher)
    }

    /// Sets the parameter files; later files override earlier ones, and the options of frames override all.
    #[must_use]
    pub fn parameters(self, files: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.set_parameters(files);
        self
    }

    /// Replaces the list of parameter files, as [`Watcher::parameters`] sets it. The frame stays until they are read.
    pub fn set_parameters(&self, files: impl IntoIterator<Item = impl Into<PathBuf>>) {
        self.order(Order::Parameters(files.into_iter().map(Into::into).collect()));
    }

    /// Watches another pipeline. The pipeline before is drawn until a plan of the new one is ready.
    pub fn set_pipeline(&self, path: impl Into<PathBuf>) {
        self.order(Order::Pipeline(path.into()));
    }

    /// Sets the glTF scene. [`Watcher::take_scene`] returns it once it is loaded, and again after each change.
    #[cfg(feature = "gltf")]
    #[must_use]
    pub fn scene(self, path: impl Into<PathBuf>) -> Self {
        self.set_scene(path);
        self
    }

    /// Watches another scene, which [`Watcher::take_scene`] returns once it is loaded.
    #[cfg(feature = "gltf")]
    pub fn set_scene(&self, path: impl Into<PathBuf>) {
        self.order(Order::Scene(path.into()));
    }

    /// Sets further files, such as pictures, that the host reads itself. The function of [`Watcher::wake`] is called
    /// after each change of one of them.
    pub fn set_files(&self, files: impl IntoIterator<Item = impl Into<PathBuf>>) {
        self.order(Order::Files(files.into_iter().map(Into::into).collect()));
    }

    /// Plans imports as the documents declare them, whatever textures the frames bring. This suits a host that creates
    /// its textures from the plan, so that an edit can change their format.
    #[must_use]
    pub fn declared_imports(mut self) -> Self {
        self.has_declared_imports = true;
        self
    }

    /// Sets a function that a thread of the watcher calls when a frame could show something new: for windows that draw
    /// on demand.
    #[must_use]
    pub fn wake(self, wake: impl Fn() + Send + 'static) -> Self {
        *self.wake.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(wake));
        self
    }

    /// Reads all files again, as if each had changed: for file systems that report no changes.
    pub fn refresh(&self) {
        self.order(Order::Changed(Instant::now()));
    }

    /// Returns the error that keeps the current files from being drawn; `None` if the current files are drawn.
    pub fn error(&self) -> Option<&Error> {
        #[cfg(feature = "gltf")]
        if let Some(error) = &self.scene.error {
            return Some(error);
        }
        self.error.as_ref()
    }

    /// Returns the warnings and notes of the pipeline that is drawn, and the source texts that they point into. `None`
    /// until the first one is ready.
    pub fn warnings(&self) -> Option<(&Diagnostics, &Sources)> {
        self.running.as_ref().map(|read| (&self.warnings, &read.sources))
    }

    /// Returns the durations of the last applied change, once; `None` until the next change.
    pub fn take_reload(&mut self) -> Option<Reload> {
        self.reload.take()
    }

    /// Returns the pipeline that is drawn; `None` until the first one is ready.
    pub fn pipeline(&self) -> Option<&Pipeline> {
        self.running.as_ref().map(|read| &read.pipeline)
    }

    /// Returns the path of the pipeline that is drawn; `None` until the first one is ready.
    pub fn path(&self) -> Option<&Path> {
        self.running.as_ref().map(|read| read.path.as_path())
    }

    /// Returns the scene once after each load; otherwise `None`. Frames draw the new scene after
    /// [`Renderer::renew_source`](crate::Renderer::renew_source).
    #[cfg(feature = "gltf")]
    pub fn take_scene(&mut self) -> Option<crate::scene::Scene> {
        self.receive();
        self.scene.new.take().map(|scene| *scene)
    }

    /// Receives the pending messages of the worker thread.
    fn receive(&mut self) {
        while let Ok(outcome) = self.outcomes.try_recv() {
            match outcome {
                Outcome::Ready(ready) => {
                    self.error = self.error.take().filter(|_| !ready.is_current);
                    self.ready = Some(ready);
                }
                Outcome::Broken(error) => self.error = Some(error),
                Outcome::Same => self.error = None,
                Outcome::Files => {}
                #[cfg(feature = "gltf")]
                Outcome::Scene(Ok(scene)) => self.scene = SceneNews { new: Some(scene), error: None },
                #[cfg(feature = "gltf")]
                Outcome::Scene(Err(error)) => self.scene.error = Some(error),
            }
        }
    }

    /// Sends the inputs of frames to the worker thread, if they have changed.
    fn tell(&mut self, options: &Options, preparer: Option<PlanPreparer>) {
        let can_prepare = preparer.is_some();
        if self.told.as_ref().is_some_and(|told| told.0 == *options && told.1 == can_prepare) {
            return;
        }
        self.told = Some((options.clone(), can_prepare));
        self.order(Order::Inputs(Box::new(Inputs { options: options.clone(), preparer })));
    }

    /// Takes the finished plan if it was made for these options; otherwise discards it and returns `None`.
    fn take_ready(&mut self, options: &Options) -> Option<Box<Ready>> {
        self.ready.take().filter(|ready| ready.options == *options)
    }

    /// Records the files, options and warnings of the plan that was just installed, or the error that prevented its
    /// installation.
    fn took(
        &mut self,
        (read, warnings): (Read, Diagnostics),
        options: Options,
        taken: Result<Option<Reload>, Error>,
    ) {
        match taken {
            Ok(reload) => {
                (self.running, self.planned_for) = (Some(read), Some(options));
                self.warnings = warnings;
                self.reload = reload.or(self.reload);
            }
            Err(error) => self.error = Some(error),
        }
    }

    /// Plans the current files again for another frame size or other imports. Returns `None` if the last plan has the
    /// same size and imports, or if there is no plan yet.
    fn plan_for_others(&mut self, options: &Options) -> Result<Option<Arc<Plan>>, Error> {
        let is_same = |planned: &Options| {
            (planned.plan.viewport, &planned.plan.imports) == (options.plan.viewport, &options.plan.imports)
        };
        let Some(running) = self.running.as_ref().filter(|_| !self.planned_for.as_ref().is_some_and(is_same))
        else {
            return Ok(None);
        };
        // Tried once, whatever becomes of it.
        self.planned_for = Some(options.clone());
        let (plan, warnings) = running.plan(options)?;
        self.warnings = warnings;
        Ok(Some(plan))
    }

    fn order(&self, order: Order) {
        // Nobody receives it only where the thread panicked.
        let _ = self.orders.send(order);
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        self.order(Order::Stop);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl fmt::Debug for Watcher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watcher")
            .field("pipeline", &self.pipeline())
            .field("error", &self.error)
            .finish_non_exhaustive()
    }
}
