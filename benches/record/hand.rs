//! The same frame by hand: the textures, pipelines and bind groups of a plan, made once, and each frame the calls of wgpu
//! that draw it, one after the other.
//!
//! Limits: passes that draw the host's meshes or cover their attachments, uniform and storage blocks, no toggles, no
//! histories, no resources that share memory: what `awsm` has without options.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::compiler::{CpuPasses, Physical, StoreOperation};
use umbragraph::data::{BlackboardData, View};
use umbragraph::draw::{DOUBLE_SIDED, DrawPass, DrawSource, HostInterface, PropertySet};
use umbragraph::frame::FrameInput;
use umbragraph::pipeline::{Aspect, Program, ProgramVariant, ResourceKind};
use umbragraph::shader::Stage;
use umbragraph::work::{
    BlockLayout, BoundSlot, Draw, Filter, LoadOperation, RenderWork, ResourceHandle, Sampler, SlotSource,
    TextureView, Work,
};
use umbragraph_test_support::gpu::Gpu;

pub(crate) struct ByHand {
    device: wgpu::Device,
    queue: wgpu::Queue,
    cpu: CpuPasses,
    passes: Vec<Pass>,
    blocks: wgpu::Buffer,
    staging: Vec<u8>,
    fills: Vec<Fill>,
    /// Offset, bytes, bytes from view to view, and whose views.
    places: Vec<(usize, usize, usize, Option<String>)>,
    view: BlackboardData,
    pub(crate) counts: Counts,
}

/// What a frame has asked of wgpu.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Counts {
    pub(crate) passes: u64,
    pub(crate) draws: u64,
    pub(crate) pipelines: u64,
    pub(crate) groups: u64,
}

/// A block that data fills.
struct Fill {
    layout: BlockLayout,
    data: String,
    offset: usize,
    size: usize,
    /// Bytes from view to view, where it is a block of the view.
    stride: Option<usize>,
}

struct Pass {
    name: String,
    /// Whether it goes on in the render pass of the one before.
    joins: bool,
    color: Vec<(wgpu::TextureView, wgpu::LoadOp<wgpu::Color>, wgpu::StoreOp)>,
    /// A view of each layer.
    depth: Vec<wgpu::TextureView>,
    depth_ops: (wgpu::LoadOp<f32>, wgpu::StoreOp),
    extent: [u32; 2],
    /// Index, bind group, bytes from view to view.
    groups: Vec<(u32, wgpu::BindGroup, Option<u32>)>,
    what: What,
}

enum What {
    Cover(wgpu::RenderPipeline),
    Meshes {
        views: String,
        filter: String,
        order: umbragraph::work::DrawOrder,
        pipelines: Vec<(PropertySet, wgpu::RenderPipeline)>,
        materials: Vec<wgpu::BindGroup>,
        object: Option<wgpu::BindGroup>,
    },
}

