//! Panels that dock: tabs around the frame that can be moved, split, resized, closed and opened again.
//!
//! A closed panel keeps its place. The frame takes whatever space the others leave: those beside it keep their sizes in
//! points when the window changes, or when another panel opens.

use std::collections::BTreeMap;

use eframe::egui::{self, Color32, Id, Sense, Stroke, StrokeKind, vec2};
use egui_tiles::{
    Behavior, Container, EditAction, LinearDir, SimplificationOptions, TabState, Tabs, Tile, TileId, Tiles,
    Tree, UiResponse,
};

use crate::app::Viewer;

/// The height of a bar of tabs, and the gap between panels, in points.
const BAR: f32 = 24.0;
const GAP: f32 = 2.0;

/// The minimum size of the frame beside other panels, in points.
const FRAME: f32 = 160.0;

/// A panel of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Pane {
    Frame,
    Values,
    Graph,
    Times,
    Notices,
    Inspector,
}

impl Pane {
    pub(crate) const ALL: [Self; 6] =
        [Self::Frame, Self::Values, Self::Graph, Self::Times, Self::Notices, Self::Inspector];

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Frame => "Frame",
            Self::Values => "Values",
            Self::Graph => "Graph",
            Self::Times => "Times",
            Self::Notices => "Notices",
            Self::Inspector => "Inspector",
        }
    }

    /// The size of a panel that was never resized, in points: its width beside the frame, its height above or below.
    fn size(self) -> egui::Vec2 {
        match self {
            Self::Values => vec2(420.0, 300.0),
            Self::Inspector => vec2(400.0, 420.0),
            _ => vec2(420.0, 252.0),
        }
    }

    /// The identity of the panel's focus: the keyboard goes from there to the first control.
    fn id(self) -> Id {
        Id::unique(("panel", self))
    }
}

/// The layout of the panels.
pub(crate) struct Dock {
    /// `None` while the panels are being shown.
    tree: Option<Tree<Pane>>,
    /// The panels to open or close before the next frame.
    asked: Vec<(Pane, bool)>,
    /// The panels in view in the last frame, in their order.
    shown: Vec<Pane>,
    /// The sizes of tiles beside the frame that the user has chosen, in points.
    sizes: BTreeMap<u64, f32>,
    /// The tile of the frame, which is never closed.
    frame: TileId,
}

impl Default for Dock {
    fn default() -> Self {
        let mut tiles = Tiles::default();
        let [frame, values, graph, times, notices, inspector] = Pane::ALL.map(|pane| tiles.insert_pane(pane));
        let alone = frame;
        let [frame, values, inspector] =
            [frame, values, inspector].map(|one| tiles.insert_tab_tile(vec![one]));
        let below = tiles.insert_tab_tile(vec![graph, times, notices]);
        let middle = tiles.insert_vertical_tile(vec![frame, below]);
        let root = tiles.insert_horizontal_tile(vec![values, middle, inspector]);
        let mut dock = Self {
            tree: Some(Tree::new(Id::unique("panels"), root, tiles)),
            asked: Vec::new(),
            shown: Vec::new(),
            sizes: BTreeMap::new(),
            frame: alone,
        };
        dock.asked.extend([Pane::Times, Pane::Notices, Pane::Inspector].map(|pane| (pane, false)));
        dock.asked.push((Pane::Graph, true));
        dock
    }
}

impl Dock {
    /// Returns `true` if a panel is in view: open, and not behind another tab.
    pub(crate) fn is_shown(&self, pane: Pane) -> bool {
        self.shown.contains(&pane)
    }

    /// Returns `true` if a panel is open, in view or behind another tab.
    pub(crate) fn is_open(&self, pane: Pane) -> bool {
        let tree = self.tree.as_ref();
        tree.is_some_and(|tree| tree.tiles.find_pane(&pane).is_some_and(|tile| tree.is_visible(tile)))
    }

    /// Opens a panel and brings it into view, or closes it.
    pub(crate) fn open(&mut self, pane: Pane, is_open: bool) {
        self.asked.push((pane, is_open));
    }

    /// The panels in view, in their order.
    pub(crate) fn shown(&self) -> &[Pane] {
        &self.shown
    }

