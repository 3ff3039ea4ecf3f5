//! The picture of a texture's texels, as captures are written to files and shown in the viewer.
//!
//! Layers lie side by side, in a square. The six faces of a cube form a row, +X −X +Y −Y +Z −Z, with one row for
//! each cube. An array of square layers whose number is a multiple of six counts as cubes, too.
//!
//! Channels between 0 and 1 are shown as they are. Depth, integers and channels with other values are stretched between
//! their first and last percentile, so that one bright light does not turn a room black. Depth of exactly 0 or 1 does
//! not count, since nothing was drawn there. The channels of a color share one range from 0. Four channels are no color
//! but, for example, moments if they are integers, negative, or more than sixteen times apart; then each has its own
//! range. Numbers of more than 8 bits get the transfer function of sRGB. A number that is not finite is magenta.

use crate::Plan;
use crate::executor::Texels;
use crate::low_level::language::TextureShape;
use crate::wgpu;

/// The gap between the layers of a texture on a sheet, in texels.
const GAP: u32 = 2;

/// The texel values of a texture as one picture, with the layers side by side.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The width, in texels.
    pub width: u32,
    /// The height, in texels.
    pub height: u32,
    /// The number of channels, from 1 to 4.
    pub channels: usize,
    /// The channel values of each pixel, row by row from the top; black in gaps.
    pub values: Vec<[f32; 4]>,
    /// For each pixel: `true` for a texel, `false` for a gap.
    is_texel: Vec<bool>,
}

/// The kind of values in a texture's texels, and the arrangement of its layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// Whether the values are depth.
    pub is_depth: bool,
    /// Whether the values are 8-bit normalised numbers, shown as they are stored.
    pub is_unorm8: bool,
    /// Whether the values are integers.
    pub is_integer: bool,
    /// Whether six layers are the faces of a cube.
    pub is_cube: bool,
}

impl Content {
    /// Returns the content of a texture of a plan; `None` for other resources.
    pub fn of(plan: &Plan, name: &str) -> Option<Self> {
        use wgpu::TextureFormat as Format;
        let resource = plan.resources.get(name)?;
        let format = resource.format?;
        let declared = plan.pipeline.resource(resource.handle).texture();
        let view = declared.and_then(|texture| texture.view_dimension);
        Some(Self {
            is_depth: format.is_depth_stencil_format(),
            is_unorm8: matches!(
                format,
                Format::R8Unorm | Format::Rg8Unorm | Format::Rgba8Unorm | Format::Bgra8Unorm
            ),
            is_integer: matches!(
                format.sample_type(None, None),
                Some(wgpu::TextureSampleType::Uint | wgpu::TextureSampleType::Sint)
            ),
            is_cube: matches!(view, Some(TextureShape::Cube | TextureShape::CubeArray)),
        })
    }
}

/// Returns `true` if a resource of a plan is a three-dimensional texture.
pub fn is_volume(plan: &Plan, name: &str) -> bool {
    let declared = plan.resources.get(name).and_then(|one| plan.pipeline.resource(one.handle).texture());
    declared.is_some_and(|texture| texture.view_dimension == Some(TextureShape::D3))
}