impl ByHand {
    pub(crate) fn new(gpu: &Gpu, plan: &Arc<Plan>, source: &dyn DrawSource, target: &wgpu::Texture) -> Self {
        let device = &gpu.device;
        let textures: Vec<wgpu::Texture> = plan
            .textures
            .iter()
            .map(|one| {
                device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&one.label),
                    size: wgpu::Extent3d {
                        width: one.size.width,
                        height: one.size.height,
                        depth_or_array_layers: one.size.layers,
                    },
                    mip_level_count: one.size.mips,
                    sample_count: one.size.samples,
                    dimension: wgpu::TextureDimension::D2,
                    format: one.format,
                    usage: one.usages,
                    view_formats: one.view_format.as_slice(),
                })
            })
            .collect();
        let texture = |handle: ResourceHandle| match plan.resource(handle).expect("a resource").physical {
            Physical::Texture(at) => &textures[at],
            _ => target,
        };
        let mut size = 0;
        let mut places: Vec<Vec<Option<(u64, u64, u64)>>> = Vec::new();
        let mut fills = Vec::new();
        let mut block_places = Vec::new();
        let mut constants: Vec<(usize, Vec<u8>)> = Vec::new();
        for planned in &plan.passes {
            let Work::Render(render) = plan.pipeline.pass(planned.handle).work() else {
                places.push(Vec::new());
                continue;
            };
            let (program, slots) = render.draw.bound();
            let program = plan.pipeline.program(program);
            let mut of_pass = Vec::new();
            for slot in slots {
                let bytes = plan
                    .pipeline
                    .block_bytes(program, slot)
                    .map(|bytes| u64::from(bytes).next_multiple_of(16));
                of_pass.push(bytes.map(|bytes| {
                    let stride = bytes.next_multiple_of(256);
                    let count =
                        if matches!(slot.source, SlotSource::View) { max_views(plan, render) } else { 1 };
                    let place = (size, bytes, stride);
                    size += stride * count;
                    let views = matches!(slot.source, SlotSource::View)
                        .then(|| plan.pipeline.resource(views_of(render)).name.clone());
                    block_places.push((place.0 as usize, bytes as usize, stride as usize, views));
                    let data = match &slot.source {
                        SlotSource::Data { data, .. } => Some((data.resource, None)),
                        SlotSource::View => Some((views_of(render), Some(stride as usize))),
                        _ => None,
                    };
                    if let Some((layout, (data, stride))) =
                        plan.pipeline.block_layout(program, slot).zip(data)
                    {
                        let data = plan.pipeline.resource(data).name.clone();
                        fills.push(Fill {
                            layout,
                            data,
                            offset: place.0 as usize,
                            size: bytes as usize,
                            stride,
                        });
                    }
                    let block = planned
                        .blocks
                        .iter()
                        .find(|block| (block.group, block.binding) == (slot.group, slot.binding));
                    constants.extend(block.map(|block| (place.0 as usize, block.bytes.clone())));
                    place
                }));
            }
            places.push(of_pass);
        }
        let mut staging = vec![0; size as usize];
        for (at, bytes) in constants {
            staging[at..at + bytes.len()].copy_from_slice(&bytes);
        }
        let blocks = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("blocks"),
            size,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut passes = Vec::new();
        for (planned, places) in plan.passes.iter().zip(&places) {
            let Work::Render(render) = plan.pipeline.pass(planned.handle).work() else { continue };
            let (program, slots) = render.draw.bound();
            let program = plan.pipeline.program(program);
            let is_scene = matches!(render.draw, Draw::Scene(_));
            let host = match &render.draw {
                Draw::Scene(scene) => source.interface(&scene.geometry),
                _ => None,
            };
            let count = program.bindings.iter().map(|binding| binding.group + 1).max().unwrap_or(0);
            let layouts: Vec<Option<wgpu::BindGroupLayout>> =
                (0..count).map(|group| layout(device, program, slots, group, is_scene)).collect();
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &layouts.iter().map(Option::as_ref).collect::<Vec<_>>(),
                immediate_size: 0,
            });
            let mut groups = Vec::new();
            for (index, layout) in (0..).zip(&layouts) {
                let Some(layout) = layout.as_ref().filter(|_| !is_scene || index < 2) else { continue };
                let mut moved = None;
                let views: Vec<_> = slots
                    .iter()
                    .map(|slot| match &slot.source {
                        SlotSource::Texture(bound) => {
                            Some(view(texture(bound.texture.resource), bound.view()))
                        }
                        _ => None,
                    })
                    .collect();
                let samplers: Vec<_> = slots
                    .iter()
                    .map(|slot| match &slot.source {
                        SlotSource::Sampler(one) => Some(sampler(device, one)),
                        _ => None,
                    })
                    .collect();
                let mut entries = Vec::new();
                for (at, slot) in slots.iter().enumerate() {
                    if slot.group != index || program.binding_at(index, slot.binding).is_none() {
                        continue;
                    }
                    let resource = match (&views[at], &samplers[at], places[at]) {
                        (Some(view), ..) => wgpu::BindingResource::TextureView(view),
                        (_, Some(sampler), _) => wgpu::BindingResource::Sampler(sampler),
                        (.., Some((offset, bytes, stride))) => {
                            if matches!(slot.source, SlotSource::View) {
                                moved = Some(stride as u32);
                            }
                            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                                buffer: &blocks,
                                offset,
                                size: wgpu::BufferSize::new(bytes),
                            })
                        }
                        _ => panic!("\"{}\" is of a kind that is not written by hand", slot.name),
                    };
                    entries.push(wgpu::BindGroupEntry { binding: slot.binding, resource });
                }
                let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout,
                    entries: &entries,
                });
                groups.push((index, group, moved));
            }
            let what = match &render.draw {
                Draw::Scene(scene) => {
                    let host = host.expect("the host's interface");
                    let pipelines = host
                        .property_sets
                        .iter()
                        .map(|set| {
                            let properties = host.property_names(*set);
                            let variant = program.variant(&properties);
                            let cull = scene.cull.filter(|_| !properties.contains(&DOUBLE_SIDED));
                            (
                                *set,
                                pipeline(
                                    device,
                                    plan,
                                    render,
                                    variant,
                                    &pipeline_layout,
                                    (Some((host, *set)), cull),
                                ),
                            )
                        })
                        .collect();
                    What::Meshes {
                        views: plan.pipeline.resource(scene.views.resource).name.clone(),
                        filter: scene.filter.clone(),
                        order: scene.order,
                        pipelines,
                        materials: (0..source.material_count())
                            .filter_map(|at| {
                                host_group(device, (program, &layouts), 2, &|name| source.material(at, name))
                            })
                            .collect(),
                        object: host_group(device, (program, &layouts), 3, &|name| source.object(name)),
                    }
                }
                Draw::Fullscreen { .. } => What::Cover(pipeline(
                    device,
                    plan,
                    render,
                    &program.variants[0],
                    &pipeline_layout,
                    (None, None),
                )),
                Draw::Buffers(_) => panic!("not written by hand"),
            };
            let store = |operation| match operation {
                StoreOperation::Store => wgpu::StoreOp::Store,
                StoreOperation::Discard => wgpu::StoreOp::Discard,
            };
            let color = render
                .color
                .iter()
                .zip(&planned.color)
                .map(|(color, planned)| {
                    let load = match color.load {
                        LoadOperation::Load => wgpu::LoadOp::Load,
                        LoadOperation::Clear([r, g, b, a]) => wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }),
                        LoadOperation::Discard => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    };
                    (layer(texture(color.to.resource), 0), load, store(planned.store))
                })
                .collect();
            let attached = render.depth.as_ref().map(|depth| (depth, texture(depth.to.resource)));
            let depth_ops = attached.zip(planned.depth.as_ref()).map(|((depth, _), planned)| {
                let load = match depth.load {
                    LoadOperation::Load => wgpu::LoadOp::Load,
                    LoadOperation::Clear(value) => wgpu::LoadOp::Clear(value as f32),
                    LoadOperation::Discard => wgpu::LoadOp::Clear(0.0),
                };
                (load, store(planned.store))
            });
            let first = attached
                .map(|(_, texture)| texture)
                .or(render.color.first().map(|color| texture(color.to.resource)));
            let extent = first.map_or([0; 2], |texture| [texture.width(), texture.height()]);
            let joins = passes.last().is_some_and(|before: &(u64, Pass)| before.0 == planned.group as u64);
            passes.push((
                planned.group as u64,
                Pass {
                    name: planned.name.clone(),
                    joins,
                    color,
                    depth: attached
                        .map(|(_, texture)| {
                            (0..texture.depth_or_array_layers()).map(|at| layer(texture, at)).collect()
                        })
                        .unwrap_or_default(),
                    depth_ops: depth_ops.unwrap_or((wgpu::LoadOp::Load, wgpu::StoreOp::Store)),
                    extent,
                    groups,
                    what,
                },
            ));
        }
        let mut passes: Vec<Pass> = passes.into_iter().map(|(_, pass)| pass).collect();
        // A render pass of several stores as its last one says.
        for at in (1..passes.len()).rev() {
            if passes[at].joins {
                let (before, after) = passes.split_at_mut(at);
                before[at - 1].color.iter_mut().zip(&after[0].color).for_each(|(a, b)| a.2 = b.2);
                before[at - 1].depth_ops.1 = after[0].depth_ops.1;
            }
        }
        Self {
            device: device.clone(),
            queue: gpu.queue.clone(),
            cpu: CpuPasses::new(plan.clone()),
            passes,
            blocks,
            staging,
            fills,
            places: block_places,
            view: BlackboardData::new(View::shape()),
            counts: Counts::default(),
        }
    }

    /// The frame.
    pub(crate) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        input: &FrameInput,
        source: &dyn DrawSource,
    ) {
        self.cpu.run(input, &[]).expect("data");
        for fill in &self.fills {
            let data = self.cpu.data(&fill.data).expect("data");
            match fill.stride {
                None => fill.layout.pack(data, &mut self.staging[fill.offset..fill.offset + fill.size]),
                Some(stride) => {
                    for (at, view) in data.views().iter().enumerate() {
                        view.publish(&mut self.view);
                        let offset = fill.offset + at * stride;
                        fill.layout.pack(&self.view, &mut self.staging[offset..offset + fill.size]);
                    }
                }
            }
        }
        // Of views that there are.
        let mut used: Vec<std::ops::Range<usize>> = Vec::new();
        for (offset, size, stride, data) in &self.places {
            let views = data
                .as_ref()
                .and_then(|data| self.cpu.data(data))
                .map_or(1, |data| data.views().len().max(1));
            let end = offset + stride * (views - 1) + size;
            match used.last_mut() {
                Some(last) if *offset <= last.end + (16 << 10) => last.end = last.end.max(end),
                _ => used.push(*offset..end),
            }
        }
        for range in used {
            self.queue.write_buffer(&self.blocks, range.start as u64, &self.staging[range]);
        }
        let mut counts = Counts::default();
        let mut open: Option<wgpu::RenderPass<'static>> = None;
        for pass in &self.passes {
            if !pass.joins {
                open = None;
            }
            match &pass.what {
                What::Cover(pipeline) => {
                    let mut render = open.take().unwrap_or_else(|| pass.begin(encoder, 0, true, &mut counts));
                    pass.viewport(&mut render, None);
                    render.set_pipeline(pipeline);
                    pass.bind(&mut render, 0, &mut counts);
                    render.draw(0..3, 0..1);
                    counts.pipelines += 1;
                    counts.draws += 1;
                    open = Some(render);
                }
                What::Meshes { views, .. } if pass.depth.len() <= 1 => {
                    let views = self.cpu.data(views).map(BlackboardData::views).unwrap_or_default();
                    let mut render = open.take().unwrap_or_else(|| pass.begin(encoder, 0, true, &mut counts));
                    for (at, view) in views.iter().enumerate() {
                        pass.draw(source, (at, view), &mut render, &mut counts);
                    }
                    open = Some(render);
                }
                What::Meshes { views, .. } => {
                    let views = self.cpu.data(views).map(BlackboardData::views).unwrap_or_default();
                    let mut drawn = [false; 64];
                    let mut first = 0;
                    for run in views.chunk_by(|a, b| a.layer == b.layer) {
                        let layer = run[0].layer as usize;
                        let is_first = !std::mem::replace(&mut drawn[layer], true);
                        let mut render = pass.begin(encoder, layer, is_first, &mut counts);
                        for (at, view) in (first..).zip(run) {
                            pass.draw(source, (at, view), &mut render, &mut counts);
                        }
                        first += run.len();
                    }
                    for layer in (0..pass.depth.len()).filter(|layer| !drawn[*layer]) {
                        drop(pass.begin(encoder, layer, true, &mut counts));
                    }
                }
            }
        }
        drop(open);
        self.counts = counts;
    }

    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.device
    }
}

