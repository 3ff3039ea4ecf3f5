//! The textures and buffers that a plan creates, and views of them.
//!
//! They are created when the plan is instantiated, or reused from the previous plan if they do not change (see
//! [`super::reuse`]). A view is created with the first pass that needs it; passes with equal views of a texture share
//! one, under any name.

use std::collections::{BTreeMap, HashMap};

use super::reuse::{Piece, reuse};
use crate::objects::creation::Creation;
use umbragraph_compiler::{Physical, PhysicalTexture, Plan, PlannedResource};
use umbragraph_pipeline::language::{Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::{Aspect, History, IndexRange, Resource};
use umbragraph_pipeline::work::TextureView;

/// The textures and buffers that one plan creates, and views of these textures.
pub(crate) struct Textures {
    textures: Vec<wgpu::Texture>,
    buffers: Vec<wgpu::Buffer>,
    views: HashMap<ViewKey, wgpu::TextureView>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct ViewKey {
    texture: usize,
    shape: TextureShape,
    mip: Option<IndexRange<u32>>,
    layer: Option<IndexRange<u32>>,
    aspect: Aspect,
    format: Option<wgpu::TextureFormat>,
}

type TextureKey = (wgpu::TextureFormat, Option<wgpu::TextureFormat>, [u32; 5], bool, wgpu::TextureUsages);
type BufferKey = (u64, wgpu::BufferUsages);

impl Textures {
    /// Creates the textures and buffers of a plan, except those that it reuses from the plan `before`.
    pub(crate) fn new(creation: &mut Creation<'_>, plan: &Plan, before: Option<(&Plan, &Self)>) -> Self {
        let none = (Vec::new(), Vec::new());
        let (old_textures, old_buffers) =
            before.map_or(none, |(plan, _)| (texture_pieces(plan), buffer_pieces(plan)));
        let textures = reuse(&old_textures, &texture_pieces(plan));
        let textures = plan.textures.iter().zip(textures).enumerate().map(|(at, (texture, old))| {
            let old = old.zip(before).and_then(|(at, (_, before))| before.textures.get(at));
            old.cloned().unwrap_or_else(|| {
                let at = Physical::Texture(at);
                creation.of_resource(declared(plan, at), |creation| create_texture(creation, texture))
            })
        });
        let textures = textures.collect();
        let buffers = reuse(&old_buffers, &buffer_pieces(plan));
        let buffers = plan.buffers.iter().zip(buffers).enumerate().map(|(at, (buffer, old))| {
            let old = old.zip(before).and_then(|(at, (_, before))| before.buffers.get(at));
            old.cloned().unwrap_or_else(|| {
                let descriptor = wgpu::BufferDescriptor {
                    label: Some(&buffer.label),
                    size: buffer.bytes,
                    usage: buffer.usages,
                    mapped_at_creation: false,
                };
                let resource = declared(plan, Physical::Buffer(at));
                creation.of_resource(resource, |creation| creation.buffer(&descriptor))
            })
        });
        let buffers = buffers.collect();
        Self { textures, buffers, views: HashMap::new() }
    }

    /// Returns `true` if the object at `place` is the same as the object at `old` of the previous plan.
    pub(crate) fn is_same(&self, place: Physical, before: &Self, old: Physical) -> bool {
        match (place, old) {
            (Physical::Texture(at), Physical::Texture(old)) => {
                self.texture(at).is_some() && self.texture(at) == before.texture(old)
            }
            (Physical::Buffer(at), Physical::Buffer(old)) => {
                self.buffer(at).is_some() && self.buffer(at) == before.buffer(old)
            }
            _ => false,
        }
    }

    /// A texture by its position in the plan.
    pub(crate) fn texture(&self, index: usize) -> Option<&wgpu::Texture> {
        self.textures.get(index)
    }

    /// A buffer by its position in the plan.
    pub(crate) fn buffer(&self, index: usize) -> Option<&wgpu::Buffer> {
        self.buffers.get(index)
    }

    /// A view of the texture at a position in the plan, created at its first access.
    pub(crate) fn view(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        index: usize,
        view: TextureView,
    ) -> Option<wgpu::TextureView> {
        let texture = self.textures.get(index)?;
        let TextureView { shape, mip, layer, aspect, format, .. } = view;
        let key = ViewKey { texture: index, shape, mip, layer, aspect, format };
        let view = self
            .views
            .entry(key)
            .or_insert_with(|| creation.view(texture, &view_descriptor(label, texture, view)));
        Some(view.clone())
    }
}

/// Returns the declaration of the first resource that is stored in a physical texture or buffer.
fn declared(plan: &Plan, physical: Physical) -> Option<&Resource> {
    let mut resources = plan.resources.values();
    let resource = resources.find(|resource| resource.physical == physical)?;
    Some(plan.pipeline.resource(resource.handle))
}

/// Returns the wgpu descriptor of a view of a texture.
pub(crate) fn view_descriptor<'a>(
    label: &'a str,
    texture: &wgpu::Texture,
    view: TextureView,
) -> wgpu::TextureViewDescriptor<'a> {
    let format = texture.format();
    let both = format.has_depth_aspect() && format.has_stencil_aspect();
    let layers = view.layer.map(|run| run.count).or((view.shape == TextureShape::D2).then_some(1));
    // A view has the usages of its texture if it does not say others, and no storage texture is of an sRGB format.
    let is_srgb = view.format.is_some_and(|format| format.is_srgb());
    let usage = is_srgb.then_some(texture.usage() - wgpu::TextureUsages::STORAGE_BINDING);
    wgpu::TextureViewDescriptor {
        label: Some(label),
        dimension: Some(view.shape.into()),
        format: view.format,
        usage,
        aspect: if both { view.aspect } else { Aspect::All }.into(),
        base_mip_level: view.mip.map_or(0, |run| run.first),
        mip_level_count: view.mip.map(|run| run.count),
        base_array_layer: view.layer.map_or(0, |run| run.first),
        array_layer_count: layers,
    }
}

