//! The solids of which the scenes are built.

use std::f64::consts::{PI, TAU};

use super::functions::{angle_of, cos, sin, sin_cos};
use super::shape::Shape;
use super::vector::{Placement, Vec3, vec3};

/// An axis-aligned box between its minimum and its maximum corner.
pub(crate) fn block(low: Vec3, high: Vec3) -> Shape {
    prism(&[(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)], low.z, high.z)
}

/// A box that stands on the XZ plane, centred on the Y axis. Sizes are in metres.
pub(crate) fn standing(width: f64, height: f64, depth: f64) -> Shape {
    block(vec3(-0.5 * width, 0.0, -0.5 * depth), vec3(0.5 * width, height, 0.5 * depth))
}

/// A beam of square cross-section between two points.
pub(crate) fn beam(from: Vec3, to: Vec3, width: f64) -> Shape {
    standing(width, (to - from).length(), width).placed(&Placement::pointing(from, to))
}

/// An outline in the XY plane, extruded along Z from `back` to `front`. It is counter-clockwise seen from +Z, and its
/// first corner must see all others.
pub(crate) fn prism(outline: &[(f64, f64)], back: f64, front: f64) -> Shape {
    let mut shape = Shape::new();
    shape.polygon(&outline.iter().map(|(x, y)| vec3(*x, *y, front)).collect::<Vec<_>>());
    let (first, rest) = (outline.first().into_iter(), outline.iter().skip(1).rev());
    shape.polygon(&first.chain(rest).map(|(x, y)| vec3(*x, *y, back)).collect::<Vec<_>>());
    for (at, (x, y)) in outline.iter().enumerate() {
        let (next_x, next_y) = outline[(at + 1) % outline.len()];
        shape.polygon(&[
            vec3(*x, *y, front),
            vec3(*x, *y, back),
            vec3(next_x, next_y, back),
            vec3(next_x, next_y, front),
        ]);
    }
    shape
}

/// A surface of revolution around the Y axis. The profile of (radius, height) runs from the bottom up on the outside.
/// Edges stay sharp where it bends by more than 40°. The ends are open unless the profile begins and ends with radius
/// 0.
pub(crate) fn lathe(profile: &[(f64, f64)], segments: u32) -> Shape {
    let mut shape = Shape::new();
    let slopes: Vec<(f64, f64)> = profile
        .windows(2)
        .map(|pair| {
            let (out, up) = (pair[1].1 - pair[0].1, pair[0].0 - pair[1].0);
            let length = (out * out + up * up).sqrt().max(1e-12);
            (out / length, up / length)
        })
        .collect();
    let blend = |a: (f64, f64), b: Option<&(f64, f64)>| match b {
        Some(b) if a.0 * b.0 + a.1 * b.1 > cos(40.0_f64.to_radians()) => (a.0 + b.0, a.1 + b.1),
        _ => a,
    };
    for (at, slope) in slopes.iter().enumerate() {
        let before = blend(*slope, at.checked_sub(1).and_then(|at| slopes.get(at)));
        let after = blend(*slope, slopes.get(at + 1));
        let ring = |(radius, height): (f64, f64), (out, up): (f64, f64)| -> Vec<(Vec3, Vec3)> {
            (0..=segments)
                .map(|segment| {
                    let (sin, cos) = sin_cos(TAU * f64::from(segment % segments) / f64::from(segments));
                    (
                        vec3(radius * sin, height, radius * cos),
                        vec3(out * sin, up, out * cos).normalize_or(Vec3::Y),
                    )
                })
                .collect()
        };
        shape.grid(&[ring(profile[at], before), ring(profile[at + 1], after)]);
    }
    shape.triangles.retain(|triangle| {
        let [a, b, c] = triangle.map(|index| shape.vertices[index as usize].position);
        (b - a).cross(c - a).length() > 1e-12
    });
    shape
}

/// A sphere of radius 1 around the origin, with `rings` bands and `segments` sides.
pub(crate) fn ball(rings: u32, segments: u32) -> Shape {
    let profile: Vec<(f64, f64)> = (0..=rings)
        .map(|ring| {
            let (sin, cos) = sin_cos(PI * f64::from(ring) / f64::from(rings));
            (if ring == 0 || ring == rings { 0.0 } else { sin }, -cos)
        })
        .collect();
    lathe(&profile, segments)
}

/// A cylinder between two points, closed at both ends.
pub(crate) fn rod(from: Vec3, to: Vec3, radius: f64, sides: u32) -> Shape {
    let height = (to - from).length();
    let profile = [(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)];
    lathe(&profile, sides).placed(&Placement::pointing(from, to))
}

