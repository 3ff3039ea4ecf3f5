//! The node kind `shadow_atlas`: the lights that cast shadows in a frame, and the places of their maps.
//!
//! Each usable light that casts shadows into the camera's view requests the resources of its kind. [`crate::atlas`]
//! grants them by importance ([`crate::importance`]), keeps tiles and slots from frame to frame, and reports lights
//! that get less than they request. The wanted sizes of the atlas and the arrays are published as sizes for textures:
//! `atlas_side`, `cube_count` and `layer_count` (see [`umbragraph_pipeline::data`]). Until the host makes a new plan,
//! lights share the existing capacity.
//!
//! Published: one element of each array for each light with shadows.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, Component, DataShape, ValueType};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, list_of};
use umbragraph_pipeline::frame::{FrameInput, Light, LightKind};
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

use super::{missing, word};
use crate::atlas::{self, Capacity, Fate, Key, Placement, Pool, PoolCounts, Request, Tile, TileRequest};
use crate::codes;
use crate::if_said::if_said;
use crate::importance::{Eye, Importance};
use crate::words::CAST_SHADOW;

/// The largest number of lights, or of shadow descriptors, that a pass can declare.
pub const MAX_CAPACITY: u32 = 4096;
/// The maximum number of cubes in a cube texture array: six layers each, at most 2048 in all.
pub const MAX_CUBES: u32 = 341;

/// The maximum number of layers in a texture array.
pub const MAX_LAYERS: u32 = 2048;

/// The maximum number of views of a frame.
pub const MAX_VIEWS: u32 = 1 << 16;

/// Decides which lights cast shadows in a frame. Spot lights get tiles of an atlas, point lights cubes of an array, and
/// directional lights layers of an array.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShadowAtlas {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// The atlas for the shadow maps of spot lights; without this key they cast no shadows.
    pub spots: Option<SpotSettings>,
    /// The cubes for the shadow maps of point lights; without this key they cast no shadows.
    pub points: Option<PointSettings>,
    /// The layers for the shadow maps of directional lights; without this key they cast no shadows.
    pub directional: Option<DirectionalSettings>,
    /// The maximum number of shadow descriptors: one for each spot or point light with shadows, and one for each
    /// cascade of a directional light.
    pub descriptors: Expr,
    /// The maximum number of shadow views: one for a spot light, six for a point light, one for each cascade of a
    /// directional light. No limit by default.
    pub views: Option<Expr>,
}

/// The shadow atlas of the spot lights. The sides of the atlas and its tiles are powers of two from 16 to 8192.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotSettings {
    /// The maximum number of spot lights with shadows; by default the value of "descriptors".
    pub capacity: Option<Expr>,
    /// The initial side of the atlas, and its minimum, in texels.
    pub min_side: Expr,
    /// The maximum side of the atlas, in texels.
    pub max_side: Expr,
    /// The minimum side of a tile, in texels. A spot light that cannot get it has no shadows.
    pub min_tile: Expr,
    /// The side of the tile for a spot light that fills the picture, in texels; other tiles are smaller.
    pub max_tile: Expr,
}

/// The cube texture array for the shadow maps of point lights.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointSettings {
    /// The maximum number of point lights with shadows, 0 to 341; each takes one cube.
    pub capacity: Expr,
}

/// The texture array for the shadow maps of directional lights.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalSettings {
    /// The maximum number of layers, 0 to 2048; with 0, directional lights cast no shadows.
    pub capacity: Expr,
    /// The number of cascades of each directional light, 1 to 8; each takes one layer.
    pub cascades: Expr,
}

/// The part of a texture that holds the shadow maps of one light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backing {
    /// A tile of the shadow atlas, for a spot light.
    Tile(Tile),
    /// A cube of the cube texture array, for a point light.
    Cube {
        /// The index of the cube in the array.
        slot: u32,
    },
    /// Consecutive layers of the texture array, for the cascades of a directional light.
    Layers {
        /// The index of the first layer.
        first: u32,
        /// The number of layers.
        count: u32,
    },
}

impl Backing {
    /// The sort order of backings: 0 for tiles, 1 for cubes, 2 for layers.
    pub(super) fn rank(self) -> u32 {
        match self {
            Self::Tile(_) => 0,
            Self::Cube { .. } => 1,
            Self::Layers { .. } => 2,
        }
    }

    /// The index of the first cube or layer, and the number of cubes or layers; (0, 1) for a tile.
    pub(super) fn slots(self) -> (u32, u32) {
        match self {
            Self::Tile(_) => (0, 1),
            Self::Cube { slot } => (slot, 1),
            Self::Layers { first, count } => (first, count),
        }
    }
}

