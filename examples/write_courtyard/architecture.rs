//! Columns, arches, walls, towers and stairs.

use crate::glb::functions::sin_cos;
use crate::glb::solids::{arch_panel, block, lathe, prism, standing};
use crate::glb::{Placement, Shape, vec3};

/// The height of a column of the arcade with base and capital, in metres.
pub(crate) const COLUMN_HEIGHT: f64 = 2.9;
/// The distance between the axes of two columns of the arcade, in metres.
pub(crate) const BAY: f64 = 4.0;
/// The height of the wall above the columns without its cornice, in metres.
pub(crate) const SPANDREL_HEIGHT: f64 = 2.2;

/// A column of the arcade with plinth, moulded base, swelling shaft and capital.
pub(crate) fn column() -> Shape {
    let shaft = lathe(
        &[
            (0.36, 0.16),
            (0.39, 0.20),
            (0.39, 0.25),
            (0.34, 0.29),
            (0.30, 0.32),
            (0.33, 0.36),
            (0.31, 0.40),
            (0.27, 0.43),
            (0.275, 1.2),
            (0.25, 1.9),
            (0.22, 2.36),
            (0.25, 2.38),
            (0.25, 2.42),
            (0.22, 2.44),
            (0.24, 2.56),
            (0.35, 2.72),
        ],
        18,
    );
    Shape::new()
        .joined(&standing(0.84, 0.16, 0.84))
        .joined(&shaft)
        .and(&standing(0.78, 0.18, 0.78), &Placement::at(0.0, 2.72, 0.0))
}

/// One bay of the wall above the columns, centred on the Y axis, with its foot at y = 0. Its arch opens along Z.
pub(crate) fn arcade_bay() -> Shape {
    arch_panel(BAY, SPANDREL_HEIGHT, 1.62, 0.12, 0.62, 16, false)
}

/// The raised bands around the arch of a bay, on both faces.
pub(crate) fn archivolts() -> Shape {
    let band = archivolt(1.62, 1.80, 0.06, 16);
    [(0.31, 0.0), (-0.31, 180.0)]
        .into_iter()
        .fold(Shape::new(), |shape, (z, turn)| shape.and(&band, &Placement::at(0.0, 0.12, z).turned_y(turn)))
}

/// A half ring around the origin in the XY plane that protrudes by `depth` from the wall towards +Z.
fn archivolt(inner: f64, outer: f64, depth: f64, segments: u32) -> Shape {
    let mut band = Shape::new();
    let at = |step: u32| sin_cos(std::f64::consts::PI * f64::from(step) / f64::from(segments));
    for step in 0..segments {
        let ((s0, c0), (s1, c1)) = (at(step), at(step + 1));
        let point = |radius: f64, (s, c): (f64, f64), z: f64| vec3(radius * c, radius * s, z);
        let (a, b) = ((s0, c0), (s1, c1));
        band.polygon(&[
            point(inner, a, depth),
            point(outer, a, depth),
            point(outer, b, depth),
            point(inner, b, depth),
        ]);
        band.polygon(&[
            point(outer, a, depth),
            point(outer, a, 0.0),
            point(outer, b, 0.0),
            point(outer, b, depth),
        ]);
        band.polygon(&[
            point(inner, b, depth),
            point(inner, b, 0.0),
            point(inner, a, 0.0),
            point(inner, a, depth),
        ]);
    }
    band
}

/// A cornice along X that protrudes on both sides of a wall, `depth` thick around the XY plane.
pub(crate) fn cornice(length: f64, depth: f64) -> Shape {
    let half = 0.5 * depth;
    let profile = [
        (0.0, 0.46),
        (-half - 0.20, 0.28),
        (-half - 0.20, 0.18),
        (-half - 0.10, 0.08),
        (-half - 0.03, 0.0),
        (half + 0.03, 0.0),
        (half + 0.10, 0.08),
        (half + 0.20, 0.18),
        (half + 0.20, 0.28),
    ];
    prism(&profile, -0.5 * length, 0.5 * length).placed(&Placement::IDENTITY.turned_y(90.0))
}

/// Battlements along X on a wall, `depth` thick around the XY plane. `width` and `height` are those of a merlon.
pub(crate) fn battlements(length: f64, depth: f64, width: f64, height: f64) -> Shape {
    let count = (length / (2.0 * width)).floor();
    let step = (length - width) / count;
    let mut shape = Shape::new();
    for at in 0..=count as u32 {
        let x = -0.5 * length + 0.5 * width + step * f64::from(at);
        let merlon = standing(width, height, depth)
            .and(&roof(width + 0.1, 0.16, depth + 0.1), &Placement::at(0.0, height, 0.0));
        shape.add(&merlon, &Placement::at(x, 0.0, 0.0));
    }
    shape
}

