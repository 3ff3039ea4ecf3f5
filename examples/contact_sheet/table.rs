//! A table top with what throws shadows that begin at a touch and end far from it: a picket fence, a ladder against a
//! wall, a hand.

use umbragraph::scene::{NoFiles, Scene, from_slice};

use super::glb::solids::{beam, block, rod};
use super::glb::{Document, Material, Placement, Shape, Vec3, vec3};

pub(crate) fn table() -> Scene {
    let mut document = Document::new("table");
    let eye = vec3(-2.9, 1.9, 2.6);
    document.camera("camera", Placement::looking_at(eye, vec3(-0.7, 0.55, -0.7)), 40.0, 0.05, 60.0);
    let mut put = |name: &str, color, shape: &Shape| {
        let material = document.material(Material { name, color, ..Material::default() });
        document.put(name, None, &[(material, shape)], Placement::IDENTITY);
    };
    put("top", [0.52, 0.44, 0.34], &block(vec3(-6.0, -0.2, -2.0), vec3(6.0, 0.0, 6.0)));
    put("wall", [0.55, 0.57, 0.60], &block(vec3(-6.0, 0.0, -2.2), vec3(6.0, 3.0, -2.0)));
    put("fence", [0.60, 0.55, 0.45], &fence());
    put("ladder", [0.45, 0.22, 0.12], &ladder());
    put("hand", [0.62, 0.36, 0.25], &hand());
    from_slice("table.glb", &document.glb(), &NoFiles).unwrap_or_else(|found| panic!("{found:?}"))
}

/// A fence: a row of pickets of different heights, with two rails.
fn fence() -> Shape {
    let mut fence = Shape::new();
    for at in 0..9 {
        let (z, height) = (-1.4 + 0.16 * f64::from(at), 0.9 - 0.08 * f64::from(at));
        fence.join(&beam(vec3(0.1, 0.0, z), vec3(0.1, height, z), 0.05));
    }
    let rail = |height: f64| beam(vec3(0.13, height, -1.5), vec3(0.13, height * 0.6, 0.0), 0.03);
    fence.joined(&rail(0.3)).joined(&rail(0.1))
}

/// A ladder that leans from the table against the wall.
fn ladder() -> Shape {
    let (foot, head) = (vec3(-1.0, 0.0, -1.0), vec3(-1.0, 1.7, -1.96));
    let side = |x: f64, point: Vec3| vec3(point.x + x, point.y, point.z);
    let mut ladder = Shape::new();
    for x in [-0.2, 0.2] {
        ladder.join(&beam(side(x, foot), side(x, head), 0.05));
    }
    for at in 1..9 {
        let rung = foot + (head - foot) * (f64::from(at) / 9.0);
        ladder.join(&rod(side(-0.2, rung), side(0.2, rung), 0.018, 8));
    }
    ladder
}

/// A hand above the table, with its finger tips lower than its wrist.
fn hand() -> Shape {
    let mut hand = block(vec3(-0.1, 0.50, -0.12), vec3(0.1, 0.54, 0.12));
    hand.join(&rod(vec3(0.08, 0.53, 0.0), vec3(0.6, 0.75, 0.1), 0.05, 12));
    for at in 0..4 {
        let z = -0.1 + 0.066 * f64::from(at);
        hand.join(&rod(vec3(-0.09, 0.52, z), vec3(-0.36, 0.30, z * 1.6), 0.022, 10));
    }
    hand.join(&rod(vec3(0.0, 0.52, 0.1), vec3(-0.2, 0.42, 0.26), 0.025, 10));
    hand.placed(&Placement::at(-1.0, 0.0, 0.2))
}
