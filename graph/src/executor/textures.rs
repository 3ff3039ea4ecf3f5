//! Textures, buffers, views and samplers of a plan.
//!
//! What the plan owns is created once. The host's own textures change from frame to frame (a swap chain has two or
//! three): their views are cached by texture, the oldest is dropped beyond sixteen.

use std::collections::HashMap;

use super::Statistics;
use crate::compiler::{Physical, Plan};
use crate::language::TextureShape;
use crate::pipeline::Pipeline;
use crate::work::{Address, Filter, ResourceHandle, Sampler, TextureView};

const MAXIMUM_IMPORT_VIEWS: usize = 16;

pub(super) struct Textures {
    textures: Vec<wgpu::Texture>,
    buffers: Vec<wgpu::Buffer>,
    views: HashMap<TextureView, wgpu::TextureView>,
    /// Views of imported textures, with the texture that they are of.
    import_views: Vec<(TextureView, wgpu::Texture, wgpu::TextureView)>,
    samplers: HashMap<Sampler, wgpu::Sampler>,
    imports: HashMap<ResourceHandle, wgpu::Texture>,
    /// Counts up whenever an imported texture is another than in the record before.
    pub(super) generation: u64,
}

impl Textures {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, statistics: &mut Statistics) -> Self {
        let textures: Vec<wgpu::Texture> = plan
            .textures
            .iter()
            .map(|texture| {
                device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&texture.label),
                    size: wgpu::Extent3d {
                        width: texture.size.width,
                        height: texture.size.height,
                        depth_or_array_layers: texture.size.layers,
                    },
                    mip_level_count: texture.size.mips,
                    sample_count: texture.size.samples,
                    dimension: if texture.volume { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
                    format: texture.format,
                    usage: texture.usages,
                    view_formats: &[],
                })
            })
            .collect();
        let buffers: Vec<wgpu::Buffer> = plan
            .buffers
            .iter()
            .map(|buffer| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(&buffer.label),
                    size: buffer.bytes,
                    usage: buffer.usages,
                    mapped_at_creation: false,
                })
            })
            .collect();
        statistics.textures += textures.len() as u64;
        statistics.buffers += buffers.len() as u64;
        Self {
            textures,
            buffers,
            views: HashMap::new(),
            import_views: Vec::new(),
            samplers: HashMap::new(),
            imports: HashMap::new(),
            generation: 0,
        }
    }

    pub(super) fn get(&self, index: usize) -> Option<&wgpu::Texture> {
        self.textures.get(index)
    }

    /// Takes over the host's textures of one record.
    pub(super) fn set_imports(&mut self, plan: &Plan, imports: &[(&str, &wgpu::Texture)]) {
        for (name, texture) in imports {
            let Some(resource) = plan.resources.get(*name) else { continue };
            let known = self.imports.get(&resource.handle);
            if known != Some(*texture) {
                self.imports.insert(resource.handle, (*texture).clone());
                self.generation += 1;
            }
        }
    }

    /// The texture of a resource.
    pub(super) fn texture(&self, plan: &Plan, resource: ResourceHandle) -> Option<&wgpu::Texture> {
        match plan.resource(resource)?.physical {
            Physical::Texture(index) => self.textures.get(index),
            Physical::Imported => self.imports.get(&resource),
            _ => None,
        }
    }

    /// The buffer of a resource.
    pub(super) fn buffer(&self, plan: &Plan, resource: ResourceHandle) -> Option<&wgpu::Buffer> {
        match plan.resource(resource)?.physical {
            Physical::Buffer(index) => self.buffers.get(index),
            _ => None,
        }
    }

    /// A view, created at its first use.
    pub(super) fn view(&mut self, plan: &Plan, view: TextureView, statistics: &mut Statistics) -> Option<wgpu::TextureView> {
        let texture = self.texture(plan, view.resource)?.clone();
        if self.imports.contains_key(&view.resource) {
            let known = self.import_views.iter().find(|(key, of, _)| *key == view && *of == texture);
            if let Some((_, _, known)) = known {
                return Some(known.clone());
            }
            if self.import_views.len() >= MAXIMUM_IMPORT_VIEWS {
                self.import_views.remove(0);
            }
            let created = create_view(&plan.pipeline, &texture, view);
            statistics.import_views += 1;
            self.import_views.push((view, texture, created.clone()));
            return Some(created);
        }
        Some(self.views.entry(view).or_insert_with(|| create_view(&plan.pipeline, &texture, view)).clone())
    }

    /// A sampler, created at its first use.
    pub(super) fn sampler(&mut self, device: &wgpu::Device, sampler: Sampler) -> wgpu::Sampler {
        self.samplers.entry(sampler).or_insert_with(|| create_sampler(device, sampler)).clone()
    }
}

fn create_view(pipeline: &Pipeline, texture: &wgpu::Texture, view: TextureView) -> wgpu::TextureView {
    let dimension = match view.shape {
        TextureShape::D2 => wgpu::TextureViewDimension::D2,
        TextureShape::D2Array => wgpu::TextureViewDimension::D2Array,
        TextureShape::Cube => wgpu::TextureViewDimension::Cube,
        TextureShape::CubeArray => wgpu::TextureViewDimension::CubeArray,
        TextureShape::D3 => wgpu::TextureViewDimension::D3,
    };
    let single = matches!(view.shape, TextureShape::D2);
    let depth = view.depth_only && texture.format().has_depth_aspect() && texture.format().has_stencil_aspect();
    texture.create_view(&wgpu::TextureViewDescriptor {
        label: Some(&pipeline.resource(view.resource).name),
        dimension: Some(dimension),
        aspect: if depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All },
        base_mip_level: view.mip.unwrap_or(0),
        mip_level_count: view.mip.map(|_| 1),
        base_array_layer: view.layer.unwrap_or(0),
        array_layer_count: (view.layer.is_some() || single).then_some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

fn create_sampler(device: &wgpu::Device, sampler: Sampler) -> wgpu::Sampler {
    let address = match sampler.address {
        Address::ClampToEdge => wgpu::AddressMode::ClampToEdge,
        Address::Repeat => wgpu::AddressMode::Repeat,
        Address::MirrorRepeat => wgpu::AddressMode::MirrorRepeat,
    };
    let (filter, mipmap_filter) = match sampler.filter {
        Filter::Nearest => (wgpu::FilterMode::Nearest, wgpu::MipmapFilterMode::Nearest),
        Filter::Linear => (wgpu::FilterMode::Linear, wgpu::MipmapFilterMode::Linear),
    };
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: None,
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter,
        compare: sampler.compare.map(Into::into),
        ..wgpu::SamplerDescriptor::default()
    })
}
