//! The attachments of a pass, and render passes into them.
//!
//! A pass whose attachments have one layer each (a fixed one, or the only one of its texture) takes one render pass.
//! Neighbours that the plan groups share one: it loads as the first pass declares and stores as the last.
//!
//! Any other pass takes one render pass for each run of views that draw into the same layer. The first access of a
//! layer loads it as the pass declares (clear, discard), later ones load its contents. Each attachment tracks that
//! itself, since one may have layers and another a fixed one. A layer that no view draws into is cleared unless the
//! pass loads, so that a frame without a light has empty maps and not the maps of the frame before.
//!
//! Discarding on load is recorded as clearing to zero: that is cheap on tiling GPUs and leaves nothing undefined.

use wgpu::RenderPassDepthStencilAttachment as DepthStencil;
use wgpu_profiler::GpuProfilerQuery;

use super::redraw::Texels;
use crate::memory::resources::{Resources, Viewed};
use crate::objects::creation::Creation;
use umbragraph_compiler::{Plan, PlannedPass, StoreOperation};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::language::TextureShape;
use umbragraph_pipeline::pipeline::{Aspect, IndexRange};
use umbragraph_pipeline::work::{
    AttachmentTarget, Byte, Color, Depth, Live, LiveValue, LoadOperation, RenderWork, TextureView,
};

/// The maximum number of color attachments of a render pass.
pub(crate) const MAX_COLORS: usize = 8;

/// The attachments of one pass, or of several passes that share one render pass.
pub(crate) struct Attachments {
    color: Vec<Attachment<Color>>,
    depth: Option<Attachment<Depth>>,
    /// Whether depth is read-only; a shader of the same pass may then sample it.
    depth_read_only: bool,
    /// The stencil attachment. If depth is attached too, both have views of the same texture.
    stencil: Option<Attachment<Byte>>,
    /// Whether stencil is read-only.
    stencil_read_only: bool,
    /// Width and height in texels.
    pub(crate) extent: [u32; 2],
}

struct Attachment<T> {
    /// A view of each layer that can be drawn into; a single view if the layer is fixed or the only one.
    layers: Vec<Viewed>,
    /// The multisample resolve target. A multisampled texture has one layer.
    resolve: Option<Viewed>,
    load: LoadOperation<Live<T>>,
    store: wgpu::StoreOp,
}

impl<T: LiveValue> Attachment<T> {
    /// Returns the index in `layers` of the layer of a view.
    fn position(&self, layer: u32) -> usize {
        if self.layers.len() > 1 { layer as usize } else { 0 }
    }

    /// Returns the load and store operations. `Discard` clears to zero, since undefined contents are unsafe.
    fn operations<V: From<T> + Default>(&self, is_first: bool) -> wgpu::Operations<V> {
        let load = match self.load {
            LoadOperation::Clear(clear) if is_first => wgpu::LoadOp::Clear(clear.value.into()),
            LoadOperation::Discard if is_first => wgpu::LoadOp::Clear(V::default()),
            _ => wgpu::LoadOp::Load,
        };
        wgpu::Operations { load, store: self.store }
    }

    /// Updates the clear value from the live values of the frame.
    fn update(&mut self, values: &[Value]) {
        if let LoadOperation::Clear(clear) = &mut self.load {
            clear.update(values);
        }
    }

    /// Returns the view and operations that clear one layer; `None` if the attachment loads its contents.
    fn cleared<'a, V: From<T> + Default>(
        &'a self,
        position: usize,
        resources: &'a Resources,
    ) -> Option<(&'a wgpu::TextureView, wgpu::Operations<V>)> {
        let begins_cleared = !matches!(self.load, LoadOperation::Load);
        let view = self.layers.get(position).filter(|_| begins_cleared)?.get(resources)?;
        Some((view, self.operations(true)))
    }
}

impl Attachment<Color> {
    fn of_color<'a>(
        &'a self,
        view: &'a wgpu::TextureView,
        resources: &'a Resources,
        ops: wgpu::Operations<wgpu::Color>,
    ) -> wgpu::RenderPassColorAttachment<'a> {
        let resolve_target = self.resolve.as_ref().and_then(|to| to.get(resources));
        wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops }
    }
}

/// Flags for the layers that a pass has drawn into so far.
#[derive(Default)]
pub(crate) struct Drawn(Vec<bool>);

