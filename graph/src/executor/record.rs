//! Recording a frame: the plan's passes, one after the other, into the host's encoder.
//!
//! A pass that draws views takes one render pass for each run of views that draw into the same layer; the first run of
//! a layer loads it as the plan says (clear, discard), later ones keep what is there. Layers that no view draws into
//! are cleared all the same, so that a frame without a light has empty maps and not those of the frame before.

use super::pipelines::RealizedPass;
use super::scene::ScenePass;
use super::textures::Textures;
use super::{Executor, Frame, Statistics, uniforms};
use crate::compiler::{Plan, StoreOperation};
use crate::data::{HostData, View};
use crate::language::TextureShape;
use crate::work::{AttachmentTarget, CopyWork, Draw, LoadOperation, RenderWork, SceneDraw, TextureView, Work};

/// Records all passes.
pub(super) fn record(executor: &mut Executor, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) {
    let plan = executor.plan.clone();
    let pool = executor.uniforms.take(&executor.device, encoder, &mut executor.statistics);
    if let Some((_, buffer)) = &pool {
        executor.uniforms.upload(&executor.queue, buffer, &plan, &executor.data);
    }
    let pool_index = pool.as_ref().map_or(0, |(index, _)| *index);
    let mut offsets = Vec::new();
    for (at, planned) in plan.passes.iter().enumerate() {
        let pass = plan.pipeline.pass(planned.handle);
        let slots = uniforms::slots(&pass.work);
        let places = executor.uniforms.places(at);
        let (textures, statistics) = (&mut executor.textures, &mut executor.statistics);
        match &mut executor.passes[at] {
            RealizedPass::Host => {}
            RealizedPass::Copy => {
                if let Work::Copy(copy) = &pass.work {
                    record_copy(encoder, &plan, textures, copy);
                }
            }
            RealizedPass::Compute { pipeline, groups } => {
                groups.prepare(&executor.device, &plan, &pass.name, slots, places, pool.as_ref(), textures, statistics);
                let [x, y, z] = planned.workgroups.unwrap_or([0; 3]);
                let descriptor = wgpu::ComputePassDescriptor { label: Some(&pass.name), timestamp_writes: None };
                let mut compute = encoder.begin_compute_pass(&descriptor);
                compute.set_pipeline(pipeline);
                for (index, group, _) in groups.made(pool_index) {
                    compute.set_bind_group(index, group, &[]);
                }
                compute.dispatch_workgroups(x, y, z);
            }
            RealizedPass::Fullscreen { pipeline, groups } => {
                let Work::Render(render) = &pass.work else { continue };
                groups.prepare(&executor.device, &plan, &pass.name, slots, places, pool.as_ref(), textures, statistics);
                let mut attachments = Attachments::new(&plan, at, render, textures, statistics);
                let Some(mut pass) = attachments.begin(encoder, &pass.name, 0, true) else { continue };
                pass.set_pipeline(pipeline);
                for (index, group, _) in groups.made(pool_index) {
                    pass.set_bind_group(index, group, &[]);
                }
                pass.draw(0..3, 0..1);
            }
            RealizedPass::Scene { pipelines, groups, host } => {
                let Work::Render(render) = &pass.work else { continue };
                let Draw::Scene(scene) = &render.draw else { continue };
                let Some(source) = frame.draws else { continue };
                groups.prepare(&executor.device, &plan, &pass.name, slots, places, pool.as_ref(), textures, statistics);
                host.prepare(&executor.device, &pass.name, source, statistics);
                let views = views_of(&executor.data, scene);
                let mut attachments = Attachments::new(&plan, at, render, textures, statistics);
                let mut drawn = 0;
                let mut seen: u128 = 0;
                let layered = attachments.is_layered();
                let layer_of = |view: &View| if layered { view.layer } else { 0 };
                let whole = attachments.extent();
                while drawn < views.len() {
                    let layer = layer_of(&views[drawn]);
                    let run = views[drawn..].iter().take_while(|view| layer_of(view) == layer).count();
                    let mixed = views[drawn..drawn + run].iter().any(|view| view.viewport.is_some());
                    let bit = 1u128.checked_shl(layer).unwrap_or(0);
                    let is_first = seen & bit == 0;
                    seen |= bit;
                    let Some(render_pass) = attachments.begin(encoder, &pass.name, layer, is_first) else { break };
                    let mut render_pass = render_pass.forget_lifetime();
                    for (offset, view) in views[drawn..drawn + run].iter().enumerate() {
                        if let Some([x, y, width, height]) = view.viewport.or(whole.filter(|_| mixed)) {
                            render_pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
                            render_pass.set_scissor_rect(x, y, width, height);
                        }
                        for (index, group, view_slot) in groups.made(pool_index) {
                            match view_slot.and_then(|slot| executor.uniforms.places(at)[slot]) {
                                Some(place) => {
                                    let offset = executor.uniforms.view_offset(place, drawn + offset);
                                    render_pass.set_bind_group(index, group, &[offset]);
                                }
                                None => render_pass.set_bind_group(index, group, &[]),
                            }
                        }
                        source.draw(&mut ScenePass {
                            geometry: &scene.geometry,
                            filter: &scene.filter,
                            view,
                            order: scene.order,
                            pipelines,
                            groups: host,
                            pass: &mut render_pass,
                            offsets: &mut offsets,
                        });
                    }
                    drop(render_pass);
                    drawn += run;
                }
                attachments.clear_rest(encoder, &pass.name, seen);
            }
        }
    }
}

