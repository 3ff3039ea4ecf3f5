//! Plants, cloth and the land around.

use crate::glb::functions::{power, sin, sin_cos};
use crate::glb::noise::{between, fractal, unit};
use crate::glb::solids::rod;
use crate::glb::{Placement, Shape, Vec3, vec3};

/// A square textured with a spray of leaves, 1 m wide, around the origin in the XY plane.
fn card() -> Shape {
    let mut card = Shape::new();
    card.textured_polygon(&[
        (vec3(-0.5, -0.5, 0.0), [0.0, 1.0]),
        (vec3(0.5, -0.5, 0.0), [1.0, 1.0]),
        (vec3(0.5, 0.5, 0.0), [1.0, 0.0]),
        (vec3(-0.5, 0.5, 0.0), [0.0, 0.0]),
    ]);
    card
}

/// `count` leaf cards of about `size` metres at random places in a box. About half lie nearly flat; the others are
/// upright.
pub(crate) fn foliage(count: i64, low: Vec3, high: Vec3, size: f64, seed: i64) -> Shape {
    let mut shape = Shape::new();
    let card = card();
    for at in 0..count {
        let random = |low: f64, high: f64, which: i64| between(low, high, at, seed * 16 + which);
        let (x, y, z) = (random(low.x, high.x, 0), random(low.y, high.y, 1), random(low.z, high.z, 2));
        let tilt =
            if unit(at, seed * 16 + 5) < 0.55 { random(-125.0, -55.0, 3) } else { random(-30.0, 30.0, 3) };
        let size = size * random(0.7, 1.25, 4);
        let place = Placement::at(x, y, z)
            .turned_y(random(0.0, 360.0, 6))
            .turned_x(tilt)
            .turned_z(random(0.0, 360.0, 7));
        shape.add(&card, &place.scaled(size, size, size));
    }
    shape
}

/// A cypress of height 1 m, to be scaled: a slender crown of uneven lobes on a short trunk.
pub(crate) fn cypress() -> Shape {
    const SEGMENTS: u32 = 12;
    const RINGS: u32 = 16;
    let point = |ring: u32, segment: u32| {
        let (t, segment) = (f64::from(ring) / f64::from(RINGS), segment % SEGMENTS);
        let angle = std::f64::consts::TAU * f64::from(segment) / f64::from(SEGMENTS);
        let bulge = 0.095 * power(1.0 - t, 0.75) * power((t * 4.0).min(1.0), 0.6);
        let ragged = if ring == 0 || ring == RINGS {
            1.0
        } else {
            1.0 + 0.36 * (unit(ring.into(), i64::from(segment) + 77) - 0.5)
        };
        let lift = 0.03 * (unit(segment.into(), i64::from(ring) + 177) - 0.5);
        let (sin, cos) = sin_cos(angle);
        vec3(
            bulge * ragged * sin,
            0.06 + 0.94 * t + if ring == 0 || ring == RINGS { 0.0 } else { lift },
            bulge * ragged * cos,
        )
    };
    let crown = Shape::surface(RINGS, SEGMENTS, |ring, segment| {
        let around = point(ring.clamp(1, RINGS - 1), segment + 1)
            - point(ring.clamp(1, RINGS - 1), segment + SEGMENTS - 1);
        let up = point((ring + 1).min(RINGS), segment) - point(ring.saturating_sub(1), segment);
        (point(ring, segment), around.cross(up).normalize_or(Vec3::Y))
    });
    crown.joined(&rod(vec3(0.0, -0.05, 0.0), vec3(0.0, 0.12, 0.0), 0.015, 7))
}

/// A hanging cloth, 1 m wide and 3 m high, with its upper edge through the origin. It waves slightly out of the XY
/// plane.
pub(crate) fn hanging_banner() -> Shape {
    const COLUMNS: u32 = 6;
    const ROWS: u32 = 10;
    let height = |column: u32, row: u32| {
        let (u, v) = (f64::from(column) / f64::from(COLUMNS), f64::from(row) / f64::from(ROWS));
        vec3(u - 0.5, -3.0 * v, v * (0.10 * sin(u * 7.0 + v * 4.0) + 0.06 * sin(v * 9.0)))
    };
    let mut shape = Shape::surface(ROWS, COLUMNS, |row, column| {
        let row = ROWS - row;
        let across = height(column + 1, row) - height(column, row);
        let up = height(column, row) - height(column, row + 1);
        (height(column, row), across.cross(up).normalize_or(Vec3::Y))
    });
    for (at, vertex) in shape.vertices.iter_mut().enumerate() {
        let (row, column) = (at as u32 / (COLUMNS + 1), at as u32 % (COLUMNS + 1));
        vertex.texcoord = [f64::from(column) / f64::from(COLUMNS), 1.0 - f64::from(row) / f64::from(ROWS)];
    }
    shape
}

/// A triangular pennant that hangs from the origin, its upper edge along X.
pub(crate) fn pennant() -> Shape {
    let mut shape = Shape::new();
    shape.polygon(&[vec3(-0.16, 0.0, 0.0), vec3(0.0, -0.46, 0.05), vec3(0.16, 0.0, 0.0)]);
    shape
}

/// A long flag at the top of a pole, streaming along +X from the origin.
pub(crate) fn streamer() -> Shape {
    let edge = |t: f64, upper: bool| {
        let half = 0.34 * (1.0 - 0.75 * t);
        vec3(2.2 * t, if upper { half } else { -half } - 0.25 * t * t, 0.16 * sin(t * 6.0))
    };
    Shape::surface(1, 8, |row, step| {
        let (upper, t) = (row == 1, f64::from(step) / 8.0);
        let along = edge(t + 0.01, upper) - edge(t - 0.01, upper);
        (edge(t, upper), along.cross(vec3(0.0, 1.0, 0.0)).normalize_or(Vec3::Y))
    })
}

/// The height of the land in metres at a point: flat around the square and the road, with hills far away.
fn height(x: f64, z: f64) -> f64 {
    let from_axis = (x.abs() - 20.0).max(0.0);
    let beyond = (-z - 105.0).max(0.0);
    let distance = (from_axis * from_axis + beyond * beyond).sqrt();
    let rise = (distance / 150.0).min(1.0);
    let hills = fractal(x / 60.0 + 40.0, z / 60.0 + 40.0, 64, 3, 3);
    -0.06 + rise * rise * (16.0 + 46.0 * hills) + (distance / 40.0).min(1.0) * (hills - 0.45)
}

/// The land as a grid of smooth hills, from z = `near` to z = `far`, extending `half_width` metres to each side.
pub(crate) fn land(near: f64, far: f64, half_width: f64, columns: u32, rows: u32) -> Shape {
    let x = |column: u32| -half_width + 2.0 * half_width * f64::from(column) / f64::from(columns);
    let z = |row: u32| near + (far - near) * f64::from(row) / f64::from(rows);
    Shape::surface(rows, columns, |row, column| {
        let (x, z) = (x(column), z(row));
        let slope = |dx: f64, dz: f64| height(x + dx, z + dz) - height(x - dx, z - dz);
        let normal = vec3(-slope(2.0, 0.0), 4.0, -slope(0.0, 2.0));
        (vec3(x, height(x, z), z), normal.normalize_or(Vec3::Y))
    })
}
