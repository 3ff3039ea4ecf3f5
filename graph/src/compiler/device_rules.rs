//! Rules of WebGPU that span more than one declaration, checked on a plan, so that no device is the first to say no.
//!
//! Views fit their textures (cubes have six square layers, multisampled bindings see multisampled textures, volumes are
//! not attached), copies join textures of one format, sample count and size, full-screen passes say which layer of
//! several they write, and blocks stay within the profile's binding sizes. Limits of one shader on its own (workgroup
//! sizes, bindings for each stage) are checked with the shader's variants.

use super::format::format_name;
use super::plan::{Plan, PlannedPass, PlannedResource};
use crate::diagnostic::{Diagnostic, codes};
use crate::language::TextureShape;
use crate::pipeline::{Pass, Program};
use crate::source::Span;
use crate::work::{AttachmentTarget, BoundSlot, CopyWork, Draw, ResourceHandle, SlotSource, Work};

/// The findings of a plan; a plan with errors among them must not be realized.
pub(super) fn check(plan: &Plan) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        let rules = Rules { plan, pass };
        if let Some((program, slots)) = super::format::slots(&plan.pipeline, planned.handle) {
            for slot in slots {
                findings.extend(rules.slot(program, slot));
            }
        }
        match &pass.work {
            Work::Copy(copy) => findings.extend(rules.copy(copy)),
            Work::Render(render) => {
                let fullscreen = matches!(render.draw, Draw::Fullscreen { .. });
                findings.extend(rules.attachments(planned, fullscreen));
            }
            _ => {}
        }
    }
    findings
}

struct Rules<'a> {
    plan: &'a Plan,
    pass: &'a Pass,
}

