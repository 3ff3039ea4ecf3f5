//! Edges of leaves with `alpha_to_coverage`, held against the mean of 64 samples per pixel.

use crate::common::gpu::{render, scene};
use crate::common::{With, check_file, root};
use umbragraph_test_support::gpu;

const SIZE: [u32; 2] = [200, 120];
/// Samples along each side of a pixel of the reference.
const FINE: u32 = 8;

/// The linear colors of the foliage by pixel, each the mean of a square of so many.
fn foliage(features: &[(&str, &str)], samples: u32) -> Option<Vec<[f64; 3]>> {
    let gpu = gpu::device()?;
    let plain =
        [("bloom", "false"), ("ambient_occlusion", "false"), ("fxaa", "false"), ("light_filter", "\"hard\"")];
    let features: Vec<_> = plain.iter().chain(features).copied().collect();
    let with = With { features: &features, size: Some(SIZE.map(|side| side * samples)), ..With::default() };
    let outcome = check_file("pipelines/umbra.json", &with);
    let picture = render(&gpu, &outcome, &scene(&root().join("examples/scenes/foliage.glb")));
    let linear = |byte: u8| {
        let value = f64::from(byte) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let mut means = vec![[0.0; 3]; (SIZE[0] * SIZE[1]) as usize];
    for (index, pixel) in picture.rgba_pixels().enumerate() {
        let (x, y) =
            (index as u32 % (SIZE[0] * samples) / samples, index as u32 / (SIZE[0] * samples) / samples);
        for (sum, byte) in means[(y * SIZE[0] + x) as usize].iter_mut().zip(pixel) {
            *sum += linear(byte) / f64::from(samples * samples);
        }
    }
    Some(means)
}

/// The root mean square of differences in levels of 255.
fn difference(first: &[[f64; 3]], second: &[[f64; 3]]) -> f64 {
    let levels = |value: f64| {
        255.0 * if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
    };
    let squares = first.iter().flatten().zip(second.iter().flatten());
    let sum: f64 = squares.map(|(one, two)| (levels(*one) - levels(*two)).powi(2)).sum();
    (sum / (3 * first.len()) as f64).sqrt()
}

#[test]
fn alpha_to_coverage_is_closer_to_64_samples() {
    let msaa = ("msaa", "true");
    let pictures = [
        foliage(&[], FINE),
        foliage(&[], 1),
        foliage(&[msaa], 1),
        foliage(&[msaa, ("alpha_to_coverage", "true")], 1),
    ];
    let [Some(fine), Some(single), Some(without), Some(with)] = pictures else { return };
    let [single, without, with] = [single, without, with].map(|picture| difference(&picture, &fine));
    println!("levels from 64 samples: {single:.2} with one, {without:.2} with msaa, {with:.2} with coverage");
    assert!(with < 0.85 * without, "{with} instead of {without}");
}

/// Without the feature no shader has another text.
#[test]
fn coverage_that_is_off_changes_no_shader() {
    let shaders = |features: &[(&str, &str)]| -> Vec<String> {
        let outcome = check_file("pipelines/umbra.json", &With { features, ..With::default() });
        let programs = &outcome.plan().pipeline.programs;
        programs.iter().flat_map(|one| &one.variants).map(|one| one.module.wgsl.to_string()).collect()
    };
    let has_mask = |texts: &[String]| texts.iter().filter(|text| text.contains("sample_mask")).count();
    assert_eq!(has_mask(&shaders(&[("msaa", "true")])), 0);
    assert!(has_mask(&shaders(&[("msaa", "true"), ("alpha_to_coverage", "true")])) > 0);
}