/// A light that casts shadows in a frame, and the place of its shadow maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The index of the light in the frame's list of lights.
    pub light: u32,
    /// The part of a texture that holds the light's shadow maps.
    pub backing: Backing,
}

/// The lights with shadows in blackboard data of a `shadow_atlas`: first lights with tiles, then with cubes, then with
/// layers.
pub fn entries(data: &BlackboardData) -> impl Iterator<Item = Entry> + '_ {
    let count = word(data, "count") as usize;
    let words = |name: &str| data.words(name).unwrap_or_default().chunks_exact(4);
    words("entry").zip(words("tile")).take(count).filter_map(|(entry, tile)| {
        let backing = match entry[1] {
            0 => Backing::Tile(Tile { x: tile[0], y: tile[1], size: tile[2] }),
            1 => Backing::Cube { slot: entry[2] },
            2 => Backing::Layers { first: entry[2], count: entry[3] },
            _ => return None,
        };
        Some(Entry { light: entry[0], backing })
    })
}

/// The names and types of the values that blackboard data of a `shadow_atlas` has.
pub(crate) fn expected() -> [(&'static str, ValueType); 4] {
    let numbers = ValueType::vector(Component::U32, 4).array(0);
    [("count", ValueType::U32), ("entry", numbers), ("tile", numbers), ("atlas_side", ValueType::U32)]
}

/// Compares two lights independently of their positions in the frame: by name, then by kind, then by their numbers.
pub fn compare(a: &Light, b: &Light) -> Ordering {
    let numbers = |light: &Light| {
        let ([x, y, z], [u, v, w]) = (light.position.to_array(), light.direction.to_array());
        let [red, green, blue] = light.color.to_array().map(f64::from);
        let (inner, outer) = match light.kind {
            LightKind::Spot { inner_angle, outer_angle } => (inner_angle, outer_angle),
            LightKind::Directional | LightKind::Point => (0.0, 0.0),
        };
        let (intensity, range) = (f64::from(light.intensity), f64::from(light.range));
        [x, y, z, u, v, w, red, green, blue, f64::from(inner), f64::from(outer), intensity, range]
    };
    let by_numbers = || {
        let (a, b) = (numbers(a), numbers(b));
        a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    };
    a.name.cmp(&b.name).then_with(|| rank(a).cmp(&rank(b))).then_with(by_numbers)
}

/// The sort order of lights by kind: 0 for directional lights, 1 for spot lights, 2 for point lights.
pub(super) fn rank(light: &Light) -> u32 {
    match light.kind {
        LightKind::Directional => 0,
        LightKind::Spot { .. } => 1,
        LightKind::Point => 2,
    }
}

/// Evaluates a whole number from 1 to `max`; returns `None` after a diagnostic.
pub(crate) fn capacity(pass: &mut PassBuilder<'_>, expr: &Expr, pointer: &str, max: u32) -> Option<u32> {
    count_between(pass, expr, pointer, 1, max)
}

/// Evaluates a whole number from `min` to `max`; returns `None` after a diagnostic.
fn count_between(pass: &mut PassBuilder<'_>, expr: &Expr, pointer: &str, min: u32, max: u32) -> Option<u32> {
    let count = pass.count(expr, pointer)?;
    if (min..=max).contains(&count) {
        return Some(count);
    }
    let help = format!("write a whole number from {min} to {max}");
    pass.reject(codes::LIGHT_CAPACITY, pointer, format!("{count} is out of range here"), help)
}

impl Node for ShadowAtlas {
    const NAME: &'static str = "shadow_atlas";
    const SUMMARY: &'static str =
        "Decides which lights cast shadows, and gives them tiles of an atlas, cubes and layers.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let descriptors = capacity(pass, &self.descriptors, "/descriptors", MAX_CAPACITY);
        let views = if_said(&self.views, |expr| capacity(pass, expr, "/views", u32::MAX));
        let spots = match &self.spots {
            Some(spots) => atlas(pass, spots, descriptors)?,
            None => (0, atlas_of([16, 16], [16, 16])),
        };
        let cubes = if_said(&self.points, |points| {
            count_between(pass, &points.capacity, "/points/capacity", 0, MAX_CUBES)
        });
        let directional = if_said(&self.directional, |directional| {
            let layers = count_between(pass, &directional.capacity, "/directional/capacity", 0, MAX_LAYERS);
            let max = crate::cascades::MAX_CASCADES as u32;
            let cascades = capacity(pass, &directional.cascades, "/directional/cascades", max);
            room_for_a_directional_light(pass, layers, cascades)
        });
        let (descriptors, views, cubes) = (descriptors?, views?.unwrap_or(u32::MAX), cubes?.unwrap_or(0));
        let (layers, cascades) = directional?.unwrap_or((0, 1));
        let (spots, atlas) = spots;
        let directional = layers / cascades;
        let node = RunShadowAtlas { atlas, spots, cubes, directional, cascades, descriptors, views };
        let output = pass.publish(&self.to, "/to", shape(descriptors, atlas.min_side, cascades))?;
        pass.produce(Work::Cpu(CpuWork::new(node, output, Vec::new())))
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", shape(1, 1, 1))]
    }
}

