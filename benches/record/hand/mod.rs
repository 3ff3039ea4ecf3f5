//! The frame recorded by hand: textures, pipelines and bind groups of a plan are made once, and each frame issues the
//! calls of wgpu that draw it.
//!
//! Limits: passes that draw the host's meshes or cover their attachments, uniform and storage blocks, no toggles, no
//! histories, no resources that share memory: what `awsm` has without options.

mod made;
mod objects;

use umbragraph::data::{BlackboardData, View};
use umbragraph::draw::{DrawPass, DrawSource, PropertySet};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::compiler::CpuPasses;
use umbragraph::work::{BlockLayout, DrawOrder};

pub(crate) struct ByHand {
    queue: wgpu::Queue,
    cpu: CpuPasses,
    passes: Vec<Pass>,
    blocks: wgpu::Buffer,
    staging: Vec<u8>,
    fills: Vec<Fill>,
    /// Byte offset, size in bytes, byte stride between views, and the views' name, for each block.
    places: Vec<(usize, usize, usize, Option<String>)>,
    view: BlackboardData,
    pub(crate) counts: Counts,
}

/// The number of wgpu calls in a frame, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Counts {
    pub(crate) passes: u64,
    pub(crate) draws: u64,
    pub(crate) pipelines: u64,
    pub(crate) groups: u64,
}

/// A uniform block that is filled with data in each frame.
struct Fill {
    layout: BlockLayout,
    data: String,
    offset: usize,
    size: usize,
    /// The byte stride between views; `None` for a block that does not depend on the view.
    stride: Option<usize>,
}

struct Pass {
    name: String,
    /// Set if the pass continues the render pass of the previous one.
    joins: bool,
    color: Vec<(wgpu::TextureView, wgpu::LoadOp<wgpu::Color>, wgpu::StoreOp)>,
    /// A depth view for each layer.
    depth: Vec<wgpu::TextureView>,
    depth_ops: (wgpu::LoadOp<f32>, wgpu::StoreOp),
    extent: [u32; 2],
    /// The index, the bind group, and the byte stride between views (`None` without a dynamic offset).
    groups: Vec<(u32, wgpu::BindGroup, Option<u32>)>,
    what: What,
}

enum What {
    Cover(wgpu::RenderPipeline),
    Meshes {
        views: String,
        filter: String,
        order: DrawOrder,
        pipelines: Vec<(PropertySet, wgpu::RenderPipeline)>,
        materials: Vec<wgpu::BindGroup>,
        object: Option<wgpu::BindGroup>,
    },
}

impl ByHand {
    /// Records a frame into a command encoder.
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
    order: DrawOrder,
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
    fn order(&self) -> DrawOrder {
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
