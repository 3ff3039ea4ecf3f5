//! Requirements of a plan on a device and a host, checked before anything is created.
//!
//! Each diagnostic names the requirement and the device's limit. Failures that no limit or feature predicts (a format
//! that a driver cannot store, memory that runs out) are caught at creation (see [`crate::objects::creation`]).

use crate::binding::draw::Host;
use crate::drawing::attachments::MAX_COLORS;
use umbragraph_compiler::{Plan, PlannedPass};
use umbragraph_pipeline::diagnostic::{Code, Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::draw::{HostFilters, HostInterface, HostResourceKind};
use umbragraph_pipeline::pipeline::{Pass, Program, check_host};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{RenderWork, SceneDraw, SlotSource, Work};

/// Returns an error for each requirement of a plan that the device does not meet.
pub(crate) fn check_device(plan: &Plan, device: &wgpu::Device) -> Diagnostics {
    let check = DeviceCheck { plan, limits: device.limits(), features: device.features() };
    let mut diagnostics = Diagnostics::new();
    check.textures(&mut diagnostics);
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        check.bindings(pass, &mut diagnostics);
        match pass.work() {
            Work::Nothing | Work::Cpu(_) | Work::Transfer(_) => {}
            Work::Compute(compute) => {
                check.compute(planned, pass, plan.pipeline.program(compute.program), &mut diagnostics);
            }
            Work::Render(render) => check.attachments(pass, render, &mut diagnostics),
        }
    }
    diagnostics
}

struct DeviceCheck<'a> {
    plan: &'a Plan,
    limits: wgpu::Limits,
    features: wgpu::Features,
}