impl Pass {
    fn begin(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: usize,
        is_first: bool,
        counts: &mut Counts,
    ) -> wgpu::RenderPass<'static> {
        counts.passes += 1;
        let color: Vec<_> = self
            .color
            .iter()
            .map(|(view, load, store)| {
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: *load, store: *store },
                })
            })
            .collect();
        let load = if is_first { self.depth_ops.0 } else { wgpu::LoadOp::Load };
        let depth = self.depth.get(layer).map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load, store: self.depth_ops.1 }),
            stencil_ops: None,
        });
        encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(&self.name),
                color_attachments: &color,
                depth_stencil_attachment: depth,
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime()
    }

    fn viewport(&self, render: &mut wgpu::RenderPass<'static>, texels: Option<[u32; 4]>) {
        let [x, y, width, height] = texels.unwrap_or([0, 0, self.extent[0], self.extent[1]]);
        render.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        render.set_scissor_rect(x, y, width, height);
    }

    fn bind(&self, render: &mut wgpu::RenderPass<'static>, view: usize, counts: &mut Counts) {
        for (index, group, moved) in &self.groups {
            match moved {
                Some(stride) => render.set_bind_group(*index, group, &[stride * view as u32]),
                None => render.set_bind_group(*index, group, &[]),
            }
            counts.groups += 1;
        }
    }

    fn draw(
        &self,
        source: &dyn DrawSource,
        (at, view): (usize, &View),
        render: &mut wgpu::RenderPass<'static>,
        counts: &mut Counts,
    ) {
        let What::Meshes { filter, order, pipelines, materials, object, .. } = &self.what else { return };
        self.viewport(render, view.viewport);
        let Some((_, pipeline)) = pipelines.first() else { return };
        render.set_pipeline(pipeline);
        counts.pipelines += 1;
        self.bind(render, at, counts);
        if let Some(material) = materials.first() {
            render.set_bind_group(2, material, &[]);
            counts.groups += 1;
        }
        if let Some(object) = object {
            render.set_bind_group(3, object, &[0]);
            counts.groups += 1;
        }
        source.draw(&mut Hand {
            filter,
            order: *order,
            view,
            pipelines,
            materials,
            object: object.as_ref(),
            render,
            counts,
        });
    }
}

