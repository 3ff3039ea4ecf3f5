//! The live frame: a watched pipeline on a watched scene, drawn into a texture of the window.
//!
//! Nothing is drawn unless something changed: files, values, the camera, the time, the size. After a change, a pipeline
//! with histories is drawn some frames more, until they have settled. One frame is on the device at a time, so that a
//! software driver leaves the window its share.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::picture::without_lights;
use umbragraph::low_level::source::Sources;
use umbragraph::scene::Scene;
use umbragraph::{Error, Frame, Library, Plan, Renderer, Watcher, wgpu};

use crate::arguments::Arguments;
use crate::camera::View;
use crate::given::Given;
use crate::guard::guarded;
use crate::progress::Progress;
use crate::shown::Shown;
use crate::sizes::Sizes;
use crate::state::Kept;
use crate::targets::{self, Targets};
use crate::values::Values;

/// The number of frames drawn after a change, until history resources have settled.
const SETTLE: u32 = 8;

/// The live frame: files, renderer, targets, and the state of drawing.
pub(crate) struct Stage {
    pub(crate) library: Library,
    watcher: Watcher,
    /// Set by the watcher when it has loaded changes; cleared when the next frame is drawn.
    news: Arc<AtomicBool>,
    pub(crate) renderer: Renderer,
    pub(crate) shown: Option<Shown>,
    pub(crate) targets: Targets,
    /// The running plan, for which targets and live values were set; `None` before the first plan.
    pub(crate) plan: Option<Arc<Plan>>,
    has_new_plan: bool,
    /// The number of plans that have run so far.
    pub(crate) plans: u64,
    /// The values from the last call of [`Stage::update`].
    pub(crate) values: Values,
    /// The input of the last frame; `None` before the first one.
    pub(crate) last: Option<FrameInput>,
    /// The contents that the last frame began with.
    pub(crate) kept: Kept,
    /// Whether somebody looks at contents, so that those that a frame begins with are kept.
    is_looked_at: bool,
    sizes: Sizes,
    given: Given,
    /// The path of the pipeline that was opened last.
    wanted: PathBuf,
    /// Whether the device can measure the GPU times of passes.
    pub(crate) has_gpu_times: bool,
    /// The reason why the last frame was not recorded; `None` if it was.
    failed: Option<Error>,
    /// The reason why the device rejected the scene; `None` if it did not.
    no_scene: Option<Error>,
    /// The reason why a live value could not be set; `None` if all were set.
    unset: Option<Error>,
    /// The reason why the plan has no picture to show; `None` if it has one.
    no_picture: Option<Error>,
    /// The number of frames that are still to be drawn.
    pending: u32,
    pub(crate) index: u64,
    progress: Progress,
}

/// The inputs of a frame: size in texels, values, camera and animation time in seconds.
pub(crate) struct Shot<'a> {
    pub(crate) size: [u32; 2],
    pub(crate) values: &'a Values,
    pub(crate) view: Option<&'a View>,
    pub(crate) time: f64,
}

impl Stage {
    pub(crate) fn new(
        arguments: &Arguments,
        state: &RenderState,
        context: &egui::Context,
    ) -> Result<Self, Error> {
        let flags = state.adapter.get_downlevel_capabilities().flags;
        let profile = umbragraph::low_level::shader::TargetProfile::webgpu();
        let mut library = Library::new().profile(profile.on_device(&state.device.limits(), flags));
        if let Some(folder) = &arguments.templates {
            library = library.templates(folder);
        }
        for folder in &arguments.root {
            library = library.root(folder);
        }
        let news: Arc<AtomicBool> = Arc::default();
        let watcher = watch(&library, arguments, &news, context)?;
        let given = Given::read(arguments)?;
        Ok(Self {
            library,
            watcher,
            news,
            renderer: Renderer::new(&state.device, &state.queue),
            shown: None,
            targets: Targets::default(),
            plan: None,
            has_new_plan: false,
            plans: 0,
            values: Values::default(),
            last: None,
            kept: Kept::default(),
            is_looked_at: false,
            sizes: Sizes::default(),
            given,
            wanted: arguments.pipeline.clone(),
            has_gpu_times: false,
            failed: None,
            no_scene: None,
            unset: None,
            no_picture: None,
            pending: SETTLE,
            index: 0,
            progress: Progress::new(),
        })
    }

    /// The reason why the frame does not show the current files; `None` if it does.
    pub(crate) fn error(&self) -> Option<&Error> {
        let own = [&self.no_scene, &self.unset, &self.no_picture, &self.failed];
        let own = || own.into_iter().flatten().next();
        self.watcher.error().or_else(own).or_else(|| self.given.error())
    }

    /// The pipeline that is drawn; `None` before the first one.
    pub(crate) fn pipeline(&self) -> Option<&umbragraph::Pipeline> {
        self.watcher.pipeline()
    }

