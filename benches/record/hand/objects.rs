//! Single objects of wgpu as a plan describes them.

use umbragraph::Plan;
use umbragraph::draw::{HostInterface, PropertySet};
use umbragraph::low_level::pipeline::{Aspect, Program, ProgramVariant, ResourceKind};
use umbragraph::low_level::shader::Stage;
use umbragraph::work::{
    BoundSlot, Draw, Filter, RenderWork, ResourceHandle, Sampler, SlotSource, TextureView,
};

/// Creates a bind group with resources that the host provides.
pub(super) fn host_group<'a>(
    device: &wgpu::Device,
    (program, layouts): (&Program, &[Option<wgpu::BindGroupLayout>]),
    index: usize,
    give: &dyn Fn(&str) -> Option<wgpu::BindingResource<'a>>,
) -> Option<wgpu::BindGroup> {
    let layout = layouts.get(index)?.as_ref()?;
    let bindings = program.bindings.iter().filter(|binding| binding.group as usize == index);
    let entries: Vec<_> = bindings
        .map(|binding| wgpu::BindGroupEntry {
            binding: binding.entry.binding,
            resource: give(&binding.name).expect("what the host has"),
        })
        .collect();
    Some(device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries }))
}

pub(super) fn views_of(render: &RenderWork) -> ResourceHandle {
    let Draw::Scene(scene) = &render.draw else { panic!("views without meshes") };
    scene.views.resource
}

pub(super) fn max_views(plan: &Plan, render: &RenderWork) -> u64 {
    match &plan.pipeline.resource(views_of(render)).kind {
        ResourceKind::Data(Some(shape)) => u64::from(shape.max_views).max(1),
        _ => 1,
    }
}

pub(super) fn layout(
    device: &wgpu::Device,
    program: &Program,
    slots: &[BoundSlot],
    group: u32,
    is_scene: bool,
) -> Option<wgpu::BindGroupLayout> {
    let entries: Vec<_> = program
        .bindings
        .iter()
        .filter(|binding| binding.group == group)
        .map(|binding| {
            let mut entry =
                wgpu::BindGroupLayoutEntry { ty: program.bound_type(binding, slots), ..binding.entry };
            let is_view = slots.iter().any(|slot| {
                (slot.group, slot.binding) == (group, entry.binding)
                    && matches!(slot.source, SlotSource::View)
            });
            if let wgpu::BindingType::Buffer { has_dynamic_offset, .. } = &mut entry.ty {
                *has_dynamic_offset = is_view || (is_scene && group == 3);
            }
            entry
        })
        .collect();
    (!entries.is_empty()).then(|| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    })
}

pub(super) fn view(texture: &wgpu::Texture, view: TextureView) -> wgpu::TextureView {
    let layers = view
        .layer
        .map(|run| run.count)
        .or((view.shape == umbragraph::low_level::language::TextureShape::D2).then_some(1));
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(view.shape.into()),
        format: view.format,
        aspect: Aspect::All.into(),
        base_mip_level: view.mip.map_or(0, |run| run.first),
        mip_level_count: view.mip.map(|run| run.count),
        base_array_layer: view.layer.map_or(0, |run| run.first),
        array_layer_count: layers,
        ..wgpu::TextureViewDescriptor::default()
    })
}

pub(super) fn layer(texture: &wgpu::Texture, at: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: at,
        array_layer_count: Some(1),
        mip_level_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

pub(super) fn sampler(device: &wgpu::Device, sampler: &Sampler) -> wgpu::Sampler {
    let (address, filter) = (sampler.address.into(), sampler.filter.into());
    device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter: if sampler.filter == Filter::Linear {
            wgpu::MipmapFilterMode::Linear
        } else {
            wgpu::MipmapFilterMode::Nearest
        },
        compare: sampler.compare.map(Into::into),
        ..wgpu::SamplerDescriptor::default()
    })
}

pub(super) fn pipeline(
    device: &wgpu::Device,
    plan: &Plan,
    render: &RenderWork,
    variant: &ProgramVariant,
    layout: &wgpu::PipelineLayout,
    (host, cull): (Option<(&HostInterface, PropertySet)>, Option<wgpu::Face>),
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(variant.module.wgsl.to_string().into()),
    });
    let constants: Vec<(&str, f64)> =
        variant.module.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    let options = wgpu::PipelineCompilationOptions {
        constants: &constants,
        ..wgpu::PipelineCompilationOptions::default()
    };
    let format = |resource| plan.resource(resource).and_then(|one| one.format);
    let targets: Vec<_> = render
        .color
        .iter()
        .map(|color| {
            Some(wgpu::ColorTargetState {
                format: color.format.or_else(|| format(color.to.resource))?,
                blend: color.blend,
                write_mask: color.write_mask,
            })
        })
        .collect();
    let depth_stencil = render.depth.as_ref().and_then(|depth| {
        Some(wgpu::DepthStencilState {
            format: format(depth.to.resource)?,
            depth_write_enabled: Some(depth.write),
            depth_compare: Some(depth.compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState { constant: 0, slope_scale: depth.slope_bias, clamp: 0.0 },
        })
    });
    let attached = render
        .color
        .first()
        .map(|color| color.to.resource)
        .or(render.depth.as_ref().map(|depth| depth.to.resource));
    let samples = attached.and_then(|one| plan.resource(one)?.size).map_or(1, |size| size.samples);
    let vertex = variant.entry_point(Stage::Vertex);
    let inputs = vertex.map(|entry| entry.inputs.as_slice()).unwrap_or_default();
    let attributes: Vec<(u64, Vec<wgpu::VertexAttribute>)> = host
        .map(|(host, set)| {
            host.buffers(set)
                .iter()
                .map(|buffer| {
                    let attributes = buffer.attributes.iter().filter_map(|one| {
                        Some(wgpu::VertexAttribute {
                            format: one.format,
                            offset: one.offset,
                            shader_location: inputs.iter().find(|input| input.name == one.name)?.location,
                        })
                    });
                    (buffer.stride, attributes.collect())
                })
                .collect()
        })
        .unwrap_or_default();
    let mut buffers: Vec<_> = attributes
        .iter()
        .map(|(stride, attributes)| {
            (!attributes.is_empty()).then_some(wgpu::VertexBufferLayout {
                array_stride: *stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        })
        .collect();
    while buffers.last().is_some_and(Option::is_none) {
        buffers.pop();
    }
    let fragment = variant.entry_point(Stage::Fragment);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: vertex.map(|entry| entry.name.as_str()),
            compilation_options: options.clone(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState { cull_mode: cull, ..wgpu::PrimitiveState::default() },
        depth_stencil,
        multisample: wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() },
        fragment: fragment.map(|entry| wgpu::FragmentState {
            module: &module,
            entry_point: Some(&entry.name),
            compilation_options: options.clone(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
