//! The host's draws of one view, in a render pass.
//!
//! The host chooses pipelines, materials and objects by number, and nothing that it chooses can leave the render pass
//! without what a draw needs: each view begins with the pipeline of the first property set, material 0 and object 0,
//! and a number that does not exist changes nothing; bind groups of its own the host binds before it draws. A pass
//! whose pipelines cannot be fed at all (no property sets, no materials) is not offered to the host. Where panics
//! unwind, one of the host's ends its draws of the view, and not the record.

use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec2;

use crate::binding::draw::{DrawPass, DrawSource};
use crate::binding::groups;
use crate::binding::groups::Group;
use crate::binding::host_groups::HostGroups;
use crate::drawing::attachments::Attachments;
use crate::instance::instantiate::InstantiatedScene;
use crate::measure::statistics::PassCounts;
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::draw::{MATERIAL_GROUP, OBJECT_GROUP, PropertySet};
use umbragraph_pipeline::frame::Bounds;
use umbragraph_pipeline::work::{DrawOrder, SceneDraw};

/// The settings and device objects that the host's draws of one pass need.
pub(crate) struct Scene<'a> {
    pub(crate) work: &'a SceneDraw,
    pub(crate) instantiated: &'a InstantiatedScene,
    pub(crate) groups: &'a [Group],
    pub(crate) materials: Option<&'a HostGroups>,
    pub(crate) objects: Option<&'a HostGroups>,
    pub(crate) attachments: &'a Attachments,
}

impl Scene<'_> {
    /// Lets the host draw one view of the pass, with the scissor rectangle `texels` (x, y, width, height); `position`
    /// is the index of the view. Returns the number of draws and of scissored texels; zero if a pipeline, material 0 or
    /// object 0 is missing.
    ///
    /// # Errors
    /// The reason why the host's draws failed, or its panic message.
    pub(crate) fn draw(
        &self,
        source: &dyn DrawSource,
        view: &View,
        (position, texels): (usize, [u32; 4]),
        pass: &mut wgpu::RenderPass<'static>,
        offsets: &mut Vec<u32>,
    ) -> Result<PassCounts, String> {
        let (_, [x, y, width, height]) = self.attachments.texels(view);
        let pipeline = self.instantiated.pipelines.first().filter(|_| width > 0 && height > 0);
        let material = self.materials.map(|materials| materials.material(0));
        let object = self.objects.map(|objects| objects.object(0, offsets));
        let (Some((_, pipeline)), None | Some(Some(_)), None | Some(Some(_))) = (pipeline, material, object)
        else {
            return Ok(PassCounts::default());
        };
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(texels[0], texels[1], texels[2], texels[3]);
        pass.set_pipeline(pipeline);
        groups::bind_render(self.groups, pass, position);
        if let Some(group) = material.flatten() {
            pass.set_bind_group(MATERIAL_GROUP, group, &[]);
        }
        if let Some(group) = object.flatten() {
            pass.set_bind_group(OBJECT_GROUP, group, offsets);
        }
        // The last level counts for all views beyond.
        let detail = self.work.detail.get(position).or(self.work.detail.last()).copied().unwrap_or(0);
        let mut drawing = ScenePass { scene: self, view, detail, pass, offsets, draws: 0, failed: None };
        let caught = catch_unwind(AssertUnwindSafe(|| source.draw(&mut drawing)));
        let failed = drawing.failed.or(caught.err().map(|payload| said_in_panic(&*payload)));
        let texels = u64::from(texels[2]) * u64::from(texels[3]);
        failed.map_or(Ok(PassCounts { draws: drawing.draws, texels, ..PassCounts::default() }), Err)
    }
}

fn said_in_panic(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
    format!("it panicked: {}", text.unwrap_or_default())
}

/// Returns the part of a view's texels that world-space bounds cover, plus one texel on each side; `None` if they cover
/// none. Rectangles are x, y, width and height in texels.
pub(crate) fn covered(bounds: &Bounds, view: &View, texels: [u32; 4]) -> Option<[u32; 4]> {
    if *bounds == Bounds::EMPTY {
        return None;
    }
    let [x, y, width, height] = texels;
    let size = DVec2::new(f64::from(width), f64::from(height));
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in bounds.corners() {
        let clip = view.clip_from_world * corner.extend(1.0);
        let place = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * size;
        // What lies behind the eye, or nowhere, may cover everything.
        if clip.w <= 0.0 || !place.is_finite() {
            return Some(texels);
        }
        (low, high) = (low.min(place), high.max(place));
    }
    // A texel more to each side than what rounding may take.
    let low = (low - 1.0).floor().clamp(DVec2::ZERO, size);
    let high = (high + 1.0).ceil().clamp(DVec2::ZERO, size);
    let [wide, high] = [high.x - low.x, high.y - low.y].map(|length| length as u32);
    (wide > 0 && high > 0).then_some([x + low.x as u32, y + low.y as u32, wide, high])
}

