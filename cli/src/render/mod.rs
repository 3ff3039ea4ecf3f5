//! `umbragraph render`: one picture or many frames of a scene, and what textures hold on the way.

pub(crate) mod capture;
mod environment;
pub(crate) mod files;
mod radiance;
mod report;
mod shown;
mod surroundings;
mod target;
mod timings;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph::executor::{Texels, read_back};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::camera_path::{CameraPath, Obstacles};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::picture::colors_of;
use umbragraph::low_level::source::Sources;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::scene::{Pose, Scene};
use umbragraph::{Executor, Frame};

use self::environment::Environment;
use self::files::{Animation, Compression, Format};
use self::report::RunReport;
use self::surroundings::Surroundings;
use self::timings::Timings;
use crate::arguments::{RenderArguments, Shot, ToggleArgument};
use crate::device::{self, Graphics};
use crate::progress::Progress;
use crate::replace::unwritable;
use crate::session::Session;
use crate::streams::print;

/// Renders a pipeline as the arguments say. Returns `true` if there were no errors.
pub(crate) fn run(mut arguments: RenderArguments) -> bool {
    if arguments.environment.is_some() {
        arguments.choices.settings.feature.push("environment".to_owned());
    }
    let mut session = Session::new(&arguments.choices.files);
    let mut progress = Progress::new();
    let result = render(&arguments, &mut session, &mut progress);
    progress.finish();
    let said = match result {
        Ok(said) => Some(said),
        Err(diagnostics) => {
            session.diagnostics.extend(diagnostics);
            None
        }
    };
    let fine = session.report();
    if let Some(said) = said.filter(|_| fine) {
        print(&format!("{said}{}\n", progress.summary()));
        return true;
    }
    false
}

/// Renders the frames, writes the files, and returns a description of the written files.
///
/// # Errors
/// Diagnostics that the session does not have already.
fn render(
    arguments: &RenderArguments,
    session: &mut Session,
    progress: &mut Progress,
) -> Result<String, Diagnostics> {
    let output = Output::of(arguments)?;
    let path = session.camera(arguments.film.camera.as_ref())?;
    let choices = &arguments.choices;
    let checked = progress.stage("check", || session.check(&arguments.pipeline, choices));
    let scene = progress.stage("load scene", || session.scene(&arguments.scene))?;
    let plan = checked.plan.as_ref().ok_or_else(Diagnostics::new)?;
    session.diagnostics.extend(umbragraph::scene::filter::left_out(&scene, plan));
    session.ensure_fine(&checked)?;
    let environment = Environment::of(arguments.environment.as_deref(), plan)?;
    let (captures, document) = capture::captures(
        plan,
        &arguments.capture,
        arguments.capture_all.as_deref(),
        arguments.report.is_some(),
    )?;
    let mut report = match &arguments.report {
        Some(folder) => RunReport::begin(folder, &checked, session)?,
        None => None,
    };
    let reported = plan.clone();
    let graphics = progress.stage("open device", || device::open(arguments.drawn.adapter.as_deref()))?;
    let checked = if document.imports.is_empty() {
        checked
    } else {
        session.included = Some(document.text.clone());
        progress.stage("check captures", || session.check(&arguments.pipeline, choices))
    };
    let checked = session.check_on(&graphics, checked, &arguments.pipeline, choices);
    session.ensure_fine(&checked)?;
    let options = Session::options(&arguments.choices);
    let given = Given { captures: document.imports.clone(), environment };
    let mut drawing = Drawing::new(&graphics, &scene, checked, options, session, given)?;
    drawing.toggles = &arguments.toggles;
    if arguments.timings || arguments.trace.is_some() || report.is_some() {
        drawing.timings = Some(Timings::begin(&mut drawing.executor, &graphics.name));
    }
    let begin = |format| {
        let (size, rate) = (arguments.choices.size, arguments.film.fps);
        Animation::begin(&arguments.out, format, size, output.frames, rate, output.compression)
    };
    let mut animation = output.animation.map(begin).transpose()?;
    if let Some(folder) = arguments.capture_all.as_ref().filter(|_| !captures.is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    }
    progress.begin("draw", u64::from(output.frames));
    for shot in arguments.film.shots(output.frames) {
        let input = drawing.input(&path, shot);
        drawing.frame(&input)?;
        drawing.wait()?;
        if let Some(animation) = &mut animation {
            animation.frame(shot.index, &mut drawing.shown()?)?;
        }
        progress.advance();
    }
    let [width, height] = arguments.choices.size;
    match animation {
        Some(animation) => animation.finish()?,
        None => {
            let write = || -> Result<(), Diagnostic> {
                if output.is_exr {
                    return files::write_exr(&arguments.out, &drawing.numbers()?, false);
                }
                files::write_png(&arguments.out, [width, height], &drawing.shown()?, output.compression)
            };
            progress.stage("write", write)?;
        }
    }
    let frames = if output.frames > 1 { format!("{} frames of ", output.frames) } else { String::new() };
    let mut said = format!("{}: {frames}{width} by {height} on {}\n", arguments.out.display(), graphics.name);
    progress.begin("write captures", captures.len() as u64);
    for ((capture, texels), by) in captures.iter().zip(drawing.captured()?).zip(&document.overwritten) {
        match &mut report {
            Some(report) if capture.is_reported() => report.add(capture, &texels),
            _ => said.push_str(&capture.write(&texels, output.compression, by.as_deref())?),
        }
        progress.advance();
    }
    if let Some(timings) = &drawing.timings {
        if arguments.timings {
            said.push_str(&timings.table());
        }
        if let Some(path) = &arguments.trace {
            said.push_str(&timings.trace(path)?);
        }
    }
    let note = drawing.note().filter(|_| !output.is_exr);
    let notices: Vec<Diagnostic> = drawing.notices().into_iter().chain(note).collect();
    session.diagnostics.extend(notices);
    if let (Some(report), Some(folder)) = (&report, &arguments.report) {
        let (frame, timings) = (drawing.shown()?, drawing.timings.as_ref());
        said.push_str(&report.write(folder, &reported, &frame, timings, (session, &graphics.name))?);
    }
    Ok(said)
}

