//! Objects that are made once for a plan, before its frames: textures, the buffer of blocks with its constants,
//! pipelines and bind groups.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::data::{BlackboardData, View};
use umbragraph::draw::{DOUBLE_SIDED, DrawSource};
use umbragraph::low_level::compiler::{CpuPasses, Physical, StoreOperation};
use umbragraph::work::{Draw, LoadOperation, ResourceHandle, SlotSource, Work};
use umbragraph_test_support::gpu::Gpu;

use super::objects::{host_group, layer, layout, max_views, pipeline, sampler, view, views_of};
use super::{ByHand, Counts, Fill, Pass, What};

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
                        LoadOperation::Clear(color) => wgpu::LoadOp::Clear(color.value.into()),
                        LoadOperation::Discard => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    };
                    (layer(texture(color.to.resource), 0), load, store(planned.store))
                })
                .collect();
            let attached = render.depth.as_ref().map(|depth| (depth, texture(depth.to.resource)));
            let depth_ops = attached.zip(planned.depth.as_ref()).map(|((depth, _), planned)| {
                let load = match depth.load {
                    LoadOperation::Load => wgpu::LoadOp::Load,
                    LoadOperation::Clear(depth) => wgpu::LoadOp::Clear(depth.value.into()),
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
}
