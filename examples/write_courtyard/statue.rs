//! The statue in the middle: a draped figure with a staff, on a pedestal in a round basin.

use crate::glb::functions::{cos, sin_cos};
use crate::glb::solids::{ball, lathe, ring, rod, standing, tube};
use crate::glb::{Placement, Shape, Vec3, vec3};

/// A robed figure, about 2 m high, that looks along +Z with one arm raised and the other hand on a staff.
pub(crate) fn figure() -> Shape {
    let mut figure = robe();
    let torso = lathe(
        &[
            (0.20, 1.00),
            (0.215, 1.12),
            (0.235, 1.28),
            (0.25, 1.40),
            (0.215, 1.50),
            (0.11, 1.57),
            (0.075, 1.60),
            (0.07, 1.70),
        ],
        20,
    );
    figure.add(&torso, &Placement::IDENTITY.scaled(1.0, 1.0, 0.68));
    // Girdle and a fold of cloth from the shoulder to the hip.
    figure
        .add(&ring(0.215, 0.022, 28, 6), &Placement::at(0.0, 1.03, 0.0).turned_x(90.0).scaled(1.0, 0.7, 1.0));
    let sash = [
        (-0.17, 1.52, 0.06),
        (-0.08, 1.42, 0.175),
        (0.05, 1.26, 0.175),
        (0.17, 1.08, 0.10),
        (0.20, 1.00, -0.04),
    ];
    figure.join(&tube(&limb(&sash, &[0.04, 0.05, 0.05, 0.05, 0.03]), 8, false));
    // Head, hair with a bun, and a hint of a face.
    figure.add(&ball(12, 16), &Placement::at(0.0, 1.80, 0.015).scaled(0.098, 0.132, 0.112));
    figure.add(&ball(8, 14), &Placement::at(0.0, 1.835, -0.025).scaled(0.108, 0.115, 0.112));
    figure.add(&ball(6, 10), &Placement::at(0.0, 1.87, -0.14).scaled(0.06, 0.06, 0.055));
    figure.add(&ball(5, 6), &Placement::at(0.0, 1.79, 0.125).scaled(0.016, 0.034, 0.02));
    // The right arm is raised with a lamp, the left one holds a staff.
    let raised = [
        (-0.2, 1.47, 0.0),
        (-0.33, 1.52, 0.05),
        (-0.43, 1.70, 0.12),
        (-0.46, 1.92, 0.17),
        (-0.46, 2.02, 0.19),
    ];
    figure.join(&tube(&limb(&raised, &[0.075, 0.065, 0.052, 0.038, 0.035]), 10, false));
    figure.add(&ball(6, 8), &Placement::at(-0.46, 2.04, 0.195).scaled(0.042, 0.05, 0.042));
    let lamp = lathe(&[(0.0, 0.0), (0.05, 0.01), (0.02, 0.05), (0.11, 0.12), (0.12, 0.15), (0.0, 0.14)], 12);
    figure.add(&lamp, &Placement::at(-0.46, 2.07, 0.2));
    let resting =
        [(0.2, 1.47, 0.0), (0.31, 1.38, 0.03), (0.37, 1.20, 0.10), (0.40, 1.17, 0.26), (0.40, 1.18, 0.30)];
    figure.join(&tube(&limb(&resting, &[0.075, 0.066, 0.052, 0.038, 0.034]), 10, false));
    figure.add(&ball(6, 8), &Placement::at(0.40, 1.18, 0.31).scaled(0.045, 0.05, 0.05));
    // A sleeve hangs from each shoulder.
    for side in [-1.0, 1.0] {
        figure.add(
            &ball(8, 12),
            &Placement::at(side * 0.2, 1.45, 0.0).turned_z(side * -35.0).scaled(0.11, 0.085, 0.1),
        );
    }
    figure
}

/// The staff in the figure's hand, 3.2 cm thick, with a ring at its top.
pub(crate) fn staff() -> Shape {
    rod(vec3(0.40, 0.0, 0.33), vec3(0.40, 2.35, 0.33), 0.016, 8)
        .and(&ring(0.11, 0.014, 20, 6), &Placement::at(0.40, 2.46, 0.33))
}

fn limb(points: &[(f64, f64, f64)], radii: &[f64]) -> Vec<(Vec3, f64)> {
    points.iter().zip(radii).map(|((x, y, z), radius)| (vec3(*x, *y, *z), *radius)).collect()
}

/// The skirt of the figure, with deep folds that flatten towards the girdle.
fn robe() -> Shape {
    const SEGMENTS: u32 = 72;
    let profile =
        [(0.41, 0.0), (0.40, 0.05), (0.36, 0.25), (0.315, 0.5), (0.27, 0.75), (0.235, 0.92), (0.21, 1.02)];
    let point = |row: usize, segment: u32| {
        let (radius, height) = profile[row];
        let angle = std::f64::consts::TAU * f64::from(segment % SEGMENTS) / f64::from(SEGMENTS);
        let depth = 0.085 * (1.0 - height / 1.1);
        let fold = cos(angle * 12.0 + 1.6 * height) * 0.6 + cos(angle * 7.0 - height) * 0.4;
        let radius = radius + depth * fold - if height < 0.01 { 0.02 } else { 0.0 };
        let (sin, cos) = sin_cos(angle);
        vec3(radius * sin, height, radius * cos * 0.82)
    };
    let last = profile.len() - 1;
    Shape::surface(last as u32, SEGMENTS, |row, segment| {
        let row = row as usize;
        let along = point(row, segment + 1) - point(row, segment + SEGMENTS - 1);
        let up = point((row + 1).min(last), segment) - point(row.saturating_sub(1), segment);
        (point(row, segment), along.cross(up).normalize_or(Vec3::Y))
    })
}

/// The base of the statue around the Y axis: round steps, a basin rim and a moulded pedestal, 1.8 m high.
pub(crate) fn pedestal() -> Shape {
    let steps = lathe(&[(3.1, 0.0), (3.1, 0.16), (2.75, 0.16), (2.75, 0.32), (2.4, 0.32)], 40);
    let basin = lathe(
        &[
            (2.4, 0.32),
            (2.36, 0.36),
            (2.30, 0.70),
            (2.36, 0.78),
            (2.36, 0.86),
            (2.06, 0.86),
            (2.04, 0.44),
            (0.5, 0.42),
        ],
        40,
    );
    let block = Shape::new()
        .and(&standing(1.3, 0.5, 1.3), &Placement::at(0.0, 0.42, 0.0))
        .and(&standing(1.02, 0.7, 1.02), &Placement::at(0.0, 0.92, 0.0))
        .and(&standing(1.22, 0.12, 1.22), &Placement::at(0.0, 1.62, 0.0))
        .and(&standing(1.1, 0.06, 1.1), &Placement::at(0.0, 1.74, 0.0));
    steps.joined(&basin).joined(&block)
}

/// The height of the pedestal on which the figure stands, in metres.
pub(crate) const PEDESTAL_HEIGHT: f64 = 1.8;

/// The water surface in the basin.
pub(crate) fn water() -> Shape {
    lathe(&[(2.1, 0.72), (0.4, 0.72)], 40)
}
