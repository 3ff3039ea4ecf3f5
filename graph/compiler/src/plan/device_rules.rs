//! Rules of WebGPU that span more than one declaration, checked on a plan, so that no device is the first to say no.
//!
//! Views fit their textures (cubes have six square layers, multisampled bindings see multisampled textures, volumes are
//! not attached), full-screen passes say which layer of several they write, color attachments stay within the bytes of
//! a sample, and blocks stay within the profile's binding sizes. Limits of one shader on its own (workgroup sizes,
//! bindings for each stage) are checked with the shader's variants, what a copy joins where copies are planned
//! ([`crate::work::copies`]), and what a target lacks of core mode in [`super::core_rules`].

use crate::plan::core_rules;
use crate::plan::planned::{Plan, PlannedPass};
use crate::request::texture_size::TextureSize;
use crate::work::drawn_buffers::{Counted, DrawnBuffer};
use umbragraph_pipeline::diagnostic::{Diagnostic, codes, counted, list_of};
use umbragraph_pipeline::language::{TextureShape, format_name};
use umbragraph_pipeline::pipeline::{Located as _, Pass, Program, ProgramBinding};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{
    BoundSlot, BufferDraw, ColorAttachment, Draw, DrawCounts, ResourceHandle, SlotSource, Work,
};
use wgpu_types::{
    BindingType, BufferBindingType, Features, ShaderStages, StorageTextureAccess, TextureFormatFeatureFlags,
};

/// Returns the violations of WebGPU rules in a plan. A plan with errors must not be instantiated.
pub(crate) fn check(plan: &Plan) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        let rules = Rules { plan, pass };
        if let Some((program, slots)) = crate::resources::format::slots(&plan.pipeline, planned.handle) {
            diagnostics.extend(rules.stages(program));
            diagnostics.extend(program.bindings.iter().filter_map(|binding| rules.storage(program, binding)));
            for slot in slots {
                diagnostics.extend(rules.slot(program, slot));
            }
        }
        if let Work::Render(render) = pass.work() {
            let fullscreen = !matches!(render.draw, Draw::Scene(_));
            diagnostics.extend(rules.attachments(planned, fullscreen));
            diagnostics.extend(render.color.iter().filter_map(|color| rules.resolve(color)));
            diagnostics.extend(rules.color_bytes(planned));
            if let Draw::Buffers(draw) = &render.draw {
                diagnostics.extend(rules.buffer_draw(draw));
            }
        }
    }
    diagnostics.extend(core_rules::check(plan));
    diagnostics
}

struct Rules<'a> {
    plan: &'a Plan,
    pass: &'a Pass,
}