impl Attachments {
    /// Creates the attachments of a planned pass; `None` if one of the resources cannot be attached.
    pub(crate) fn new(
        creation: &mut Creation<'_>,
        resources: &mut Resources,
        plan: &Plan,
        planned: &PlannedPass,
        render: &RenderWork,
    ) -> Option<Self> {
        let mut extent = None;
        let mut view_layers = |resources: &mut Resources,
                               target: AttachmentTarget,
                               format: Option<wgpu::TextureFormat>|
         -> Option<Vec<Viewed>> {
            let size = plan.resource(target.resource)?.size?;
            let side = |length: u32| length.checked_shr(target.mip).unwrap_or(0).max(1);
            extent.get_or_insert([side(size.width), side(size.height)]);
            let all = target.layer.map_or(0..size.layers, |layer| layer..layer.saturating_add(1));
            let view = |layer| {
                let shape = TextureShape::D2;
                let (resource, mip, layer) =
                    (target.resource, Some(IndexRange::one(target.mip)), Some(IndexRange::one(layer)));
                let view = TextureView { resource, shape, mip, layer, aspect: Aspect::All, format };
                resources.view(creation, plan, view)
            };
            all.map(view).collect()
        };
        let mut color = Vec::with_capacity(render.color.len());
        for (attachment, planned) in render.color.iter().zip(&planned.color) {
            let layers = view_layers(resources, attachment.to.target(), attachment.format)?;
            let resolve = match &attachment.resolve {
                Some(to) => view_layers(resources, to.target(), attachment.format)?.into_iter().next(),
                None => None,
            };
            color.push(Attachment { layers, resolve, load: attachment.load, store: store(planned.store) });
        }
        let depth = match render.depth.as_ref().zip(planned.depth.as_ref()) {
            None => None,
            Some((attachment, planned)) => {
                let (load, store) = (attachment.load, store(planned.store));
                let layers = view_layers(resources, attachment.to.target(), None)?;
                Some(Attachment { layers, resolve: None, load, store })
            }
        };
        let stencil = match render.stencil.as_ref().zip(planned.stencil.as_ref()) {
            None => None,
            Some((attachment, planned)) => {
                let (load, store) = (attachment.load, store(planned.store));
                let layers = view_layers(resources, attachment.to.target(), None)?;
                Some(Attachment { layers, resolve: None, load, store })
            }
        };
        let is_read_only = |depth: &umbragraph_pipeline::work::DepthAttachment| {
            !depth.write && depth.load == LoadOperation::Load
        };
        let depth_read_only = render.depth.as_ref().is_some_and(is_read_only);
        let stencil_read_only = render.stencil.as_ref().is_some_and(|stencil| !stencil.usage().writes());
        Some(Self { color, depth, depth_read_only, stencil, stencil_read_only, extent: extent? })
    }

    /// Updates the clear values from the live values of the frame.
    pub(crate) fn update(&mut self, values: &[Value]) {
        self.color.iter_mut().for_each(|color| color.update(values));
        self.depth.iter_mut().for_each(|depth| depth.update(values));
        self.stencil.iter_mut().for_each(|stencil| stencil.update(values));
    }

    /// Returns `true` if every attachment has one layer, so that one render pass suffices.
    pub(crate) fn is_flat(&self) -> bool {
        self.layer_count() <= 1
    }

    /// The highest layer count of the attachments.
    pub(crate) fn layer_count(&self) -> usize {
        self.layer_counts().max().unwrap_or(0)
    }

    /// The number of layers that a view can select; `None` if the attachments ignore the view's layer.
    pub(crate) fn view_layers(&self) -> Option<usize> {
        self.layer_counts().filter(|count| *count > 1).min()
    }

    fn layer_counts(&self) -> impl Iterator<Item = usize> {
        let depth = self.depth.as_ref().map(|depth| depth.layers.len());
        let stencil = self.stencil.as_ref().map(|stencil| stencil.layers.len());
        self.color.iter().map(|color| color.layers.len()).chain(depth).chain(stencil)
    }

    /// Adopts the store operations of a later pass that is recorded into the same render pass. Depth and stencil stay
    /// read-only only if they are in both.
    pub(crate) fn end_like(&mut self, last: &Self) {
        for (color, last) in self.color.iter_mut().zip(&last.color) {
            color.store = last.store;
        }
        if let (Some(depth), Some(last)) = (&mut self.depth, &last.depth) {
            depth.store = last.store;
        }
        if let (Some(stencil), Some(last)) = (&mut self.stencil, &last.stencil) {
            stencil.store = last.store;
        }
        self.depth_read_only &= last.depth_read_only;
        self.stencil_read_only &= last.stencil_read_only;
    }

