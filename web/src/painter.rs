//! [`Painter`]: a WebGPU device that draws pipelines with a scene, into a texture and onto a canvas.

use std::sync::{Arc, Mutex, PoisonError};

use serde_json::Value;
use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::executor::{read_back, read_bytes};
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::glam::{DQuat, DVec3};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::Sources;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::scene::{NoFiles, Pose, Scene, from_slice};
use umbragraph::wgpu;
use wasm_bindgen::prelude::wasm_bindgen;
use web_sys::OffscreenCanvas;

use crate::contents::{Contents, Extended};
use crate::picture::Picture;
use crate::project::Project;
use crate::settings;

/// A device, a scene on it, and the pipeline that draws it.
#[wasm_bindgen]
pub struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    canvas: Option<wgpu::Surface<'static>>,
    flags: wgpu::DownlevelFlags,
    name: String,
    lost: Arc<Mutex<Option<String>>>,
    scene: Option<Shown>,
    picture: Option<Picture>,
    view: View,
}

/// The scene that is shown, on the device.
struct Shown {
    scene: Scene,
    pose: Pose,
    draws: SceneResources,
}

/// The orbit of the camera around the middle of the scene, relative to the scene's own camera.
#[derive(Clone, Copy)]
struct View {
    /// The turn of the camera, to the side and up, in radians.
    turn: [f64; 2],
    /// The distance to the middle, as a multiple of the scene's camera distance.
    distance: f64,
}

/// The error type for the web page: a sentence, or diagnostics as readable text.
type Reason = String;

