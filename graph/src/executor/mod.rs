//! The executor: a plan, realized with wgpu and recorded into an encoder of the host's.
//!
//! It is middleware, not a framework: the host owns device, queue, encoder and surface, submits and presents. An
//! [`Executor`] creates textures, pipelines and bind groups once, when it is made or given another plan; recording a
//! frame then runs the host passes, packs their data into one uniform buffer, and records the passes in the plan's
//! order. In a steady frame nothing is created on the device.
//!
//! - [`textures`]: the plan's textures and buffers, views, samplers;
//! - [`pipelines`]: bind group layouts from reflection, render and compute pipelines;
//! - [`uniforms`]: where the blocks of one record lie, and buffers that several records in flight do not share;
//! - [`groups`]: bind groups, made when what they bind changes;
//! - [`scene`]: the host's draws, view by view.
//!
//! Limits: the copy of a volume and stencil attachments are not recorded; a draw pass has at most 32 mesh properties.

mod groups;
mod pipelines;
mod record;
mod scene;
mod textures;
mod uniforms;

use std::sync::Arc;

use crate::compiler::{Physical, Plan};
use crate::data::HostData;
use crate::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use crate::draw::{DrawSource, check_host};
use crate::frame::FrameInput;
use crate::pipeline::ResourceKind;
use crate::work::{Draw, ResourceHandle, Work};

use pipelines::RealizedPass;
use textures::Textures;
use uniforms::Uniforms;

/// What a frame consists of.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// Camera, lights and bounds.
    pub input: &'a FrameInput,
    /// The host's meshes, if the pipeline draws any.
    pub draws: Option<&'a dyn DrawSource>,
    /// The host's textures by the names of the resources that stand for them.
    pub imports: &'a [(&'a str, &'a wgpu::Texture)],
}

/// What an executor has created so far; in a steady frame nothing is added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Textures.
    pub textures: u64,
    /// Buffers, those for uniforms included.
    pub buffers: u64,
    /// Render and compute pipelines.
    pub pipelines: u64,
    /// Bind groups.
    pub bind_groups: u64,
    /// Views of the host's textures.
    pub import_views: u64,
}

/// A plan, realized on a device.
pub struct Executor {
    device: wgpu::Device,
    queue: wgpu::Queue,
    plan: Arc<Plan>,
    textures: Textures,
    uniforms: Uniforms,
    passes: Vec<RealizedPass>,
    /// The data of host passes by resource, kept from frame to frame.
    data: Vec<Option<HostData>>,
    statistics: Statistics,
}

impl Executor {
    /// Realizes a plan. `source` says how the host's meshes are stored; a plan that draws none needs none.
    ///
    /// The future is ready at once except in a browser, where errors of the device arrive late.
    ///
    /// # Errors
    /// A host whose interface does not fit the shaders, a device that lacks what the plan needs, errors of the device.
    pub async fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Diagnostics> {
        let mut findings = check_source(&plan, source);
        findings.extend(check_device(&plan, device));
        if findings.has_errors() {
            return Err(findings);
        }
        let out_of_memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut statistics = Statistics::default();
        let textures = Textures::new(device, &plan, &mut statistics);
        let uniforms = Uniforms::new(device, &plan);
        let passes = pipelines::realize(device, &plan, source, &mut statistics);
        for scope in [validation, out_of_memory] {
            if let Some(error) = scope.pop().await {
                let finding = Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("the device refused the plan: {error}"));
                findings.push(finding.help("make pictures and maps smaller, or use another device"));
            }
        }
        if findings.has_errors() {
            return Err(findings);
        }
        let data = plan.pipeline.resources.iter().map(|resource| match &resource.kind {
            ResourceKind::Data(Some(shape)) => Some(HostData::new(shape.clone())),
            _ => None,
        });
        let data = data.collect();
        Ok(Self { device: device.clone(), queue: queue.clone(), plan, textures, uniforms, passes, data, statistics })
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// What was created so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// The data that a host pass published in the last record, by the name of its resource.
    pub fn data(&self, name: &str) -> Option<&HostData> {
        let handle = self.plan.pipeline.find_resource(name)?;
        self.data.get(handle.index())?.as_ref()
    }

