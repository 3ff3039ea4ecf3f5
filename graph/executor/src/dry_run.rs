//! Dry runs: plans instantiated and recorded on a device without a driver.
//!
//! wgpu validates on its backend `noop` as on any other: shader modules, layouts, pipelines, bind groups, views, the
//! usage scopes of passes, copies, dispatches. A [`DryRun`] opens such a device with the limits and features of a
//! profile, gives a plan to an executor on it, and records a frame with every light kind, textures in place of the
//! host's, and no meshes. What wgpu rejects there, it rejects on every device of the profile.
//!
//! Limits: nothing is drawn, and the draws of meshes are the host's own, so neither is validated; of runtime toggles
//! the state that the pipeline gives is recorded. Formats that a driver may lack are not known to be missing.

use std::error::Error;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use umbragraph_pipeline::draw::HostResourceKind;

use super::executor::Executor;
use crate::binding::draw::{DrawPass, DrawSource};
use crate::frame::input::Frame;
use crate::instance::requirements::scenes;
use crate::memory::imports::imported_texture;
use crate::objects::creation::causes;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph_pipeline::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
use umbragraph_pipeline::shader::TargetProfile;

/// A device without a driver, on which plans of one profile are recorded to find errors of wgpu.
pub struct DryRun {
    device: wgpu::Device,
    queue: wgpu::Queue,
    executor: Option<Executor>,
}

impl DryRun {
    /// Creates a device with the limits and features of a profile.
    ///
    /// # Errors
    /// A profile that wgpu does not accept for any device.
    pub async fn new(profile: &TargetProfile) -> Result<Self, Diagnostic> {
        let noop = wgpu::NoopBackendOptions {
            limits: Some(profile.limits.clone()),
            features: Some(profile.features),
            ..wgpu::NoopBackendOptions::enabled()
        };
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::NOOP,
            backend_options: wgpu::BackendOptions { noop, ..wgpu::BackendOptions::default() },
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await;
        let adapter = adapter.map_err(|error| no_device(profile, &error))?;
        let descriptor = wgpu::DeviceDescriptor {
            label: None,
            required_features: profile.features,
            required_limits: profile.limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|error| no_device(profile, &error))?;
        Ok(Self { device, queue, executor: None })
    }

    /// Returns the errors of wgpu for a plan, each at the pass that causes it. A plan that draws meshes of unknown
    /// layout is not run.
    pub async fn run(&mut self, plan: &Arc<Plan>) -> Diagnostics {
        if scenes(plan).any(|(_, scene)| !plan.pipeline.hosts.contains_key(&scene.geometry)) {
            return Diagnostics::new();
        }
        let source = Nothing::new(&self.device, plan);
        let executor = match &mut self.executor {
            Some(executor) => match executor.set_plan_and_source(plan.clone(), &source) {
                Ok(()) => executor,
                Err(error) => return error.into(),
            },
            empty => match Executor::new(&self.device, &self.queue, plan.clone(), Some(&source)) {
                Ok(executor) => empty.insert(executor),
                Err(error) => return error.into(),
            },
        };
        executor.reset_history();
        record(&self.device, &self.queue, executor, plan, &source).await
    }
}

fn no_device(profile: &TargetProfile, error: &dyn Error) -> Diagnostic {
    let message = format!("no dry run is possible for the profile \"{}\": {error}", profile.name);
    Diagnostic::warning(codes::DEVICE, Place::Nowhere, message)
}