/// The kind of output that the arguments select.
struct Output {
    /// The format of an animation or of numbered pictures; `None` for a single picture.
    animation: Option<Format>,
    /// Set if the output is a single EXR picture with unconverted numbers.
    is_exr: bool,
    frames: u32,
    compression: Compression,
}

impl Output {
    /// Determines the kind of output from the arguments.
    ///
    /// # Errors
    /// Arguments that exclude each other.
    fn of(arguments: &RenderArguments) -> Result<Self, Diagnostic> {
        let frames = arguments.frames.unwrap_or(1);
        let formats =
            [(".png", Format::Png), (".exr", Format::Exr), (".apng", Format::Apng), (".gif", Format::Gif)];
        let format = files::check("--out", &arguments.out, &formats)?;
        let is_exr = format == Format::Exr;
        if is_exr && (frames > 1 || files::is_numbered(&arguments.out)) {
            let message = format!("--out: \"{}\" is one picture", arguments.out.display());
            return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
                .help("write frames as .png, .apng or .gif; an .exr is one frame"));
        }
        if frames > 1 && format == Format::Png && !files::is_numbered(&arguments.out) {
            let message =
                format!("--out: \"{}\" is one picture, --frames asks for {frames}", arguments.out.display());
            return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
                .help("write # where the number of a frame goes, as in frame-####.png, or a file that ends in .apng or .gif"));
        }
        let compression = Compression { fast: arguments.fast };
        let is_picture = is_exr || format == Format::Png;
        let single = frames == 1 && is_picture && !files::is_numbered(&arguments.out);
        Ok(Self { animation: (!single).then_some(format), is_exr, frames, compression })
    }
}

/// The maximum number of times that one frame is recorded. After each recording but the last, CPU passes may request
/// other data sizes, and the frame is planned again.
const ROUNDS: usize = 8;