    /// The path of the pipeline that is drawn; `None` before the first one.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.watcher.path()
    }

    /// The warnings and notes of the files that are drawn, with their sources, and those of the viewer about the plan.
    pub(crate) fn warnings(&self) -> (Vec<Diagnostic>, Sources) {
        let (found, sources) = self.watcher.warnings().unzip();
        let own = self
            .plan
            .iter()
            .flat_map(|plan| self.given.warnings(plan).into_iter().chain(targets::note(plan)));
        let all = found.into_iter().flatten().cloned().chain(own).collect();
        (all, sources.cloned().unwrap_or_default())
    }

    /// Opens another pipeline. The old one is drawn until a plan of the new one is there.
    pub(crate) fn open_pipeline(&mut self, path: &Path) {
        self.watcher.set_pipeline(path);
        self.wanted = path.to_owned();
    }

    /// The path of the pipeline that was opened last; it may not be drawn yet.
    pub(crate) fn wanted(&self) -> &Path {
        &self.wanted
    }

    /// Opens another scene. The old one is drawn until the new one is loaded.
    pub(crate) fn open_scene(&mut self, path: &Path) {
        self.watcher.set_scene(path);
    }

    /// Applies other parameter files.
    pub(crate) fn open_parameters(&mut self, paths: &[PathBuf]) {
        self.watcher.set_parameters(paths);
    }

    pub(crate) fn scene(&self) -> Option<&Scene> {
        self.shown.as_ref().map(|shown| &shown.scene)
    }

    /// Requests at least one more frame, several if the plan has history resources.
    pub(crate) fn touch(&mut self) {
        let settles = self.plan.as_ref().is_some_and(|plan| !plan.histories.is_empty());
        self.pending = self.pending.max(if settles { SETTLE } else { 1 });
    }

    /// Returns `true` if frames are still to be drawn or in progress on the device.
    pub(crate) fn is_busy(&self) -> bool {
        self.shown.is_some() && (self.pending > 0 || self.progress.is_in_flight())
    }

    /// Takes the time from recording to completion of the last frame, in milliseconds. `None` if it was already taken.
    pub(crate) fn take_frame_time(&self) -> Option<f64> {
        self.progress.take_time()
    }

    /// The resolution of the picture in an area of the given size in pixels: texels per pixel along the width. It is 1
    /// before the first picture.
    pub(crate) fn scale_of(&self, area: [u32; 2]) -> f32 {
        self.targets.shown().map_or(1.0, |(_, size)| size[0] as f32 / area[0].max(1) as f32)
    }

    /// Returns `true` if the plan has changed since the last call.
    pub(crate) fn take_new_plan(&mut self) -> bool {
        std::mem::take(&mut self.has_new_plan)
    }

    /// Reloads all files and requests a frame.
    pub(crate) fn refresh(&mut self) {
        self.watcher.refresh();
        self.touch();
    }

    /// The notices of the last frame, such as a light for which a shadow atlas has no room.
    pub(crate) fn notices(&mut self) -> Vec<Diagnostic> {
        let Some(executor) = self.renderer.executor() else { return Vec::new() };
        let unread = self.last.as_ref().map(|input| executor.unread_lights(input)).unwrap_or_default();
        executor.notices().cloned().chain(without_lights(unread.into_iter())).collect()
    }

    /// Begins or ends the copies of persistent contents, which only a look needs. The frame on screen is drawn once
    /// more, so that a first look has what it began with.
    pub(crate) fn look(&mut self, is_looked_at: bool) {
        if self.is_looked_at == is_looked_at {
            return;
        }
        self.is_looked_at = is_looked_at;
        if !is_looked_at {
            self.kept = Kept::default();
        } else if self.plan.as_deref().is_some_and(Kept::is_needed) {
            self.pending = self.pending.max(1);
        }
    }

    /// Draws a frame if one is requested and the device has finished the last one. Returns `true` if a frame was drawn.
    pub(crate) fn update(&mut self, state: &RenderState, shot: Shot<'_>, context: &egui::Context) -> bool {
        if self.values != *shot.values {
            self.values = shot.values.clone();
            self.set_live();
            self.touch();
        }
        if self.targets.shown().is_some_and(|(_, size)| size != shot.size) {
            self.touch();
        }
        if self.progress.is_in_flight() || self.shown.is_none() {
            return false;
        }
        // What the watcher has ready is taken over by a record alone.
        if self.news.swap(false, Ordering::AcqRel) {
            self.pending = self.pending.max(1);
            if self.given.read_again(self.plan.as_deref()) {
                self.touch();
            }
        }
        if self.pending == 0 {
            return false;
        }
        self.pending = self.pending.saturating_sub(1);
        if let Some(plan) = self.plan.clone() {
            self.fit(state, &plan, shot.size);
        }
        let Some(shown) = &mut self.shown else { return false };
        let input = shown.input(state, &shot, self.index);
        self.progress.begin();
        let mut recorded = self.record(state, &input, shot.size);
        // A new plan may import what was not there yet.
        if self.notice_plan(state, shot.size) && recorded.is_err() {
            recorded = self.record(state, &input, shot.size);
        }
        let drawn = matches!(recorded, Ok(true));
        self.failed = recorded.err();
        if drawn {
            self.last = Some(input);
            self.index += 1;
            self.progress.submitted(&state.queue, context);
        }
        drawn
    }

    /// Takes the scene that the watcher has loaded. Returns `true` if there is one that the device takes.
    pub(crate) fn take_scene(&mut self, state: &RenderState) -> bool {
        let Some(scene) = self.watcher.take_scene() else { return false };
        match Shown::new(state, scene) {
            Ok(shown) => {
                self.shown = Some(shown);
                self.renderer.renew_source();
                self.no_scene = None;
            }
            Err(error) => self.no_scene = Some(error),
        }
        self.touch();
        self.no_scene.is_none()
    }

    /// Records and submits a frame. Returns `true` if a frame was drawn.
    fn record(&mut self, state: &RenderState, input: &FrameInput, size: [u32; 2]) -> Result<bool, Error> {
        guarded(&state.device, "the frame", || self.record_frame(state, input, size)).map_err(error_of)?
    }

    fn record_frame(
        &mut self,
        state: &RenderState,
        input: &FrameInput,
        size: [u32; 2],
    ) -> Result<bool, Error> {
        let mut options = self.values.options(size, self.plan.as_deref());
        if let Some(sizes) = &self.sizes.wanted {
            options = options.data_sizes(sizes.clone());
        }
        let Some(shown) = &self.shown else { return Ok(false) };
        let imports = self.targets.imports();
        let mut toggles = self.plan.as_deref().map(|plan| self.values.toggles_of(plan)).unwrap_or_default();
        if let Some(plan) = &self.plan {
            self.given.bring(&state.queue, plan, &imports, &mut toggles);
        }
        let frame = Frame::new(input).draws(&shown.meshes).imports(&imports).toggles(&toggles);
        let mut encoder = state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let (Some(executor), Some(plan), true) = (self.renderer.executor(), &self.plan, self.is_looked_at)
        {
            self.kept.save(&state.device, &mut encoder, executor, plan, &imports);
        }
        let drawn = self.renderer.record_watched(&mut self.watcher, &options, &mut encoder, &frame)?;
        if drawn {
            self.targets.convert(&mut encoder);
            state.queue.submit([encoder.finish()]);
            self.kept.submitted();
            self.given.drawn();
        }
        let wanted = self.renderer.executor().map(|executor| executor.wanted_sizes());
        if wanted.is_some_and(|wanted| self.sizes.request(wanted)) {
            self.touch();
        }
        Ok(drawn)
    }

    /// Updates live values, targets and time measurement if the executor has a new plan. Returns `true` if it has one.
    fn notice_plan(&mut self, state: &RenderState, size: [u32; 2]) -> bool {
        let Some(executor) = self.renderer.executor() else { return false };
        let plan = executor.plan().clone();
        if self.plan.as_ref().is_some_and(|known| Arc::ptr_eq(known, &plan)) {
            return false;
        }
        executor.measure_times(true);
        self.has_gpu_times = executor.measure_gpu_times(true);
        let names = |plan: &Plan| plan.imports().map(|(name, _)| name.to_owned()).collect::<Vec<_>>();
        let is_alike = self.plan.as_ref().is_some_and(|known| names(known) == names(&plan));
        if !is_alike {
            self.targets.clear();
        }
        self.fit(state, &plan, size);
        self.given.planned(&plan);
        self.plan = Some(plan);
        self.has_new_plan = true;
        self.plans += 1;
        self.set_live();
        self.touch();
        true
    }

    /// Creates the textures that a plan imports, and stores the error if the plan has no picture to show.
    fn fit(&mut self, state: &RenderState, plan: &Plan, size: [u32; 2]) {
        let fitted = self.targets.fit(state, plan, size);
        self.no_picture = fitted.err().map(|found| Error::new(found.into(), &plan.pipeline.sources));
    }

    fn set_live(&mut self) {
        if let Some(executor) = self.renderer.executor() {
            self.unset = self.values.set_live(executor).err();
        }
    }
}

/// Creates a watcher for the pipeline, parameter files and scene of the arguments.
fn watch(
    library: &Library,
    arguments: &Arguments,
    news: &Arc<AtomicBool>,
    context: &egui::Context,
) -> Result<Watcher, Error> {
    let (news, wake) = (news.clone(), context.clone());
    let watcher = Watcher::new(library.clone(), &arguments.pipeline)?;
    watcher.set_files(arguments.imports.iter().map(|one| &one.path));
    Ok(watcher.parameters(arguments.params.clone()).scene(&arguments.scene).declared_imports().wake(
        move || {
            news.store(true, Ordering::Release);
            wake.request_repaint();
        },
    ))
}

/// Converts a diagnostic without a source location to an error.
pub(crate) fn error_of(found: Diagnostic) -> Error {
    Error::new(found.into(), &Default::default())
}