/// Returns the numbers of layers and cascades. Returns `None` after a diagnostic, which also reports too few layers for
/// one directional light. 0 layers are allowed: directional lights then cast no shadows.
fn room_for_a_directional_light(
    pass: &mut PassBuilder<'_>,
    layers: Option<u32>,
    cascades: Option<u32>,
) -> Option<(u32, u32)> {
    let (layers, cascades) = layers.zip(cascades)?;
    if (1..cascades).contains(&layers) {
        let message = format!(
            "no directional light fits: each has {cascades} cascades, and there is room for {layers}"
        );
        let help =
            format!("give directional lights at least {cascades} layers, or 0 where they cast no shadows");
        return pass.reject(codes::LIGHT_CAPACITY, "/directional/capacity", message, help);
    }
    Some((layers, cascades))
}

/// Evaluates the maximum number of spot lights and the settings of their atlas; returns `None` after a diagnostic.
fn atlas(
    pass: &mut PassBuilder<'_>,
    spots: &SpotSettings,
    descriptors: Option<u32>,
) -> Option<(u32, atlas::Settings)> {
    let capacity = match &spots.capacity {
        Some(expr) => count_between(pass, expr, "/spots/capacity", 0, MAX_CAPACITY),
        None => descriptors,
    };
    let mut side = |expr: &Expr, pointer: &str| {
        let side = pass.count(expr, pointer)?;
        if side.is_power_of_two() && (16..=8192).contains(&side) {
            return Some(side);
        }
        let key = pointer.rsplit('/').next().unwrap_or(pointer);
        let message = format!("\"{key}\" is {side} texels, not a power of two from 16 to 8192");
        pass.reject(codes::LIGHT_CAPACITY, pointer, message, "write a power of two from 16 to 8192")
    };
    let min_side = side(&spots.min_side, "/spots/min_side")?;
    let max_side = side(&spots.max_side, "/spots/max_side")?;
    let min_tile = side(&spots.min_tile, "/spots/min_tile")?;
    let max_tile = side(&spots.max_tile, "/spots/max_tile")?;
    let capacity = capacity?;
    for ((small, low), (large, high)) in [
        (("min_side", min_side), ("max_side", max_side)),
        (("min_tile", min_tile), ("max_tile", max_tile)),
        (("min_tile", min_tile), ("min_side", min_side)),
    ] {
        if low > high {
            let message = format!("\"{small}\" ({low} texels) is larger than \"{large}\" ({high} texels)");
            let help = format!("raise \"{large}\", or lower \"{small}\"");
            return pass.reject(codes::LIGHT_CAPACITY, &format!("/spots/{small}"), message, help);
        }
    }
    Some((capacity, atlas_of([min_side, max_side], [min_tile, max_tile])))
}

/// The settings for an atlas with a minimum and maximum side, and a minimum and maximum side of its tiles, in texels.
fn atlas_of([min_side, max_side]: [u32; 2], [min_tile, max_tile]: [u32; 2]) -> atlas::Settings {
    atlas::Settings { min_side, max_side, min_tile, max_tile, ..atlas::Settings::default() }
}

/// The shape of the published data for up to `descriptors` descriptors. The initial texture sizes are an atlas with a
/// side of `atlas_side` texels, one cube, and `cascades` layers.
fn shape(descriptors: u32, atlas_side: u32, cascades: u32) -> DataShape {
    let numbers = ValueType::vector(Component::U32, 4).array(descriptors);
    DataShape::new()
        .value("count", ValueType::U32, "the lights with shadows")
        .value(
            "entry",
            numbers,
            "position among the frame's lights; 0 for a tile, 1 for a cube, 2 for layers; first slot or layer; their number",
        )
        .value("tile", numbers, "x, y and side of the tile, in texels from the top left")
        .value(
            "label",
            numbers,
            "sixteen letters of the light's name, upper case ASCII, the first in the lowest byte",
        )
        .value("atlas_side", ValueType::U32, "the side of the atlas that the tiles were placed in, texels")
        .size("atlas_side", atlas_side)
        .size("cube_count", 1)
        .size("layer_count", cascades)
}

