//! Layouts and pipelines of passes.
//!
//! A program's layout is the union of its variants' reflected interfaces. Reflection cannot know which blocks have a
//! dynamic offset (`view`, and the blocks of an object); these are added here. A bind group that a program does not use
//! is a hole in its layout; a group that the host fills itself has the host's layout.
//!
//! A pass that draws the host's meshes has one pipeline for each property set of the host's interface, with the vertex
//! buffers that the variant reads; sets with the same variant share it. Front faces are counter-clockwise.

use std::collections::BTreeSet;

use crate::binding::blocks;
use crate::drawing::redraw;
use crate::objects::creation::Creation;
use crate::objects::shared::{ComputeKey, Objects, Primitive, RenderKey, VertexBufferKey};
use umbragraph_compiler::Plan;
use umbragraph_pipeline::draw::{DOUBLE_SIDED, HostAttribute, HostInterface, OBJECT_GROUP, PropertySet};
use umbragraph_pipeline::pipeline::{Program, ProgramVariant};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{BufferDraw, RenderWork, ResourceHandle, SceneDraw, SlotSource, Work};

/// The bind group layouts and the pipeline layout of a program. The index in `groups` is the bind group; `None` is a
/// group without bindings.
pub(crate) struct Layouts {
    pub(crate) groups: Vec<Option<wgpu::BindGroupLayout>>,
    pub(crate) pipeline: wgpu::PipelineLayout,
}

impl Layouts {
    /// The layout of the bind group at an index; `None` if the program has no bindings in it.
    pub(crate) fn group(&self, index: u32) -> Option<&wgpu::BindGroupLayout> {
        self.groups.get(index as usize)?.as_ref()
    }
}

/// Creates the layouts and pipelines of one pass.
pub(crate) struct Pipelines<'a, 'c> {
    pub(crate) creation: &'a mut Creation<'c>,
    pub(crate) objects: &'a mut Objects,
    pub(crate) plan: &'a Plan,
    /// The name of the pass, used as the label of its objects.
    pub(crate) name: &'a str,
    pub(crate) program: &'a Program,
}

impl Pipelines<'_, '_> {
    /// Creates the layouts of the program for a pass with this work. `host` is the layout of the host's meshes that the
    /// pass draws; `None` if it draws none.
    pub(crate) fn layouts(&mut self, work: &Work, host: Option<&HostInterface>) -> Layouts {
        let views = blocks::slots(work).iter().filter(|slot| matches!(slot.source, SlotSource::View));
        let views: BTreeSet<(u32, u32)> = views.map(|slot| (slot.group, slot.binding)).collect();
        let bindings = &self.program.bindings;
        let count = bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
        let is_used = |group: u32| bindings.iter().any(|binding| binding.group == group);
        let entries = |group: u32| -> Vec<wgpu::BindGroupLayoutEntry> {
            let own_layout = host.and_then(|host| host.own_layout(group));
            if let Some(entries) = own_layout.filter(|_| is_used(group)) {
                return entries.to_vec();
            }
            let own = bindings.iter().filter(|binding| binding.group == group);
            let entries = own.map(|binding| {
                let mut entry = wgpu::BindGroupLayoutEntry {
                    ty: self.program.bound_type(binding, blocks::slots(work)),
                    ..binding.entry
                };
                if let wgpu::BindingType::Buffer { has_dynamic_offset, .. } = &mut entry.ty {
                    let is_moved = host.is_some_and(|host| host.is_moved(&binding.name));
                    *has_dynamic_offset =
                        (is_moved && group == OBJECT_GROUP) || views.contains(&(group, entry.binding));
                }
                entry
            });
            entries.collect()
        };
        let all: Vec<_> = (0..count).map(entries).collect();
        let groups: Vec<Option<wgpu::BindGroupLayout>> = all
            .into_iter()
            .map(|entries| {
                let is_used = !entries.is_empty();
                is_used.then(|| self.objects.group_layout(self.creation, self.name, entries))
            })
            .collect();
        let pipeline = self.objects.pipeline_layout(self.creation, self.name, groups.clone());
        Layouts { groups, pipeline }
    }

    /// Creates the pipeline of a compute pass.
    pub(crate) fn compute(&mut self, layouts: &Layouts) -> Option<wgpu::ComputePipeline> {
        let variant = self.program.variants.first()?;
        let key = ComputeKey {
            layout: layouts.pipeline.clone(),
            module: self.objects.module(self.creation, &variant.module),
            entry_point: entry_point(variant, Stage::Compute),
            constants: bits(variant.module.constants.iter().map(|(name, value)| (name.clone(), *value))),
        };
        Some(self.objects.compute_pipeline(self.creation, self.name, key))
    }

    /// Creates the pipeline of a full-screen pass: one triangle over all texels of its attachments.
    pub(crate) fn fullscreen(
        &mut self,
        render: &RenderWork,
        layouts: &Layouts,
    ) -> Option<wgpu::RenderPipeline> {
        let variant = self.program.variants.first()?;
        Some(self.render(render, variant, layouts, Vec::new(), Primitive::default()))
    }

    /// Creates the pipeline of a pass that draws vertices from buffers of the render graph.
    pub(crate) fn buffers(
        &mut self,
        render: &RenderWork,
        draw: &BufferDraw,
        layouts: &Layouts,
    ) -> Option<wgpu::RenderPipeline> {
        let variant = self.program.variants.first()?;
        let streams = draw.vertices.iter();
        let buffers = streams.map(|stream| Some((stream.stride, stream.step, stream.attributes.clone())));
        let is_strip = draw.topology.is_strip();
        let primitive = Primitive {
            topology: draw.topology,
            cull: draw.cull,
            strip_indices: draw.indices.as_ref().filter(|_| is_strip).map(|indices| indices.format),
        };
        Some(self.render(render, variant, layouts, buffers.collect(), primitive))
    }

