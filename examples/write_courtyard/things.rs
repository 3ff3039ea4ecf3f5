//! Things that stand about: jars, crates, a bench, a cart, a pergola, railings, ropes.

use std::f64::consts::TAU;

use crate::glb::functions::sin_cos;
use crate::glb::solids::{ball, beam, block, lathe, ring, rod, standing, tube};
use crate::glb::{Placement, Shape, Vec3, vec3};

/// An amphora one metre high with two handles.
pub(crate) fn amphora() -> Shape {
    let mut jar = lathe(
        &[
            (0.0, 0.0),
            (0.10, 0.0),
            (0.12, 0.04),
            (0.085, 0.09),
            (0.17, 0.24),
            (0.25, 0.42),
            (0.27, 0.56),
            (0.23, 0.68),
            (0.12, 0.78),
            (0.085, 0.84),
            (0.09, 0.93),
            (0.125, 0.96),
            (0.125, 1.0),
            (0.09, 1.0),
            (0.07, 0.9),
            (0.0, 0.88),
        ],
        20,
    );
    for side in [-1.0, 1.0] {
        let path = [(0.085, 0.92), (0.17, 0.955), (0.235, 0.91), (0.25, 0.82), (0.225, 0.69)];
        let path: Vec<(Vec3, f64)> = path.iter().map(|(x, y)| (vec3(side * x, *y, 0.0), 0.022)).collect();
        jar.join(&tube(&path, 7, false));
    }
    jar
}

/// A wide plant pot, 0.5 m high.
pub(crate) fn pot() -> Shape {
    let profile = [
        (0.0, 0.0),
        (0.2, 0.0),
        (0.3, 0.4),
        (0.34, 0.42),
        (0.34, 0.5),
        (0.29, 0.5),
        (0.27, 0.42),
        (0.0, 0.42),
    ];
    lathe(&profile, 18)
}

/// A crate of slats with sides of 1 m.
pub(crate) fn crate_of_slats() -> Shape {
    let mut shape = Shape::new();
    for (x, z) in [(-0.46, -0.46), (0.46, -0.46), (-0.46, 0.46), (0.46, 0.46)] {
        shape.add(&standing(0.08, 1.0, 0.08), &Placement::at(x, 0.0, z));
    }
    for side in 0..4 {
        let turn = Placement::IDENTITY.turned_y(90.0 * f64::from(side));
        for slat in 0..5 {
            let y = 0.03 + 0.195 * f64::from(slat);
            shape.add(&block(vec3(-0.5, y, 0.47), vec3(0.5, y + 0.155, 0.5)), &turn);
        }
        let brace = beam(vec3(-0.44, 0.06, 0.515), vec3(0.44, 0.94, 0.515), 0.05);
        shape.add(&brace, &turn);
    }
    for slat in 0..5 {
        let x = -0.5 + 0.2 * f64::from(slat) + 0.01;
        shape.join(&block(vec3(x, 0.97, -0.49), vec3(x + 0.18, 1.0, 0.49)));
    }
    shape
}

/// A stone bench two metres long, along X.
pub(crate) fn bench() -> Shape {
    let foot = lathe(&[(0.16, 0.0), (0.2, 0.05), (0.12, 0.12), (0.10, 0.3), (0.17, 0.42)], 12);
    Shape::new()
        .and(&standing(2.1, 0.1, 0.56), &Placement::at(0.0, 0.42, 0.0))
        .and(&foot, &Placement::at(-0.75, 0.0, 0.0).scaled(1.0, 1.0, 1.3))
        .and(&foot, &Placement::at(0.75, 0.0, 0.0).scaled(1.0, 1.0, 1.3))
}

/// A spoked wheel of radius 0.62 m, around the Z axis through the origin.
pub(crate) fn wheel() -> Shape {
    let mut wheel = ring(0.59, 0.035, 32, 8).placed(&Placement::IDENTITY.scaled(1.0, 1.0, 1.3));
    let hub = rod(vec3(0.0, 0.0, -0.13), vec3(0.0, 0.0, 0.13), 0.085, 12);
    wheel.join(&hub);
    for spoke in 0..12 {
        let (sin, cos) = sin_cos(TAU * f64::from(spoke) / 12.0);
        wheel.join(&rod(vec3(0.06 * cos, 0.06 * sin, 0.0), vec3(0.58 * cos, 0.58 * sin, 0.0), 0.02, 6));
    }
    wheel
}

/// The body of a handcart with its axle 0.62 m above the ground. Its handles point along +X and rest on a leg.
pub(crate) fn cart_body() -> Shape {
    let mut cart = Shape::new();
    for z in [-0.36, 0.36] {
        cart.join(&beam(vec3(-0.95, 0.7, z), vec3(1.75, 0.7, z), 0.08));
        cart.join(&beam(vec3(0.95, 0.0, z), vec3(0.95, 0.7, z), 0.06));
    }
    for plank in 0..9 {
        let x = -0.95 + 0.2 * f64::from(plank);
        cart.join(&block(vec3(x, 0.74, -0.44), vec3(x + 0.17, 0.78, 0.44)));
    }
    for z in [-0.45, 0.45] {
        for x in [-0.93, -0.3, 0.3, 0.8] {
            cart.join(&beam(vec3(x, 0.72, z), vec3(x, 1.22, z), 0.045));
        }
        for y in [0.86, 1.02, 1.18] {
            cart.join(&block(vec3(-0.97, y, z - 0.015), vec3(0.84, y + 0.09, z + 0.015)));
        }
    }
    cart.joined(&rod(vec3(0.0, 0.62, -0.6), vec3(0.0, 0.62, 0.6), 0.035, 8))
}

