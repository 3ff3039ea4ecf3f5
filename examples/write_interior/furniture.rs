//! Furniture that stands on the floor around the origin, its front towards +Z.

use crate::glb::noise::between;
use crate::glb::solids::{beam, block, rod, standing};
use crate::glb::{Placement, Shape, vec3};

/// A table, 1.8 m by 0.9 m, with slender legs.
pub(crate) fn table() -> Shape {
    let mut shape = block(vec3(-0.9, 0.71, -0.45), vec3(0.9, 0.75, 0.45));
    for (x, z) in [(-0.84, -0.39), (0.84, -0.39), (-0.84, 0.39), (0.84, 0.39)] {
        shape.join(&beam(vec3(0.95 * x, 0.71, 0.95 * z), vec3(x, 0.0, z), 0.05));
    }
    shape
}

/// A chair with legs 3 cm thick and a back of bars.
pub(crate) fn chair() -> Shape {
    let mut shape = block(vec3(-0.21, 0.43, -0.21), vec3(0.21, 0.46, 0.21));
    for (x, z, height) in [(-0.19, -0.19, 0.9), (0.19, -0.19, 0.9), (-0.19, 0.19, 0.44), (0.19, 0.19, 0.44)] {
        shape.add(&standing(0.03, height, 0.03), &Placement::at(x, 0.0, z));
    }
    shape.join(&block(vec3(-0.19, 0.84, -0.205), vec3(0.19, 0.9, -0.18)));
    for bar in -2..=2 {
        let x = 0.075 * f64::from(bar);
        shape.join(&rod(vec3(x, 0.46, -0.192), vec3(x, 0.85, -0.192), 0.008, 6));
    }
    shape
}

/// A shelf, 1.6 m wide and 2 m high, with books.
pub(crate) fn shelf() -> Shape {
    let mut shape = Shape::new();
    for x in [-0.8, -0.02, 0.77] {
        shape.join(&block(vec3(x, 0.0, -0.15), vec3(x + 0.03, 2.0, 0.15)));
    }
    for board in 0..6 {
        let y = 0.39 * f64::from(board);
        shape.join(&block(vec3(-0.8, y, -0.15), vec3(0.8, y + 0.03, 0.15)));
    }
    for board in 0..5_i64 {
        let mut x = -0.74;
        for book in 0..30_i64 {
            let width = between(0.02, 0.055, book, 40 + board);
            if x + width > 0.72 {
                break;
            }
            // Some are missing, and the upright in the middle stays free.
            let stands =
                between(0.0, 1.0, book, 50 + board) > 0.22 && !(-0.08..0.03).contains(&(x + 0.5 * width));
            if stands {
                let (height, depth) =
                    (between(0.2, 0.33, book, 60 + board), between(0.0, 0.1, book, 70 + board));
                let y = 0.39 * board as f64 + 0.03;
                shape.join(&block(vec3(x, y, -0.13), vec3(x + 0.92 * width, y + height, depth)));
            }
            x += width;
        }
    }
    shape
}

/// An upright ladder, 2.4 m high.
pub(crate) fn ladder() -> Shape {
    let mut shape = Shape::new();
    for x in [-0.22, 0.22] {
        shape.add(&standing(0.03, 2.4, 0.05), &Placement::at(x, 0.0, 0.0));
    }
    for rung in 1..9 {
        let y = 0.26 * f64::from(rung);
        shape.join(&rod(vec3(-0.22, y, 0.0), vec3(0.22, y, 0.0), 0.014, 8));
    }
    shape
}

/// A railing along X, `length` metres long, with bars 1.6 cm thick.
pub(crate) fn rail(length: f64) -> Shape {
    let mut shape = Shape::new();
    let bars = (length / 0.12).round() as i32;
    let end = 0.5 * length;
    for (y, width) in [(0.95, 0.05), (0.08, 0.03)] {
        shape.join(&beam(vec3(-end, y, 0.0), vec3(end, y, 0.0), width));
    }
    for bar in 0..=bars {
        let x = -end + length * f64::from(bar) / f64::from(bars);
        shape.join(&rod(vec3(x, 0.0, 0.0), vec3(x, 0.95, 0.0), 0.008, 6));
    }
    shape
}

/// A sofa made of blocks.
pub(crate) fn sofa() -> Shape {
    let mut shape = block(vec3(-0.9, 0.12, -0.4), vec3(0.9, 0.42, 0.42));
    for (low, high) in [
        (vec3(-0.9, 0.42, -0.4), vec3(0.9, 0.82, -0.18)),
        (vec3(-1.05, 0.08, -0.4), vec3(-0.9, 0.6, 0.42)),
        (vec3(0.9, 0.08, -0.4), vec3(1.05, 0.6, 0.42)),
    ] {
        shape.join(&block(low, high));
    }
    for (x, z) in [(-0.98, -0.33), (0.98, -0.33), (-0.98, 0.35), (0.98, 0.35)] {
        shape.add(&standing(0.05, 0.1, 0.05), &Placement::at(x, 0.0, z));
    }
    shape
}

/// An upright picture frame of four bars around the origin, 3 cm deep. Sizes are those of the opening, in metres.
pub(crate) fn frame(width: f64, height: f64) -> Shape {
    let (x, y, bar) = (0.5 * width, 0.5 * height, 0.04);
    let mut shape = block(vec3(-x - bar, y, -0.005), vec3(x + bar, y + bar, 0.025));
    for (low, high) in [
        (vec3(-x - bar, -y - bar, -0.005), vec3(x + bar, -y, 0.025)),
        (vec3(-x - bar, -y, -0.005), vec3(-x, y, 0.025)),
        (vec3(x, -y, -0.005), vec3(x + bar, y, 0.025)),
    ] {
        shape.join(&block(low, high));
    }
    shape
}