/// Arranges all layers of a texture side by side, or one layer if `layer` is given.
pub fn sheet(texels: &Texels, content: Content, layer: Option<u32>) -> Sheet {
    let layers: Vec<u32> = layer.map_or_else(|| (0..texels.layers).collect(), |layer| vec![layer]);
    let count = layers.len() as u32;
    let columns = match (layer, content.is_cube) {
        (None, true) => 6,
        // Cubes that shaders read as arrays.
        _ if count >= 6 && count.is_multiple_of(6) && texels.width == texels.height => 6,
        _ => (1..=count).find(|side| side * side >= count).unwrap_or(1),
    };
    let rows = count.div_ceil(columns);
    let width = columns * (texels.width + GAP) - GAP;
    let height = rows * (texels.height + GAP) - GAP;
    let mut values = vec![[0.0, 0.0, 0.0, 1.0]; width as usize * height as usize];
    let mut is_texel = vec![false; values.len()];
    for (at, layer) in (0u32..).zip(layers) {
        let (left, top) = (at % columns * (texels.width + GAP), at / columns * (texels.height + GAP));
        for y in 0..texels.height {
            let from = ((layer * texels.height + y) as usize) * texels.width as usize;
            let to = (top + y) as usize * width as usize + left as usize;
            let row = texels.width as usize;
            let Some(line) = texels.values.get(from..from + row) else { continue };
            values[to..to + row].copy_from_slice(line);
            is_texel[to..to + row].fill(true);
        }
    }
    Sheet { width, height, channels: texels.channels, values, is_texel }
}

/// The range of channel values that is shown from black to white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The value shown as black.
    pub min: f32,
    /// The value shown as white.
    pub max: f32,
}

impl Sheet {
    /// Returns the displayed range of each channel, without alpha if there are four; empty if values are shown
    /// unscaled.
    pub fn ranges(&self, content: Content) -> Vec<Range> {
        let sorted: Vec<Vec<f32>> = (0..self.channels).map(|channel| self.sorted(channel, content)).collect();
        let fits = |values: &Vec<f32>| {
            values.first().is_none_or(|min| *min >= 0.0) && values.last().is_none_or(|max| *max <= 1.0)
        };
        if content.is_unorm8 || (!content.is_depth && sorted.iter().all(fits)) {
            return Vec::new();
        }
        let of =
            |values: &Vec<f32>| match (values.get(values.len() / 100), values.get(values.len() * 99 / 100)) {
                (Some(min), Some(max)) => Range { min: *min, max: *max },
                _ => Range { min: 0.0, max: 1.0 },
            };
        let ranges: Vec<Range> = sorted.iter().map(of).collect();
        match ranges.as_slice() {
            [colors @ .., _alpha] if self.channels == 4 => {
                let max = colors.iter().fold(f32::NEG_INFINITY, |max, range| max.max(range.max));
                let is_of_color = |range: &Range| range.min >= 0.0 && range.max * 16.0 >= max;
                if content.is_integer || !colors.iter().all(is_of_color) {
                    return colors.to_vec();
                }
                vec![Range { min: 0.0, max }; 3]
            }
            _ => ranges,
        }
    }

    /// Returns the finite values of a channel that count for its range, in ascending order. Depth values of exactly 0
    /// or 1 do not count.
    fn sorted(&self, channel: usize, content: Content) -> Vec<f32> {
        let shown = self.values.iter().zip(&self.is_texel).filter(|(_, is_texel)| **is_texel);
        let values = shown.map(|(value, _)| value[channel]).filter(|value| value.is_finite());
        let mut values: Vec<f32> =
            values.filter(|value| !content.is_depth || (*value != 0.0 && *value != 1.0)).collect();
        values.sort_unstable_by(f32::total_cmp);
        values
    }

    /// Converts the sheet to RGBA with 8 bits per channel. `ranges` is the result of [`Sheet::ranges`].
    pub fn rgba(&self, content: Content, ranges: &[Range]) -> Vec<u8> {
        let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        self.values
            .iter()
            .flat_map(|value| {
                let mut shown = *value;
                if !value[..self.channels].iter().all(|one| one.is_finite()) {
                    return [255, 0, 255, 255];
                }
                for (one, range) in shown.iter_mut().zip(ranges) {
                    let span = range.max - range.min;
                    *one = if span > 0.0 { ((*one - range.min) / span).clamp(0.0, 1.0) } else { 0.5 };
                }
                if !content.is_unorm8 {
                    shown[..3].iter_mut().for_each(|one| *one = encoded(*one));
                }
                if self.channels == 1 {
                    shown = [shown[0]; 4];
                }
                // The picture of a texture is opaque: what is invisible would not be looked at.
                [byte(shown[0]), byte(shown[1]), byte(shown[2]), 255]
            })
            .collect()
    }
}

