//! Contents that the last frame began with, so that it can be recorded once more.
//!
//! A look at a texture records the shown frame again, with copies. What a frame writes from scratch comes out as it was,
//! and so do histories. Persistent resources and textures of the window that a frame changes step by step do not: a
//! simulation would go on with each look. While somebody looks, their contents are copied aside before each frame, and
//! brought back before the frame is repeated.
//!
//! Limits: at most [`MOST`] bytes; larger resources go on by one step with each look. Buffers of the host are not
//! copied. Maps whose views are kept from frame to frame are not copied, since a repeated frame draws all of their
//! views.

use std::sync::Arc;

use umbragraph::low_level::compiler::{PlannedPass, PlannedResource};
use umbragraph::low_level::language::Lifetime;
use umbragraph::{Executor, Plan, wgpu};

/// The maximum number of bytes of all saved contents, 256 MiB.
const MOST: u64 = 256 << 20;

/// The saved contents of a texture or buffer.
enum Saved {
    Texture { live: wgpu::Texture, copy: wgpu::Texture, is_filled: bool },
    Buffer { live: wgpu::Buffer, copy: wgpu::Buffer, is_filled: bool },
}

/// The saved contents of all resources of a plan that frames change step by step.
#[derive(Default)]
pub(crate) struct Kept {
    of: Option<Arc<Plan>>,
    names: Vec<String>,
    saved: Vec<Saved>,
}

impl Kept {
    /// Returns `true` if frames of a plan change contents step by step.
    pub(crate) fn is_needed(plan: &Plan) -> bool {
        !changing(plan).is_empty()
    }

    /// The number of bytes that are copied before a frame.
    pub(crate) fn bytes(&self) -> u64 {
        let planned = |name: &String| self.of.as_ref()?.resources.get(name).map(|one| one.bytes);
        self.names.iter().filter_map(planned).sum()
    }

    /// Records copies of the contents that the next frame begins with.
    pub(crate) fn save(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        executor: &Executor,
        plan: &Arc<Plan>,
        imports: &[(&str, &wgpu::Texture)],
    ) {
        if !self.of.as_ref().is_some_and(|of| Arc::ptr_eq(of, plan)) {
            (self.of, self.names) = (Some(plan.clone()), changing(plan));
        }
        let mut before = std::mem::take(&mut self.saved);
        for name in &self.names {
            let imported = imports.iter().find(|(known, _)| known == name).map(|(_, texture)| *texture);
            let texture = executor.texture(name).or(imported).filter(|texture| is_copyable(texture));
            let buffer = executor.buffer(name).filter(|buffer| {
                buffer.usage().contains(wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST)
            });
            let known = before.iter().position(|saved| match saved {
                Saved::Texture { live, .. } => texture == Some(live),
                Saved::Buffer { live, .. } => buffer == Some(live),
            });
            let saved = match (known, texture, buffer) {
                (Some(at), ..) => Some(before.swap_remove(at)),
                (None, Some(live), _) => Some(Saved::Texture {
                    live: live.clone(),
                    copy: texture_like(device, live),
                    is_filled: false,
                }),
                (None, None, Some(live)) => Some(Saved::Buffer {
                    live: live.clone(),
                    copy: buffer_like(device, live),
                    is_filled: false,
                }),
                (None, None, None) => None,
            };
            self.saved.extend(saved);
        }
        for saved in &self.saved {
            match saved {
                Saved::Texture { live, copy, .. } => copy_texture(encoder, live, copy),
                Saved::Buffer { live, copy, .. } => {
                    encoder.copy_buffer_to_buffer(live, 0, copy, 0, live.size())
                }
            }
        }
    }

    /// Notes that the recorded copies were submitted. Contents whose copies were not are never brought back.
    pub(crate) fn submitted(&mut self) {
        for saved in &mut self.saved {
            match saved {
                Saved::Texture { is_filled, .. } | Saved::Buffer { is_filled, .. } => *is_filled = true,
            }
        }
    }