    /// Begins a render pass into a layer. `drawn` holds the layers that this pass drew into before, and is updated.
    pub(crate) fn begin(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        label: &str,
        query: Option<&GpuProfilerQuery>,
        layer: u32,
        drawn: &mut Drawn,
    ) -> Option<wgpu::RenderPass<'static>> {
        let count = self.layer_count();
        let mut colors: [Option<wgpu::RenderPassColorAttachment<'_>>; MAX_COLORS] =
            [const { None }; MAX_COLORS];
        for (at, (color, slot)) in self.color.iter().zip(&mut colors).enumerate() {
            let position = color.position(layer);
            let ops = color.operations(drawn.is_first(at * count + position));
            let view = color.layers.get(position)?.get(resources)?;
            *slot = Some(color.of_color(view, resources, ops));
        }
        let mut view = None;
        let mut depth_ops = None;
        if let Some(depth) = &self.depth {
            let position = depth.position(layer);
            let ops = depth.operations(drawn.is_first(self.color.len() * count + position));
            view = Some(depth.layers.get(position)?.get(resources)?);
            depth_ops = (!self.depth_read_only).then_some(ops);
        }
        let mut stencil_ops = None;
        if let Some(stencil) = &self.stencil {
            let position = stencil.position(layer);
            let ops = stencil.operations(drawn.is_first((self.color.len() + 1) * count + position));
            view = Some(stencil.layers.get(position)?.get(resources)?);
            stencil_ops = (!self.stencil_read_only).then_some(ops);
        }
        // An aspect without operations is read-only.
        let depth = view.map(|view| DepthStencil { view, depth_ops, stencil_ops });
        let timestamps = query.and_then(GpuProfilerQuery::render_pass_timestamp_writes);
        let colors = &colors[..self.color.len().min(MAX_COLORS)];
        Some(begin(encoder, label, timestamps, colors, depth))
    }

    /// Begins a render pass into a layer of the depth attachment only, and either clears or loads the depth.
    pub(crate) fn begin_depth(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        label: &str,
        query: Option<&GpuProfilerQuery>,
        layer: u32,
        load: wgpu::LoadOp<f32>,
    ) -> Option<wgpu::RenderPass<'static>> {
        let depth = self.depth.as_ref()?;
        let view = depth.layers.get(depth.position(layer))?.get(resources)?;
        let operations = wgpu::Operations { load, store: depth.store };
        let timestamps = query.and_then(GpuProfilerQuery::render_pass_timestamp_writes);
        let depth = DepthStencil { view, depth_ops: Some(operations), stencil_ops: None };
        Some(begin(encoder, label, timestamps, &[], Some(depth)))
    }

    /// The texels that a view draws into: the index of its layer in the depth attachment, and its viewport.
    pub(crate) fn texels(&self, view: &View) -> Texels {
        let layer = self.depth.as_ref().map_or(0, |depth| depth.position(view.layer));
        (layer, view.viewport.unwrap_or([0, 0, self.extent[0], self.extent[1]]))
    }

    /// Clears the layers that no view drew into, unless the pass loads its attachments.
    pub(crate) fn clear_rest(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        label: &str,
        drawn: &Drawn,
    ) {
        let count = self.layer_count();
        for position in 0..count {
            let mut colors: [Option<wgpu::RenderPassColorAttachment<'_>>; MAX_COLORS] =
                [const { None }; MAX_COLORS];
            for (at, (color, slot)) in self.color.iter().zip(&mut colors).enumerate() {
                if !drawn.contains(at * count + position)
                    && let Some((view, ops)) = color.cleared(position, resources)
                {
                    *slot = Some(color.of_color(view, resources, ops));
                }
            }
            let is_left = |aspect: usize| !drawn.contains((self.color.len() + aspect) * count + position);
            let depth = self.depth.as_ref().filter(|_| is_left(0));
            let depth = depth.and_then(|depth| depth.cleared(position, resources)).unzip();
            let stencil = self.stencil.as_ref().filter(|_| is_left(1));
            let stencil = stencil.and_then(|stencil| stencil.cleared(position, resources)).unzip();
            let (depth_ops, stencil_ops) = (depth.1, stencil.1);
            let view = depth.0.or(stencil.0);
            let depth = view.map(|view| DepthStencil { view, depth_ops, stencil_ops });
            if depth.is_some() || colors.iter().any(Option::is_some) {
                drop(begin(encoder, label, None, &colors[..self.color.len().min(MAX_COLORS)], depth));
            }
        }
    }
}

impl Drawn {
    /// Resets all flags, for the attachments of a pass.
    pub(crate) fn reset(&mut self, attachments: &Attachments) {
        let count = (attachments.color.len() + 2) * attachments.layer_count();
        self.0.clear();
        self.0.resize(count, false);
    }

    /// Sets the flag at an index. Returns `true` if the flag was not set before.
    fn is_first(&mut self, at: usize) -> bool {
        self.0.get_mut(at).is_some_and(|drawn| !std::mem::replace(drawn, true))
    }

    fn contains(&self, at: usize) -> bool {
        self.0.get(at).copied().unwrap_or(false)
    }
}

fn store(operation: StoreOperation) -> wgpu::StoreOp {
    match operation {
        StoreOperation::Store => wgpu::StoreOp::Store,
        StoreOperation::Discard => wgpu::StoreOp::Discard,
    }
}

fn begin(
    encoder: &mut wgpu::CommandEncoder,
    label: &str,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    color_attachments: &[Option<wgpu::RenderPassColorAttachment<'_>>],
    depth_stencil_attachment: Option<DepthStencil<'_>>,
) -> wgpu::RenderPass<'static> {
    let descriptor = wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments,
        depth_stencil_attachment,
        timestamp_writes,
        ..wgpu::RenderPassDescriptor::default()
    };
    encoder.begin_render_pass(&descriptor).forget_lifetime()
}
