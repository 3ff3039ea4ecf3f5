//! Parts of WebGPU's core mode that a target lacks, and a plan that needs them.
//!
//! OpenGL and compatibility mode lack some (views in another format, reading depth while it is tested against, a blend
//! state for each attachment), WebGL 2 lacks compute as well. wgpu rejects what needs them when objects are created or
//! commands are recorded, with a panic where the host has no error scope; here they are diagnostics of the plan.
//!
//! Arrays of cubes and shading by sample are checked with the shaders, since naga knows both. Numbers of storage
//! buffers are limits.

use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::language::format_name;
use umbragraph_pipeline::pipeline::{Located, Pass, Program, Usage};
use umbragraph_pipeline::shader::Capability;
use umbragraph_pipeline::work::{
    BoundSlot, Dispatch, Draw, DrawCounts, RenderWork, ResourceHandle, SlotSource, TransferEnd, Work,
};
use wgpu_types::{
    BindingType, BufferBindingType, BufferUsages, DownlevelFlags as Flags, ShaderStages,
    StorageTextureAccess, TextureViewDimension,
};

use crate::memory::physical::Physical;
use crate::plan::planned::{Plan, PlannedResource};
use crate::resources::view_shape;

/// Returns errors for passes and buffers that need a part of WebGPU's core mode that the device profile lacks.
pub(super) fn check(plan: &Plan) -> Vec<Diagnostic> {
    let lacking = Flags::all() - plan.pipeline.profile.downlevel;
    let mut diagnostics = Vec::new();
    if lacking.is_empty() {
        return diagnostics;
    }
    for planned in &plan.passes {
        let needs = Needs { plan, pass: plan.pipeline.pass(planned.handle), lacking };
        diagnostics.extend(needs.work());
        if let Some((program, slots)) = crate::resources::format::slots(&plan.pipeline, planned.handle) {
            diagnostics.extend(slots.iter().filter_map(|slot| needs.other_format(slot)));
            diagnostics.extend(slots.iter().filter_map(|slot| needs.other_shape(program, slot)));
            diagnostics.extend(needs.program(program));
        }
    }
    diagnostics.extend(index_buffers(plan, lacking));
    diagnostics
}

struct Needs<'a> {
    plan: &'a Plan,
    pass: &'a Pass,
    lacking: Flags,
}