/// A gable roof over a rectangle, with its ridge along X.
fn roof(width: f64, height: f64, depth: f64) -> Shape {
    let half = 0.5 * depth;
    prism(&[(-half, 0.0), (half, 0.0), (0.0, height)], -0.5 * width, 0.5 * width)
        .placed(&Placement::IDENTITY.turned_y(90.0))
}

/// A straight flight of steps that rises along −Z from z = 0, centred on the Y axis. Sizes are in metres.
pub(crate) fn steps(width: f64, count: u32, rise: f64, tread: f64) -> Shape {
    let mut shape = Shape::new();
    let depth = f64::from(count) * tread;
    for step in 0..count {
        let (y, z) = (f64::from(step) * rise, -f64::from(step) * tread);
        let nosing = if step == 0 { 0.0 } else { 0.03 };
        shape.join(&block(vec3(-0.5 * width, y, -depth), vec3(0.5 * width, y + rise, z + nosing)));
    }
    shape
}

/// A square pyramid over the origin.
pub(crate) fn pyramid(width: f64, height: f64) -> Shape {
    let (half, tip) = (0.5 * width, vec3(0.0, height, 0.0));
    let corner =
        [vec3(-half, 0.0, half), vec3(half, 0.0, half), vec3(half, 0.0, -half), vec3(-half, 0.0, -half)];
    let mut shape = Shape::new();
    for at in 0..4 {
        let (a, b) = (corner[at], corner[(at + 1) % 4]);
        let length = ((half * half) + height * height).sqrt();
        shape.textured_polygon(&[
            (a, [-half / 1.2, 0.0]),
            (b, [half / 1.2, 0.0]),
            (tip, [0.0, -length / 1.2]),
        ]);
    }
    shape.polygon(&[corner[3], corner[2], corner[1], corner[0]]);
    shape
}

/// The body of a square tower: a shaft with bands and slits, and an open belfry with an arch on each side.
pub(crate) fn tower_body(width: f64, height: f64) -> Shape {
    let belfry = 4.4;
    let shaft = height - belfry;
    let mut shape = standing(width, shaft, width);
    for y in [0.0, shaft * 0.45, shaft - 0.35] {
        shape.add(&standing(width + 0.3, 0.35, width + 0.3), &Placement::at(0.0, y, 0.0));
    }
    let panel = arch_panel(width, belfry, width * 0.27, 1.9, 0.7, 12, true);
    for side in 0..4 {
        let turn = Placement::IDENTITY.turned_y(90.0 * f64::from(side));
        let outward = turn.direction(vec3(0.0, 0.0, 0.5 * width - 0.35));
        let corner_to_corner = if side % 2 == 0 { 1.0 } else { (width - 1.4) / width };
        let place = Placement { origin: outward + vec3(0.0, shaft, 0.0), ..turn };
        shape.add(&panel, &place.scaled(corner_to_corner, 1.0, 1.0));
        for (y, x) in [(shaft * 0.25, -0.9), (shaft * 0.25, 0.9), (shaft * 0.7, 0.0)] {
            let frame = turn.point(vec3(x, y, 0.5 * width));
            shape.add(&slit_frame(), &Placement { origin: frame, ..turn });
        }
    }
    shape
}

/// The protruding frame around a slit window of the tower.
fn slit_frame() -> Shape {
    Shape::new()
        .joined(&block(vec3(-0.34, 0.0, 0.0), vec3(-0.16, 1.7, 0.14)))
        .joined(&block(vec3(0.16, 0.0, 0.0), vec3(0.34, 1.7, 0.14)))
        .joined(&block(vec3(-0.46, 1.7, 0.0), vec3(0.46, 1.95, 0.22)))
        .joined(&block(vec3(-0.46, -0.2, 0.0), vec3(0.46, 0.0, 0.22)))
}

/// One bay of the aqueduct: a large arch with three small arches on top. `width` is in metres.
pub(crate) fn aqueduct_bay(width: f64) -> Shape {
    let mut bay = arch_panel(width, 11.0, width * 0.38, 6.2, 2.2, 10, true);
    bay.add(&standing(width, 0.5, 2.8), &Placement::at(0.0, 11.0, 0.0));
    let small = width / 3.0;
    let upper = arch_panel(small, 2.8, small * 0.36, 1.0, 1.6, 6, true);
    for at in [-1.0, 0.0, 1.0] {
        bay.add(&upper, &Placement::at(at * small, 11.5, 0.0));
    }
    bay.and(&standing(width, 0.6, 2.0), &Placement::at(0.0, 14.3, 0.0))
}