fn create_texture(creation: &mut Creation<'_>, texture: &PhysicalTexture) -> wgpu::Texture {
    let descriptor = wgpu::TextureDescriptor {
        label: Some(&texture.label),
        size: wgpu::Extent3d {
            width: texture.size.width,
            height: texture.size.height,
            depth_or_array_layers: texture.size.layers + u32::from(texture.spare_layer),
        },
        mip_level_count: texture.size.mips,
        sample_count: texture.size.samples,
        dimension: if texture.volume { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
        format: texture.format,
        usage: texture.usages,
        view_formats: texture.view_format.as_slice(),
    };
    creation.texture(&descriptor, texture.bytes)
}

fn texture_pieces(plan: &Plan) -> Vec<Piece<'_, TextureKey>> {
    let keepers = keepers(plan);
    let pieces = plan.textures.iter().enumerate().map(|(at, texture)| {
        let size = texture.size;
        let layers = size.layers + u32::from(texture.spare_layer);
        let size = [size.width, size.height, layers, size.mips, size.samples];
        let descriptor = (texture.format, texture.view_format, size, texture.volume, texture.usages);
        Piece { descriptor, keeps: keepers.get(&Physical::Texture(at)).copied(), label: &texture.label }
    });
    pieces.collect()
}

fn buffer_pieces(plan: &Plan) -> Vec<Piece<'_, BufferKey>> {
    let keepers = keepers(plan);
    let pieces = plan.buffers.iter().enumerate().map(|(at, buffer)| Piece {
        descriptor: (buffer.bytes, buffer.usages),
        keeps: keepers.get(&Physical::Buffer(at)).copied(),
        label: &buffer.label,
    });
    pieces.collect()
}

/// Returns the name of the resource that outlives frames in each physical texture or buffer, including the frames of
/// histories.
fn keepers(plan: &Plan) -> BTreeMap<Physical, &str> {
    let outlives = |resource: &PlannedResource| resource.lifetime != Lifetime::Transient;
    let kept = plan.resources.iter().filter(|(_, resource)| outlives(resource));
    let kept = kept.map(|(name, resource)| (resource.physical, name.as_str()));
    // The frames of a history each go on under their own names, also those that no pass reads.
    let frames = plan.histories.values().flat_map(|history| {
        let members = plan.pipeline.resource(history.handle).history.into_iter().flat_map(History::members);
        let names = members.map(|member| plan.pipeline.resource(member).name.as_str());
        history.places.iter().copied().zip(names)
    });
    kept.chain(frames).collect()
}
