//! Bind group layouts and pipelines.
//!
//! Layouts are what reflection says of a program, the union over its variants; two things reflection cannot know are
//! added: which blocks move by a dynamic offset (`view`, and the blocks of an object). Shader modules are created once
//! for each distinct text. For a pass that draws the host's meshes there is one pipeline for each set of properties
//! that the host's interface names, with the vertex buffers from which the variant reads.

use std::collections::HashMap;

use super::Statistics;
use super::groups::Groups;
use super::scene::SceneGroups;
use super::uniforms;
use crate::compiler::{Plan, PlannedPass};
use crate::draw::{DOUBLE_SIDED, DrawSource, HostInterface, PropertySet};
use crate::pipeline::{Program, ProgramVariant};
use crate::shader::{ShaderModule, Stage};
use crate::work::{Draw, RenderWork, SceneDraw, SlotSource, Work};

/// A pass with everything that the device needs for it.
pub(super) enum RealizedPass {
    /// Nothing to record.
    Host,
    /// A copy.
    Copy,
    /// A dispatch.
    Compute { pipeline: wgpu::ComputePipeline, groups: Groups },
    /// A triangle.
    Fullscreen { pipeline: wgpu::RenderPipeline, groups: Groups },
    /// The host's draws.
    Scene { pipelines: Vec<(PropertySet, wgpu::RenderPipeline)>, groups: Groups, host: SceneGroups },
}

/// The layouts of a program.
pub(super) struct Layouts {
    pub(super) groups: Vec<wgpu::BindGroupLayout>,
    pub(super) pipeline: wgpu::PipelineLayout,
}

/// Creates everything that the passes of a plan need.
pub(super) fn realize(
    device: &wgpu::Device,
    plan: &Plan,
    source: Option<&dyn DrawSource>,
    statistics: &mut Statistics,
) -> Vec<RealizedPass> {
    let mut realizer = Realizer { device, plan, modules: HashMap::new(), statistics };
    plan.passes.iter().map(|planned| realizer.pass(planned, source)).collect()
}

struct Realizer<'a> {
    device: &'a wgpu::Device,
    plan: &'a Plan,
    modules: HashMap<[u8; 32], wgpu::ShaderModule>,
    statistics: &'a mut Statistics,
}

