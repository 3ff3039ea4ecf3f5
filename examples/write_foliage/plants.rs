//! Plants of cut-out cards, and the textures that they are cut out by.

use std::f64::consts::TAU;

use crate::glb::functions::{cos, power, sin, sin_cos};
use crate::glb::noise::{between, unit};
use crate::glb::png::{Color, paletted, ramp};
use crate::glb::solids::tube;
use crate::glb::{Placement, Shape, Vec3, vec3};

const SIDE: u32 = 128;

/// The leaf texture as a PNG file: a spray of seven pointed leaves.
pub(crate) fn leaf_texture() -> Vec<u8> {
    cut_out(&[[28, 62, 18], [74, 120, 36], [140, 168, 64]], |px, py| {
        (0..7_i64).find_map(|leaf| {
            let (a, b) = (unit(leaf, 11), unit(leaf, 12));
            let angle = TAU * (leaf as f64 / 7.0 + 0.05 * a);
            let (sine, cosine) = sin_cos(angle);
            let (x, y) = (px - 0.5, py - 0.5);
            // 0 at the stem, 1 at the tip.
            let along = (x * cosine + y * sine) / (0.40 + 0.08 * b);
            let across = (y * cosine - x * sine) / 0.12;
            let width =
                if (0.0..1.0).contains(&along) { power(along * (1.0 - along) * 4.0, 0.8) } else { 0.0 };
            let vein = if across.abs() < 0.06 { 0.2 } else { 0.0 };
            (across.abs() < width && along > 0.02).then_some(0.35 + 0.3 * b + vein - 0.15 * across.abs())
        })
    })
}

/// The grass texture as a PNG file: nine blades, broad at the bottom.
pub(crate) fn grass_texture() -> Vec<u8> {
    cut_out(&[[44, 66, 18], [96, 128, 40], [158, 170, 78]], |px, py| {
        let height = 1.0 - py;
        (0..9_i64).find_map(|blade| {
            let (a, b, c) = (unit(blade, 31), unit(blade, 32), unit(blade, 33));
            let top = 0.55 + 0.42 * a;
            let middle = (blade as f64 + 0.5) / 9.0 + 0.16 * (b - 0.5) * height * height * 4.0;
            let width = 0.045 * (1.0 - height / top);
            (height < top && (px - middle).abs() < width).then_some(0.25 + 0.4 * c + 0.3 * height)
        })
    })
}

/// A PNG texture with the colour ramp `stops` for values from 0 to 1, and holes where `value` returns `None`. The
/// arguments of `value` run from 0 to 1, to the right and downwards.
fn cut_out(stops: &[[u8; 3]; 3], value: impl Fn(f64, f64) -> Option<f64>) -> Vec<u8> {
    let mut palette: Vec<Color> = ramp(63, stops);
    let hidden = palette.len() as u8;
    // What filtering mixes in at the edges is the plant's own colour.
    palette.push([stops[1][0], stops[1][1], stops[1][2], 0]);
    paletted(SIDE, SIDE, &palette, |x, y| {
        let at = |texel: u32| (f64::from(texel) + 0.5) / f64::from(SIDE);
        value(at(x), at(y)).map_or(hidden, |value| (value.clamp(0.0, 1.0) * 62.0).round() as u8)
    })
}

/// A textured rectangle in the XY plane that rises from the origin. Sizes are in metres.
fn card(width: f64, height: f64) -> Shape {
    let mut card = Shape::new();
    let x = 0.5 * width;
    card.textured_polygon(&[
        (vec3(-x, 0.0, 0.0), [0.0, 1.0]),
        (vec3(x, 0.0, 0.0), [1.0, 1.0]),
        (vec3(x, height, 0.0), [1.0, 0.0]),
        (vec3(-x, height, 0.0), [0.0, 0.0]),
    ]);
    card
}

/// `count` leaf cards of about `size` metres at random places in a box.
pub(crate) fn cards(count: i64, low: Vec3, high: Vec3, size: f64, seed: i64) -> Shape {
    let mut shape = Shape::new();
    for at in 0..count {
        let random = |low: f64, high: f64, which: i64| between(low, high, at, seed * 16 + which);
        let size = size * random(0.7, 1.3, 4);
        let place =
            Placement::at(random(low.x, high.x, 0), random(low.y, high.y, 1), random(low.z, high.z, 2))
                .turned_y(random(0.0, 360.0, 5))
                .turned_x(random(-80.0, 80.0, 3));
        shape.add(&card(size, size), &place);
    }
    shape
}

/// A tree of `height` metres: the trunk with boughs, and the crown of leaf cards.
pub(crate) fn tree(height: f64, seed: i64) -> (Shape, Shape) {
    let bend = |t: f64| vec3(0.18 * sin(2.0 * t + seed as f64), t * height, 0.12 * sin(3.0 * t));
    let path = |from: f64, to: f64, thick: f64| -> Vec<(Vec3, f64)> {
        (0..=6)
            .map(|step| {
                let t = from + (to - from) * f64::from(step) / 6.0;
                (bend(t), thick * (1.15 - t))
            })
            .collect()
    };
    let mut trunk = tube(&path(0.0, 0.85, 0.13), 9, false);
    let mut crown = Shape::new();
    for bough in 0..6_i64 {
        let t = 0.42 + 0.07 * bough as f64;
        let from = bend(t);
        let angle = TAU * (0.38 * bough as f64 + unit(bough, 70 + seed));
        let reach = 0.30 * height * (1.05 - 0.5 * t);
        let tip = from + vec3(reach * cos(angle), 0.14 * height, reach * sin(angle));
        let middle = from + (tip - from) * 0.5 + vec3(0.0, -0.02 * height, 0.0);
        trunk.join(&tube(&[(from, 0.05), (middle, 0.036), (tip, 0.012)], 6, false));
        let around = 0.17 * height;
        let (low, high) = (tip - vec3(around, 0.6 * around, around), tip + vec3(around, around, around));
        crown.join(&cards(26, low, high, 0.42, 100 + 10 * seed + bough));
    }
    let top = bend(0.9);
    let around = vec3(0.16 * height, 0.14 * height, 0.16 * height);
    crown.join(&cards(34, top - around, top + around, 0.42, 190 + seed));
    (trunk, crown)
}

/// A fern: fronds around the origin that lean outwards.
pub(crate) fn fern(seed: i64) -> Shape {
    let mut shape = Shape::new();
    for frond in 0..11_i64 {
        let turn = 360.0 * frond as f64 / 11.0 + between(-12.0, 12.0, frond, 300 + seed);
        let place = Placement::IDENTITY.turned_y(turn).turned_x(between(28.0, 62.0, frond, 320 + seed));
        shape.add(&card(0.34, between(0.6, 0.9, frond, 340 + seed)), &place);
    }
    shape
}

/// A tuft of grass: three crossed cards.
pub(crate) fn tuft() -> Shape {
    let mut shape = Shape::new();
    for turn in 0..3 {
        shape.add(&card(0.4, 0.32), &Placement::IDENTITY.turned_y(60.0 * f64::from(turn)).turned_x(8.0));
    }
    shape
}