fn views_of<'a>(data: &'a [Option<HostData>], scene: &SceneDraw) -> &'a [View] {
    data.get(scene.views.index()).and_then(Option::as_ref).map(HostData::views).unwrap_or_default()
}

fn record_copy(encoder: &mut wgpu::CommandEncoder, plan: &Plan, textures: &Textures, copy: &CopyWork) {
    let end = |target: &AttachmentTarget| {
        let texture = textures.texture(plan, target.resource)?;
        Some(wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: target.mip,
            origin: wgpu::Origin3d { x: 0, y: 0, z: target.layer.unwrap_or(0) },
            aspect: wgpu::TextureAspect::All,
        })
    };
    let (Some(source), Some(destination)) = (end(&copy.source), end(&copy.destination)) else { return };
    let layers = if copy.source.layer.is_some() { 1 } else { source.texture.depth_or_array_layers() };
    let side = |length: u32| (length >> copy.source.mip).max(1);
    let extent = wgpu::Extent3d {
        width: side(source.texture.width()),
        height: side(source.texture.height()),
        depth_or_array_layers: layers,
    };
    encoder.copy_texture_to_texture(source, destination, extent);
}

/// The attachments of one pass, for each of its layers in turn.
struct Attachments<'a> {
    plan: &'a Plan,
    position: usize,
    render: &'a RenderWork,
    textures: &'a mut Textures,
    statistics: &'a mut Statistics,
}

impl<'a> Attachments<'a> {
    fn new(
        plan: &'a Plan,
        position: usize,
        render: &'a RenderWork,
        textures: &'a mut Textures,
        statistics: &'a mut Statistics,
    ) -> Self {
        Self { plan, position, render, textures, statistics }
    }