    /// Gives the keyboard to the panel that comes `by` panels after the one that has it; to the first one if none has.
    pub(crate) fn focus(&self, context: &egui::Context, by: isize) {
        let count = self.shown.len().max(1) as isize;
        let focused = context.memory(|memory| memory.focused());
        let rect_of = |id: Id| context.read_response(id).map(|response| response.rect);
        let place = focused.and_then(rect_of).map(|rect| rect.center());
        let at = self.shown.iter().position(|pane| {
            focused == Some(pane.id())
                || place.is_some_and(|place| rect_of(pane.id()).is_some_and(|rect| rect.contains(place)))
        });
        let next = at.map_or(0, |at| (at as isize + by).rem_euclid(count) as usize);
        if let Some(pane) = self.shown.get(next) {
            context.memory_mut(|memory| memory.request_focus(pane.id()));
        }
    }

    /// Carries out what was asked for, and takes the tree to show it in an area of the given size.
    fn begin(&mut self, area: egui::Vec2) -> Option<Tree<Pane>> {
        let mut tree = self.tree.take()?;
        for (pane, is_open) in std::mem::take(&mut self.asked) {
            if let Some(tile) = tree.tiles.find_pane(&pane) {
                tree.set_visible(tile, is_open);
                if is_open {
                    tree.make_active(|one, _| one == tile);
                }
            }
        }
        self.fit(&mut tree, area);
        Some(tree)
    }

    /// Gives the tiles beside the frame their sizes, and the frame the rest.
    fn fit(&self, tree: &mut Tree<Pane>, mut area: egui::Vec2) {
        for (parent, on_way) in way(tree, self.frame) {
            let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get(parent) else {
                continue;
            };
            let axis = usize::from(linear.dir == LinearDir::Vertical);
            let visible = |one: &TileId| tree.tiles.is_visible_in_layout(*one);
            let children: Vec<TileId> = linear.children.iter().copied().filter(visible).collect();
            let others = children.iter().copied().filter(|one| *one != on_way);
            let mut sizes: Vec<(TileId, f32)> = others
                .map(|one| {
                    let sides = panes(&tree.tiles, one).into_iter().map(|pane| pane.size()[axis]);
                    let usual = sides.fold(0.0, f32::max);
                    (one, self.sizes.get(&one.0).copied().unwrap_or(usual))
                })
                .collect();
            let room = area[axis] - GAP * children.len().saturating_sub(1) as f32;
            let sum: f32 = sizes.iter().map(|one| one.1).sum();
            let scale = ((room - FRAME).max(0.0) / sum.max(1.0)).min(1.0);
            sizes.iter_mut().for_each(|one| one.1 *= scale);
            area[axis] = (room - sum * scale).max(1.0);
            sizes.push((on_way, area[axis]));
            if let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get_mut(parent) {
                sizes.into_iter().for_each(|(one, size)| linear.shares.set_share(one, size));
            }
        }
    }

    /// Puts the tree back. `is_resized` stores the sizes of the tiles beside the frame.
    fn end(&mut self, tree: Tree<Pane>, shown: Vec<Pane>, is_resized: bool) {
        self.shown = shown;
        if is_resized {
            for (parent, on_way) in way(&tree, self.frame) {
                let Some(Tile::Container(Container::Linear(linear))) = tree.tiles.get(parent) else {
                    continue;
                };
                // The shares are sizes in points, which the drag has changed.
                let others = linear.children.iter().filter(|one| **one != on_way);
                let sizes = others.filter(|one| tree.tiles.is_visible_in_layout(**one));
                self.sizes.extend(sizes.map(|one| (one.0, linear.shares[*one])));
            }
        }
        self.tree = Some(tree);
    }
}

/// The containers from the root to a tile, each with its child on the way.
fn way(tree: &Tree<Pane>, tile: TileId) -> Vec<(TileId, TileId)> {
    let mut way = Vec::new();
    let mut child = tile;
    while let Some(parent) = tree.tiles.parent_of(child) {
        way.push((parent, child));
        child = parent;
    }
    way.reverse();
    way
}

