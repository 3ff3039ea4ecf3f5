//! The rectangle of whole texels that holds a box in light space.
//!
//! The texel's size follows from the box alone: its size divided by the texels that are left when the border (margin
//! for filter taps) is taken off on both sides, and one more, by which laying the rectangle on a grid can move it.
//! Whatever the snap, the rectangle holds the box and the border around it.
//!
//! | snap | what is whole | a translation of the camera moves static points by |
//! |---|---|---|
//! | world | the corner's light-space coordinates, in texels, rounded down | whole texels |
//! | origin | the texel coordinates of the projected world origin, rounded to nearest | whole texels |
//! | projection | the translation of the projection, in a light view centred on the slice, rounded down | any fraction |
//! | none | nothing | any fraction |
//!
//! "world" and "origin" use one grid (for an odd resolution, two that are half a texel apart). They differ where texels
//! are left over, as on the shorter side of a tight fit: "origin" leaves as many on either side of the slice, "world"
//! all of them beyond it. "projection" is what engines do that re-centre the light view on the slice for each frame;
//! it is there to be compared with, since what it rounds does not change as the camera moves.
//!
//! Limits: a texel is at least a nanometre, or 2⁻⁴⁰ of the coordinates, since `f64` cannot count smaller ones.

use glam::DVec2;
use schemars::JsonSchema;
use serde::Deserialize;

use super::fit::Extent;

/// The grid to which the texels of a cascade are snapped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Snap {
    /// The corner in light space is rounded down to whole texels: static points move by whole texels as the camera
    /// moves.
    #[default]
    World,
    /// The projected world origin is rounded to whole texels: static points move by whole texels, too.
    Origin,
    /// The projection's translation, in a light view centred on the slice, is rounded down to whole texels (2 /
    /// resolution in clip space). Static points move by fractions of texels.
    Projection,
    /// No grid: static points move by fractions of texels.
    None,
}

/// The resolution of a cascade and the use of its texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texels {
    /// The width and height of the cascade, in texels.
    pub resolution: u32,
    /// The border on each side that stays free for filter taps, in texels.
    pub border: u32,
    /// Whether texels are as wide as they are high.
    pub square: bool,
}

/// A rectangle of whole texels in light space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// The corner of the minimum coordinates, in metres.
    pub min: DVec2,
    /// The size of a texel, in metres.
    pub texel: DVec2,
    /// The width and height of the rectangle, in metres.
    pub size: DVec2,
}

/// The rectangle of whole texels that contains an extent and the border around it, snapped to a grid.
pub fn rectangle(extent: &Extent, texels: Texels, snap: Snap) -> Rectangle {
    let Texels { resolution, border, square } = texels;
    let usable = (f64::from(resolution) - 2.0 * f64::from(border) - 1.0).max(1.0);
    let size = if square { DVec2::splat(extent.size.max_element()) } else { extent.size };
    let min = extent.min.truncate();
    let lower = (min.abs().max_element() * 2f64.powi(-40)).max(1e-9);
    let texel = (size / usable).max(DVec2::splat(power_of_two_above(lower, 1e-9)));
    let (half, border) = (0.5 * f64::from(resolution), f64::from(border));
    let center = extent.center.truncate();
    // In texels, from light space's origin to the rectangle's corner.
    let corner = min / texel - border;
    // The free texels (one at least) half to each side, so that rounding to nearest uncovers nothing.
    let centered = corner - 0.5 * (f64::from(resolution) - 2.0 * border - extent.size / texel);
    let snapped = match snap {
        Snap::World => (min / texel).floor() - border,
        Snap::Origin => -((-centered - half).round() + half),
        Snap::Projection => {
            // Rounding down moves the rectangle up by as much as one texel.
            let from_center = corner - center / texel - 1.0;
            center / texel - ((-from_center - half).floor() + half)
        }
        Snap::None => centered,
    };
    Rectangle { min: snapped * texel, texel, size: texel * f64::from(resolution) }
}