/// Returns the intersection of two rectangles of x, y, width and height in texels; `None` if they do not overlap.
pub(crate) fn common(a: [u32; 4], b: [u32; 4]) -> Option<[u32; 4]> {
    let low = [a[0].max(b[0]), a[1].max(b[1])];
    let wide = (a[0] + a[2]).min(b[0] + b[2]).checked_sub(low[0])?;
    let high = (a[1] + a[3]).min(b[1] + b[3]).checked_sub(low[1])?;
    (wide > 0 && high > 0).then_some([low[0], low[1], wide, high])
}

/// The render pass of one view into which the host records its draws.
struct ScenePass<'a> {
    scene: &'a Scene<'a>,
    view: &'a View,
    detail: u32,
    pass: &'a mut wgpu::RenderPass<'static>,
    offsets: &'a mut Vec<u32>,
    /// The number of calls of `set_object` so far, one for each draw.
    draws: u64,
    failed: Option<String>,
}

impl DrawPass for ScenePass<'_> {
    fn geometry(&self) -> &str {
        &self.scene.work.geometry
    }

    fn filter(&self) -> &str {
        &self.scene.work.filter
    }

    fn view(&self) -> &View {
        self.view
    }

    fn order(&self) -> DrawOrder {
        self.scene.work.order
    }

    fn detail(&self) -> u32 {
        self.detail
    }

    fn set_properties(&mut self, properties: PropertySet) -> bool {
        let found = self.scene.instantiated.pipelines.iter().find(|(set, _)| *set == properties);
        found.map(|(_, pipeline)| self.pass.set_pipeline(pipeline)).is_some()
    }

    fn set_material(&mut self, material: u32) {
        if let Some(group) = self.scene.materials.and_then(|materials| materials.material(material)) {
            self.pass.set_bind_group(MATERIAL_GROUP, group, &[]);
        }
    }

    fn set_object(&mut self, object: u32) {
        self.draws += 1;
        if let Some(group) = self.scene.objects.and_then(|objects| objects.object(object, self.offsets)) {
            self.pass.set_bind_group(OBJECT_GROUP, group, self.offsets);
        }
    }

    fn set_bind_group(&mut self, index: u32, group: &wgpu::BindGroup, offsets: &[u32]) -> bool {
        let is_own = self.scene.instantiated.own_groups.contains(&index);
        if is_own {
            self.pass.set_bind_group(index, group, offsets);
        }
        is_own
    }

    fn fail(&mut self, reason: String) {
        self.failed.get_or_insert(reason);
    }

    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        self.pass
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3, DVec4};

    use super::*;

    const TEXELS: [u32; 4] = [8, 16, 64, 32];

    fn seen(clip_from_world: DMat4, min: [f64; 3], max: [f64; 3]) -> Option<[u32; 4]> {
        let view = View::new(clip_from_world, DMat4::IDENTITY, DVec3::ZERO, DVec3::NEG_Z);
        covered(&Bounds::between(min, max), &view, TEXELS)
    }

    #[test]
    fn what_bounds_cover_is_where_they_are_seen_and_a_texel_around() {
        let flat = |min, max| seen(DMat4::IDENTITY, min, max);
        assert_eq!(flat([-0.5, 0.0, 0.0], [0.5, 1.0, 1.0]), Some([8 + 15, 16, 34, 17]));
        assert_eq!(flat([-9.0, -9.0, 0.0], [9.0, 9.0, 1.0]), Some(TEXELS));
        assert_eq!(flat([1.5, 0.0, 0.0], [2.0, 1.0, 1.0]), None, "beyond the right edge");
        assert_eq!(flat([0.0, -3.0, 0.0], [1.0, -2.0, 1.0]), None, "beyond the lower edge");
        assert_eq!(flat([0.0, 0.0, 0.0], [f64::INFINITY, 1.0, 1.0]), Some(TEXELS), "nowhere");
        let view = View::new(DMat4::IDENTITY, DMat4::IDENTITY, DVec3::ZERO, DVec3::NEG_Z);
        assert_eq!(covered(&Bounds::EMPTY, &view, TEXELS), None);
        // What is twice as far away is half as large.
        let eye = DMat4::from_cols(DVec4::X, DVec4::Y, -DVec4::W, DVec4::Z);
        assert_eq!(seen(eye, [-1.0, 0.0, -4.0], [1.0, 1.0, -2.0]), Some([8 + 15, 16 + 7, 34, 10]));
        assert_eq!(seen(eye, [-1.0, 0.0, -4.0], [1.0, 1.0, 2.0]), Some(TEXELS), "in part behind the eye");
        assert_eq!(seen(eye, [-1.0, 0.0, -4.0], [1.0, 1.0, 0.0]), Some(TEXELS), "as far as the eye");
    }

    #[test]
    fn rectangles_have_in_common_what_lies_in_both() {
        assert_eq!(common([0, 0, 4, 4], [2, 1, 8, 2]), Some([2, 1, 2, 2]));
        assert_eq!(common([3, 5, 4, 4], [0, 0, 8, 6]), Some([3, 5, 4, 1]));
        assert_eq!(common([0, 0, 4, 4], [4, 0, 4, 4]), None, "side by side");
        assert_eq!(common([0, 0, 4, 4], [0, 4, 4, 4]), None, "one above the other");
        assert_eq!(common([0, 0, 4, 4], [9, 9, 1, 1]), None);
    }
}
