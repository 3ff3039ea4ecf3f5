//! Materials, textures and samplers of a scene on the device.
//!
//! Every material has the same bindings; a texture that it lacks is white. Images beyond what the device allows begin
//! with the first mip level that fits.

use std::collections::HashMap;
use std::num::NonZeroU64;
use umbragraph_executor::wgpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::interface::{BLOCK_STRIDE, MaterialBlock};
use crate::material::{AlphaMode, Material};
use crate::mipmap;
use crate::scene::Scene;
use crate::texture::{Image, Sampler};

/// The maximum anisotropy of material samplers, for textures at grazing angles.
const ANISOTROPY: u16 = 8;

/// The textures of a material, by the beginning of the names of their bindings.
const MAPS: [&str; 2] = ["base_color", "emissive"];

pub(super) struct Materials {
    blocks: wgpu::Buffer,
    /// For each material, the indices of the image and the sampler of each of [`MAPS`].
    textures: Vec<[(usize, usize); MAPS.len()]>,
    /// The images, and a white texel last.
    images: Vec<wgpu::TextureView>,
    samplers: Vec<wgpu::Sampler>,
}

impl Materials {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Self {
        let mut images: Vec<wgpu::TextureView> =
            scene.images.iter().map(|image| upload(device, queue, image)).collect();
        let white = Image { name: "white".to_owned(), width: 1, height: 1, rgba: vec![255; 4] };
        images.push(upload(device, queue, &white));
        let (mut samplers, mut known) = (Vec::new(), HashMap::new());
        let mut sampler_of = |sampler: Sampler| {
            *known.entry(sampler).or_insert_with(|| {
                samplers.push(device.create_sampler(&descriptor(sampler)));
                samplers.len() - 1
            })
        };
        let mut textures = Vec::with_capacity(scene.materials.len());
        let stride = BLOCK_STRIDE as usize;
        let mut blocks = vec![0; scene.materials.len().max(1) * stride];
        for (material, bytes) in scene.materials.iter().zip(blocks.chunks_exact_mut(stride)) {
            bytes[..size_of::<MaterialBlock>()].copy_from_slice(bytemuck::bytes_of(&block(material)));
            let maps = [material.base_color_texture, material.emissive_texture];
            textures.push(maps.map(|texture| {
                let texture = texture.and_then(|texture| scene.textures.get(texture));
                let image = texture.map_or(scene.images.len(), |texture| texture.image);
                (image, sampler_of(texture.map(|texture| texture.sampler).unwrap_or_default()))
            }));
        }
        let blocks = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("scene materials"),
            contents: &blocks,
            usage: wgpu::BufferUsages::UNIFORM,
        });
        Self { blocks, textures, images, samplers }
    }

    pub(super) fn count(&self) -> u32 {
        self.textures.len() as u32
    }

    /// The resource that a material binds under a name.
    pub(super) fn binding(&self, material: u32, name: &str) -> Option<wgpu::BindingResource<'_>> {
        let textures = self.textures.get(material as usize)?;
        if name == "material" {
            return Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &self.blocks,
                offset: u64::from(material) * u64::from(BLOCK_STRIDE),
                size: NonZeroU64::new(u64::from(MaterialBlock::SIZE)),
            }));
        }
        let (map, kind) = name.rsplit_once('_')?;
        let (image, sampler) = textures[MAPS.iter().position(|known| *known == map)?];
        match kind {
            "texture" => self.images.get(image).map(wgpu::BindingResource::TextureView),
            "sampler" => self.samplers.get(sampler).map(wgpu::BindingResource::Sampler),
            _ => None,
        }
    }
}

fn block(material: &Material) -> MaterialBlock {
    MaterialBlock {
        base_color: material.base_color,
        emissive: material.emissive,
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque | AlphaMode::Blend => 0.0,
        },
        receive_shadow: u32::from(material.receive_shadow),
    }
}

fn upload(device: &wgpu::Device, queue: &wgpu::Queue, image: &Image) -> wgpu::TextureView {
    let max = device.limits().max_texture_dimension_2d;
    let smaller = mipmap::levels(image);
    let levels: Vec<(u32, u32, &[u8])> = std::iter::once((image.width, image.height, &image.rgba[..]))
        .chain(smaller.iter().map(|(width, height, texels)| (*width, *height, &texels[..])))
        .skip_while(|(width, height, _)| *width.max(height) > max)
        .collect();
    let size = |width: u32, height: u32| wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let base = levels.first().map_or(size(1, 1), |(width, height, _)| size(*width, *height));
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: base,
        mip_level_count: levels.len().max(1) as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, (width, height, texels)) in levels.into_iter().enumerate() {
        let target = wgpu::TexelCopyTextureInfo {
            texture: &texture,
            mip_level: level as u32,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        };
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * 4),
            rows_per_image: Some(height),
        };
        queue.write_texture(target, texels, rows, size(width, height));
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn descriptor(sampler: Sampler) -> wgpu::SamplerDescriptor<'static> {
    let Sampler { wrap_u, wrap_v, magnify, minify, mipmap } = sampler;
    let is_linear = [magnify, minify] == [wgpu::FilterMode::Linear; 2];
    let is_mixed = mipmap == Some(wgpu::MipmapFilterMode::Linear);
    wgpu::SamplerDescriptor {
        label: Some("scene texture"),
        address_mode_u: wrap_u,
        address_mode_v: wrap_v,
        mag_filter: magnify,
        min_filter: minify,
        mipmap_filter: mipmap.unwrap_or(wgpu::MipmapFilterMode::Nearest),
        // Without mip levels, only the first one is ever chosen.
        lod_max_clamp: if mipmap.is_some() { 32.0 } else { 0.0 },
        anisotropy_clamp: if is_linear && is_mixed { ANISOTROPY } else { 1 },
        ..wgpu::SamplerDescriptor::default()
    }
}