/// Returns the sRGB-encoded value of a linear number.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTH: Content = Content { is_depth: true, is_unorm8: false, is_integer: false, is_cube: false };

    fn texels(layers: u32, values: &[f32]) -> Texels {
        let height = values.len() as u32 / 2 / layers;
        Texels {
            width: 2,
            height,
            layers,
            channels: 1,
            values: values.iter().map(|one| [*one, 0.0, 0.0, 1.0]).collect(),
        }
    }

    #[test]
    fn depth_is_stretched_between_what_was_drawn() {
        let sheet = sheet(&texels(1, &[1.0, 0.25, 0.5, 0.75]), DEPTH, None);
        let ranges = sheet.ranges(DEPTH);
        assert_eq!(ranges, [Range { min: 0.25, max: 0.75 }]);
        let reds: Vec<u8> = sheet.rgba(DEPTH, &ranges).chunks(4).map(|pixel| pixel[0]).collect();
        assert_eq!(reds, [255, 0, 188, 255]);
    }

    #[test]
    fn faces_are_a_row_for_each_cube_and_layers_a_square() {
        let values = vec![0.5; 2 * 2 * 12];
        let cubes = sheet(&texels(12, &values), Content { is_cube: true, ..DEPTH }, None);
        assert_eq!((cubes.width, cubes.height), (6 * 2 + 5 * GAP, 2 * 2 + GAP));
        let layers = sheet(&texels(4, &values[..16]), DEPTH, None);
        assert_eq!((layers.width, layers.height), (2 * 2 + GAP, 2 * 2 + GAP));
        let one = sheet(&texels(4, &values[..16]), DEPTH, Some(3));
        assert_eq!((one.width, one.height), (2, 2));
    }

    #[test]
    fn layers_fill_their_cells_and_gaps_do_not_count() {
        let sheet = sheet(&texels(2, &[0.1, 0.2, 0.3, 0.4]), DEPTH, None);
        assert_eq!((sheet.width, sheet.height), (2 + GAP + 2, 1));
        let row: Vec<f32> = sheet.values.iter().map(|value| value[0]).collect();
        assert_eq!(row, [0.1, 0.2, 0.0, 0.0, 0.3, 0.4]);
        assert_eq!(sheet.ranges(DEPTH), [Range { min: 0.1, max: 0.4 }]);
    }

    #[test]
    fn colors_share_a_range_and_moments_have_their_own() {
        let content = Content { is_depth: false, ..DEPTH };
        let ranges = |second: [f32; 4]| {
            let values = vec![[0.0, 0.0, 0.0, 1.0], second];
            let texels = Texels { width: 2, height: 1, layers: 1, channels: 4, values };
            let ranges = sheet(&texels, content, None).ranges(content);
            ranges.iter().map(|range| (range.min, range.max)).collect::<Vec<_>>()
        };
        assert_eq!(ranges([2.0, 1.0, 0.5, 1.0]), [(0.0, 2.0); 3]);
        assert_eq!(ranges([2.0, 400.0, 0.5, 1.0]), [(0.0, 2.0), (0.0, 400.0), (0.0, 0.5)]);
        assert_eq!(ranges([2.0, 1.0, -0.5, 1.0]), [(0.0, 2.0), (0.0, 1.0), (-0.5, 0.0)]);
    }

    #[test]
    fn what_is_not_finite_is_magenta() {
        let content = Content { is_depth: false, ..DEPTH };
        let sheet = sheet(&texels(1, &[f32::NAN, 0.5]), content, None);
        let picture = sheet.rgba(content, &sheet.ranges(content));
        assert_eq!(picture[..4], [255, 0, 255, 255]);
        assert_eq!(picture[4], 188, "linear numbers are encoded");
    }
}
