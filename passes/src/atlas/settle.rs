//! Numbers that follow requests with hysteresis: only when these change by more than a tolerance.
//!
//! All decisions use these numbers only. While they stay, all decisions stay, even if the requested numbers vary within
//! the tolerance.

use super::request::PoolCounts;

/// The values of a light's request after hysteresis, on which all decisions depend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settled {
    pub(super) importance: f32,
    /// The size class of the preferred tile: 0 for the smallest tile, 1 more for each doubling.
    pub(super) wanted: u8,
    /// The size class of the smallest acceptable tile.
    pub(super) min: u8,
    /// The number of tiles.
    pub(super) tiles: u32,
    /// The number of slots that the light needs in each pool.
    pub(super) slots: PoolCounts,
}

/// The importance after hysteresis: `before` while `asked` is within a factor of 1 + `tolerance` of it, else `asked`.
/// NaN and negative values of `asked` count as 0.
pub(super) fn importance(before: Option<f32>, asked: f32, tolerance: f32) -> f32 {
    let asked = if asked > 0.0 { asked.min(f32::MAX) } else { 0.0 };
    let factor = 1.0 + tolerance;
    match before {
        Some(before) if asked <= before * factor && asked >= before / factor => before,
        _ => asked,
    }
}

/// The size class after hysteresis: 0 for the smallest tile, 1 more for each doubling. It stays `before` while a change
/// of `texels` by a factor of at most 1 + `tolerance` would round up to it. `min` is the side of the smallest tile in
/// texels, `max` the largest class.
pub(super) fn class(before: Option<u8>, texels: u32, min: u32, max: u8, tolerance: f32) -> u8 {
    let asked = class_of(texels, min, max);
    let Some(before) = before.filter(|before| *before <= max) else { return asked };
    let factor = 1.0 + f64::from(tolerance);
    let size = f64::from(min) * f64::from(1u32 << before);
    let texels = f64::from(texels);
    let not_larger = before == max || texels <= size * factor;
    let not_smaller = before == 0 || texels > 0.5 * size / factor;
    if not_larger && not_smaller { before } else { asked }
}

/// The smallest size class whose tiles have at least `texels` texels on a side, at most `max`. `min` is the side of the
/// smallest tile in texels.
pub(super) fn class_of(texels: u32, min: u32, max: u8) -> u8 {
    let parts = texels.div_ceil(min).max(1);
    let class = u32::BITS - (parts - 1).leading_zeros();
    (class as u8).min(max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_rounded_up_and_kept_within_the_tolerance() {
        let fresh = |texels| class(None, texels, 16, 9, 0.25);
        assert_eq!([0, 1, 16, 17, 32, 33, 8192, 8193, u32::MAX].map(fresh), [0, 0, 0, 1, 1, 2, 9, 9, 9]);
        let kept = |texels| class(Some(3), texels, 16, 9, 0.25);
        // 128 texels: kept from 64 / 1.25 to 128 · 1.25.
        assert_eq!([51, 52, 128, 160, 161, 300].map(kept), [2, 3, 3, 3, 4, 5]);
        // The ends of the range have no other side.
        assert_eq!(class(Some(0), 0, 16, 9, 0.25), 0);
        assert_eq!(class(Some(9), u32::MAX, 16, 9, 0.25), 9);
        assert_eq!(class(Some(9), 8192, 16, 4, 0.25), 4);
    }

    #[test]
    fn an_importance_is_finite_and_kept_within_the_tolerance() {
        assert_eq!(
            [f32::NAN, -1.0, 0.0, 2.0].map(|asked| importance(None, asked, 0.25)),
            [0.0, 0.0, 0.0, 2.0]
        );
        assert_eq!(importance(None, f32::INFINITY, 0.25), f32::MAX);
        assert_eq!(
            [1.61, 2.49, 1.59, 2.51].map(|asked| importance(Some(2.0), asked, 0.25)),
            [2.0, 2.0, 1.59, 2.51]
        );
        assert_eq!(importance(Some(0.0), 0.0, 0.25), 0.0);
        assert_eq!(importance(Some(f32::MAX), f32::MAX, 0.25), f32::MAX);
    }
}