#[wasm_bindgen]
impl Painter {
    /// Opens a device; pictures are shown on a canvas, if one is given.
    ///
    /// # Errors
    /// A browser without WebGPU, or one that has no device for it.
    pub async fn open(canvas: Option<OffscreenCanvas>) -> Result<Painter, Reason> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = instance.request_adapter(&options).await;
        let adapter = adapter.map_err(|error| format!("this browser has no WebGPU adapter: {error}"))?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("umbragraph"),
            required_features: adapter.features() & wgpu::Features::all_webgpu_mask(),
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|error| format!("the adapter gives no device: {error}"))?;
        let canvas =
            canvas.map(|canvas| instance.create_surface(wgpu::SurfaceTarget::OffscreenCanvas(canvas)));
        let canvas = canvas.transpose().map_err(|error| format!("the canvas cannot be drawn on: {error}"))?;
        let lost: Arc<Mutex<Option<String>>> = Arc::default();
        let reason = lost.clone();
        device.set_device_lost_callback(move |_, message| {
            *reason.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        });
        let info = adapter.get_info();
        Ok(Self {
            device,
            queue,
            canvas,
            flags: adapter.get_downlevel_capabilities().flags,
            name: if info.name.is_empty() { "WebGPU".to_owned() } else { info.name },
            lost,
            scene: None,
            picture: None,
            view: View { turn: [0.0; 2], distance: 1.0 },
        })
    }

    /// The name that the browser gives the adapter.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Returns the reason of a lost device; `None` while it works. A lost device draws nothing, so open another
    /// painter.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Takes the scene of a `.glb` file.
    ///
    /// # Errors
    /// Diagnostics of a file that is none, as text.
    pub fn scene(&mut self, name: &str, bytes: &[u8]) -> Result<(), Reason> {
        let scene = from_slice(name, bytes, &NoFiles).map_err(|found| in_words(&found, &Sources::new()))?;
        let pose = scene.rest_pose();
        let draws = SceneResources::new(&self.device, &self.queue, &scene, &pose);
        let draws = draws.map_err(|found| in_words(&found, &Sources::new()))?;
        self.scene = Some(Shown { scene, pose, draws });
        // Meshes are stored in another way, perhaps.
        self.picture = None;
        Ok(())
    }

    /// Takes a pipeline, with the values of a parameter file. The answer is that of [`Project::plan`] without a plan;
    /// where it has errors, the pipeline before goes on.
    pub fn pipeline(
        &mut self,
        project: &mut Project,
        path: &str,
        values: &str,
        width: u32,
        height: u32,
    ) -> String {
        let options = PlanOptions::new(width, height);
        let (planned, mut diagnostics) = project.planned(path, values, None, options.clone());
        let is_whole = |planned: &_, diagnostics: &Diagnostics| {
            let planned: &umbragraph::low_level::session::Planned = planned;
            planned.report.plan.is_some() && !diagnostics.has_errors()
        };
        let Some(mut planned) = planned.filter(|planned| is_whole(planned, &diagnostics)) else {
            return project.answer(diagnostics, Value::Null);
        };
        if let Some(pipeline) = &planned.report.pipeline {
            let profile = self.profile(pipeline);
            if profile != pipeline.profile
                && let (Some(again), found) = project.planned(path, values, Some(profile), options.clone())
            {
                (planned, diagnostics) = (again, found);
                if !is_whole(&planned, &diagnostics) {
                    return project.answer(diagnostics, Value::Null);
                }
            }
        }
        let draws = self.scene.as_ref().map(|shown| &shown.draws);
        let made = match &mut self.picture {
            Some(picture) => picture.go_on(&self.device, planned.report, options, project.sources(), draws),
            None => {
                let made = Picture::new(
                    &self.device,
                    &self.queue,
                    planned.report,
                    options,
                    project.sources(),
                    draws,
                );
                made.map(|picture| self.picture = Some(picture))
            }
        };
        diagnostics.extend(made.err().into_iter().flatten());
        project.answer(diagnostics, Value::Null)
    }

    /// Sets a live parameter to a value in JSON, from the next frame onwards.
    ///
    /// # Errors
    /// A value that the parameter does not take, in words.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Reason> {
        let Some(picture) = &mut self.picture else { return Ok(()) };
        let value: Value = serde_json::from_str(value).map_err(|error| format!("{name}: {error}"))?;
        let value = settings::from_json(&value).ok_or_else(|| format!("{name}: {value} is no value"))?;
        let set =
            picture.executor.parameter(name).and_then(|parameter| picture.executor.set(parameter, value));
        set.map_err(|error| error.to_string())
    }

    /// Moves the camera around the scene: to the side and up, in radians, and how many times as far away as the scene
    /// has it.
    pub fn look(&mut self, side: f64, up: f64, distance: f64) {
        self.view = View { turn: [side, up], distance };
    }

    /// Draws a frame at a time in seconds, and shows it; whether there is a pipeline to draw.
    ///
    /// # Errors
    /// Diagnostics as text, those of the device about earlier frames among them.
    pub fn frame(&mut self, index: u32, time: f64) -> Result<bool, Reason> {
        let Some(picture) = &mut self.picture else { return Ok(false) };
        let (input, draws) = posed(&self.queue, &mut self.scene, self.view, picture.size(), index, time);
        let drawn = picture.draw(&self.device, &self.queue, &input, draws);
        drawn.map_err(|found| in_words(&found, picture.sources()))?;
        if let Some(canvas) = &self.canvas {
            picture.show(&self.device, &self.queue, canvas)?;
        }
        Ok(true)
    }

    /// The last frame's texels, four bytes each: red, green, blue, alpha, from the top.
    ///
    /// # Errors
    /// No frame; a lost device.
    pub async fn read(&self) -> Result<Vec<u8>, Reason> {
        let Some(texture) = self.picture.as_ref().and_then(Picture::texture) else {
            return Err("nothing was drawn".to_owned());
        };
        let bytes = read_bytes(&self.device, &self.queue, texture).await;
        bytes.map_err(|found| in_words(&found.into(), &Sources::new()))
    }

    /// Draws a frame, and reads what a texture holds: `NAME`, at its end, or `NAME@PASS`, after a pass. `path` and `values`
    /// are those that the last [`pipeline`](Self::pipeline) took.
    ///
    /// # Errors
    /// A texture that cannot be read, in words; no frame.
    #[allow(clippy::too_many_arguments)] // A page gives them by name.
    pub async fn contents(
        &mut self,
        project: &mut Project,
        path: &str,
        values: &str,
        reference: &str,
        mip: u32,
        index: u32,
        time: f64,
    ) -> Result<Contents, Reason> {
        let texels = self.captured(project, (path, values), (reference, mip), (index, time));
        let (plan, texture) = texels.map_err(|found| in_words(&found, project.sources()))?;
        let texels = read_back(&self.device, &self.queue, &texture).await;
        let texels = texels.map_err(|found| in_words(&found.into(), &Sources::new()))?;
        Ok(Contents::new(&plan, reference, &texels))
    }

    /// Waits until the device has finished all submitted work.
    pub async fn done(&self) {
        let (sender, receiver) = futures_channel::oneshot::channel();
        self.queue.on_submitted_work_done(move || {
            let _ = sender.send(());
        });
        // Without an answer there is nothing to wait for.
        let _ = receiver.await;
    }

    /// Opens a scope for validation errors of the device; [`Listener::rejected`] returns the error that it caught.
    pub fn listen(&self) -> Listener {
        Listener(Some(self.device.push_error_scope(wgpu::ErrorFilter::Validation)))
    }
}

