//! Reuse of depth. If a view moved over its own plane by whole texels, its still visible part is moved and not drawn
//! again. A view that is drawn over another texture begins with that texture's depth.
//!
//! Both views of a move have the same projection without perspective, except for a translation by whole texels, and the
//! same depth. The common part is copied: the layer to a texture of the same size, and from there to its new place by a
//! triangle that writes depth, since WebGPU cannot copy parts of depth textures. The newly visible part is a strip at
//! up to two edges, which is cleared and drawn.
//!
//! Limits: textures of one sample. Texels that were moved are not bit for bit those that would be drawn now: a
//! rasteriser rounds the depth of a triangle by where in the map the triangle lies. Of a walk over the courtyard 41 %
//! of the texels differ on Mesa's software driver, all but 0.1 % of them by at most four units in the last place of 32
//! bits, and 0.002 % by more than 0.0001, at edges of triangles that are clipped at the border of the view. Whole
//! texels are exact in both matrices; with the vertices laid on the rasteriser's own parts of a texel too, so that they
//! move exactly, as many texels differ (38 %).

use crate::memory::resources::{Resources, Texture};
use crate::objects::creation::Creation;
use crate::objects::shared::{Objects, RenderKey};
use umbragraph_compiler::Plan;
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::work::AttachmentTarget;

/// The maximum error of a translation, in texels; errors add up from frame to frame.
const TOLERANCE: f64 = 1e-6;

/// The key of this shader module in the module cache, in place of a hash.
const KEY: [u8; 32] = *b"executor: scrolls a view's depth";

const WGSL: &str = "@group(0) @binding(0) var kept: texture_depth_2d;
struct Moved { @builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) by: vec2<i32> }
@vertex fn cover(@builtin(vertex_index) index: u32, @builtin(instance_index) by: u32) -> Moved {
    let corner = vec4<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0, 0.0, 1.0);
    return Moved(corner, vec2<i32>(i32(by & 0xffffu), i32(by >> 16u)) - 32768);
}
@fragment fn moved(texel: Moved) -> @builtin(frag_depth) f32 {
    return textureLoad(kept, vec2<i32>(texel.position.xy) - texel.by, 0);
}
";

/// A copy of texels into the depth attachment of a pass: of its own texels, shifted, or of another texture's.
pub(crate) struct Scroll {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    /// The texture that holds the copy of a layer.
    copy: wgpu::Texture,
    texture: Texture,
    mip: u32,
    /// The source layer; `None` if it is the layer of the view.
    layer: Option<u32>,
}

impl Scroll {
    /// Creates the copy of texels of the texture `from` into the depth attachment `attached`; `None` if either has
    /// several samples or no texture.
    pub(crate) fn new(
        creation: &mut Creation<'_>,
        objects: &mut Objects,
        resources: &Resources,
        plan: &Plan,
        attached: AttachmentTarget,
        from: AttachmentTarget,
    ) -> Option<Self> {
        let (attached, planned) = (plan.resource(attached.resource)?, plan.resource(from.resource)?);
        let (format, size) = (planned.format?, planned.size?);
        if size.samples > 1 || attached.size?.samples > 1 {
            return None;
        }
        let [width, height] =
            [size.width, size.height].map(|length| length.checked_shr(from.mip).unwrap_or(0).max(1));
        let label = "scroll a view";
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let descriptor = wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let bytes = u64::from(width) * u64::from(height) * 4;
        let copy = creation.texture(&descriptor, bytes);
        let aspect = wgpu::TextureAspect::DepthOnly;
        let descriptor = wgpu::TextureViewDescriptor { label: Some(label), aspect, ..Default::default() };
        let view = creation.view(&copy, &descriptor);
        let entry = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Depth,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let layout = objects.group_layout(creation, label, vec![entry]);
        let entries =
            [wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) }];
        let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout: &layout, entries: &entries };
        let group = creation.bind_group(&descriptor);
        let layout = objects.pipeline_layout(creation, label, vec![Some(layout)]);
        let module = objects.built_in(creation, label, KEY, WGSL);
        let key = RenderKey::depth_alone(layout, module, "cover", Some("moved"), attached.format?, 1);
        let pipeline = objects.render_pipeline(creation, label, key);
        let texture = resources.texture(plan, from.resource)?;
        Some(Self { pipeline, group, copy, texture, mip: from.mip, layer: from.layer })
    }

    /// Copies the contents of a layer to the copy texture, before the render pass into that layer.
    pub(crate) fn copy(&self, encoder: &mut wgpu::CommandEncoder, resources: &Resources, layer: usize) {
        let Some(texture) = self.texture.get(resources) else { return };
        let last = texture.depth_or_array_layers().saturating_sub(1);
        let z = self.layer.unwrap_or(layer as u32).min(last);
        let origin = wgpu::Origin3d { z, ..wgpu::Origin3d::ZERO };
        let from = wgpu::TexelCopyTextureInfo { mip_level: self.mip, origin, ..texture.as_image_copy() };
        encoder.copy_texture_to_texture(from, self.copy.as_image_copy(), self.copy.size());
    }

    /// Draws the copied texels into the rectangle `texels`, shifted by `by` texels.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'static>, texels: [u32; 4], by: [i32; 2]) {
        let [x, y, width, height] = texels;
        let [left, top] = [by[0].max(0) as u32, by[1].max(0) as u32];
        let packed = (by[0] + 32768) as u32 | ((by[1] + 32768) as u32) << 16;
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        let (wide, high) = (width - by[0].unsigned_abs(), height - by[1].unsigned_abs());
        pass.set_scissor_rect(x + left, y + top, wide, high);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, packed..packed + 1);
    }
}