/// The evaluated settings of a `shadow_atlas` pass, with which it runs on the CPU.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RunShadowAtlas {
    /// The sides of the atlas and its tiles, in texels.
    atlas: atlas::Settings,
    spots: u32,
    cubes: u32,
    directional: u32,
    cascades: u32,
    descriptors: u32,
    views: u32,
}

impl RunShadowAtlas {
    /// The number of slots of each pool; `cubes` and `layers` are the numbers of existing cubes and layers.
    fn pools(&self, cubes: u32, layers: u32) -> PoolCounts {
        Pool::counts(&[
            (Pool::Descriptors, self.descriptors),
            (Pool::Views, self.views.min(MAX_VIEWS)),
            (Pool::Cubes, cubes),
            (Pool::Layers, layers),
            (Pool::Spots, self.spots),
        ])
    }

    /// Returns `true` if the settings allow shadows for lights of this kind.
    fn has_room(&self, light: &Light) -> bool {
        match light.kind {
            LightKind::Spot { .. } => self.spots > 0,
            LightKind::Point => self.cubes > 0,
            LightKind::Directional => self.directional > 0,
        }
    }

    /// The tiles and slots that a light requests; `None` if the settings allow no shadows for lights of its kind.
    fn wants(&self, light: &Light, importance: &Importance) -> Option<(TileRequest, PoolCounts)> {
        use Pool::{Cubes, Descriptors, Layers, Spots, Views};
        let none = TileRequest::NONE;
        Some(match light.kind {
            LightKind::Spot { .. } if self.spots > 0 => {
                let wanted = importance.texels(self.atlas.max_tile).max(self.atlas.min_tile);
                let tiles = TileRequest { count: 1, wanted, min: self.atlas.min_tile };
                (tiles, Pool::counts(&[Descriptors, Views, Spots].map(|pool| (pool, 1))))
            }
            LightKind::Point if self.cubes > 0 => {
                (none, Pool::counts(&[(Descriptors, 1), (Views, 6), (Cubes, 1)]))
            }
            LightKind::Directional if self.directional > 0 => {
                (none, Pool::counts(&[Descriptors, Views, Layers].map(|pool| (pool, self.cascades))))
            }
            _ => return None,
        })
    }
}

#[derive(Debug, Default)]
struct State {
    /// The current placement; `None` before the first frame.
    placement: Option<Placement>,
    /// The indices of the lights with requests, in the frame's list of lights.
    asking: Vec<u32>,
    requests: Vec<Request>,
    /// The published entries, sorted by backing, then by name.
    entries: Vec<Entry>,
    /// Whether the last notices report that no light casts shadows.
    said_dark: bool,
}

impl CpuNode for RunShadowAtlas {
    type State = State;

    fn run(&self, state: &mut State, context: &CpuContext<'_>, data: &mut BlackboardData) {
        let State { placement, asking, requests, entries, said_dark } = state;
        let max_layers = self.directional * self.cascades;
        let placement = placement.get_or_insert_with(|| {
            let max_pools = self.pools(self.cubes, max_layers);
            Placement::new(atlas::Settings { max_pools, ..self.atlas })
        });
        self.ask(context.frame, asking, requests);
        let side = data.planned_size("atlas_side");
        let (cubes, layers) = (data.planned_size("cube_count"), data.planned_size("layer_count"));
        let pools = self.pools(cubes.min(self.cubes), layers.min(max_layers));
        placement.update(requests, &Capacity { side, pools });
        let wanted = placement.wanted();
        data.want_size("atlas_side", wanted.side.max(self.atlas.min_side));
        data.want_size("cube_count", wanted.pools[Pool::Cubes as usize].max(1));
        data.want_size("layer_count", wanted.pools[Pool::Layers as usize].max(1));
        let lights = &context.frame.lights;
        entries.clear();
        for (light, (request, grant)) in asking.iter().zip(requests.iter().zip(placement.grants())) {
            if matches!(grant.fate, Fate::Evicted(_)) {
                continue;
            }
            let first = |pool: Pool| grant.first_slots[pool as usize];
            let count = |pool: Pool| request.slots[pool as usize];
            let backing = match grant.tiles.first() {
                Some(tile) => Backing::Tile(*tile),
                None if count(Pool::Cubes) > 0 => Backing::Cube { slot: first(Pool::Cubes) },
                None => Backing::Layers { first: first(Pool::Layers), count: count(Pool::Layers) },
            };
            entries.push(Entry { light: *light, backing });
        }
        entries.sort_unstable_by(|a, b| {
            let of = |entry: &Entry| &lights[entry.light as usize];
            a.backing.rank().cmp(&b.backing.rank()).then_with(|| compare(of(a), of(b)))
        });
        publish(entries, lights, side, data);
        // Lights that could cast shadows here, where none does.
        let dark = || lights.iter().filter(|light| light.check().is_none() && self.has_room(light));
        let is_dark = dark().next().is_some() && !dark().any(|light| light.has(CAST_SHADOW));
        if placement.fates_changed() || *said_dark != is_dark {
            let mut notices = notices(asking, lights, placement);
            notices.extend(is_dark.then(|| missing::casting_light(dark())));
            data.set_notices(notices);
            *said_dark = is_dark;
        }
    }
}