impl Painter {
    /// Returns the target profile of a pipeline on this device.
    fn profile(&self, pipeline: &TypedPipeline) -> TargetProfile {
        let features = pipeline.device_features() & self.device.features();
        let profile = pipeline.profile.clone().on_device(&self.device.limits(), self.flags);
        if features.is_empty() { profile } else { profile.with_features(features) }
    }

    /// The plan that runs, and the texture that a frame's capture was copied to.
    fn captured(
        &mut self,
        project: &mut Project,
        (path, values): (&str, &str),
        (reference, mip): (&str, u32),
        (index, time): (u32, f64),
    ) -> Result<(Arc<Plan>, wgpu::Texture), Diagnostics> {
        let Some(picture) = &self.picture else { return Err(nothing_drawn()) };
        let plan = picture.executor.plan().clone();
        let extended = Extended::new(&plan, path, reference, mip)?;
        project.write(&extended.path, &extended.text);
        let (profile, options) = (self.profile(&plan.pipeline), picture.options().clone());
        let (planned, diagnostics) = project.planned(&extended.path, values, Some(profile), options);
        let Some(captures) = planned.and_then(|planned| planned.report.plan) else { return Err(diagnostics) };
        let Some(picture) = &mut self.picture else { return Err(nothing_drawn()) };
        let (input, draws) = posed(&self.queue, &mut self.scene, self.view, picture.size(), index, time);
        let capture = (captures, extended.import.as_str());
        let texture = picture.capture(&self.device, &self.queue, capture, &input, draws)?;
        Ok((plan, texture))
    }
}

/// The diagnostic of a question about a frame that there is not.
fn nothing_drawn() -> Diagnostics {
    let message = "nothing was drawn";
    Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help("wait for the first frame").into()
}

/// The input of a frame at a time, and the meshes, if there is a scene.
fn posed<'a>(
    queue: &wgpu::Queue,
    scene: &'a mut Option<Shown>,
    view: View,
    [width, height]: [u32; 2],
    index: u32,
    time: f64,
) -> (FrameInput, Option<&'a SceneResources>) {
    let aspect = f64::from(width) / f64::from(height);
    let (input, draws) = match scene {
        Some(Shown { scene, pose, draws }) => {
            scene.pose_into(time, pose);
            draws.update(queue, scene, pose);
            let input = scene.frame_input_of(pose, aspect, time);
            let camera = view.around(&input.camera, input.scene_bounds.center());
            (input.camera(camera), Some(&*draws))
        }
        None => {
            let camera = Camera::look_at([0.0, 0.0, 1.0], [0.0; 3], 0.8, aspect);
            (FrameInput::new(camera), None)
        }
    };
    (input.index(u64::from(index)), draws)
}

/// An open error scope.
#[wasm_bindgen]
pub struct Listener(Option<wgpu::ErrorScopeGuard>);

#[wasm_bindgen]
impl Listener {
    /// Closes the scope. Returns the first validation error of the device since it was opened; `None` without one.
    pub async fn rejected(mut self) -> Option<String> {
        Some(self.0.take()?.pop().await?.to_string())
    }
}

impl View {
    fn around(self, camera: &Camera, middle: DVec3) -> Camera {
        let [side, up] = self.turn;
        let right = camera.rotation * DVec3::X;
        let turn = DQuat::from_rotation_y(side) * DQuat::from_axis_angle(right, up);
        let mut camera = *camera;
        camera.position = middle + turn * (camera.position - middle) * self.distance;
        camera.rotation = (turn * camera.rotation).normalize();
        camera
    }
}

/// Formats diagnostics as readable text.
fn in_words(found: &Diagnostics, sources: &Sources) -> Reason {
    umbragraph::diagnostic::render::human_all(found, sources)
}
