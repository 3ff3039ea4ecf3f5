//! Numbers of a texture: ranges, histograms, and the difference of two.

use umbragraph::executor::Texels;

/// The number of bars of a histogram.
pub(crate) const BARS: usize = 64;

/// The statistics of one channel of a texture; range and mean count finite values only.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Channel {
    pub(crate) min: f32,
    pub(crate) max: f32,
    pub(crate) mean: f64,
    /// The number of NaN or infinite values.
    pub(crate) not_finite: usize,
    /// The histogram: the number of finite values in each of [`BARS`] equal parts of the range.
    pub(crate) bars: Vec<u32>,
}

/// The statistics of each channel, for one layer or, with `None`, for all layers.
pub(crate) fn channels(texels: &Texels, layer: Option<u32>) -> Vec<Channel> {
    let values = layer_values(texels, layer);
    (0..texels.channels).map(|channel| statistics(values.iter().map(|value| value[channel]))).collect()
}

/// The texel values of one layer or, with `None`, of all layers.
fn layer_values(texels: &Texels, layer: Option<u32>) -> &[[f32; 4]] {
    let Some(layer) = layer else { return &texels.values };
    let count = texels.width as usize * texels.height as usize;
    let start = layer as usize * count;
    texels.values.get(start..start + count).unwrap_or_default()
}

fn statistics(values: impl Iterator<Item = f32> + Clone) -> Channel {
    let (mut min, mut max, mut sum, mut count, mut not_finite) =
        (f32::INFINITY, f32::NEG_INFINITY, 0.0, 0u32, 0);
    for value in values.clone() {
        if value.is_finite() {
            (min, max) = (min.min(value), max.max(value));
            sum += f64::from(value);
            count += 1;
        } else {
            not_finite += 1;
        }
    }
    let mut bars = vec![0; BARS];
    if count == 0 {
        return Channel { min: 0.0, max: 0.0, mean: 0.0, not_finite, bars };
    }
    for value in values.filter(|value| value.is_finite()) {
        bars[bar_of(value, min, max)] += 1;
    }
    Channel { min, max, mean: sum / f64::from(count), not_finite, bars }
}

/// The index of the histogram bar for a value between `min` and `max`.
fn bar_of(value: f32, min: f32, max: f32) -> usize {
    let span = f64::from(max) - f64::from(min);
    let part = if span > 0.0 { (f64::from(value) - f64::from(min)) / span } else { 0.0 };
    ((part * BARS as f64) as usize).min(BARS - 1)
}

/// The absolute difference of two textures for each texel and channel; `None` if their sizes differ.
pub(crate) fn difference(one: &Texels, other: &Texels) -> Option<Texels> {
    let size = |texels: &Texels| [texels.width, texels.height, texels.layers];
    if size(one) != size(other) {
        return None;
    }
    let channels = one.channels.max(other.channels);
    let apart = |(a, b): (&[f32; 4], &[f32; 4])| {
        let [red, green, blue, alpha] = std::array::from_fn(|channel| (a[channel] - b[channel]).abs());
        [red, green, blue, if channels == 4 { alpha } else { 1.0 }]
    };
    let values = one.values.iter().zip(&other.values).map(apart).collect();
    Some(Texels { channels, values, ..one.clone() })
}

/// The texels of one channel alone.
pub(crate) fn channel(texels: &Texels, channel: usize) -> Texels {
    let one = |value: &[f32; 4]| [value[channel.min(3)], 0.0, 0.0, 1.0];
    Texels { channels: 1, values: texels.values.iter().map(one).collect(), ..texels.clone() }
}

/// Texels whose alpha is added to the picture: each colour channel is at least as large as the fourth channel. A
/// picture shows no alpha, and a difference of alpha alone would be black.
pub(crate) fn with_visible_alpha(texels: Texels) -> Texels {
    if texels.channels < 4 {
        return texels;
    }
    let visible = |value: &[f32; 4]| value.map(|one| one.max(value[3]));
    Texels { values: texels.values.iter().map(visible).collect(), ..texels }
}