struct Hand<'a> {
    filter: &'a str,
    order: umbragraph::work::DrawOrder,
    view: &'a View,
    pipelines: &'a [(PropertySet, wgpu::RenderPipeline)],
    materials: &'a [wgpu::BindGroup],
    object: Option<&'a wgpu::BindGroup>,
    render: &'a mut wgpu::RenderPass<'static>,
    counts: &'a mut Counts,
}

impl DrawPass for Hand<'_> {
    fn geometry(&self) -> &str {
        "scene"
    }
    fn filter(&self) -> &str {
        self.filter
    }
    fn view(&self) -> &View {
        self.view
    }
    fn order(&self) -> umbragraph::work::DrawOrder {
        self.order
    }
    fn set_properties(&mut self, properties: PropertySet) -> bool {
        let found = self.pipelines.iter().find(|(set, _)| *set == properties);
        found.map(|(_, pipeline)| self.render.set_pipeline(pipeline)).is_some()
    }
    fn set_material(&mut self, material: u32) {
        if let Some(group) = self.materials.get(material as usize) {
            self.render.set_bind_group(2, group, &[]);
        }
    }
    fn set_object(&mut self, object: u32) {
        self.counts.draws += 1;
        if let Some(group) = self.object {
            self.render.set_bind_group(3, group, &[object * 256]);
        }
    }
    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        self.render
    }
}

/// A bind group that the host fills.
fn host_group<'a>(
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

fn views_of(render: &RenderWork) -> ResourceHandle {
    let Draw::Scene(scene) = &render.draw else { panic!("views without meshes") };
    scene.views.resource
}

fn max_views(plan: &Plan, render: &RenderWork) -> u64 {
    match &plan.pipeline.resource(views_of(render)).kind {
        ResourceKind::Data(Some(shape)) => u64::from(shape.max_views).max(1),
        _ => 1,
    }
}

fn layout(
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

fn view(texture: &wgpu::Texture, view: TextureView) -> wgpu::TextureView {
    let layers = view
        .layer
        .map(|run| run.count)
        .or((view.shape == umbragraph::language::TextureShape::D2).then_some(1));
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

fn layer(texture: &wgpu::Texture, at: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: at,
        array_layer_count: Some(1),
        mip_level_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

fn sampler(device: &wgpu::Device, sampler: &Sampler) -> wgpu::Sampler {
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

fn pipeline(
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