impl Realizer<'_> {
    fn pass(&mut self, planned: &PlannedPass, source: Option<&dyn DrawSource>) -> RealizedPass {
        let pass = self.plan.pipeline.pass(planned.handle);
        match &pass.work {
            Work::Host(_) => RealizedPass::Host,
            Work::Copy(_) => RealizedPass::Copy,
            Work::Compute(compute) => {
                let program = self.plan.pipeline.program(compute.program);
                let layouts = self.layouts(program, &pass.work, &pass.name);
                let variant = &program.variants[0];
                let module = self.module(&variant.module);
                let constants = constants(&variant.module);
                let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(&pass.name),
                    layout: Some(&layouts.pipeline),
                    module: &module,
                    entry_point: variant.entry_point(Stage::Compute).map(|entry| entry.name.as_str()),
                    compilation_options: options(&constants),
                    cache: None,
                });
                self.statistics.pipelines += 1;
                RealizedPass::Compute { pipeline, groups: Groups::new(self.plan, &pass.work, &layouts) }
            }
            Work::Render(render) => {
                let program = match &render.draw {
                    Draw::Fullscreen { program, .. } => *program,
                    Draw::Scene(scene) => scene.program,
                };
                let program = self.plan.pipeline.program(program);
                let layouts = self.layouts(program, &pass.work, &pass.name);
                let groups = Groups::new(self.plan, &pass.work, &layouts);
                match &render.draw {
                    Draw::Fullscreen { .. } => {
                        let pipeline = self.render_pipeline(&pass.name, render, &program.variants[0], &layouts, None, None);
                        RealizedPass::Fullscreen { pipeline, groups }
                    }
                    Draw::Scene(scene) => {
                        let interface = source.and_then(|source| source.interface(&scene.geometry));
                        let pipelines = interface.map(|interface| self.scene_pipelines(&pass.name, render, scene, program, &layouts, interface));
                        let host = SceneGroups::new(program, &layouts, interface);
                        RealizedPass::Scene { pipelines: pipelines.unwrap_or_default(), groups, host }
                    }
                }
            }
        }
    }

    fn scene_pipelines(
        &mut self,
        name: &str,
        render: &RenderWork,
        scene: &SceneDraw,
        program: &Program,
        layouts: &Layouts,
        interface: &HostInterface,
    ) -> Vec<(PropertySet, wgpu::RenderPipeline)> {
        interface
            .property_sets
            .iter()
            .map(|set| {
                let properties = interface.property_names(*set);
                let cull = scene.cull.filter(|_| !properties.contains(&DOUBLE_SIDED));
                let variant = program.variant(&properties);
                (*set, self.render_pipeline(name, render, variant, layouts, Some(interface), cull))
            })
            .collect()
    }

    fn render_pipeline(
        &mut self,
        name: &str,
        render: &RenderWork,
        variant: &ProgramVariant,
        layouts: &Layouts,
        interface: Option<&HostInterface>,
        cull: Option<wgpu::Face>,
    ) -> wgpu::RenderPipeline {
        let module = self.module(&variant.module);
        let constants = constants(&variant.module);
        let vertex = variant.entry_point(Stage::Vertex);
        let attributes: Vec<Vec<wgpu::VertexAttribute>> = interface.map_or_else(Vec::new, |interface| {
            interface
                .vertex_buffers
                .iter()
                .map(|buffer| {
                    let inputs = vertex.map(|entry| entry.inputs.as_slice()).unwrap_or_default();
                    let wanted = |name: &str| inputs.iter().find(|input| input.name == name);
                    buffer
                        .attributes
                        .iter()
                        .filter_map(|attribute| {
                            Some(wgpu::VertexAttribute {
                                format: attribute.format,
                                offset: attribute.offset,
                                shader_location: wanted(&attribute.name)?.location,
                            })
                        })
                        .collect()
                })
                .collect()
        });
        let mut buffers: Vec<Option<wgpu::VertexBufferLayout<'_>>> = interface.map_or_else(Vec::new, |interface| {
            interface
                .vertex_buffers
                .iter()
                .zip(&attributes)
                .map(|(buffer, attributes)| {
                    (!attributes.is_empty()).then_some(wgpu::VertexBufferLayout {
                        array_stride: buffer.stride,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes,
                    })
                })
                .collect()
        });
        while buffers.last().is_some_and(Option::is_none) {
            buffers.pop();
        }
        let format = |resource| self.plan.resource(resource).and_then(|resource| resource.format);
        let samples = render
            .color
            .iter()
            .map(|color| color.target.resource)
            .chain(render.depth.as_ref().map(|depth| depth.target.resource))
            .find_map(|resource| self.plan.resource(resource)?.size)
            .map_or(1, |size| size.samples);
        let targets: Vec<Option<wgpu::ColorTargetState>> = render
            .color
            .iter()
            .map(|color| {
                Some(wgpu::ColorTargetState {
                    format: format(color.target.resource)?,
                    blend: color.blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })
            })
            .collect();
        let depth_stencil = render.depth.as_ref().and_then(|depth| {
            Some(wgpu::DepthStencilState {
                format: format(depth.target.resource)?,
                depth_write_enabled: Some(depth.write),
                depth_compare: Some(depth.compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState { constant: 0, slope_scale: depth.slope_bias, clamp: 0.0 },
            })
        });
        let fragment = variant.entry_point(Stage::Fragment).map(|entry| wgpu::FragmentState {
            module: &module,
            entry_point: Some(&entry.name),
            compilation_options: options(&constants),
            targets: &targets,
        });
        self.statistics.pipelines += 1;
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(name),
            layout: Some(&layouts.pipeline),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: vertex.map(|entry| entry.name.as_str()),
                compilation_options: options(&constants),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: cull, ..wgpu::PrimitiveState::default() },
            depth_stencil,
            multisample: wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() },
            fragment,
            multiview_mask: None,
            cache: None,
        })
    }

    fn module(&mut self, shader: &ShaderModule) -> wgpu::ShaderModule {
        let device = self.device;
        self.modules
            .entry(shader.hash)
            .or_insert_with(|| {
                device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(&shader.template),
                    source: wgpu::ShaderSource::Wgsl(std::borrow::Cow::Borrowed(&shader.wgsl)),
                })
            })
            .clone()
    }

    fn layouts(&self, program: &Program, work: &Work, name: &str) -> Layouts {
        let is_scene = matches!(work, Work::Render(render) if matches!(render.draw, Draw::Scene(_)));
        let moves = |group: u32, binding: u32| {
            (is_scene && group == 3)
                || uniforms::slots(work)
                    .iter()
                    .any(|slot| (slot.group, slot.binding) == (group, binding) && matches!(slot.source, SlotSource::View(_)))
        };
        let count = program.bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
        let groups: Vec<wgpu::BindGroupLayout> = (0..count)
            .map(|group| {
                let entries: Vec<wgpu::BindGroupLayoutEntry> = program
                    .bindings
                    .iter()
                    .filter(|binding| binding.group == group)
                    .map(|binding| {
                        let mut entry = binding.entry;
                        if let wgpu::BindingType::Buffer { has_dynamic_offset, .. } = &mut entry.ty {
                            *has_dynamic_offset = moves(group, entry.binding);
                        }
                        entry
                    })
                    .collect();
                self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries })
            })
            .collect();
        let references: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().map(Some).collect();
        let pipeline = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &references,
            immediate_size: 0,
        });
        Layouts { groups, pipeline }
    }
}

fn constants(shader: &ShaderModule) -> Vec<(&str, f64)> {
    shader.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect()
}

fn options<'a>(constants: &'a [(&'a str, f64)]) -> wgpu::PipelineCompilationOptions<'a> {
    wgpu::PipelineCompilationOptions { constants, ..wgpu::PipelineCompilationOptions::default() }
}
