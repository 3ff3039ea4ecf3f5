//! A scene that is rendered frame by frame.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::executor::{read_back, read_buffer, read_sample};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::camera_path::{CameraPath, Obstacles};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::environment::Environment;
use umbragraph::low_level::import::ImportFiles;
use umbragraph::low_level::picture::{colors_of, without_lights};
use umbragraph::low_level::source::Sources;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::scene::{Pose, Scene};
use umbragraph::{Executor, Frame};

use super::capture::Captured;
use super::surroundings::Surroundings;
use super::target;
use super::timings::Timings;
use crate::arguments::{Shot, ToggleArgument};
use crate::device::Graphics;
use crate::session::Session;

/// The maximum number of times that one frame is recorded. After each recording but the last, CPU passes may request
/// other data sizes, and the frame is planned again.
const ROUNDS: usize = 8;

/// A scene that is rendered frame by frame.
pub(crate) struct Drawing<'a> {
    pub(super) graphics: &'a Graphics,
    scene: &'a Scene,
    checked: CheckReport,
    options: PlanOptions,
    sources: Sources,
    pub(super) toggles: &'a [ToggleArgument],
    pub(super) picture: String,
    /// The names of the imports for captures.
    pub(super) captures: Vec<String>,
    draws: SceneResources,
    pose: Pose,
    /// The obstacles that a moving camera avoids; `None` for other cameras.
    surroundings: Option<Surroundings<'a>>,
    pub(crate) executor: Executor,
    pub(super) imports: Vec<(String, wgpu::Texture)>,
    /// The buffers for captures, which the executor keeps.
    buffers: Vec<(String, wgpu::Buffer)>,
    environment: Option<Environment>,
    files: ImportFiles,
    pub(super) timings: Option<Timings>,
    /// The names of lights that no pass has read in any frame so far; `None` before the first frame.
    unread_lights: Option<Vec<String>>,
}

/// The inputs of a [`Drawing`] that depend on the command line: captures, environment, and files of imports.
#[derive(Clone, Default)]
pub(crate) struct Given {
    /// The names of the imports into which captures are copied.
    pub(crate) captures: Vec<String>,
    /// The environment picture; `None` if there is none.
    pub(crate) environment: Option<Environment>,
    /// The pictures for imported textures.
    pub(crate) files: ImportFiles,
}