/// A round tube along a path of points and radii. Its ends are open and meant to be hidden; `closed` joins the end to
/// the start.
pub(crate) fn tube(path: &[(Vec3, f64)], sides: u32, closed: bool) -> Shape {
    let count = path.len();
    let point = |at: usize| path[at % count].0;
    let mut side = Placement::pointing(point(0), point(1)).axes[0];
    let mut rows = Vec::new();
    for at in 0..count + usize::from(closed) {
        let before = if at > 0 {
            point(at - 1)
        } else if closed {
            point(count - 1)
        } else {
            point(0)
        };
        let after = if at + 1 < count || closed { point(at + 1) } else { point(at) };
        let along = (after - before).normalize_or(Vec3::Y);
        // The section is carried along without twisting.
        side = (side - along * side.dot(along)).normalize_or(Vec3::Y);
        let other = along.cross(side);
        let radius = path[at % count].1;
        let ring = (0..=sides).map(|step| {
            let (sin, cos) = sin_cos(TAU * f64::from(step % sides) / f64::from(sides));
            let normal = side * cos + other * sin;
            (point(at) + normal * radius, normal)
        });
        rows.push(ring.collect());
    }
    let mut shape = Shape::new();
    shape.grid(&rows);
    shape
}

/// A torus around the Z axis: a circle of `radius` in the XY plane, with a tube of radius `thickness`.
pub(crate) fn ring(radius: f64, thickness: f64, segments: u32, sides: u32) -> Shape {
    let path: Vec<(Vec3, f64)> = (0..segments)
        .map(|at| {
            let (sin, cos) = sin_cos(TAU * f64::from(at) / f64::from(segments));
            (vec3(radius * cos, radius * sin, 0.0), thickness)
        })
        .collect();
    tube(&path, sides, true)
}

/// A wall panel of `width` × `height` with a round arch cut out at its foot. The panel is `depth` thick, centred on the
/// Y axis and the XY plane. The opening is `2 * radius` wide, with straight sides of height `rise` below the arch.
/// `ends` adds the faces at the panel's sides and top.
pub(crate) fn arch_panel(
    width: f64,
    height: f64,
    radius: f64,
    rise: f64,
    depth: f64,
    segments: u32,
    ends: bool,
) -> Shape {
    let mut shape = Shape::new();
    let (half, front) = (0.5 * width, 0.5 * depth);
    let arc = |at: u32| {
        let (sin, cos) = sin_cos(PI * f64::from(at) / f64::from(segments));
        (radius * cos, rise + radius * sin)
    };
    // Where the ray from the arch's centre through a point of the arc meets the outline of the panel, seen as a
    // rectangle above the springing line.
    let outline = |at: u32| {
        let (x, y) = arc(at);
        let (x, y) = (x, y - rise);
        let scale = (half / x.abs().max(1e-9)).min((height - rise) / y.max(1e-9));
        (x * scale, rise + y * scale)
    };
    let mut stations: Vec<((f64, f64), (f64, f64))> =
        (0..=segments).map(|at| (arc(at), outline(at))).collect();
    // The panel's upper corners lie between two rays; without points there the outline would cut them off.
    for corner in [(half, height), (-half, height)] {
        let angle = angle_of(corner.1 - rise, corner.0);
        let foot = (radius * cos(angle), rise + radius * sin(angle));
        let at = stations
            .iter()
            .position(|(arc, _)| angle_of(arc.1 - rise, arc.0) > angle)
            .unwrap_or(stations.len());
        stations.insert(at, (foot, corner));
    }
    for (z, facing_front) in [(front, true), (-front, false)] {
        let mut face = |corners: [(f64, f64); 4]| {
            let mut corners = corners.map(|(x, y)| vec3(x, y, z)).to_vec();
            if !facing_front {
                corners.reverse();
            }
            shape.polygon(&corners);
        };
        for pair in stations.windows(2) {
            face([pair[0].0, pair[0].1, pair[1].1, pair[1].0]);
        }
        if rise > 0.0 {
            face([(radius, 0.0), (half, 0.0), (half, rise), (radius, rise)]);
            face([(-half, 0.0), (-radius, 0.0), (-radius, rise), (-half, rise)]);
        }
    }
    // The soffit, smooth, seen from inside the opening.
    let row = |z: f64| -> Vec<(Vec3, Vec3)> {
        let along = stations.iter().map(|(arc, _)| *arc);
        along.map(|(x, y)| (vec3(x, y, z), vec3(-x, rise - y, 0.0).normalize_or(Vec3::Y))).collect()
    };
    shape.grid(&[row(front), row(-front)]);
    let mut side = |x: f64, low: f64, high: f64, towards_right: bool| {
        let z = if towards_right { front } else { -front };
        shape.polygon(&[vec3(x, low, z), vec3(x, low, -z), vec3(x, high, -z), vec3(x, high, z)]);
    };
    if rise > 0.0 {
        side(radius, 0.0, rise, false);
        side(-radius, 0.0, rise, true);
    }
    if ends {
        side(half, 0.0, height, true);
        side(-half, 0.0, height, false);
        shape.polygon(&[
            vec3(-half, height, front),
            vec3(half, height, front),
            vec3(half, height, -front),
            vec3(-half, height, -front),
        ]);
    }
    let foot = |low: f64, high: f64, y: f64| {
        [vec3(low, y, -front), vec3(high, y, -front), vec3(high, y, front), vec3(low, y, front)]
    };
    shape.polygon(&foot(-half, -radius, 0.0));
    shape.polygon(&foot(radius, half, 0.0));
    shape
}
