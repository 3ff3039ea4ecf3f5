//! Mip levels, averaged in linear light.
//!
//! Each level halves the one before it (rounding down, at least 1) by a box filter. Numbers, such as those of normal
//! maps, are averaged channel by channel. Colours are decoded from sRGB before
//! they are averaged and encoded again afterwards: averaging encoded values darkens fine patterns. They are weighted by
//! alpha, so that the colour of invisible texels does not bleed into the edges of masks. Where a side is odd, its last
//! texel belongs to the last box, which then is three texels wide: nothing is left out.

use crate::texture::Image;

/// The mip levels of an image after level 0, down to 1 × 1: width and height in texels, and four bytes (RGBA) per
/// texel. If `is_srgb` is `true`, colours are averaged in linear light and encoded as sRGB again.
pub fn levels(image: &Image, is_srgb: bool) -> Vec<(u32, u32, Vec<u8>)> {
    let decode = is_srgb.then(decode_table);
    let mut levels: Vec<(u32, u32, Vec<u8>)> = Vec::new();
    let (mut width, mut height) = (image.width, image.height);
    while width > 1 || height > 1 {
        let source = levels.last().map_or(&image.rgba, |(_, _, texels)| texels);
        let half = halve(source, width, height, decode.as_ref());
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        levels.push((width, height, half));
    }
    levels
}

fn halve(source: &[u8], width: u32, height: u32, decode: Option<&[f32; 256]>) -> Vec<u8> {
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let mut half = Vec::with_capacity(half_width as usize * half_height as usize * 4);
    for y in 0..half_height {
        for x in 0..half_width {
            let (mut weighted, mut plain, mut alpha, mut count) = ([0.0; 3], [0.0; 3], 0.0, 0.0);
            for row in extent(y, half_height, height) {
                for column in extent(x, half_width, width) {
                    let at = (row as usize * width as usize + column as usize) * 4;
                    let Some([red, green, blue, opacity]) =
                        source.get(at..at + 4).and_then(|texel| texel.first_chunk())
                    else {
                        continue;
                    };
                    let opacity = f32::from(*opacity);
                    for (part, value) in [red, green, blue].into_iter().enumerate() {
                        let value = decode.map_or(f32::from(*value), |decode| decode[usize::from(*value)]);
                        weighted[part] += value * opacity;
                        plain[part] += value;
                    }
                    alpha += opacity;
                    count += 1.0;
                }
            }
            let is_weighted = decode.is_some() && alpha > 0.0;
            let color =
                if is_weighted { weighted.map(|sum| sum / alpha) } else { plain.map(|sum| sum / count) };
            half.extend(
                color.map(|value| if decode.is_some() { encode(value) } else { value.round() as u8 }),
            );
            half.push((alpha / count).round() as u8);
        }
    }
    half
}

/// The range of texels of the larger level, along one axis, that are averaged for texel `at` of the smaller level.
/// `boxes` and `texels` are the sizes of the smaller and the larger level.
fn extent(at: u32, boxes: u32, texels: u32) -> std::ops::Range<u32> {
    at * 2..if at + 1 == boxes { texels } else { at * 2 + 2 }
}

fn decode_table() -> [f32; 256] {
    std::array::from_fn(|value| {
        let encoded = value as f32 / 255.0;
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    })
}

fn encode(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, rgba: Vec<u8>) -> Image {
        Image { name: String::new(), width, height, rgba }
    }

    #[test]
    fn black_and_white_average_to_half_the_light_not_half_the_code() {
        let checker = image(2, 2, [[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]].concat());
        assert_eq!(levels(&checker, true), [(1, 1, vec![188, 188, 188, 255])]);
    }

    #[test]
    fn numbers_average_channel_by_channel() {
        let two = image(2, 1, [[0, 128, 255, 0], [255, 128, 1, 255]].concat());
        assert_eq!(levels(&two, false), [(1, 1, vec![128, 128, 128, 128])]);
    }

    #[test]
    fn invisible_texels_do_not_color_the_edge_of_a_mask() {
        let edge = image(2, 1, [[200, 100, 50, 255], [0, 0, 0, 0]].concat());
        assert_eq!(levels(&edge, true), [(1, 1, vec![200, 100, 50, 128])]);
    }

    #[test]
    fn odd_sides_lose_no_texel_and_end_at_one_by_one() {
        let white = image(5, 3, vec![255; 60]);
        let sizes: Vec<(u32, u32)> =
            levels(&white, true).iter().map(|(width, height, _)| (*width, *height)).collect();
        assert_eq!(sizes, [(2, 1), (1, 1)]);
        let narrow = levels(&image(1, 4, vec![255; 16]), true);
        assert_eq!(narrow.iter().map(|level| (level.0, level.1)).collect::<Vec<_>>(), [(1, 2), (1, 1)]);
        let mut last_column = image(3, 1, vec![0; 12]);
        last_column.rgba[8..].fill(255);
        assert_eq!(levels(&last_column, true)[0].2[3], 85, "a third of the coverage");
    }

    #[test]
    fn one_color_stays_one_color_on_every_level() {
        for value in [0, 1, 7, 90, 128, 254, 255] {
            let flat = image(8, 8, [value, value, value, 255].repeat(64));
            assert!(
                levels(&flat, true)
                    .iter()
                    .all(|(_, _, texels)| texels.chunks(4).all(|texel| texel == [value, value, value, 255]))
            );
        }
    }
}