impl Needs<'_> {
    fn work(&self) -> Vec<Diagnostic> {
        match self.pass.work() {
            Work::Nothing | Work::Cpu(_) => Vec::new(),
            Work::Compute(compute) => {
                let dispatched = self.lacks(Flags::COMPUTE_SHADERS, self.pass, || {
                    format!("\"{}\" runs a compute shader", self.pass.name)
                });
                let indirect = match &compute.dispatch {
                    Dispatch::Indirect(counts) => self.indirect(counts),
                    _ => None,
                };
                dispatched.or(indirect).into_iter().collect()
            }
            Work::Transfer(transfer) => {
                let ends = [transfer.source.as_ref(), Some(&transfer.destination)];
                let is_buffer = |end: &&TransferEnd| matches!(end, TransferEnd::Buffer(_));
                let with_buffer = ends.iter().flatten().any(is_buffer);
                let textures = ends.into_iter().flatten().filter(|end| with_buffer && !is_buffer(end));
                textures.filter_map(|end| self.depth_copy(end)).collect()
            }
            Work::Render(render) => self.render(render),
        }
    }

    fn render(&self, render: &RenderWork) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        if let Draw::Buffers(draw) = &render.draw
            && let DrawCounts::Indirect(counts) = &draw.counts
        {
            found.extend(self.indirect(counts));
        }
        let mut colors = render.color.iter();
        if let Some(first) = colors.next()
            && let Some(other) =
                colors.find(|color| color.blend != first.blend || color.write_mask != first.write_mask)
        {
            found.extend(self.lacks(Flags::INDEPENDENT_BLEND, &other.to, || {
                let [a, b] = [first, other].map(|color| self.name(color.to.resource));
                format!("\"{a}\" and \"{b}\" have blend states or write masks of their own")
            }));
        }
        for color in &render.color {
            found.extend(color.format.and_then(|format| self.seen_as(color.to.resource, format, &color.to)));
        }
        let (program, slots) = render.draw.bound();
        let tested = self.pass.accesses().iter().find(|one| one.usage == Usage::DepthAttachmentReadOnly);
        let is_read = |slot: &&BoundSlot, depth: ResourceHandle| match &slot.source {
            SlotSource::Texture(bound) => {
                let program = self.plan.pipeline.program(program);
                bound.texture.resource == depth && program.binding_at(slot.group, slot.binding).is_some()
            }
            _ => false,
        };
        if let Some(tested) = tested
            && let Some(slot) = slots.iter().find(|slot| is_read(slot, tested.resource))
        {
            found.extend(self.lacks(Flags::READ_ONLY_DEPTH_STENCIL, slot, || {
                let name = self.name(tested.resource);
                format!("\"{}\" reads \"{name}\" while it is tested against it", self.pass.name)
            }));
        }
        found
    }

    fn program(&self, program: &Program) -> Vec<Diagnostic> {
        let template = &program.template;
        let found = program.bindings.iter().filter_map(|binding| {
            let (name, entry) = (&binding.name, &binding.entry);
            let is_written = match entry.ty {
                BindingType::Buffer { ty: BufferBindingType::Storage { read_only }, .. } => !read_only,
                BindingType::StorageTexture { access, .. } => access != StorageTextureAccess::ReadOnly,
                _ => false,
            };
            if is_written && entry.visibility.contains(ShaderStages::FRAGMENT) {
                return self.lacks(Flags::FRAGMENT_WRITABLE_STORAGE, self.pass, || {
                    format!("the fragment stage of {template} writes \"{name}\"")
                });
            }
            let BindingType::Buffer { min_binding_size: Some(bytes), .. } = entry.ty else { return None };
            let is_crooked = bytes.get() % 16 != 0;
            let aligned = Flags::BUFFER_BINDINGS_NOT_16_BYTE_ALIGNED;
            let profile = &self.plan.pipeline.profile.name;
            (is_crooked && self.lacking.contains(aligned)).then(|| {
                let message = format!(
                    "the block \"{name}\" of {template} has {bytes} bytes, which is no multiple of 16, as {profile} wants"
                );
                let help = format!(
                    "write @align(16) before the first member of its structure, or leave {profile} out of \"profiles\""
                );
                self.pass.error(codes::DEVICE_RULE, message).help(help)
            })
        });
        found.collect()
    }

    fn other_format(&self, slot: &BoundSlot) -> Option<Diagnostic> {
        let SlotSource::Texture(bound) = &slot.source else { return None };
        self.seen_as(bound.texture.resource, bound.format?, slot)
    }

    /// Returns an error for a sampled view that has another dimension than the texture has on OpenGL, or covers only
    /// some of its layers.
    fn other_shape(&self, program: &Program, slot: &BoundSlot) -> Option<Diagnostic> {
        let SlotSource::Texture(bound) = &slot.source else { return None };
        let binding = program.binding_at(slot.group, slot.binding)?;
        let BindingType::Texture { view_dimension, .. } = binding.entry.ty else { return None };
        let view = &bound.texture;
        let resource = self.plan.resource(view.resource)?;
        let size = resource.size?;
        let own = match resource.physical {
            _ if view_dimension == TextureViewDimension::D3 => view_dimension,
            Physical::Texture(at) if self.plan.textures[at].spare_layer => TextureViewDimension::D2Array,
            _ => view_shape::of(size),
        };
        let is_part = own == TextureViewDimension::D2Array
            && view.range.layer.is_some_and(|layers| layers.first > 0 || layers.count != size.layers);
        if own == view_dimension && !is_part {
            return None;
        }
        self.lacks(Flags::VIEW_FORMATS, slot, || {
            let (pass, name) = (&self.pass.name, self.name(view.resource));
            let [seen, own] = [view_dimension, own].map(view_shape::name);
            match seen == own {
                true => format!("\"{pass}\" samples some layers of \"{name}\", which is bound with all"),
                false => format!("\"{pass}\" samples \"{name}\" as {seen}, which is bound as {own} alone"),
            }
        })
    }

    fn seen_as(
        &self,
        resource: ResourceHandle,
        format: wgpu_types::TextureFormat,
        place: &dyn Located,
    ) -> Option<Diagnostic> {
        let own = self.plan.resource(resource)?.format.filter(|own| *own != format)?;
        self.lacks(Flags::VIEW_FORMATS, place, || {
            let (name, own, format) = (self.name(resource), format_name(own), format_name(format));
            format!("\"{}\" sees \"{name}\", which is {own}, as {format}", self.pass.name)
        })
    }

    fn indirect(&self, counts: &dyn Located) -> Option<Diagnostic> {
        self.lacks(Flags::INDIRECT_EXECUTION, counts, || {
            format!("\"{}\" takes its counts from a buffer", self.pass.name)
        })
    }

    fn depth_copy(&self, end: &TransferEnd) -> Option<Diagnostic> {
        let texture = end.subresource();
        let is_depth = self.plan.resource(texture.resource)?.format?.is_depth_stencil_format();
        let flag = if is_depth { Flags::DEPTH_TEXTURE_AND_BUFFER_COPIES } else { Flags::empty() };
        self.lacks(flag, texture, || {
            format!("\"{}\" copies \"{}\" to or from a buffer", self.pass.name, self.name(texture.resource))
        })
    }

    fn name(&self, resource: ResourceHandle) -> &str {
        &self.plan.pipeline.resource(resource).name
    }

    /// Returns an error if the device profile lacks a capability, else `None`.
    fn lacks(
        &self,
        part: Flags,
        place: &dyn Located,
        message: impl FnOnce() -> String,
    ) -> Option<Diagnostic> {
        if part.is_empty() || !self.lacking.contains(part) {
            return None;
        }
        let (profile, name) = (&self.plan.pipeline.profile.name, Capability::name_of(part));
        let message = format!("{}; {profile} lacks \"{name}\"", message());
        Some(place.error(codes::DEVICE_RULE, message).help(format!(
            "let the feature that wants it have \"required_features\": [\"{name}\"], so that it is off there; or switch it off"
        )))
    }
}

/// Returns errors for index buffers that have other usages too, if the device profile does not allow this.
fn index_buffers(plan: &Plan, lacking: Flags) -> Vec<Diagnostic> {
    if !lacking.contains(Flags::UNRESTRICTED_INDEX_BUFFER) {
        return Vec::new();
    }
    let beside = BufferUsages::INDEX | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let of_indices =
        plan.buffers.iter().enumerate().filter(|(_, buffer)| {
            buffer.usages.contains(BufferUsages::INDEX) && !beside.contains(buffer.usages)
        });
    let found = of_indices.filter_map(|(at, _)| {
        let is_it = |one: &&PlannedResource| one.physical == Physical::Buffer(at);
        let resource = plan.pipeline.resource(plan.resources.values().find(is_it)?.handle);
        let profile = &plan.pipeline.profile.name;
        let message = format!(
            "\"{}\" holds indices and is used otherwise too, which {profile} does not allow",
            resource.name
        );
        let diagnostic = Diagnostic::error(codes::DEVICE_RULE, resource.place, message);
        Some(diagnostic.pointer(&resource.pointer).help("copy the indices to a buffer of their own"))
    });
    found.collect()
}