impl Rules<'_> {
    /// Reports vertex and index buffers that have fewer bytes than a draw reads, unless the counts are indirect.
    fn buffer_draw(&self, draw: &BufferDraw) -> Vec<Diagnostic> {
        let DrawCounts::Direct { count, instances } = draw.counts else { return Vec::new() };
        let drawn = DrawnBuffer::all(draw).into_iter().map(|one| {
            let elements = if one.counted == Counted::Elements { count } else { instances };
            (one.buffer, one.bytes(elements.value.into()))
        });
        let too_short = |(resource, wanted): (ResourceHandle, u64)| {
            let bytes = self.plan.resource(resource)?.bytes;
            let message =
                format!("\"{}\" has {bytes} bytes, but {wanted} of it are drawn", self.name(resource));
            (bytes < wanted).then(|| self.reject(resource, message, "make the buffer larger, or draw less"))
        };
        drawn.filter_map(too_short).collect()
    }

    /// Returns an error for a shader variant that lacks an entry point of a needed stage, or has several of one stage
    /// to choose from.
    fn stages(&self, program: &Program) -> Option<Diagnostic> {
        let (needed, optional) = match self.pass.work() {
            Work::Compute(_) => (Stage::Compute, None),
            _ => (Stage::Vertex, Some(Stage::Fragment)),
        };
        let template = &program.template;
        let reject = |message: String, help: String| {
            Some(self.pass.error(codes::UNKNOWN_ENTRY_POINT, message).help(help))
        };
        for variant in &program.variants {
            if variant.entry_point(needed).is_none() {
                let stage = needed.name();
                let message = format!("{template} has no entry point of the stage @{stage}");
                return reject(message, format!("add a function with @{stage}"));
            }
            for stage in [Some(needed), optional].into_iter().flatten() {
                if variant.entry_points.contains_key(&stage) {
                    continue;
                }
                let entries = variant.module.reflection.entry_points.iter();
                let names: Vec<&str> =
                    entries.filter(|entry| entry.stage == stage).map(|entry| entry.name.as_str()).collect();
                if let [first, _, ..] = names[..] {
                    let stage = stage.name();
                    let message = format!(
                        "{template} has {} entry points of the stage @{stage}: {}",
                        names.len(),
                        list_of(names)
                    );
                    let help =
                        format!("say which is meant: \"entry_points\": {{ \"{stage}\": \"{first}\" }}");
                    return reject(message, help);
                }
            }
        }
        None
    }

    /// Returns an error if the vertex stage writes a storage binding, or if the format of a storage texture does not
    /// support the access.
    fn storage(&self, program: &Program, binding: &ProgramBinding) -> Option<Diagnostic> {
        let features = self.plan.pipeline.profile.features;
        let (template, name) = (&program.template, &binding.name);
        let reject = |message: String, help: &str| {
            let declared = program.plain().variable(name);
            Some(self.pass.error(codes::DEVICE_RULE, message).help(help).labelled(declared, "declared here"))
        };
        let is_written = match binding.entry.ty {
            BindingType::Buffer { ty: BufferBindingType::Storage { read_only }, .. } => !read_only,
            BindingType::StorageTexture { access, .. } => access != StorageTextureAccess::ReadOnly,
            _ => return None,
        };
        let in_vertex = binding.entry.visibility.contains(ShaderStages::VERTEX);
        if is_written && in_vertex && !features.contains(Features::VERTEX_WRITABLE_STORAGE) {
            let message = format!("the vertex stage of {template} uses \"{name}\", which is written storage");
            return reject(message, "write storage in a fragment or compute stage, or declare it read-only");
        }
        let BindingType::StorageTexture { access, format, .. } = binding.entry.ty else { return None };
        let (needed, uses) = match access {
            StorageTextureAccess::WriteOnly => (TextureFormatFeatureFlags::STORAGE_WRITE_ONLY, "writes"),
            StorageTextureAccess::ReadOnly => (TextureFormatFeatureFlags::STORAGE_READ_ONLY, "reads"),
            StorageTextureAccess::ReadWrite => {
                (TextureFormatFeatureFlags::STORAGE_READ_WRITE, "reads and writes")
            }
            StorageTextureAccess::Atomic => (TextureFormatFeatureFlags::STORAGE_ATOMIC, "counts in"),
        };
        if format.guaranteed_format_features(features).flags.contains(needed) {
            return None;
        }
        let message = format!(
            "{template} {uses} \"{name}\", a storage texture of {}, which the profile {} does not guarantee",
            format_name(format),
            self.plan.pipeline.profile.name
        );
        let help = match access {
            StorageTextureAccess::ReadWrite => {
                "read and write r32float, r32sint or r32uint; or read one texture and write another"
            }
            _ => "declare a format that the profile guarantees, such as r32uint",
        };
        reject(message, help)
    }

    fn name(&self, resource: ResourceHandle) -> &str {
        &self.plan.pipeline.resource(resource).name
    }

    fn reject(&self, resource: ResourceHandle, message: String, help: &str) -> Diagnostic {
        let used = self.pass.access_or_self(|one| one.resource == resource);
        used.error(codes::DEVICE_RULE, message).help(help)
    }

    fn slot(&self, program: &Program, slot: &BoundSlot) -> Option<Diagnostic> {
        let binding = program.binding_at(slot.group, slot.binding)?;
        let declared = || program.plain().variable(&slot.name);
        let reject = |message: String, help: &str| {
            let diagnostic = slot.error(codes::DEVICE_RULE, message).help(help);
            Some(diagnostic.labelled(declared(), "the shader's declaration"))
        };
        let limits = &self.plan.pipeline.profile.limits;
        match (&slot.source, binding.entry.ty) {
            (SlotSource::Texture(bound), BindingType::Texture { multisampled, .. }) => {
                let view = bound.view();
                let size = self.plan.resource(view.resource)?.size?;
                let name = self.name(view.resource);
                if multisampled != (size.samples > 1) {
                    let message = format!(
                        "\"{name}\" has {}, \"{}\" is {}",
                        counted(size.samples as usize, "sample"),
                        slot.name,
                        binding.type_name
                    );
                    let help = "declare the binding as texture_multisampled_2d for several samples, as texture_2d for one";
                    return reject(message, help);
                }
                let layers = view.layer.map_or(size.layers, |run| run.count);
                let fits = match view.shape {
                    TextureShape::Cube => layers == 6 && size.width == size.height,
                    TextureShape::CubeArray => layers % 6 == 0 && size.width == size.height,
                    _ => true,
                };
                let volume = self.plan.pipeline.resource(view.resource).texture()?.view_dimension
                    == Some(TextureShape::D3);
                if !fits {
                    let message = format!(
                        "\"{name}\" is {} by {} with {}, \"{}\" is {}",
                        size.width,
                        size.height,
                        counted(layers as usize, "layer"),
                        slot.name,
                        binding.type_name
                    );
                    let help = format!(
                        "declare \"{}\" as {} in the shader, or give \"{name}\" a square size, \"layers\": 6 and \
                         \"view_dimension\": \"cube\"",
                        slot.name,
                        if layers > 1 { "texture_2d_array<f32>" } else { "texture_2d<f32>" }
                    );
                    return reject(message, &help);
                }
                if volume != (view.shape == TextureShape::D3) {
                    let message = format!("\"{name}\" cannot be seen as {}", binding.type_name);
                    return reject(message, "volumes are seen as texture_3d, and nothing else is");
                }
                None
            }
            (SlotSource::Buffer { buffer, .. }, BindingType::Buffer { ty, .. }) => {
                let (name, planned) = (self.name(buffer.resource), self.plan.resource(buffer.resource)?);
                let bytes = buffer.range.bytes.map_or(planned.bytes, |run| run.count);
                let offset = buffer.offset();
                let (align, max, what) = match ty {
                    BufferBindingType::Uniform => (
                        limits.min_uniform_buffer_offset_alignment,
                        limits.max_uniform_buffer_binding_size,
                        "uniform",
                    ),
                    BufferBindingType::Storage { .. } => (
                        limits.min_storage_buffer_offset_alignment,
                        limits.max_storage_buffer_binding_size,
                        "storage",
                    ),
                };
                if offset % u64::from(align.max(1)) != 0 {
                    let help = format!("{what} bindings start at multiples of {align} bytes");
                    return reject(format!("\"{name}\" is bound from byte {offset}"), &help);
                }
                let bound = || format!("{bytes} bytes of \"{name}\" are bound");
                if bytes > max {
                    let help =
                        format!("the profile allows {max} for a {what} binding: bind a subresource range");
                    return reject(bound(), &help);
                }
                let min = binding.block.as_ref().map_or(0, |block| u64::from(block.size()));
                if bytes < min {
                    let message =
                        format!("{}, but \"{}\" of {} has {min}", bound(), slot.name, program.template);
                    let place = self.plan.pipeline.resource(buffer.resource).place;
                    let diagnostic = slot.error(codes::DEVICE_RULE, message).related(place, "declared here");
                    let help = match buffer.range.bytes {
                        None => format!("give \"{name}\" \"size\": {min}, or more"),
                        Some(_) => format!("bind at least {min} bytes of \"{name}\""),
                    };
                    return Some(diagnostic.labelled(declared(), "the shader's declaration").help(help));
                }
                if matches!(ty, BufferBindingType::Storage { .. }) && bytes % 4 != 0 {
                    return reject(bound(), "storage bindings have a multiple of 4 bytes");
                }
                None
            }
            (
                SlotSource::Data { .. } | SlotSource::View | SlotSource::Values(_),
                BindingType::Buffer { ty, .. },
            ) => {
                let bytes = self.plan.pipeline.block_bytes(program, slot).map_or(0, u64::from);
                let limit = match ty {
                    BufferBindingType::Uniform => limits.max_uniform_buffer_binding_size,
                    BufferBindingType::Storage { read_only: true } => limits.max_storage_buffer_binding_size,
                    BufferBindingType::Storage { read_only: false } => {
                        let message = format!(
                            "\"{}\" is written by the shader, but holds values of the host",
                            slot.name
                        );
                        let help = "declare it as var<storage, read> or var<uniform>, or bind a buffer";
                        return reject(message, help);
                    }
                };
                if bytes <= limit {
                    return None;
                }
                let message = format!("the block \"{}\" has {bytes} bytes", slot.name);
                reject(message, &format!("the profile allows {limit}"))
            }
            _ => None,
        }
    }

    fn resolve(&self, color: &ColorAttachment) -> Option<Diagnostic> {
        let (source, target) = (color.to.target(), color.resolve.as_ref()?.target());
        let (from, to) = (self.plan.resource(source.resource)?, self.plan.resource(target.resource)?);
        let (a, b) = (self.name(source.resource), self.name(target.resource));
        let (from_mip, source, destination) = (source.mip, from.size?, to.size?);
        if source.samples == 1 || destination.samples > 1 {
            let message = format!(
                "\"{a}\" with {} samples is resolved to \"{b}\" with {}",
                source.samples, destination.samples
            );
            let help = "a texture with several samples is resolved to one with one";
            return Some(self.reject(target.resource, message, help));
        }
        if from.format != to.format {
            let names = [from.format, to.format].map(|format| format.map(format_name).unwrap_or_default());
            let message =
                format!("\"{a}\" is {}, \"{b}\" is {}: resolving changes no format", names[0], names[1]);
            return Some(self.reject(
                target.resource,
                message,
                &format!("give \"{a}\" the format {}", names[1]),
            ));
        }
        let side = |length: u32, mip: u32| (length >> mip.min(31)).max(1);
        let extent = |size: TextureSize, mip| [side(size.width, mip), side(size.height, mip)];
        let (own, wanted) = (extent(destination, target.mip), extent(source, from_mip));
        if own != wanted {
            let message =
                format!("\"{b}\" is {} by {}, \"{a}\" {} by {}", own[0], own[1], wanted[0], wanted[1]);
            return Some(self.reject(target.resource, message, "resolving changes no size"));
        }
        if target.layer.is_some() || destination.layers == 1 {
            return None;
        }
        let message = format!("nothing says which layer of \"{b}\" is resolved to");
        Some(self.reject(target.resource, message, "add \"layer\""))
    }

    /// Returns an error if the color attachments of a pass need more bytes per sample than the device profile allows.
    /// Each attachment is aligned to the size of its components.
    fn color_bytes(&self, planned: &PlannedPass) -> Option<Diagnostic> {
        let formats =
            planned.color.iter().filter_map(|color| self.plan.resource(color.target.resource)?.format);
        let bytes = formats.fold(0, |bytes: u32, format| {
            let aligned = bytes.next_multiple_of(format.target_component_alignment().unwrap_or(1));
            aligned + format.target_pixel_byte_cost().unwrap_or(0)
        });
        let allowed = self.plan.pipeline.profile.limits.max_color_attachment_bytes_per_sample;
        let message = format!(
            "the color attachments of \"{}\" have {bytes} bytes for each sample, but only {allowed} are guaranteed",
            self.pass.name
        );
        let help = "choose smaller formats, or write them in two passes";
        (bytes > allowed).then(|| self.pass.error(codes::DEVICE_RULE, message).help(help))
    }

    fn attachments(&self, planned: &PlannedPass, fullscreen: bool) -> Vec<Diagnostic> {
        let mut diagnostics = Vec::new();
        for attachment in planned.attachments() {
            let resource = attachment.target.resource;
            let declared = self.plan.pipeline.resource(resource).texture();
            if declared.is_some_and(|texture| texture.view_dimension == Some(TextureShape::D3)) {
                let message = format!("\"{}\" is a volume, which cannot be attached", attachment.resource);
                diagnostics.push(self.reject(resource, message, "write volumes from a compute pass"));
                continue;
            }
            let layers =
                self.plan.resource(resource).and_then(|planned| planned.size).map_or(1, |size| size.layers);
            if fullscreen && layers > 1 && attachment.target.layer.is_none() {
                let message = format!(
                    "\"{}\" has {layers} layers, and nothing says which is written",
                    attachment.resource
                );
                diagnostics.push(self.reject(resource, message, "add \"layer\" to the attachment"));
            }
        }
        diagnostics
    }
}
