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

/// A WebGPU device with a scene, and the pipeline that draws the scene.
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

/// The current scene, its pose, and its GPU resources.
struct Shown {
    scene: Scene,
    pose: Pose,
    draws: SceneResources,
}

/// The orbit of the viewer's camera around the center of the scene, relative to the scene's own camera.
#[derive(Clone, Copy)]
struct View {
    /// The angles by which the camera is rotated around the center, to the side and up, in radians.
    turn: [f64; 2],
    /// The distance of the camera to the center, as a multiple of the distance of the scene's own camera.
    distance: f64,
}

/// An error for the web page: a message, or diagnostics as readable text.
type Reason = String;

#[wasm_bindgen]
impl Painter {
    /// Opens a WebGPU device. If `canvas` is given, each frame is also shown on this canvas.
    ///
    /// # Errors
    /// A message if the browser provides no WebGPU adapter or device, or if the canvas cannot be drawn on.
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

    /// The name of the GPU adapter that the browser reports; `WebGPU` if it reports none.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Returns the reason why the device is lost; `None` while it works. A lost device draws nothing, so open a new
    /// painter.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Loads a scene from the bytes of a `.glb` file, in place of the current one. `name` is the name of the scene in
    /// diagnostics. The current pipeline is dropped.
    ///
    /// # Errors
    /// Diagnostics as text, if the file is invalid or the scene needs larger buffers than the device supports.
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

    /// Plans a pipeline of the project and draws with it from the next frame. The parameters and the returned JSON are
    /// those of [`Project::plan`], but `plan` is always `null`. If there are errors, the previous pipeline stays in
    /// use.
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

    /// Sets a live parameter of the pipeline to a JSON value, from the next frame onwards. Without a pipeline, does
    /// nothing.
    ///
    /// # Errors
    /// A message if there is no such live parameter, or if the value is invalid for it.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Reason> {
        let Some(picture) = &mut self.picture else { return Ok(()) };
        let value: Value = serde_json::from_str(value).map_err(|error| format!("{name}: {error}"))?;
        let value = settings::from_json(&value).ok_or_else(|| format!("{name}: {value} is no value"))?;
        let set =
            picture.executor.parameter(name).and_then(|parameter| picture.executor.set(parameter, value));
        set.map_err(|error| error.to_string())
    }

    /// Moves the camera on an orbit around the center of the scene. `side` and `up` are angles in radians; `distance`
    /// is a multiple of the distance of the scene's own camera.
    pub fn look(&mut self, side: f64, up: f64, distance: f64) {
        self.view = View { turn: [side, up], distance };
    }

    /// Draws frame number `index` at `time` in seconds, and shows it on the canvas. Returns `false` if there is no
    /// pipeline to draw.
    ///
    /// # Errors
    /// Diagnostics as text, including those of the device about earlier frames, or a message if the canvas has no
    /// texture.
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

    /// Reads the texels of the last frame, four bytes each (red, green, blue, alpha), row by row from the top.
    ///
    /// # Errors
    /// A message if no pipeline is set, or diagnostics as text if reading fails, as with a lost device.
    pub async fn read(&self) -> Result<Vec<u8>, Reason> {
        let Some(texture) = self.picture.as_ref().and_then(Picture::texture) else {
            return Err("nothing was drawn".to_owned());
        };
        let bytes = read_bytes(&self.device, &self.queue, texture).await;
        bytes.map_err(|found| in_words(&found.into(), &Sources::new()))
    }

    /// Draws frame number `index` at `time` in seconds, and reads mip level `mip` of a texture. `reference` is `NAME`
    /// for the texture at the end of the frame, or `NAME@PASS` for the texture after a pass. `path` and `values` must
    /// be those of the last call of [`pipeline`](Self::pipeline).
    ///
    /// # Errors
    /// Diagnostics as text, if the texture cannot be captured or read, or if no pipeline is set.
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

    /// Opens a WebGPU error scope that catches validation errors of the device; [`Listener::rejected`] closes it and
    /// returns the first error.
    pub fn listen(&self) -> Listener {
        Listener(Some(self.device.push_error_scope(wgpu::ErrorFilter::Validation)))
    }
}

impl Painter {
    /// Returns the target profile of a pipeline, adapted to the limits and features of this device.
    fn profile(&self, pipeline: &TypedPipeline) -> TargetProfile {
        let features = pipeline.device_features() & self.device.features();
        let profile = pipeline.profile.clone().on_device(&self.device.limits(), self.flags);
        if features.is_empty() { profile } else { profile.with_features(features) }
    }

    /// Draws a frame in which a texture is copied. Returns the plan in use and the copy.
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

/// The diagnostic for a capture before a pipeline is set.
fn nothing_drawn() -> Diagnostics {
    let message = "nothing was drawn";
    Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help("wait for the first frame").into()
}

/// Poses the scene at a time in seconds, and returns the input of a frame with the scene's draws. The draws are `None`
/// without a scene.
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

/// An open WebGPU error scope for validation errors.
#[wasm_bindgen]
pub struct Listener(Option<wgpu::ErrorScopeGuard>);

#[wasm_bindgen]
impl Listener {
    /// Closes the error scope. Returns the first validation error since the scope was opened; `None` if there was none.
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