/// The texels of a rectangle (x, y, width, height) of one layer; `None` if none of it lies within the texture.
pub(crate) fn part(texels: &Texels, layer: u32, [x, y, width, height]: [u32; 4]) -> Option<Texels> {
    let (width, height) =
        (width.min(texels.width.checked_sub(x)?), height.min(texels.height.checked_sub(y)?));
    if width == 0 || height == 0 || layer >= texels.layers {
        return None;
    }
    let row = |y: u32| {
        let start =
            (layer as usize * texels.height as usize + y as usize) * texels.width as usize + x as usize;
        texels.values.get(start..start + width as usize).unwrap_or_default().iter().copied()
    };
    let values = (y..y + height).flat_map(row).collect();
    Some(Texels { width, height, layers: 1, values, ..texels.clone() })
}

/// Formats a number briefly for the inspector.
pub(crate) fn shown(number: f32) -> String {
    let size = number.abs();
    if number == 0.0 || !number.is_finite() {
        format!("{number}")
    } else if (1e-3..1e6).contains(&size) {
        let text = format!("{number:.5}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{number:.4e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texels(values: &[f32]) -> Texels {
        let values: Vec<_> = values.iter().map(|one| [*one, 0.0, 0.0, 1.0]).collect();
        Texels { width: 2, height: 1, layers: values.len() as u32 / 2, channels: 1, values }
    }

    #[test]
    fn a_histogram_counts_each_finite_value_once() {
        let texels = texels(&[1.0, 3.0, 3.0, 5.0, f32::NAN, f32::INFINITY]);
        let channel = &channels(&texels, None)[0];
        assert_eq!((channel.min, channel.max, channel.mean, channel.not_finite), (1.0, 5.0, 3.0, 2));
        assert_eq!((channel.bars[0], channel.bars[BARS / 2], channel.bars[BARS - 1]), (1, 2, 1));
        assert_eq!(channel.bars.iter().sum::<u32>(), 4);
        let layer = &channels(&texels, Some(0))[0];
        assert_eq!((layer.min, layer.max), (1.0, 3.0));
    }

    #[test]
    fn a_difference_is_how_far_values_are_apart() {
        let apart = difference(&texels(&[1.0, 4.0]), &texels(&[3.0, 4.0])).unwrap();
        assert_eq!([apart.values[0][0], apart.values[1][0]], [2.0, 0.0]);
        assert!(difference(&texels(&[1.0, 4.0]), &texels(&[1.0, 2.0, 3.0, 4.0])).is_none());
    }

    #[test]
    fn a_difference_of_alpha_alone_is_seen() {
        let of = |alpha| Texels { channels: 4, values: vec![[0.5, 0.0, 0.0, alpha]; 2], ..texels(&[0.0; 2]) };
        let apart = difference(&of(1.0), &of(0.25)).unwrap();
        assert_eq!((apart.channels, apart.values[0]), (4, [0.0, 0.0, 0.0, 0.75]));
        assert_eq!(with_visible_alpha(apart.clone()).values[0][..3], [0.75; 3]);
        assert_eq!(channel(&apart, 3).values[0][0], 0.75);
    }

    #[test]
    fn a_part_is_a_rectangle_of_one_layer() {
        let two = texels(&[1.0, 2.0, 3.0, 4.0]);
        let part_of =
            |layer, area| part(&two, layer, area).map(|one| one.values.iter().map(|one| one[0]).collect());
        assert_eq!(part_of(1, [1, 0, 5, 1]), Some(vec![4.0]));
        assert_eq!(part_of(0, [0, 0, 2, 9]), Some(vec![1.0, 2.0]));
        assert_eq!([part_of(2, [0, 0, 1, 1]), part_of(0, [2, 0, 1, 1])], [None::<Vec<f32>>, None]);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [shown(0.5), shown(1e-7), shown(12.0), shown(f32::NAN)],
            ["0.5", "1.0000e-7", "12", "NaN"]
        );
    }
}
