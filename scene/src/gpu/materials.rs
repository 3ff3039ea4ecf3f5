//! Materials, textures and samplers of a scene on the device.
//!
//! Every material has the same bindings; a texture that it lacks is white. Images beyond what the device allows begin
//! with the first mip level that fits.

use std::collections::HashMap;
use std::num::NonZeroU64;
use umbragraph_executor::wgpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::interface::{BLOCK_STRIDE, MAPS, MaterialBlock, MaterialDetailBlock, maps};
use crate::material::Material;
use crate::mipmap;
use crate::scene::Scene;
use crate::texture::{Image, Sampler};

/// The maximum anisotropy of material samplers, for textures at grazing angles.
const ANISOTROPY: u16 = 8;

pub(super) struct Materials {
    blocks: wgpu::Buffer,
    details: wgpu::Buffer,
    /// For each material and each texture map in [`MAPS`], an index into `images` and an index into `samplers`.
    textures: Vec<[(usize, usize); MAPS.len()]>,
    images: Vec<wgpu::TextureView>,
    samplers: Vec<wgpu::Sampler>,
}

/// The images uploaded so far. An image is uploaded once for each encoding (sRGB or linear) in which materials sample
/// it.
struct Images<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    views: Vec<wgpu::TextureView>,
    known: HashMap<(usize, bool), usize>,
}

impl Images<'_> {
    /// The index in `views` of the image with index `image` in the scene, which is uploaded on first use. An image that
    /// does not exist is replaced by a white texel.
    fn index(&mut self, scene: &Scene, image: usize, is_srgb: bool) -> usize {
        let found = scene.images.get(image);
        let key = if found.is_some() { (image, is_srgb) } else { (usize::MAX, true) };
        *self.known.entry(key).or_insert_with(|| {
            let white = || Image { name: "white".to_owned(), width: 1, height: 1, rgba: vec![255; 4] };
            let view = match found {
                Some(image) => upload(self.device, self.queue, image, is_srgb),
                None => upload(self.device, self.queue, &white(), true),
            };
            self.views.push(view);
            self.views.len() - 1
        })
    }
}

impl Materials {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Self {
        let mut images = Images { device, queue, views: Vec::new(), known: HashMap::new() };
        let (mut samplers, mut known) = (Vec::new(), HashMap::new());
        let mut sampler_of = |sampler: Sampler| {
            *known.entry(sampler).or_insert_with(|| {
                samplers.push(device.create_sampler(&descriptor(sampler)));
                samplers.len() - 1
            })
        };
        let textures = scene.materials.iter().map(|material| {
            maps(material).map(|(map, is_srgb)| {
                let texture = map.and_then(|map| scene.textures.get(map.texture));
                let image = texture.map_or(usize::MAX, |texture| texture.image);
                let sampler = texture.map(|texture| texture.sampler).unwrap_or_default();
                (images.index(scene, image, is_srgb), sampler_of(sampler))
            })
        });
        let textures = textures.collect();
        let blocks = uniforms(device, scene, |material| MaterialBlock::from(material));
        let details = uniforms(device, scene, |material| MaterialDetailBlock::from(material));
        Self { blocks, details, textures, images: images.views, samplers }
    }

    pub(super) fn count(&self) -> u32 {
        self.textures.len() as u32
    }

    /// The block, texture or sampler of the material with index `material` for the shader binding `name`. `None` for an
    /// unknown name or material.
    pub(super) fn binding(&self, material: u32, name: &str) -> Option<wgpu::BindingResource<'_>> {
        let textures = self.textures.get(material as usize)?;
        let block = |buffer, size: u32| {
            let offset = u64::from(material) * u64::from(BLOCK_STRIDE);
            let size = NonZeroU64::new(u64::from(size));
            Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size }))
        };
        match name {
            "material" => return block(&self.blocks, MaterialBlock::SIZE),
            "material_detail" => return block(&self.details, MaterialDetailBlock::SIZE),
            _ => {}
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

/// Creates a uniform buffer with one block for each material; consecutive blocks are [`BLOCK_STRIDE`] bytes apart.
fn uniforms<T: bytemuck::Pod>(
    device: &wgpu::Device,
    scene: &Scene,
    block: impl Fn(&Material) -> T,
) -> wgpu::Buffer {
    let stride = BLOCK_STRIDE as usize;
    let mut bytes = vec![0; scene.materials.len().max(1) * stride];
    for (material, bytes) in scene.materials.iter().zip(bytes.chunks_exact_mut(stride)) {
        bytes[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(&block(material)));
    }
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some("scene materials"),
        contents: &bytes,
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

fn upload(device: &wgpu::Device, queue: &wgpu::Queue, image: &Image, is_srgb: bool) -> wgpu::TextureView {
    let max = device.limits().max_texture_dimension_2d;
    let smaller = mipmap::levels(image, is_srgb);
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
        format: if is_srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm },
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