    /// Begins a render pass into a layer; `is_first` says that the layer holds what was there before the pass.
    fn begin<'e>(
        &mut self,
        encoder: &'e mut wgpu::CommandEncoder,
        name: &str,
        layer: u32,
        is_first: bool,
    ) -> Option<wgpu::RenderPass<'e>> {
        let planned = &self.plan.passes[self.position];
        let store = |operation: StoreOperation| match operation {
            StoreOperation::Store => wgpu::StoreOp::Store,
            StoreOperation::Discard => wgpu::StoreOp::Discard,
        };
        let mut color_views = Vec::with_capacity(self.render.color.len());
        for color in &self.render.color {
            color_views.push(self.view(color.target, layer)?);
        }
        let depth_view = match &self.render.depth {
            Some(depth) => Some(self.view(depth.target, layer)?),
            None => None,
        };
        let colors: Vec<Option<wgpu::RenderPassColorAttachment<'_>>> = self
            .render
            .color
            .iter()
            .zip(&color_views)
            .zip(&planned.color)
            .map(|((color, view), planned)| {
                let clear = |[r, g, b, a]: [f64; 4]| wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a });
                let load = match color.load {
                    _ if !is_first => wgpu::LoadOp::Load,
                    LoadOperation::Load => wgpu::LoadOp::Load,
                    LoadOperation::Clear(value) => clear(value),
                    LoadOperation::Discard => clear([0.0; 4]),
                };
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: store(planned.store) },
                })
            })
            .collect();
        let depth = self.render.depth.as_ref().zip(depth_view.as_ref()).zip(planned.depth.as_ref()).map(
            |((depth, view), planned)| {
                let load = match depth.load {
                    _ if !is_first => wgpu::LoadOp::Load,
                    LoadOperation::Load => wgpu::LoadOp::Load,
                    LoadOperation::Clear(value) => wgpu::LoadOp::Clear(value as f32),
                    LoadOperation::Discard => wgpu::LoadOp::Clear(0.0),
                };
                // Depth that is only tested against may be sampled by the same pass.
                let read_only = !depth.write && depth.load == LoadOperation::Load;
                let depth_ops = (!read_only).then_some(wgpu::Operations { load, store: store(planned.store) });
                wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
            },
        );
        Some(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(name),
            color_attachments: &colors,
            depth_stencil_attachment: depth,
            ..wgpu::RenderPassDescriptor::default()
        }))
    }

    /// Clears the layers of the attachments that no view drew into (`seen` has a bit for each that one did).
    fn clear_rest(&mut self, encoder: &mut wgpu::CommandEncoder, name: &str, seen: u128) {
        let targets: Vec<AttachmentTarget> = (self.render.color.iter().map(|color| color.target))
            .chain(self.render.depth.as_ref().map(|depth| depth.target))
            .collect();
        let layers = targets.iter().map(|target| self.layers(*target)).min().unwrap_or(0);
        for layer in 0..layers.min(128) {
            if seen & (1 << layer) == 0 {
                drop(self.begin(encoder, name, layer, true));
            }
        }
    }

    /// Whether the views draw into different layers.
    fn is_layered(&self) -> bool {
        let targets = self.render.color.iter().map(|color| color.target).chain(self.render.depth.as_ref().map(|depth| depth.target));
        targets.into_iter().any(|target| self.layers(target) > 1)
    }

    /// All texels of the attachments, as a viewport.
    fn extent(&self) -> Option<[u32; 4]> {
        let target = self.render.color.first().map(|color| color.target).or(self.render.depth.as_ref().map(|depth| depth.target))?;
        let texture = self.textures.texture(self.plan, target.resource)?;
        let side = |length: u32| (length >> target.mip).max(1);
        Some([0, 0, side(texture.width()), side(texture.height())])
    }

    /// How many layers the views of the pass can draw into.
    fn layers(&self, target: AttachmentTarget) -> u32 {
        let layers = self.textures.texture(self.plan, target.resource).map_or(0, wgpu::Texture::depth_or_array_layers);
        if target.layer.is_some() { layers.min(1) } else { layers }
    }

    fn view(&mut self, target: AttachmentTarget, view_layer: u32) -> Option<wgpu::TextureView> {
        let layers = self.textures.texture(self.plan, target.resource)?.depth_or_array_layers();
        let layer = target.layer.unwrap_or(if layers > 1 { view_layer } else { 0 });
        if layer >= layers {
            return None;
        }
        let view = TextureView {
            resource: target.resource,
            shape: TextureShape::D2,
            mip: Some(target.mip),
            layer: Some(layer),
            depth_only: false,
        };
        self.textures.view(self.plan, view, self.statistics)
    }
}
