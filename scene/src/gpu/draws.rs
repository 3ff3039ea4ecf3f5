//! The draws of a view, and their order.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use umbragraph_executor::DrawPass;
use umbragraph_pipeline::draw::PropertySet;
use umbragraph_pipeline::frame::Bounds;
use umbragraph_pipeline::work::DrawOrder;

use super::geometry::{Geometry, Part};
use super::objects::world_from_object;
use crate::filter::wants_draw;
use crate::interface::properties;
use crate::material::AlphaMode;
use crate::pose::Pose;
use crate::scene::{Draw, Scene};
use crate::visibility::may_be_visible;

/// A draw of the scene, with the data needed to record its draw call.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) draw: Draw,
    part: Part,
    properties: PropertySet,
    is_blended: bool,
    /// The index of the draw in [`Scene::draws_of_all_details`], and of its uniform block in the object buffers.
    object: u32,
    bounds: Bounds,
    is_mirrored: bool,
}

impl Item {
    /// Updates the bounding box of the draw for a pose, and whether its transform mirrors it.
    pub(super) fn place(&mut self, scene: &Scene, pose: &Pose) {
        self.bounds = scene.draw_bounds(self.draw, pose);
        self.is_mirrored = world_from_object(self.draw, pose).determinant() < 0.0;
    }

    fn indices(&self) -> Range<u32> {
        if self.is_mirrored { self.part.mirrored.clone() } else { self.part.indices.clone() }
    }
}

/// The draws of a scene, sorted to minimize state changes: opaque before blended, then by properties, material and
/// mesh.
pub(super) fn sorted_items(scene: &Scene, geometry: &Geometry) -> Vec<Item> {
    let mut items: Vec<Item> = scene
        .draws_of_all_details()
        .enumerate()
        .filter_map(|(number, draw)| {
            Some(Item {
                draw,
                part: geometry.part(scene, number, draw)?.clone(),
                properties: properties(scene, draw),
                is_blended: scene.material(draw).alpha_mode == AlphaMode::Blend,
                object: number as u32,
                bounds: Bounds::EMPTY,
                is_mirrored: false,
            })
        })
        .collect();
    items.sort_by_key(|item| {
        (
            item.is_blended,
            item.properties,
            item.draw.material,
            item.draw.mesh,
            item.draw.primitive,
            item.object,
        )
    });
    items
}

/// Records the draws that match the filter and level of detail of the pass and may be visible in its view.
pub(super) fn record(
    items: &[Item],
    geometry: &Geometry,
    sorted: &Mutex<Vec<(f64, u32)>>,
    pass: &mut dyn DrawPass,
) {
    geometry.bind(pass.render_pass());
    let (view, mut state) = (*pass.view(), State::default());
    let wanted = |item: &Item, pass: &dyn DrawPass| {
        wants_draw(pass.filter(), item.draw, item.is_blended)
            && item.draw.detail == pass.detail().min(item.draw.last_detail)
            && may_be_visible(&item.bounds, &view.clip_from_world)
    };
    // How far the middle of a draw lies along the view.
    let distance = |item: &Item| (item.bounds.center() - view.position).dot(view.forward);
    // Opaque draws come first in the list.
    let first_blended = items.partition_point(|item| !item.is_blended);
    let mut sorted = sorted.lock().unwrap_or_else(PoisonError::into_inner);
    match pass.order() {
        DrawOrder::State => {
            for item in &items[..first_blended] {
                if wanted(item, pass) {
                    state.issue(item, geometry, pass);
                }
            }
        }
        DrawOrder::FrontToBack => {
            sort(items, 0..first_blended, |item| wanted(item, pass).then(|| distance(item)), &mut sorted);
            sorted.iter().for_each(|(_, at)| state.issue(&items[*at as usize], geometry, pass));
        }
    }
    let blended = first_blended..items.len();
    sort(items, blended, |item| wanted(item, pass).then(|| -distance(item)), &mut sorted);
    sorted.iter().for_each(|(_, at)| state.issue(&items[*at as usize], geometry, pass));
}

/// Fills `sorted` with the draws of a range of `items`, by ascending key. Draws for which `key` returns `None` are left
/// out.
fn sort(
    items: &[Item],
    range: Range<usize>,
    key: impl Fn(&Item) -> Option<f64>,
    sorted: &mut Vec<(f64, u32)>,
) {
    sorted.clear();
    sorted.extend(range.filter_map(|at| Some((key(&items[at])?, at as u32))));
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
}

/// The render pass state set by the previous draw, so that unchanged state is not set again.
#[derive(Default)]
struct State {
    properties: Option<(PropertySet, bool)>,
    material: Option<usize>,
    /// `true` if the buffer of previous positions is bound, `false` if the current positions are bound in its place.
    /// `None` before the first draw.
    has_previous: Option<bool>,
}

impl State {
    fn issue(&mut self, item: &Item, geometry: &Geometry, pass: &mut dyn DrawPass) {
        if self.properties.is_none_or(|(properties, _)| properties != item.properties) {
            self.properties = Some((item.properties, pass.set_properties(item.properties)));
            // Another pipeline may have another layout.
            self.material = None;
        }
        if self.properties.is_some_and(|(_, may_draw)| !may_draw) {
            return;
        }
        if self.material != Some(item.draw.material) {
            self.material = Some(item.draw.material);
            pass.set_material(item.draw.material as u32);
        }
        let has_previous = geometry.has_previous(&item.part);
        if self.has_previous != Some(has_previous) {
            self.has_previous = Some(has_previous);
            geometry.bind_previous(has_previous, pass.render_pass());
        }
        pass.set_object(item.object);
        pass.render_pass().draw_indexed(item.indices(), item.part.first_vertex, 0..1);
    }
}