/// The open panels in a tile.
fn panes(tiles: &Tiles<Pane>, tile: TileId) -> Vec<Pane> {
    match tiles.get(tile).filter(|_| tiles.is_visible(tile)) {
        Some(Tile::Pane(pane)) => vec![*pane],
        Some(Tile::Container(container)) => {
            container.children().flat_map(|child| panes(tiles, *child)).collect()
        }
        None => Vec::new(),
    }
}

impl Viewer {
    /// Shows the panels in the area that the bars leave.
    pub(crate) fn panels(&mut self, ui: &mut egui::Ui) {
        let Some(mut tree) = self.dock.begin(ui.available_size()) else { return };
        let mut panels = Panels { viewer: self, shown: Vec::new(), is_resized: false };
        tree.ui(&mut panels, ui);
        let Panels { shown, is_resized, .. } = panels;
        self.dock.end(tree, shown, is_resized);
    }

    /// Closes a panel. The inspector forgets its selection.
    pub(crate) fn close_panel(&mut self, pane: Pane) {
        if pane == Pane::Inspector {
            self.inspector.selected = None;
        }
        self.dock.open(pane, false);
    }
}

/// The contents and the look of the panels.
struct Panels<'a> {
    viewer: &'a mut Viewer,
    shown: Vec<Pane>,
    is_resized: bool,
}

impl Behavior<Pane> for Panels<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        self.shown.push(*pane);
        let rect = ui.max_rect();
        let focus = ui.interact(rect, pane.id(), Sense::focusable_noninteractive());
        let viewer = &mut *self.viewer;
        viewer.places.note(&format!("panel {}", pane.title()), &focus);
        if *pane == Pane::Frame {
            viewer.frame(ui);
        } else {
            ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
            egui::Frame::new().inner_margin(egui::Margin::symmetric(8, 6)).show(ui, |ui| {
                ui.set_min_size(ui.available_size());
                match pane {
                    Pane::Values => viewer.values_panel(ui),
                    Pane::Graph => viewer.graph_panel(ui),
                    Pane::Times => viewer.times_panel(ui),
                    Pane::Notices => viewer.notices(ui),
                    Pane::Inspector => viewer.inspect(ui),
                    Pane::Frame => {}
                }
            });
        }
        if focus.has_focus() {
            let stroke = Stroke::new(2.0, FOCUS);
            ui.painter().rect_stroke(rect, 0.0, stroke, StrokeKind::Inside);
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile).is_some_and(|pane| *pane != Pane::Frame)
    }

    fn on_tab_close(&mut self, tiles: &mut Tiles<Pane>, tile: TileId) -> bool {
        if let Some(pane) = tiles.get_pane(&tile) {
            self.viewer.close_panel(*pane);
        }
        // It keeps its place.
        false
    }

    fn on_tab_button(
        &mut self,
        tiles: &mut Tiles<Pane>,
        tile: TileId,
        response: egui::Response,
    ) -> egui::Response {
        if let Some(pane) = tiles.get_pane(&tile) {
            self.viewer.places.note(&format!("tab {}", pane.title()), &response);
        }
        response
    }

    /// A whole row of tabs is not dragged, so that the keyboard does not stop at its background.
    fn is_tile_draggable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile).is_some()
    }

    /// The frame alone needs no title.
    fn is_tab_bar_visible(&self, _: TileId, tabs: &Tabs) -> bool {
        tabs.children != [self.viewer.dock.frame]
    }

    fn tab_bar_height(&self, _: &egui::Style) -> f32 {
        BAR
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        GAP
    }

    fn min_size(&self) -> f32 {
        80.0
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn tab_bar_color(&self, visuals: &egui::Visuals) -> Color32 {
        visuals.extreme_bg_color.lerp_to_gamma(visuals.panel_fill, 0.5)
    }

    fn tab_outline_stroke(&self, _: &egui::Visuals, _: &Tiles<Pane>, _: TileId, _: &TabState) -> Stroke {
        Stroke::NONE
    }

    fn on_edit(&mut self, action: EditAction) {
        self.is_resized |= action == EditAction::TileResized;
    }
}

/// The colour around a panel, a pass or a resource that has the keyboard.
pub(crate) const FOCUS: Color32 = Color32::from_rgb(120, 175, 255);