impl DeviceCheck<'_> {
    fn textures(&self, diagnostics: &mut Diagnostics) {
        for texture in &self.plan.textures {
            let size = texture.size;
            let (side, layers) = if texture.volume {
                (self.limits.max_texture_dimension_3d, self.limits.max_texture_dimension_3d)
            } else {
                (self.limits.max_texture_dimension_2d, self.limits.max_texture_array_layers)
            };
            let label = &texture.label;
            if size.width > side || size.height > side || size.layers > layers {
                let (width, height, count) = (size.width, size.height, size.layers);
                let message = format!(
                    "\"{label}\" is {width} by {height} with {count} layers; the device allows {side} and {layers}"
                );
                diagnostics.push(lacks(message, "make it smaller"));
            }
            let what = format!("in {:?}", texture.format);
            self.feature(label, texture.format.required_features(), what, diagnostics);
        }
        for buffer in &self.plan.buffers {
            let allowed = self.limits.max_buffer_size;
            if buffer.bytes > allowed {
                let message =
                    format!("\"{}\" has {} bytes; the device allows {allowed}", buffer.label, buffer.bytes);
                diagnostics.push(lacks(message, "make it smaller"));
            }
        }
    }

    fn feature(&self, name: &str, needed: wgpu::Features, what: String, diagnostics: &mut Diagnostics) {
        let missing = needed - self.features;
        if !missing.is_empty() {
            let message = format!("\"{name}\" {what} needs the feature {missing:?}");
            diagnostics.push(lacks(message, "request the feature, or add a format candidate"));
        }
    }

    /// Checks the number of bind groups, the sizes of blocks and the filtered textures that the shader of a pass binds.
    fn bindings(&self, pass: &Pass, diagnostics: &mut Diagnostics) {
        let Some(program) = pass.work().program() else { return };
        let program = self.plan.pipeline.program(program);
        let groups = program.bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
        if groups > self.limits.max_bind_groups {
            let allowed = self.limits.max_bind_groups;
            let message =
                format!("{} has {groups} bind groups; the device allows {allowed}", program.template);
            diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "use fewer bind groups"));
        }
        for binding in &program.bindings {
            let wgpu::BindingType::Buffer { ty, min_binding_size: Some(bytes), .. } = binding.entry.ty else {
                continue;
            };
            let allowed = match ty {
                wgpu::BufferBindingType::Uniform => self.limits.max_uniform_buffer_binding_size,
                wgpu::BufferBindingType::Storage { .. } => self.limits.max_storage_buffer_binding_size,
            };
            if bytes.get() > allowed {
                let (name, template) = (&binding.name, &program.template);
                let message =
                    format!("\"{name}\" of {template} has {bytes} bytes; the device allows {allowed}");
                diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "make the block smaller"));
            }
        }
        for slot in crate::binding::blocks::slots(pass.work()) {
            let SlotSource::Texture(bound) = &slot.source else { continue };
            let is_filtered = program.binding_at(slot.group, slot.binding).is_some_and(|binding| {
                let filtered = wgpu::TextureSampleType::Float { filterable: true };
                let bound = program.bound_type(binding, crate::binding::blocks::slots(pass.work()));
                matches!(bound, wgpu::BindingType::Texture { sample_type, .. } if sample_type == filtered)
            });
            let format = self.plan.resource(bound.texture.resource).and_then(|resource| resource.format);
            if let Some(format) = format.filter(|format| is_filtered && has_float32(*format)) {
                let name = &self.plan.pipeline.resource(bound.texture.resource).name;
                let what = format!("in {format:?}, which {} filters,", program.template);
                self.feature(name, wgpu::Features::FLOAT32_FILTERABLE, what, diagnostics);
            }
        }
    }

    fn attachments(&self, pass: &Pass, render: &RenderWork, diagnostics: &mut Diagnostics) {
        let allowed = (self.limits.max_color_attachments as usize).min(MAX_COLORS);
        if render.color.len() > allowed {
            let message = format!(
                "\"{}\" has {} color attachments; the device allows {allowed}",
                pass.name,
                render.color.len()
            );
            diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "use fewer"));
        }
        let program = self.plan.pipeline.program(render.draw.bound().0);
        let has_two_sources = program.variants.iter().any(|variant| {
            variant.entry_point(Stage::Fragment).is_some_and(|fragment| fragment.has_second_source)
        });
        if has_two_sources {
            let what = "with a second source to blend".to_owned();
            self.feature(&pass.name, wgpu::Features::DUAL_SOURCE_BLENDING, what, diagnostics);
        }
        for color in render.color.iter().filter(|color| color.blend.is_some()) {
            let format = self.plan.resource(color.to.resource).and_then(|resource| resource.format);
            if let Some(format) = format.filter(|format| has_float32(*format)) {
                let name = &self.plan.pipeline.resource(color.to.resource).name;
                let what = format!("in {format:?}, onto which \"{}\" blends,", pass.name);
                self.feature(name, wgpu::Features::FLOAT32_BLENDABLE, what, diagnostics);
            }
        }
    }

    fn compute(&self, planned: &PlannedPass, pass: &Pass, program: &Program, diagnostics: &mut Diagnostics) {
        let limits = &self.limits;
        let Some(entry) = program.variants.first().and_then(|variant| variant.entry_point(Stage::Compute))
        else {
            return;
        };
        let [x, y, z] = entry.workgroup_size;
        let sides = [
            limits.max_compute_workgroup_size_x,
            limits.max_compute_workgroup_size_y,
            limits.max_compute_workgroup_size_z,
        ];
        let invocations = x.saturating_mul(y).saturating_mul(z);
        let allowed = limits.max_compute_invocations_per_workgroup;
        let is_beyond = [x, y, z].iter().zip(&sides).any(|(size, allowed)| size > allowed);
        if is_beyond || invocations > allowed {
            let message = format!(
                "the workgroups of {} are {x} by {y} by {z}; the device allows {sides:?} and {allowed} invocations",
                program.template
            );
            diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "make workgroups smaller"));
        }
        let allowed = limits.max_compute_workgroup_storage_size;
        if entry.workgroup_storage > allowed {
            let (template, bytes) = (&program.template, entry.workgroup_storage);
            let message = format!("a workgroup of {template} has {bytes} bytes; the device allows {allowed}");
            diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "use less workgroup memory"));
        }
        let allowed = limits.max_compute_workgroups_per_dimension;
        if planned.workgroups.is_some_and(|counts| counts.iter().any(|count| *count > allowed)) {
            let message = format!(
                "\"{}\" runs {:?} workgroups; the device allows {allowed} each way",
                pass.name,
                planned.workgroups.unwrap_or_default()
            );
            diagnostics.push(at(pass, codes::DEVICE_LIMIT, message, "make workgroups larger"));
        }
    }
}