    /// The texture that stands for a resource, unless it is the host's own.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        match self.plan.resources.get(name)?.physical {
            Physical::Texture(index) => self.textures.get(index),
            _ => None,
        }
    }

    /// Records a frame into an encoder. Several records in one submission do not disturb one another.
    ///
    /// # Errors
    /// Imports that are missing or not as planned, a draw source that is missing or does not know a filter, host data
    /// that a host pass did not declare. Nothing is recorded then.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> Result<(), Diagnostics> {
        let findings = self.check_frame(frame);
        if findings.has_errors() {
            return Err(findings);
        }
        self.textures.set_imports(&self.plan, frame.imports);
        self.run_host_passes(frame)?;
        record::record(self, encoder, frame);
        Ok(())
    }

    fn check_frame(&self, frame: &Frame<'_>) -> Diagnostics {
        let mut findings = Diagnostics::new();
        if let Some(reason) = frame.input.camera.check() {
            findings.push(
                Diagnostic::warning(codes::FRAME_INPUT, Place::Nowhere, format!("the camera cannot be used: {reason}"))
                    .help("nothing is drawn from it"),
            );
        }
        for (name, resource) in &self.plan.resources {
            if resource.physical != Physical::Imported {
                continue;
            }
            let declared = self.plan.pipeline.resource(resource.handle);
            let refuse = |message: String| {
                Diagnostic::error(codes::IMPORT, declared.place, message)
                    .pointer(&declared.pointer)
                    .help("give the executor the texture that the plan was made for, or plan anew")
            };
            let Some((_, texture)) = frame.imports.iter().find(|(given, _)| given == name) else {
                findings.push(refuse(format!("the host gave no texture for \"{name}\"")));
                continue;
            };
            if let (Some(format), Some(size)) = (resource.format, resource.size) {
                let given = (texture.format(), texture.width(), texture.height(), texture.depth_or_array_layers(), texture.sample_count());
                if given != (format, size.width, size.height, size.layers, size.samples) {
                    findings.push(refuse(format!(
                        "the texture for \"{name}\" is {} by {} in {:?}, planned are {} by {} in {format:?}",
                        texture.width(),
                        texture.height(),
                        texture.format(),
                        size.width,
                        size.height
                    )));
                }
            }
        }
        findings.extend(check_source(&self.plan, frame.draws));
        findings
    }

    fn run_host_passes(&mut self, frame: &Frame<'_>) -> Result<(), Diagnostics> {
        let plan = self.plan.clone();
        let mut findings = Diagnostics::new();
        for planned in &plan.passes {
            let pass = plan.pipeline.pass(planned.handle);
            let Work::Host(host) = &pass.work else { continue };
            let Some(mut data) = self.data.get_mut(host.output.index()).and_then(Option::take) else { continue };
            data.clear();
            let read = |handle: &ResourceHandle| self.data.get(handle.index()).and_then(Option::as_ref);
            let mut inputs: Vec<&HostData> = Vec::new();
            inputs.extend(host.inputs.iter().filter_map(read));
            host.node.run(&crate::work::HostContext { frame: frame.input, inputs: &inputs }, &mut data);
            if let Some(reason) = data.refused() {
                findings.push(
                    Diagnostic::error(codes::HOST_DATA, pass.place, format!("\"{}\" publishes {reason}", pass.name))
                        .pointer(&pass.pointer)
                        .help("a host pass publishes what it declared; this is a defect of its node kind"),
                );
            }
            self.data[host.output.index()] = Some(data);
        }
        if findings.is_empty() { Ok(()) } else { Err(findings) }
    }
}

/// Whether the host's meshes fit every shader that draws them.
fn check_source(plan: &Plan, source: Option<&dyn DrawSource>) -> Diagnostics {
    let mut findings = Diagnostics::new();
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        let Work::Render(render) = &pass.work else { continue };
        let Draw::Scene(scene) = &render.draw else { continue };
        let refuse = |code, message: String, help: &str| {
            Diagnostic::error(code, pass.place, message).pointer(&pass.pointer).help(help)
        };
        let Some(source) = source else {
            let message = format!("\"{}\" draws meshes, but the host gave none", pass.name);
            findings.push(refuse(codes::HOST_INTERFACE, message, "give the executor a draw source"));
            continue;
        };
        match source.interface(&scene.geometry) {
            Some(interface) => findings.extend(check_host(&plan.pipeline, &scene.geometry, interface)),
            None => {
                let message = format!("the host knows no geometry \"{}\"", scene.geometry);
                findings.push(refuse(codes::HOST_INTERFACE, message, "let the host's draw source describe it"));
            }
        }
        if !source.filters().contains(&scene.filter.as_str()) {
            let message = format!("the host knows no filter \"{}\"", scene.filter);
            let help = format!("it knows {}", source.filters().join(", "));
            findings.push(refuse(codes::UNKNOWN_FILTER, message, &help));
        }
    }
    findings
}

/// Whether the device offers what the plan needs.
fn check_device(plan: &Plan, device: &wgpu::Device) -> Diagnostics {
    let mut findings = Diagnostics::new();
    let limits = device.limits();
    let lacks = |message: String, help: &str| Diagnostic::error(codes::DEVICE_LIMIT, Place::Nowhere, message).help(help);
    for texture in &plan.textures {
        let size = texture.size;
        let (side, layers) = if texture.volume {
            (limits.max_texture_dimension_3d, limits.max_texture_dimension_3d)
        } else {
            (limits.max_texture_dimension_2d, limits.max_texture_array_layers)
        };
        if size.width > side || size.height > side || size.layers > layers {
            findings.push(lacks(
                format!("\"{}\" is {} by {} with {} layers; the device allows {side} and {layers}", texture.label, size.width, size.height, size.layers),
                "make it smaller",
            ));
        }
        let missing = texture.format.required_features() - device.features();
        if !missing.is_empty() {
            let message = format!("\"{}\" in {:?} needs the feature {missing:?}", texture.label, texture.format);
            findings.push(lacks(message, "request the feature, or add a format candidate"));
        }
    }
    findings
}