impl RunShadowAtlas {
    /// Collects the requests of all lights that cast shadows and reach something in the camera's view.
    fn ask(&self, frame: &FrameInput, asking: &mut Vec<u32>, requests: &mut Vec<Request>) {
        asking.clear();
        requests.clear();
        let Some(eye) = Eye::new(&frame.camera) else { return };
        let casts = |light: &Light| light.has(CAST_SHADOW) && light.check().is_none();
        asking.extend((0..frame.lights.len() as u32).filter(|at| casts(&frame.lights[*at as usize])));
        let of = |at: &u32| &frame.lights[*at as usize];
        asking.sort_unstable_by(|a, b| compare(of(a), of(b)));
        let mut name = "";
        let mut occurrence = 0;
        asking.retain(|at| {
            let light = of(at);
            occurrence = if light.name == name { occurrence + 1 } else { 0 };
            name = &light.name;
            let importance = eye.importance(light);
            let Some((tiles, slots)) = self.wants(light, &importance) else { return false };
            if importance.coverage <= 0.0 {
                return false;
            }
            let key = Key::of(&light.name, occurrence);
            requests.push(Request { key, importance: importance.value(), tiles, slots });
            true
        });
    }
}

fn publish(entries: &[Entry], lights: &[Light], side: u32, data: &mut BlackboardData) {
    data.set_u32("count", entries.len() as u32);
    data.set_u32("atlas_side", side);
    let words = entries.iter().flat_map(|entry| {
        let (first, count) = entry.backing.slots();
        [entry.light, entry.backing.rank(), first, count]
    });
    data.set_words("entry", words);
    let tiles = entries.iter().flat_map(|entry| match entry.backing {
        Backing::Tile(tile) => [tile.x, tile.y, tile.size, 0],
        _ => [0; 4],
    });
    data.set_words("tile", tiles);
    data.set_words("label", entries.iter().flat_map(|entry| label(&lights[entry.light as usize].name)));
}

/// Builds notices that name the lights with less than they request: one notice for each reason.
fn notices(asking: &[u32], lights: &[Light], placement: &Placement) -> Diagnostics {
    let mut by_reason: BTreeMap<(u32, String), Vec<String>> = BTreeMap::new();
    for (light, grant) in asking.iter().zip(placement.grants()) {
        let name = &lights[*light as usize].name;
        let (rank, reason, name) = match grant.fate {
            Fate::Granted => continue,
            Fate::Downsized { from, to } => {
                let reason = "the shadow atlas is full".to_owned();
                (0, reason, format!("\"{name}\" ({to} instead of {from} texels)"))
            }
            Fate::Evicted(why) => (1, why.to_string(), format!("\"{name}\"")),
        };
        by_reason.entry((rank, reason)).or_default().push(name);
    }
    let notice = |((rank, reason), names): ((u32, String), Vec<String>)| {
        let lights = if names.len() == 1 { "light has" } else { "lights have" };
        let (fate, help) = match rank {
            0 => (
                "smaller shadow maps than they ask for",
                "let the atlas grow larger, or the largest tile be smaller",
            ),
            _ => ("no shadows", "raise the limit, or give what matters more priority"),
        };
        let message = format!("{} {lights} {fate}, since {reason}: {}", names.len(), list_of(names));
        Diagnostic::warning(codes::SHADOWS_LEFT_OUT, Place::Nowhere, message).help(help)
    };
    by_reason.into_iter().map(notice).collect()
}

/// The first sixteen characters of a name in upper case ASCII, padded with spaces; the first is in the lowest byte.
/// Other characters become `?`.
fn label(name: &str) -> [u32; 4] {
    let mut bytes = [b' '; 16];
    for (byte, letter) in bytes.iter_mut().zip(name.chars()) {
        *byte =
            if letter == ' ' || letter.is_ascii_graphic() { letter.to_ascii_uppercase() as u8 } else { b'?' };
    }
    std::array::from_fn(|at| u32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[4 * at + byte])))
}