/// Returns the errors of the host's mesh layouts and filters for the passes that draw meshes; empty if all fit.
pub(crate) fn check_source(plan: &Plan, device: &wgpu::Device, host: Host<'_>) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    for (pass, scene) in scenes(plan) {
        match (host.interface(plan, &scene.geometry), host.source) {
            (Some(interface), _) => {
                diagnostics.extend(check_host(&plan.pipeline, &scene.geometry, interface));
                diagnostics.extend(check_strides(pass, interface, &device.limits()));
                diagnostics.extend(check_filter(pass, scene, &interface.filters));
            }
            (None, None) => diagnostics.push(lacks_source(pass)),
            (None, Some(_)) => {
                let message = format!("the host knows no geometry \"{}\"", scene.geometry);
                diagnostics.push(at(
                    pass,
                    codes::HOST_INTERFACE,
                    message,
                    "say with Library::host how it is stored, or let the draw source say it (Executor::set_plan_and_source)",
                ));
            }
        }
    }
    diagnostics
}

/// Returns the error for a pass that draws meshes although the host has no draw source.
pub(crate) fn lacks_source(pass: &Pass) -> Diagnostic {
    let message = format!("\"{}\" draws meshes, but the host gave none", pass.name);
    at(pass, codes::HOST_INTERFACE, message, "give the executor a draw source")
}

/// Returns an error if the filter of a pass is not in the host's list of filters; `None` if it is, or if the host has
/// no list.
fn check_filter(pass: &Pass, scene: &SceneDraw, filters: &HostFilters) -> Option<Diagnostic> {
    let HostFilters::Words(filters) = filters else { return None };
    if filters.contains(&scene.filter) {
        return None;
    }
    let message = format!("the host knows no filter \"{}\"", scene.filter);
    Some(at(pass, codes::UNKNOWN_FILTER, message, format!("it knows {}", list_of(filters))))
}

/// The passes that draw the host's meshes, with the settings of their draws.
pub(crate) fn scenes(plan: &Plan) -> impl Iterator<Item = (&Pass, &SceneDraw)> {
    plan.passes.iter().filter_map(|planned| {
        let pass = plan.pipeline.pass(planned.handle);
        Some((pass, pass.work().scene()?))
    })
}

/// Returns an error for each block of objects whose stride in bytes is no multiple of the device's alignment of dynamic
/// offsets.
fn check_strides(pass: &Pass, interface: &HostInterface, limits: &wgpu::Limits) -> Vec<Diagnostic> {
    let alignment =
        limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment).max(1);
    let blocks = interface.object.iter().filter(|_| interface.object_layout.is_none());
    let strides = blocks.filter_map(|slot| match slot.kind {
        HostResourceKind::Block { stride, .. } => Some((&slot.name, stride)),
        HostResourceKind::Opaque(_) | HostResourceKind::Array { .. } => None,
    });
    let crooked = strides.filter(|(_, stride)| stride % alignment != 0);
    crooked
        .map(|(name, stride)| {
            let message = format!(
                "the host's blocks \"{name}\" lie {stride} bytes apart, which is no multiple of {alignment}"
            );
            at(pass, codes::HOST_INTERFACE, message, "pad the blocks to a multiple of 256 bytes")
        })
        .collect()
}

fn has_float32(format: wgpu::TextureFormat) -> bool {
    use wgpu::TextureFormat as F;
    matches!(format, F::R32Float | F::Rg32Float | F::Rgba32Float)
}

fn at(pass: &Pass, code: Code, message: String, help: impl Into<String>) -> Diagnostic {
    Diagnostic::error(code, pass.place, message).pointer(&pass.pointer).help(help)
}

fn lacks(message: String, help: &str) -> Diagnostic {
    Diagnostic::error(codes::DEVICE_LIMIT, Place::Nowhere, message).help(help)
}