/// A pergola along −Z, over x from 0 to `width`. It has posts at x = `width`, a beam on the posts, rafters, and thin
/// laths across them. Sizes are in metres.
pub(crate) fn pergola(width: f64, length: f64, height: f64) -> Shape {
    let mut shape = Shape::new();
    let posts = (length / 4.0).round() as u32;
    for post in 0..=posts {
        let z = -length * f64::from(post) / f64::from(posts);
        shape.add(&standing(0.17, height, 0.17), &Placement::at(width, 0.0, z));
        shape.add(&standing(0.34, 0.22, 0.34), &Placement::at(width, 0.0, z));
        for end in [-0.75, 0.75] {
            shape.join(&beam(vec3(width, height - 0.75, z), vec3(width, height, z + end), 0.08));
        }
    }
    shape.join(&block(vec3(width - 0.09, height, -length - 0.5), vec3(width + 0.09, height + 0.2, 0.5)));
    shape.join(&block(vec3(0.02, height, -length - 0.5), vec3(0.14, height + 0.2, 0.5)));
    let rafters = (length / 0.8).round() as u32;
    for rafter in 0..=rafters {
        let z = -length * f64::from(rafter) / f64::from(rafters);
        let low = vec3(0.0, height + 0.2, z - 0.04);
        shape.join(&block(low, vec3(width + 0.55, height + 0.36, z + 0.04)));
    }
    let laths = (width / 0.42).round() as u32;
    for lath in 0..=laths {
        let x = 0.2 + (width + 0.1) * f64::from(lath) / f64::from(laths);
        let low = vec3(x - 0.02, height + 0.36, -length - 0.4);
        shape.join(&block(low, vec3(x + 0.02, height + 0.39, 0.4)));
    }
    shape
}

/// An iron railing between two foot points: posts with knobs, two rails, and thin bars.
pub(crate) fn railing(from: Vec3, to: Vec3, height: f64) -> Shape {
    let mut shape = Shape::new();
    let up = |height: f64| vec3(0.0, height, 0.0);
    for y in [0.12, height] {
        shape.join(&rod(from + up(y), to + up(y), if y > 0.5 { 0.026 } else { 0.016 }, 6));
    }
    for end in [from, to] {
        shape.join(&rod(end, end + up(height + 0.06), 0.03, 8));
        let knob = end + up(height + 0.1);
        shape.add(&ball(6, 8), &Placement::at(knob.x, knob.y, knob.z).scaled(0.06, 0.06, 0.06));
    }
    let bars = ((to - from).length() / 0.14).round() as u32;
    for bar in 1..bars {
        let foot = from + (to - from) * (f64::from(bar) / f64::from(bars));
        shape.join(&rod(foot + up(0.12), foot + up(height), 0.009, 4));
    }
    shape
}

/// A rope between two points that sags by `sag` metres in the middle, made of `steps` segments.
pub(crate) fn rope(from: Vec3, to: Vec3, sag: f64, radius: f64, steps: u32) -> Shape {
    tube(
        &(0..=steps)
            .map(|step| (sagging(from, to, sag, f64::from(step) / f64::from(steps)), radius))
            .collect::<Vec<_>>(),
        5,
        false,
    )
}

/// A point of a rope that sags by `sag` metres between two points; `t` runs from 0 to 1.
pub(crate) fn sagging(from: Vec3, to: Vec3, sag: f64, t: f64) -> Vec3 {
    from + (to - from) * t - vec3(0.0, 4.0 * sag * t * (1.0 - t), 0.0)
}

/// A lantern pole, about 5 m high, with the arm along +X.
pub(crate) fn lantern_pole() -> Shape {
    let pole = lathe(&[(0.14, 0.0), (0.14, 0.2), (0.08, 0.3), (0.05, 0.5), (0.035, 5.0), (0.0, 5.2)], 10);
    let lantern = lathe(&[(0.0, 0.0), (0.08, 0.0), (0.13, 0.3), (0.17, 0.32), (0.03, 0.46), (0.0, 0.52)], 6);
    let brace: Vec<(Vec3, f64)> = [(0.0, 4.2), (0.3, 4.32), (0.55, 4.55), (0.66, 4.75)]
        .iter()
        .map(|(x, y)| (vec3(*x, *y, 0.0), 0.014))
        .collect();
    pole.joined(&rod(vec3(0.0, 4.75, 0.0), vec3(0.85, 4.75, 0.0), 0.02, 6))
        .joined(&tube(&brace, 5, false))
        .joined(&rod(vec3(0.8, 4.52, 0.0), vec3(0.8, 4.75, 0.0), 0.012, 5))
        .and(&lantern, &Placement::at(0.8, 4.02, 0.0))
}
