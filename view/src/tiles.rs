//! The rectangles of a texture that views are drawn into, such as the tiles of a shadow atlas.
//!
//! The views are those of the last frame, in the order in which the passes that draw them get them. A view is named
//! after the light that has its place, or, if it is orthographic, its direction.

use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::{Executor, Plan};

/// A rectangle of a texture that one view is drawn into.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    pub(crate) label: String,
    pub(crate) layer: u32,
    /// The rectangle in texels of mip level 0: x, y, width, height.
    area: [u32; 4],
}

impl Tile {
    /// The rectangle in texels of a mip level.
    pub(crate) fn area(&self, mip: u32) -> [u32; 4] {
        let [x, y, width, height] = self.area.map(|side| side >> mip.min(31));
        [x, y, width.max(1), height.max(1)]
    }
}

/// The tiles of a texture as `pass` draws them, or else the last pass that draws views into it. Empty if no view has a
/// rectangle of its own.
pub(crate) fn of(
    executor: &Executor,
    plan: &Plan,
    [texture, pass]: [&str; 2],
    input: Option<&FrameInput>,
) -> Vec<Tile> {
    let Some(resource) = plan.resources.get(texture) else { return Vec::new() };
    let drawn = plan.passes.iter().filter(|one| plan.writes(one.handle, resource.handle)).filter_map(|one| {
        let scene = plan.pipeline.pass(one.handle).work().scene()?;
        Some((one.name.as_str(), scene.views.resource))
    });
    let drawn: Vec<_> = drawn.collect();
    let chosen = drawn.iter().find(|(name, _)| *name == pass).or(drawn.last());
    let data = chosen.and_then(|(_, views)| executor.data(&plan.pipeline.resource(*views).name));
    let lights = input.map(|input| input.lights.as_slice()).unwrap_or_default();
    let views = data.map(umbragraph::data::BlackboardData::views).unwrap_or_default();
    let tiles = views.iter().enumerate().filter_map(|(at, view)| {
        let area @ [x, y, width, height] = view.viewport?;
        let has_place = |light: &&Light| match light.kind {
            LightKind::Directional => {
                view.clip_from_world.row(3).truncate().length() < 1e-9
                    && light.direction.dot(view.forward) > 0.9999
            }
            _ => light.position.distance(view.position) < 1e-3,
        };
        let light = lights.iter().find(has_place).map(|light| format!(" {}", light.name)).unwrap_or_default();
        let label = format!("{at}{light}: {width} × {height} at ({x}, {y}), layer {}", view.layer);
        Some(Tile { label, layer: view.layer, area })
    });
    tiles.collect()
}