    /// Creates the pipelines of a pass that draws the host's meshes, one for each property set of the host's interface.
    pub(crate) fn scene(
        &mut self,
        render: &RenderWork,
        scene: &SceneDraw,
        layouts: &Layouts,
        interface: &HostInterface,
    ) -> Vec<(PropertySet, wgpu::RenderPipeline)> {
        let mut pipelines: Vec<(PropertySet, wgpu::RenderPipeline)> = Vec::new();
        for set in &interface.property_sets {
            let properties = interface.property_names(*set);
            let cull = scene.cull.filter(|_| !properties.contains(&DOUBLE_SIDED));
            let variant = self.program.variant(&properties);
            let buffers = vertex_buffers(variant, interface, *set);
            let primitive = Primitive { cull, ..Primitive::default() };
            pipelines.push((*set, self.render(render, variant, layouts, buffers, primitive)));
        }
        pipelines
    }

    /// Creates the pipeline that clears the depth of one view; `None` if the pass does not keep views from frame to
    /// frame.
    pub(crate) fn clear(&mut self, render: &RenderWork, scene: &SceneDraw) -> Option<wgpu::RenderPipeline> {
        scene.redraw.as_ref()?;
        let depth = self.plan.resource(render.depth.as_ref()?.to.resource)?;
        Some(redraw::clear_pipeline(self.creation, self.objects, depth.format?, depth.size?.samples))
    }

    fn render(
        &mut self,
        render: &RenderWork,
        variant: &ProgramVariant,
        layouts: &Layouts,
        buffers: Vec<Option<VertexBufferKey>>,
        primitive: Primitive,
    ) -> wgpu::RenderPipeline {
        let format =
            |resource: ResourceHandle| self.plan.resource(resource).and_then(|resource| resource.format);
        let attached = render.color.iter().map(|color| color.to.resource);
        let depth = render.depth.as_ref().map(|depth| depth.to.resource);
        let stencil = render.stencil.as_ref().map(|stencil| stencil.to.resource);
        let mut attached = attached.chain(depth).chain(stencil);
        let samples =
            attached.find_map(|resource| self.plan.resource(resource)?.size).map_or(1, |size| size.samples);
        let targets = render.color.iter().map(|color| {
            Some(wgpu::ColorTargetState {
                format: color.format.or_else(|| format(color.to.resource))?,
                blend: color.blend,
                write_mask: color.write_mask,
            })
        });
        let depth_stencil = depth.or(stencil).and_then(|resource| {
            let format = format(resource)?;
            let depth = render.depth.as_ref();
            // A format with depth wants to be told also where only its stencil is attached.
            let unused = format.has_depth_aspect().then_some((false, wgpu::CompareFunction::Always));
            let (write, compare) = depth.map(|depth| (depth.write, depth.compare)).or(unused).unzip();
            let slope_scale = depth.map_or(0.0, |depth| depth.slope_bias);
            Some(wgpu::DepthStencilState {
                format,
                depth_write_enabled: write,
                depth_compare: compare,
                stencil: render.stencil.as_ref().map(|stencil| stencil.state.clone()).unwrap_or_default(),
                bias: wgpu::DepthBiasState { constant: 0, slope_scale, clamp: 0.0 },
            })
        });
        let key = RenderKey {
            layout: layouts.pipeline.clone(),
            vertex: entry_point(variant, Stage::Vertex),
            fragment: entry_point(variant, Stage::Fragment),
            constants: bits(self.plan.constants(self.program, variant, render)),
            buffers,
            targets: targets.collect(),
            depth_stencil,
            samples,
            primitive,
            module: self.objects.module(self.creation, &variant.module),
        };
        self.objects.render_pipeline(self.creation, self.name, key)
    }
}

/// Returns the layouts of the host's vertex buffers, with the attributes that a shader variant reads. `None` is a
/// buffer of which the variant reads nothing; such buffers at the end of the list are left out.
fn vertex_buffers(
    variant: &ProgramVariant,
    interface: &HostInterface,
    set: PropertySet,
) -> Vec<Option<VertexBufferKey>> {
    let inputs = variant.entry_point(Stage::Vertex).map(|entry| entry.inputs.as_slice()).unwrap_or_default();
    let buffers = interface.buffers(set).iter().map(|buffer| {
        // Of attributes with one name the first counts, as it does when the interface is checked.
        let counts = |attribute: &&HostAttribute| {
            let first = interface.attribute(set, &attribute.name);
            first.is_some_and(|first| std::ptr::eq(first, *attribute))
        };
        let attributes = buffer.attributes.iter().filter(counts).filter_map(|attribute| {
            Some(wgpu::VertexAttribute {
                format: attribute.format,
                offset: attribute.offset,
                shader_location: inputs.iter().find(|input| input.name == attribute.name)?.location,
            })
        });
        let attributes: Vec<_> = attributes.collect();
        (!attributes.is_empty()).then_some((buffer.stride, buffer.step, attributes))
    });
    let mut buffers: Vec<_> = buffers.collect();
    while buffers.last().is_some_and(Option::is_none) {
        buffers.pop();
    }
    buffers
}

fn entry_point(variant: &ProgramVariant, stage: Stage) -> Option<String> {
    variant.entry_point(stage).map(|entry| entry.name.clone())
}

fn bits(constants: impl Iterator<Item = (String, f64)>) -> Vec<(String, u64)> {
    constants.map(|(name, value)| (name, value.to_bits())).collect()
}