/// The smallest power of two times `unit` that is not below `lower`: constant while `lower` changes little.
fn power_of_two_above(lower: f64, unit: f64) -> f64 {
    (lower / unit).log2().ceil().exp2() * unit
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    const SNAPS: [Snap; 4] = [Snap::World, Snap::Origin, Snap::Projection, Snap::None];

    fn extent(min: DVec2, size: DVec2) -> Extent {
        let min = min.extend(0.0);
        Extent { min, size, near: 1.0, center: min + DVec3::new(0.3 * size.x, 0.6 * size.y, 0.5) }
    }

    fn texel_of(point: DVec2, rectangle: &Rectangle) -> DVec2 {
        (point - rectangle.min) / rectangle.texel
    }

    #[test]
    fn the_rectangle_holds_the_box_and_its_border_with_any_snap() {
        for snap in SNAPS {
            for (resolution, border, square) in
                [(2048, 2, true), (1023, 1, true), (16, 0, false), (64, 31, true)]
            {
                for step in 0..200 {
                    let min = DVec2::new(-17.3 + 0.137 * f64::from(step), 5.1 - 0.071 * f64::from(step));
                    let extent = extent(min, DVec2::new(20.0, 11.0));
                    let rectangle = rectangle(&extent, Texels { resolution, border, square }, snap);
                    let margin = f64::from(border) - 1e-9;
                    let low = texel_of(min, &rectangle);
                    let high = texel_of(min + extent.size, &rectangle);
                    assert!(low.min_element() >= margin, "{snap:?} {resolution} {low}");
                    assert!(
                        high.max_element() <= f64::from(resolution) - margin,
                        "{snap:?} {resolution} {high}"
                    );
                    assert_eq!(rectangle.texel.x == rectangle.texel.y, square);
                }
            }
        }
    }

    #[test]
    fn only_world_snaps_move_static_points_by_whole_texels() {
        for snap in SNAPS {
            let texels = Texels { resolution: 1024, border: 1, square: true };
            let size = DVec2::splat(51.15);
            let worst = (0..500)
                .map(|step| {
                    let moved = DVec2::new(0.0031 * f64::from(step), -0.0173 * f64::from(step));
                    let before =
                        texel_of(DVec2::ZERO, &rectangle(&extent(DVec2::splat(-20.0), size), texels, snap));
                    let after = texel_of(
                        DVec2::ZERO,
                        &rectangle(&extent(DVec2::splat(-20.0) + moved, size), texels, snap),
                    );
                    let shift = after - before;
                    (shift - shift.round()).abs().max_element()
                })
                .fold(0.0, f64::max);
            match snap {
                Snap::World | Snap::Origin => assert!(worst < 1e-6, "{snap:?} {worst}"),
                Snap::Projection | Snap::None => assert!(worst > 0.4, "{snap:?} {worst}"),
            }
        }
    }

    #[test]
    fn grids_of_world_and_origin_are_equal_or_half_a_texel_apart() {
        for (resolution, apart) in [(64, 0.0), (63, 0.5)] {
            for (snap, offset) in [(Snap::World, 0.0), (Snap::Origin, apart)] {
                let extent = extent(DVec2::new(-17.3, 5.1), DVec2::new(20.0, 11.0));
                let rectangle = rectangle(&extent, Texels { resolution, border: 2, square: true }, snap);
                let place = rectangle.min / rectangle.texel - offset;
                assert!((place - place.round()).abs().max_element() < 1e-9, "{snap:?} {resolution} {place}");
            }
        }
    }

    #[test]
    fn a_box_without_size_still_has_texels() {
        for snap in SNAPS {
            let rectangle = rectangle(
                &extent(DVec2::splat(1e6), DVec2::ZERO),
                Texels { resolution: 1, border: 4, square: true },
                snap,
            );
            let least = 1e6 * 2f64.powi(-40);
            assert!((least..2.0 * least).contains(&rectangle.texel.min_element()), "{rectangle:?}");
            assert!(rectangle.min.is_finite());
        }
    }
}