impl Rules<'_> {
    fn planned(&self, resource: ResourceHandle) -> Option<&PlannedResource> {
        self.plan.resource(resource)
    }

    fn name(&self, resource: ResourceHandle) -> &str {
        &self.plan.pipeline.resource(resource).name
    }

    fn place(&self, resource: ResourceHandle) -> (Span, &str) {
        let used = self.pass.uses.iter().find(|one| one.resource == resource);
        used.map_or((self.pass.place, self.pass.pointer.as_str()), |one| (one.place, one.pointer.as_str()))
    }

    fn refuse(&self, resource: ResourceHandle, message: String, help: &str) -> Diagnostic {
        let (place, pointer) = self.place(resource);
        Diagnostic::error(codes::DEVICE_RULE, place, message).pointer(pointer).help(help)
    }

    fn slot(&self, program: &Program, slot: &BoundSlot) -> Option<Diagnostic> {
        let binding = program.binding_at(slot.group, slot.binding)?;
        let refuse = |message: String, help: &str| {
            Some(Diagnostic::error(codes::DEVICE_RULE, slot.place, message).pointer(&slot.pointer).help(help))
        };
        let limits = &self.plan.pipeline.profile.limits;
        match (&slot.source, binding.entry.ty) {
            (SlotSource::Texture(view), wgpu_types::BindingType::Texture { multisampled, .. }) => {
                let size = self.planned(view.resource)?.size?;
                let name = self.name(view.resource);
                if multisampled != (size.samples > 1) {
                    let help = "declare the binding as texture_multisampled_2d for several samples, as texture_2d for one";
                    return refuse(
                        format!(
                            "\"{name}\" has {} samples, \"{}\" is {}",
                            size.samples, slot.name, binding.type_name
                        ),
                        help,
                    );
                }
                let layers = view.layer.map_or(size.layers, |run| run.count);
                let fits = match view.shape {
                    TextureShape::Cube => layers == 6 && size.width == size.height,
                    TextureShape::CubeArray => layers % 6 == 0 && size.width == size.height,
                    _ => true,
                };
                let volume =
                    self.plan.pipeline.resource(view.resource).texture()?.view == Some(TextureShape::D3);
                if !fits {
                    let message = format!(
                        "\"{name}\" is {} by {} with {layers} layers, \"{}\" is {}",
                        size.width, size.height, slot.name, binding.type_name
                    );
                    return refuse(message, "cubes are square and have six layers each");
                }
                if volume != (view.shape == TextureShape::D3) {
                    return refuse(
                        format!("\"{name}\" cannot be seen as {}", binding.type_name),
                        "volumes are seen as texture_3d, and nothing else is",
                    );
                }
                None
            }
            (
                source @ (SlotSource::Data { .. } | SlotSource::View(_) | SlotSource::Values(_)),
                wgpu_types::BindingType::Buffer { ty, .. },
            ) => {
                let bytes = match source {
                    SlotSource::Values(values) => u64::from(values.layout.size()),
                    SlotSource::Data { layout, .. } | SlotSource::View(layout) => u64::from(layout.size),
                    _ => 0,
                };
                let limit = match ty {
                    wgpu_types::BufferBindingType::Uniform => limits.max_uniform_buffer_binding_size,
                    wgpu_types::BufferBindingType::Storage { read_only: true } => {
                        limits.max_storage_buffer_binding_size
                    }
                    wgpu_types::BufferBindingType::Storage { read_only: false } => {
                        let message = format!(
                            "\"{}\" is written by the shader, but holds values of the host",
                            slot.name
                        );
                        return refuse(
                            message,
                            "declare it as var<storage, read> or var<uniform>, or bind a buffer",
                        );
                    }
                };
                (bytes > limit).then(|| {
                    refuse(
                        format!("the block \"{}\" has {bytes} bytes", slot.name),
                        &format!("the profile allows {limit}"),
                    )
                })?
            }
            _ => None,
        }
    }

    fn copy(&self, copy: &CopyWork) -> Option<Diagnostic> {
        let (source, destination) = (copy.source, copy.destination);
        let (from, to) = (self.planned(source.resource)?, self.planned(destination.resource)?);
        let extent = |end: AttachmentTarget, planned: &PlannedResource| {
            let size = planned.size?;
            let layers = if end.layer.is_some() { 1 } else { size.layers };
            Some(((size.width >> end.mip).max(1), (size.height >> end.mip).max(1), layers, size.samples))
        };
        let (from_extent, to_extent) = (extent(source, from)?, extent(destination, to)?);
        let (a, b) = (self.name(source.resource), self.name(destination.resource));
        if from.format != to.format {
            let name = |planned: &PlannedResource| planned.format.map(format_name).unwrap_or_default();
            let message =
                format!("\"{a}\" is {}, \"{b}\" is {}: a copy changes no format", name(from), name(to));
            return Some(self.refuse(destination.resource, message, "use a full-screen pass to convert"));
        }
        if from_extent != to_extent {
            let words = |(width, height, layers, samples): (u32, u32, u32, u32)| {
                format!("{width} by {height} with {layers} layers and {samples} samples")
            };
            let message = format!("\"{a}\" is {}, \"{b}\" is {}", words(from_extent), words(to_extent));
            return Some(self.refuse(
                destination.resource,
                message,
                "a copy joins parts of one size; choose mip and layer",
            ));
        }
        None
    }

    fn attachments(&self, planned: &PlannedPass, fullscreen: bool) -> Vec<Diagnostic> {
        let mut findings = Vec::new();
        for attachment in planned.attachments() {
            let resource = attachment.target.resource;
            let declared = self.plan.pipeline.resource(resource).texture();
            if declared.is_some_and(|texture| texture.view == Some(TextureShape::D3)) {
                let message = format!("\"{}\" is a volume, which cannot be attached", attachment.resource);
                findings.push(self.refuse(resource, message, "write volumes from a compute pass"));
                continue;
            }
            let layers =
                self.planned(resource).and_then(|planned| planned.size).map_or(1, |size| size.layers);
            if fullscreen && layers > 1 && attachment.target.layer.is_none() {
                let message = format!(
                    "\"{}\" has {layers} layers, and nothing says which is written",
                    attachment.resource
                );
                findings.push(self.refuse(resource, message, "add \"layer\" to the attachment"));
            }
        }
        findings
    }
}