/// A scene that is rendered frame by frame.
pub(crate) struct Drawing<'a> {
    graphics: &'a Graphics,
    scene: &'a Scene,
    checked: CheckReport,
    options: PlanOptions,
    sources: Sources,
    toggles: &'a [ToggleArgument],
    picture: String,
    /// The names of the imported textures for captures.
    captures: Vec<String>,
    draws: SceneResources,
    pose: Pose,
    /// The obstacles that a moving camera avoids; `None` for other cameras.
    surroundings: Option<Surroundings<'a>>,
    pub(crate) executor: Executor,
    imports: Vec<(String, wgpu::Texture)>,
    environment: Option<Environment>,
    timings: Option<Timings>,
    /// The names of lights that no pass has read in any frame so far; `None` before the first frame.
    unread_lights: Option<Vec<String>>,
}

/// The inputs of a [`Drawing`] that depend on the command line: the textures to capture, and the environment.
#[derive(Default)]
pub(crate) struct Given {
    /// The names of the textures into which captures are copied.
    captures: Vec<String>,
    /// The environment picture; `None` if there is none.
    environment: Option<Environment>,
}

impl<'a> Drawing<'a> {
    pub(crate) fn new(
        graphics: &'a Graphics,
        scene: &'a Scene,
        checked: CheckReport,
        options: PlanOptions,
        session: &Session,
        Given { captures, environment }: Given,
    ) -> Result<Self, Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        // A plan that needs a picture of the surroundings is rejected without one.
        let environment = environment.map_or_else(|| Environment::of(None, &plan), |one| Ok(Some(one)))?;
        let pose = scene.rest_pose();
        let draws = SceneResources::new(&graphics.device, &graphics.queue, scene, &pose)?;
        let picture = colors_of(&plan, &captures)?.to_owned();
        let imports = target::imports(graphics, &plan, &picture);
        let executor = Executor::new(&graphics.device, &graphics.queue, plan, Some(&draws))?;
        Ok(Self {
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
            environment,
            timings: None,
            unread_lights: None,
        })
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
                environment.bring(queue, &self.imports);
            }
            let imports: Vec<(&str, &wgpu::Texture)> =
                self.imports.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
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
    fn wait(&self) -> Result<(), Diagnostic> {
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
        Ok(self.executor.set_plan(Arc::new(plan))?)
    }

    /// Continues with a plan that was checked with other settings.
    #[cfg(feature = "score")]
    pub(crate) fn set_plan(&mut self, checked: CheckReport, session: &Session) -> Result<(), Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        (self.checked, self.sources) = (checked, session.sources().clone());
        self.options.data_sizes.clear();
        self.imports = target::imports(self.graphics, &plan, &self.picture);
        Ok(self.executor.set_plan(plan)?)
    }

    /// Returns the notices of CPU passes about the last frame, and a warning about lights that no pass read.
    fn notices(&self) -> Vec<Diagnostic> {
        let unread = self.unread_lights.as_deref().filter(|names| !names.is_empty()).map(|names| {
            let names = list_of(names.iter().map(String::as_str));
            let message = format!("no pass of the pipeline reads the lights {names}");
            Diagnostic::warning(crate::codes::UNREAD_LIGHTS, Place::Nowhere, message)
                .help("the picture is without them; pipelines/awsm.json takes every kind of light")
        });
        self.executor.notices().cloned().chain(unread).collect()
    }

    /// Reads the captured textures of the last frame back from the device.
    fn captured(&self) -> Result<Vec<Texels>, Diagnostics> {
        let Graphics { device, queue, .. } = self.graphics;
        let texture = |name: &String| self.imports.iter().find(|(import, _)| import == name);
        let textures = self.captures.iter().filter_map(texture);
        let texels: Result<Vec<_>, Diagnostic> =
            textures.map(|(_, texture)| pollster::block_on(read_back(device, queue, texture))).collect();
        Ok(texels?)
    }
}
