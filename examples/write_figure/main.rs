//! Writes `examples/scenes/figure.glb`: a jointed figure that waves, in the sun and in a spot.
//!
//! The scene is made to show shadows of what moves. The figure is one skinned mesh over eleven joints; its animation lifts
//! an arm, waves it and shifts the weight from foot to foot, for four seconds, and ends where it began. It stands on a
//! round plinth with steps, so that the shadow bends; the low sun draws it out over the floor to the right, the spot to
//! the left.
//!
//! `cargo run --example write_figure [FILE]`

#[path = "../glb/mod.rs"]
mod glb;

mod body;

use glb::solids::{block, lathe, rod};
use glb::{Document, Light, Material, Placement, Vec3, vec3};

fn main() -> std::io::Result<()> {
    glb::save("figure.glb", &figure())
}

fn figure() -> Document {
    let mut document = Document::new("figure");
    let eye = vec3(1.3, 1.75, 5.2);
    document.camera("camera", Placement::looking_at(eye, vec3(-0.25, 0.95, 0.0)), 40.0, 0.05, 60.0);
    let sun = Light {
        name: "sun",
        kind: "directional",
        color: [1.0, 0.92, 0.80],
        intensity: 2.6,
        range: None,
        cone: None,
        size: Some(("angular_diameter_deg", 0.53)),
    };
    document.light(None, Placement::looking_at(vec3(-5.0, 3.6, 3.4), Vec3::ZERO), &sun);
    let spot = Light {
        name: "stage spot",
        kind: "spot",
        color: [0.55, 0.75, 1.0],
        intensity: 45.0,
        range: Some(12.0),
        cone: Some((16.0, 24.0)),
        size: Some(("radius", 0.05)),
    };
    document.light(None, Placement::looking_at(vec3(3.6, 3.4, 3.0), vec3(0.0, 0.9, 0.0)), &spot);
    let plain = |document: &mut Document, name, color| {
        document.material(Material { name, color, ..Material::default() })
    };
    let floor = plain(&mut document, "floor", [0.46, 0.44, 0.40]);
    let stone = plain(&mut document, "plinth", [0.60, 0.57, 0.52]);
    let wall = plain(&mut document, "wall", [0.62, 0.52, 0.42]);
    let skin = plain(&mut document, "figure", [0.62, 0.30, 0.16]);
    let put = |document: &mut Document, name: &str, material, shape: &glb::Shape| {
        let mesh = document.mesh(name, &[(material, shape)]);
        document.place(name, None, mesh, Placement::IDENTITY);
    };
    put(&mut document, "floor", floor, &block(vec3(-7.0, -0.3, -4.0), vec3(7.0, 0.0, 7.0)));
    let mut back = block(vec3(-7.0, 0.0, -2.6), vec3(7.0, 3.4, -2.4));
    for at in 0..8 {
        let x = -3.5 + f64::from(at);
        back.add(&rod(vec3(x, 0.0, -2.2), vec3(x, 3.0, -2.2), 0.05, 10), &Placement::IDENTITY);
    }
    put(&mut document, "wall", wall, &back);
    let plinth = lathe(&[(0.0, 0.0), (0.95, 0.0), (0.95, 0.1), (0.7, 0.1), (0.7, 0.2), (0.0, 0.2)], 40);
    put(&mut document, "plinth", stone, &plinth);
    body::add(&mut document, skin, Placement::at(0.0, 0.2, 0.0));
    document
}