impl<'a> Drawing<'a> {
    pub(crate) fn new(
        graphics: &'a Graphics,
        scene: &'a Scene,
        checked: CheckReport,
        options: PlanOptions,
        session: &Session,
        Given { captures, environment, files }: Given,
    ) -> Result<Self, Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        // A plan that needs a picture of the surroundings is rejected without one.
        let environment = environment.map_or_else(|| Environment::of(None, &plan), |one| Ok(Some(one)))?;
        let pose = scene.rest_pose();
        let draws = SceneResources::new(&graphics.device, &graphics.queue, scene, &pose)?;
        let picture = colors_of(&plan, &captures)?.to_owned();
        let imports = target::imports(graphics, &plan, &picture);
        let executor = Executor::new(&graphics.device, &graphics.queue, plan, Some(&draws))?;
        let mut drawing = Self {
            graphics,
            scene,
            checked,
            options,
            sources: session.sources().clone(),
            toggles: &[],
            picture,
            captures,
            draws,
            pose,
            surroundings: None,
            executor,
            imports,
            buffers: Vec::new(),
            environment,
            files,
            timings: None,
            unread_lights: None,
        };
        drawing.give_buffers()?;
        Ok(drawing)
    }

    /// Creates the buffers for captures, as large as the plan says, and gives them to the executor.
    fn give_buffers(&mut self) -> Result<(), Diagnostics> {
        self.buffers = target::buffers(self.graphics, self.executor.plan(), &self.captures);
        for (name, buffer) in &self.buffers {
            let import = self.executor.import::<wgpu::Buffer>(name)?;
            self.executor.give(import, buffer)?;
        }
        Ok(())
    }

    /// Places the camera on its path, and the meshes in their pose, for one frame. Returns the input of that frame.
    pub(crate) fn input(&mut self, path: &CameraPath, shot: Shot) -> FrameInput {
        let Shot { index, time, part } = shot;
        let index = u64::from(index);
        self.place(time);
        let [width, height] = self.options.viewport;
        let aspect = f64::from(width) / f64::from(height);
        let input = self.scene.frame_input_of(&self.pose, aspect, time);
        if path.may_collide() && self.surroundings.is_none() {
            self.surroundings = Some(Surroundings::new(self.scene));
        }
        let moment = [index as f64, part, time];
        let around = self.surroundings.as_ref().map(|around| around as &dyn Obstacles);
        let camera = path.camera(input.camera, &input.scene_bounds, around, moment);
        input.camera(camera).index(index)
    }

    /// Moves the meshes to an animation time, in seconds.
    pub(crate) fn place(&mut self, time: f64) {
        self.scene.pose_into(time, &mut self.pose);
        self.draws.update(&self.graphics.queue, self.scene, &self.pose);
    }

    /// Returns the pose that the last call of [`Self::input`] or [`Self::place`] set.
    #[cfg(feature = "score")]
    pub(crate) fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Renders a frame and returns the errors of wgpu as diagnostics.
    pub(crate) fn frame(&mut self, input: &FrameInput) -> Result<(), Diagnostics> {
        let Graphics { device, .. } = self.graphics;
        let scopes = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::OutOfMemory]
            .map(|filter| device.push_error_scope(filter));
        let drawn = self.record(input);
        let errors = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
        // All of them are taken, the last first, whatever was found.
        let rejected = errors.collect::<Vec<_>>().into_iter().flatten().next();
        drawn?;
        match rejected {
            Some(error) => {
                let message = format!("the device rejected the frame: {error}");
                Err(Diagnostic::error(codes::DEVICE, Place::Nowhere, message)
                    .help("please report this: what a device rejects should have been found before")
                    .into())
            }
            None => Ok(()),
        }
    }

    /// Records and submits a frame; plans again while CPU passes request other data sizes.
    fn record(&mut self, input: &FrameInput) -> Result<(), Diagnostics> {
        let Graphics { device, queue, .. } = self.graphics;
        for round in 0..ROUNDS {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(environment) = &mut self.environment {
                environment.bring(queue, self.imports.iter().map(|(name, texture)| (name.as_str(), texture)));
            }
            let imports: Vec<(&str, &wgpu::Texture)> =
                self.imports.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
            self.files.bring(queue, self.executor.plan(), imports.iter().copied());
            let begun = self.toggles.iter().filter(|toggle| u64::from(toggle.since) <= input.index);
            // Of several for one toggle the latest counts.
            let kept = self.environment.as_ref().and_then(|one| one.kept(self.executor.plan()));
            let states: BTreeMap<&str, (u32, bool)> =
                begun.fold(kept.into_iter().collect(), |mut states: BTreeMap<_, _>, toggle| {
                    let state = states.entry(&toggle.name).or_insert((toggle.since, toggle.on));
                    if toggle.since >= state.0 {
                        *state = (toggle.since, toggle.on);
                    }
                    states
                });
            let toggles: Vec<(&str, bool)> = states.into_iter().map(|(name, (_, on))| (name, on)).collect();
            let frame = Frame::new(input).draws(&self.draws).imports(&imports).toggles(&toggles);
            let start = Instant::now();
            self.executor.record(&mut encoder, &frame)?;
            let end = Instant::now();
            match self.executor.wanted_sizes().filter(|_| round + 1 < ROUNDS) {
                Some(sizes) => self.plan_again(sizes)?,
                None => {
                    queue.submit([encoder.finish()]);
                    self.environment.iter_mut().for_each(Environment::drawn);
                    if let Some(timings) = &mut self.timings {
                        timings.frame(&mut self.executor, [start, end], input.index);
                    }
                    break;
                }
            }
        }
        let unread = self.executor.unread_lights(input);
        match &mut self.unread_lights {
            Some(known) => known.retain(|name| unread.contains(&name.as_str())),
            None => self.unread_lights = Some(unread.into_iter().map(str::to_owned).collect()),
        }
        Ok(())
    }

    /// Waits until the device has executed all submitted work.
    pub(super) fn wait(&self) -> Result<(), Diagnostic> {
        let waited = self.graphics.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map(|_| ()).map_err(|error| {
            Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("the device does not finish: {error}"))
                .help("try a smaller picture, or another driver")
        })
    }

    /// Replaces the plan by one with the data sizes that CPU passes request.
    fn plan_again(&mut self, data_sizes: BTreeMap<String, u32>) -> Result<(), Diagnostics> {
        self.options.data_sizes = data_sizes;
        let plan: Plan = self.checked.plan_again(&self.options, &self.sources)?;
        self.imports = target::imports(self.graphics, &plan, &self.picture);
        self.executor.set_plan(Arc::new(plan))?;
        self.give_buffers()
    }

    /// Continues with a plan that was checked with other settings.
    #[cfg(feature = "score")]
    pub(crate) fn set_plan(&mut self, checked: CheckReport, session: &Session) -> Result<(), Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        (self.checked, self.sources) = (checked, session.sources().clone());
        self.options.data_sizes.clear();
        self.imports = target::imports(self.graphics, &plan, &self.picture);
        self.executor.set_plan(plan)?;
        self.give_buffers()
    }

    /// Returns the notices of CPU passes about the last frame, and a warning about lights that no pass read.
    pub(super) fn notices(&self) -> Vec<Diagnostic> {
        let unread = self.unread_lights.iter().flatten().map(String::as_str);
        let unread = without_lights(unread);
        self.executor.notices().cloned().chain(unread).collect()
    }

    /// Reads the captures of the last frame back from the device, one by one.
    pub(crate) fn captured(&self) -> impl Iterator<Item = Result<Captured, Diagnostic>> {
        self.captures.iter().map(|name| {
            let Graphics { device, queue, .. } = self.graphics;
            if let Some((_, buffer)) = self.buffers.iter().find(|(known, _)| known == name) {
                return pollster::block_on(read_buffer(device, queue, buffer)).map(Captured::Bytes);
            }
            let Some((_, texture)) = self.imports.iter().find(|(import, _)| import == name) else {
                let message = format!("the plan has no import \"{name}\" for a capture");
                return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message));
            };
            let samples = texture.sample_count();
            let texels = match samples {
                1 => pollster::block_on(read_back(device, queue, texture)),
                _ => pollster::block_on(read_sample(device, queue, texture, 0)),
            };
            texels.map(|texels| Captured::Texels { texels, samples })
        })
    }
}