    /// Records copies that bring the saved contents back.
    pub(crate) fn restore(&self, encoder: &mut wgpu::CommandEncoder) {
        for saved in &self.saved {
            match saved {
                Saved::Texture { live, copy, is_filled: true } => copy_texture(encoder, copy, live),
                Saved::Buffer { live, copy, is_filled: true } => {
                    encoder.copy_buffer_to_buffer(copy, 0, live, 0, live.size());
                }
                Saved::Texture { .. } | Saved::Buffer { .. } => {}
            }
        }
    }
}

/// The names of the resources that a frame changes and of which it may read what the frame before left, the smallest
/// first, with at most [`MOST`] bytes together.
fn changing(plan: &Plan) -> Vec<String> {
    let outlives = |resource: &PlannedResource| match resource.lifetime {
        Lifetime::Persistent => true,
        Lifetime::Imported => resource.format.is_some(),
        _ => false,
    };
    let mut found: Vec<(u64, &String)> = plan
        .resources
        .iter()
        .filter(|(_, resource)| outlives(resource) && changes(plan, resource))
        .map(|(name, resource)| (resource.bytes, name))
        .collect();
    found.sort();
    let mut all = 0;
    let fitting = found.into_iter().take_while(|(bytes, _)| {
        all += bytes;
        all <= MOST
    });
    fitting.map(|(_, name)| name.clone()).collect()
}

/// Returns `true` if a frame writes a resource, and its first access leaves contents of the frame before.
fn changes(plan: &Plan, resource: &PlannedResource) -> bool {
    let writes = |pass: &&PlannedPass| plan.writes(pass.handle, resource.handle);
    let keeps_views = |pass: &PlannedPass| {
        plan.pipeline.pass(pass.handle).work().scene().is_some_and(|scene| scene.redraw.is_some())
    };
    let mut writers = plan.passes.iter().filter(writes).peekable();
    if writers.peek().is_none() || writers.all(keeps_views) {
        return false;
    }
    let is_single = resource.size.is_none_or(|size| size.mips == 1 && size.layers == 1);
    let first = plan.passes.iter().find_map(|pass| {
        let mut accesses = plan.pipeline.pass(pass.handle).accesses().iter();
        accesses.find(|one| one.resource == resource.handle).map(|access| (pass, access))
    });
    first.is_some_and(|(pass, access)| {
        let range = access.range;
        let is_whole = range.bytes.is_none() && (is_single || (range.mip.is_none() && range.layer.is_none()));
        pass.toggle.is_some() || !(access.usage.replaces_contents() && is_whole)
    })
}

fn is_copyable(texture: &wgpu::Texture) -> bool {
    texture.usage().contains(wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST)
}

fn texture_like(device: &wgpu::Device, like: &wgpu::Texture) -> wgpu::Texture {
    let copies = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
    // A texture of several samples has to be an attachment.
    let more = if like.sample_count() > 1 {
        wgpu::TextureUsages::RENDER_ATTACHMENT
    } else {
        wgpu::TextureUsages::empty()
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("contents before the frame"),
        size: like.size(),
        mip_level_count: like.mip_level_count(),
        sample_count: like.sample_count(),
        dimension: like.dimension(),
        format: like.format(),
        usage: copies | more,
        view_formats: &[],
    })
}

fn buffer_like(device: &wgpu::Device, like: &wgpu::Buffer) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("contents before the frame"),
        size: like.size(),
        usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Records copies of all mip levels and layers of a texture.
fn copy_texture(encoder: &mut wgpu::CommandEncoder, from: &wgpu::Texture, to: &wgpu::Texture) {
    let is_volume = from.dimension() == wgpu::TextureDimension::D3;
    for mip_level in 0..from.mip_level_count() {
        let side = |side: u32| (side >> mip_level).max(1);
        let (layers, depth) = match is_volume {
            true => (1, side(from.depth_or_array_layers())),
            false => (from.depth_or_array_layers(), 1),
        };
        let extent = wgpu::Extent3d {
            width: side(from.width()),
            height: side(from.height()),
            depth_or_array_layers: depth,
        };
        // wgpu 30 panics where the layers of one copy were last used in more than one way.
        for z in 0..layers {
            let at = |texture| wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                aspect: wgpu::TextureAspect::All,
            };
            encoder.copy_texture_to_texture(at(from), at(to), extent);
        }
    }
}