/// Returns the texels by which a view moved, to the right and down. `None` if the views differ in more than a
/// translation, or have no texels in common.
pub(crate) fn moved(from: &View, to: &View, [width, height]: [u32; 2]) -> Option<[i32; 2]> {
    let (a, b) = (&from.clip_from_world, &to.clip_from_world);
    let is_flat = a.row(3) == glam::DVec4::W && b.row(3) == glam::DVec4::W;
    let is_alike = a.x_axis == b.x_axis && a.y_axis == b.y_axis && a.z_axis == b.z_axis;
    let by = b.w_axis - a.w_axis;
    if !(is_flat && is_alike && by.z == 0.0 && from.reverse == to.reverse) {
        return None;
    }
    let texels = |by: f64, length: u32| {
        let texels = 0.5 * by * f64::from(length);
        let whole = texels.round();
        let is_whole = (texels - whole).abs() < TOLERANCE && whole.abs() < f64::from(length.min(32768));
        is_whole.then_some(whole as i32)
    };
    Some([texels(by.x, width)?, texels(-by.y, height)?])
}

/// Returns the newly visible strips of a rectangle: left or right over the full height, then the rest at the top or
/// bottom.
pub(crate) fn strips([x, y, width, height]: [u32; 4], by: [i32; 2]) -> impl Iterator<Item = [u32; 4]> {
    let [wide, high] = by.map(i32::unsigned_abs);
    let left = if by[0] > 0 { x } else { x + width - wide };
    let rest = if by[0] > 0 { x + wide } else { x };
    let top = if by[1] > 0 { y } else { y + height - high };
    let strips = [[left, y, wide, height], [rest, top, width - wide, high]];
    strips.into_iter().filter(|[_, _, width, height]| *width > 0 && *height > 0)
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;

    fn view(scale: DVec3, offset: DVec3) -> View {
        View::new(
            DMat4::from_translation(offset) * DMat4::from_scale(scale),
            DMat4::IDENTITY,
            DVec3::ZERO,
            DVec3::NEG_Z,
        )
    }

    #[test]
    fn only_translations_by_whole_texels_at_one_depth_are_found() {
        let from = view(DVec3::ONE, DVec3::ZERO);
        let to = |x: f64, y: f64, z: f64| moved(&from, &view(DVec3::ONE, DVec3::new(x, y, z)), [8, 16]);
        assert_eq!(to(0.25, 0.5, 0.0), Some([1, -4]));
        assert_eq!(to(-1.75, 0.0, 0.0), Some([-7, 0]));
        assert_eq!(to(0.3, 0.0, 0.0), None);
        assert_eq!(to(2.0, 0.0, 0.0), None, "nothing is left in view");
        assert_eq!(to(0.25, 0.0, 1e-9), None, "another depth");
        for scale in [DVec3::new(2.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 1.0), DVec3::new(1.0, 1.0, 2.0)] {
            assert_eq!(moved(&from, &view(scale, DVec3::ZERO), [8, 8]), None, "{scale}");
        }
        let mut perspective = view(DVec3::ONE, DVec3::ZERO);
        perspective.clip_from_world.z_axis.w = -1.0;
        let mut nearer = view(DVec3::ONE, DVec3::ZERO);
        nearer.clip_from_world.w_axis.w = 2.0;
        for (from, to) in [(&perspective, &perspective), (&from, &nearer), (&nearer, &from)] {
            assert_eq!(moved(from, to, [8, 8]), None);
        }
    }

    #[test]
    fn what_is_moved_and_the_strips_cover_each_texel_once() {
        for by in [[0, 0], [3, 0], [-3, 2], [1, -7], [0, 5], [-7, -7]] {
            let [x, y, width, height] = [4, 2, 8, 9];
            let mut covered = vec![0; 20 * 20];
            let [left, top] = [by[0].max(0) as u32, by[1].max(0) as u32];
            let (wide, high) = (width - i32::unsigned_abs(by[0]), height - i32::unsigned_abs(by[1]));
            let kept = [x + left, y + top, wide, high];
            assert!(strips([x, y, width, height], by).all(|[_, _, width, height]| width > 0 && height > 0));
            for [x, y, width, height] in strips([x, y, width, height], by).chain([kept]) {
                for at in 0..width * height {
                    covered[((y + at / width) * 20 + x + at % width) as usize] += 1;
                }
            }
            let inside =
                |at: u32| (x..x + width).contains(&(at % 20)) && (y..y + height).contains(&(at / 20));
            assert!((0..400).all(|at| covered[at as usize] == u32::from(inside(at))), "{by:?}");
        }
    }
}
