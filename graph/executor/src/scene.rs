//! The host's draws of one view, in a render pass.
//!
//! The host chooses pipelines, materials and objects by number, and nothing that it chooses can leave the render pass
//! without what a draw needs: each view begins with the pipeline of the first property set, material 0 and object 0, and
//! a number that does not exist changes nothing. A pass whose pipelines cannot be fed at all (no property sets, no
//! materials) is not offered to the host.

use super::groups::{self, Group};
use super::host_groups::{Materials, Objects};
use crate::data::View;
use crate::work::DrawOrder;
use crate::{DrawPass, DrawSource};
use umbragraph_pipeline::draw::{MATERIAL_GROUP, OBJECT_GROUP, PropertySet};

/// The objects that the host's draws of a pass need.
pub(super) struct Scene<'a> {
    pub(super) geometry: &'a str,
    pub(super) filter: &'a str,
    pub(super) order: DrawOrder,
    pub(super) pipelines: &'a [(PropertySet, wgpu::RenderPipeline)],
    pub(super) groups: &'a [Group],
    pub(super) materials: Option<&'a Materials>,
    pub(super) objects: Option<&'a Objects>,
    /// Width and height of the attachments.
    pub(super) extent: [u32; 2],
}

impl Scene<'_> {
    /// Lets the host draw a view, which is the one at `position` among those of the pass.
    pub(super) fn draw(
        &self,
        source: &dyn DrawSource,
        view: &View,
        position: usize,
        pass: &mut wgpu::RenderPass<'static>,
        offsets: &mut Vec<u32>,
    ) {
        let [x, y, width, height] = view.viewport.unwrap_or([0, 0, self.extent[0], self.extent[1]]);
        let Some((_, pipeline)) = self.pipelines.first().filter(|_| width > 0 && height > 0) else { return };
        let material = match self.materials {
            Some(materials) => match materials.get(0) {
                Some(group) => Some(group),
                None => return,
            },
            None => None,
        };
        let object = match self.objects {
            Some(objects) => match objects.get(0, offsets) {
                Some(group) => Some(group),
                None => return,
            },
            None => None,
        };
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, width, height);
        pass.set_pipeline(pipeline);
        groups::bind_render(self.groups, pass, position);
        if let Some(group) = material {
            pass.set_bind_group(MATERIAL_GROUP, group, &[]);
        }
        if let Some(group) = object {
            pass.set_bind_group(OBJECT_GROUP, group, offsets);
        }
        source.draw(&mut ScenePass { scene: self, view, pass, offsets });
    }
}

/// The render pass of one view, as the host sees it.
struct ScenePass<'a> {
    scene: &'a Scene<'a>,
    view: &'a View,
    pass: &'a mut wgpu::RenderPass<'static>,
    offsets: &'a mut Vec<u32>,
}

impl DrawPass for ScenePass<'_> {
    fn geometry(&self) -> &str {
        self.scene.geometry
    }

    fn filter(&self) -> &str {
        self.scene.filter
    }

    fn view(&self) -> &View {
        self.view
    }

    fn order(&self) -> DrawOrder {
        self.scene.order
    }

    fn set_properties(&mut self, properties: PropertySet) -> bool {
        match self.scene.pipelines.iter().find(|(set, _)| *set == properties) {
            Some((_, pipeline)) => {
                self.pass.set_pipeline(pipeline);
                true
            }
            None => false,
        }
    }

    fn set_material(&mut self, material: u32) {
        if let Some(group) = self.scene.materials.and_then(|materials| materials.get(material)) {
            self.pass.set_bind_group(MATERIAL_GROUP, group, &[]);
        }
    }

    fn set_object(&mut self, object: u32) {
        if let Some(group) = self.scene.objects.and_then(|objects| objects.get(object, self.offsets)) {
            self.pass.set_bind_group(OBJECT_GROUP, group, self.offsets);
        }
    }

    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        self.pass
    }
}
