//! The region of each cascade in the map: a layer for each, or tiles of one layer.
//!
//! With layers, every cascade draws into the layer of its index. The map is as large as the largest resolution; a
//! cascade of a smaller one uses the upper left part of its layer. With tiles, all draw into layer 0 at given texels.
//! Either way a texel of the map is found by `uv · scale + offset`, where uv runs over the cascade from its upper left
//! corner, and filter taps are kept within `uv_bounds`: the cascade's part of the map less half a texel.
//!
//! Limits: a map has at most 2¹⁶ texels on a side; whether a device takes as many is checked where the texture is.

use glam::{DVec4, UVec2};

use super::MAX_CASCADES;

/// The part of a map that one cascade draws into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tile {
    /// The index of the layer in the texture.
    pub layer: u32,
    /// The texel of the upper left corner.
    pub origin: UVec2,
    /// The width and height, in texels.
    pub resolution: u32,
}

/// The size of a shadow map, and the part of it that each cascade draws into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// The width and height of the map, in texels.
    pub map: UVec2,
    /// The part of the map for each cascade; zero from the number of cascades on.
    pub tiles: [Tile; MAX_CASCADES],
}

/// The largest side of a map, in texels.
pub const MAX_SIDE: u32 = 1 << 16;

/// The reason why the tiles of cascades do not fit a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutError {
    /// A tile reaches beyond the map.
    Outside {
        /// The tile's index.
        tile: usize,
    },
    /// Two tiles have texels in common.
    Overlap {
        /// The index of the earlier tile.
        first: usize,
        /// The index of the later tile.
        second: usize,
    },
}

impl Layout {
    /// Creates a layout with a layer for each cascade. `map` is the size of the map in texels; `None` is the largest
    /// resolution.
    pub fn layers(resolutions: &[u32], map: Option<UVec2>) -> Self {
        Self::of(resolutions, map, |at| (at as u32, UVec2::ZERO))
    }

    /// Creates a layout with a tile of layer 0 for each cascade. `map` is the size of the map in texels; `None` is the
    /// smallest that holds all tiles.
    pub fn tiles(resolutions: &[u32], origins: &[UVec2], map: Option<UVec2>) -> Self {
        Self::of(resolutions, map, |at| (0, origins.get(at).copied().unwrap_or_default()))
    }

    fn of(resolutions: &[u32], map: Option<UVec2>, place: impl Fn(usize) -> (u32, UVec2)) -> Self {
        let mut tiles = [Tile::default(); MAX_CASCADES];
        for (at, (tile, resolution)) in tiles.iter_mut().zip(resolutions).enumerate() {
            let (layer, origin) = place(at);
            *tile = Tile { layer, origin, resolution: *resolution };
        }
        let needed = tiles.iter().fold(UVec2::ONE, |size, tile| size.max(tile.end()));
        Self { map: map.unwrap_or(needed), tiles }
    }

    /// The errors in the first `count` tiles; empty if all lie inside the map and none overlap.
    pub fn errors(&self, count: usize) -> Vec<LayoutError> {
        let tiles = &self.tiles[..count.min(MAX_CASCADES)];
        let mut errors = Vec::new();
        for (at, tile) in tiles.iter().enumerate() {
            if tile.end().cmpgt(self.map).any() {
                errors.push(LayoutError::Outside { tile: at });
            }
            let first = tiles[..at].iter().position(|other| tile.overlaps(other));
            errors.extend(first.map(|first| LayoutError::Overlap { first, second: at }));
        }
        errors
    }

    /// The texels that a cascade draws into (x, y, width, height from the upper left); `None` if it is the whole map.
    pub fn viewport(&self, at: usize) -> Option<[u32; 4]> {
        let Tile { origin, resolution, .. } = self.tiles[at];
        let whole = origin == UVec2::ZERO && self.map == UVec2::splat(resolution);
        (!whole).then_some([origin.x, origin.y, resolution, resolution])
    }

    /// The transform from a cascade's uv to the map's: scale in x and y, offset in z and w.
    pub fn scale_offset(&self, at: usize) -> DVec4 {
        let (map, tile) = (self.map.as_dvec2(), &self.tiles[at]);
        let (scale, offset) = (f64::from(tile.resolution) / map, tile.origin.as_dvec2() / map);
        DVec4::new(scale.x, scale.y, offset.x, offset.y)
    }

    /// The range of uv within which filter taps of cascade `at` stay: minimum u and v, then maximum u and v.
    pub fn uv_bounds(&self, at: usize) -> DVec4 {
        let (map, tile) = (self.map.as_dvec2(), &self.tiles[at]);
        let (low, high) = ((tile.origin.as_dvec2() + 0.5) / map, (tile.end().as_dvec2() - 0.5) / map);
        DVec4::new(low.x, low.y, high.x, high.y)
    }
}

impl Tile {
    /// The texel coordinates just beyond the lower right corner.
    pub fn end(&self) -> UVec2 {
        self.origin.saturating_add(UVec2::splat(self.resolution))
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.layer == other.layer
            && self.origin.cmplt(other.end()).all()
            && other.origin.cmplt(self.end()).all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_of_its_own_is_drawn_whole_and_a_smaller_one_in_part() {
        let layout = Layout::layers(&[2048, 2048, 1024], None);
        assert_eq!(layout.map, UVec2::splat(2048));
        assert_eq!((layout.viewport(0), layout.viewport(2)), (None, Some([0, 0, 1024, 1024])));
        assert_eq!(layout.tiles[2].layer, 2);
        assert_eq!(layout.scale_offset(2), DVec4::new(0.5, 0.5, 0.0, 0.0));
        assert_eq!(layout.errors(3), []);
    }

    #[test]
    fn tiles_lie_side_by_side_or_in_a_square() {
        let row = Layout::tiles(&[1024; 3], &[UVec2::ZERO, UVec2::new(1024, 0), UVec2::new(2048, 0)], None);
        assert_eq!(row.map, UVec2::new(3072, 1024));
        assert_eq!(row.viewport(2), Some([2048, 0, 1024, 1024]));
        assert!((row.scale_offset(1) - DVec4::new(1.0 / 3.0, 1.0, 1.0 / 3.0, 0.0)).length() < 1e-12);
        let square =
            Layout::tiles(&[1024; 3], &[UVec2::ZERO, UVec2::new(1024, 0), UVec2::new(0, 1024)], None);
        assert_eq!(square.map, UVec2::splat(2048));
        let half = 0.5 / 2048.0;
        assert_eq!(square.uv_bounds(2), DVec4::new(half, 0.5 + half, 0.5 - half, 1.0 - half));
        assert_eq!(square.errors(3), []);
    }

    #[test]
    fn tiles_outside_the_map_or_on_one_another_are_found() {
        let origins = [UVec2::ZERO, UVec2::new(512, 0), UVec2::new(1025, 1024), UVec2::splat(u32::MAX)];
        let layout = Layout::tiles(&[1024; 4], &origins, Some(UVec2::splat(2048)));
        assert_eq!(
            layout.errors(4),
            [
                LayoutError::Overlap { first: 0, second: 1 },
                LayoutError::Outside { tile: 2 },
                LayoutError::Outside { tile: 3 }
            ]
        );
    }
}