/// Records and submits one frame of a plan, and returns the errors.
async fn record(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    executor: &mut Executor,
    plan: &Plan,
    source: &Nothing,
) -> Diagnostics {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    for (name, resource) in plan.imports() {
        if resource.format.is_none() {
            let usage = wgpu::BufferUsages::all()
                - (wgpu::BufferUsages::MAP_READ
                    | wgpu::BufferUsages::MAP_WRITE
                    | wgpu::BufferUsages::BLAS_INPUT
                    | wgpu::BufferUsages::TLAS_INPUT);
            let size = resource.bytes;
            let descriptor =
                wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
            let buffer = device.create_buffer(&descriptor);
            let given = executor.import::<wgpu::Buffer>(name);
            if let Err(error) = given.and_then(|import| executor.give(import, &buffer)) {
                return error.into();
            }
        }
    }
    let imports = imports(device, plan);
    let imports: Vec<(&str, &wgpu::Texture)> =
        imports.iter().map(|(name, texture)| (*name, texture)).collect();
    let input = input();
    let frame = Frame::new(&input).draws(source).imports(&imports);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut diagnostics =
        executor.record(&mut encoder, &frame).err().map_or_else(Diagnostics::new, Diagnostics::from);
    let commands = encoder.finish();
    if !diagnostics.has_errors() {
        queue.submit([commands]);
    }
    if let Some(error) = scope.pop().await {
        let causes = causes(&error);
        let named = |name: &str| causes.contains(&format!("'{name}'"));
        let pass = plan.passes.iter().find(|pass| named(&pass.name));
        let pass = pass.map(|planned| plan.pipeline.pass(planned.handle));
        let resource = plan.resources.iter().find(|(name, _)| named(name));
        let resource = resource.map(|(_, planned)| plan.pipeline.resource(planned.handle));
        let site = pass.map(|pass| (pass.place, &pass.pointer));
        let site = site.or(resource.map(|resource| (resource.place, &resource.pointer)));
        let place = site.map_or(Place::Nowhere, |(place, _)| place.into());
        let diagnostic = Diagnostic::error(codes::DEVICE, place, format!("the device rejected: {causes}"));
        diagnostics.push(match site {
            Some((_, pointer)) => diagnostic.pointer(pointer),
            None => diagnostic,
        });
    }
    diagnostics
}

/// Creates a texture for each import of a plan.
fn imports<'p>(device: &wgpu::Device, plan: &'p Plan) -> Vec<(&'p str, wgpu::Texture)> {
    let texture = |name| imported_texture(device, plan, name, wgpu::TextureUsages::COPY_SRC);
    plan.resources.keys().filter_map(|name| Some((name.as_str(), texture(name)?))).collect()
}

/// Returns a frame input with a camera in front of a cube, and a light of each kind.
fn input() -> FrameInput {
    let kinds =
        [LightKind::Directional, LightKind::Point, LightKind::Spot { inner_angle: 0.3, outer_angle: 0.5 }];
    let light = |kind: LightKind| {
        Light::new(format!("{kind:?}"), kind)
            .position(DVec3::new(1.0, 2.0, 1.0))
            .range(10.0)
            .angular_diameter(0.01)
            .radius(0.1)
    };
    FrameInput::new(Camera::new(
        DVec3::new(0.0, 0.0, 4.0),
        DQuat::IDENTITY,
        Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 },
        1.0,
    ))
    .lights(kinds.map(light).to_vec())
    .scene_bounds(Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE })
}

/// A draw source without meshes, whose objects are all bound to one buffer.
struct Nothing {
    block: wgpu::Buffer,
}

impl Nothing {
    fn new(device: &wgpu::Device, plan: &Plan) -> Self {
        let slots = plan.pipeline.hosts.values().flat_map(|interface| &interface.object);
        let sizes = slots.filter_map(|slot| match slot.kind {
            HostResourceKind::Block { size, .. } => Some(u64::from(size)),
            HostResourceKind::Array { stride, .. } => Some(u64::from(stride)),
            HostResourceKind::Opaque(_) => None,
        });
        let block = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("objects"),
            size: sizes.max().unwrap_or(0).next_multiple_of(256).max(256),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        Self { block }
    }
}

impl DrawSource for Nothing {
    fn object(&self, _: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(self.block.as_entire_binding())
    }

    fn draw(&self, _: &mut dyn DrawPass) {}
}
