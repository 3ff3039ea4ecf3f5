//! Writes `examples/scenes/figure.glb`: a jointed figure that waves, in the sun and in a spot.
//!
//! The scene is made to show shadows of what moves. The figure is one skinned mesh over eleven joints; its animation
//! lifts an arm, waves it and shifts the weight from foot to foot, for four seconds, and ends where it began. It stands
//! on a round plinth with steps, so that the shadow bends; the low sun draws it out over the floor to the right, the
//! spot to the left.
//!
//! `cargo run --example write_figure [FILE]`

#[path = "../glb/mod.rs"]
mod glb;

mod body;

use glb::solids::{block, lathe, rod};
use glb::{Document, Light, Placement, Vec3, vec3};

fn main() -> std::io::Result<()> {
    glb::save("figure.glb", &figure())
}

fn figure() -> Document {
    let mut document = Document::new("figure");
    let eye = vec3(1.3, 1.75, 5.2);
    document.camera("camera", Placement::looking_at(eye, vec3(-0.25, 0.95, 0.0)), 40.0, 0.05, 60.0);
    let sun = Light::sun([1.0, 0.92, 0.80], 2.6);
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
    let floor = document.plain("floor", [0.46, 0.44, 0.40]);
    let stone = document.plain("plinth", [0.60, 0.57, 0.52]);
    let wall = document.plain("wall", [0.62, 0.52, 0.42]);
    let skin = document.plain("figure", [0.62, 0.30, 0.16]);
    let boards = block(vec3(-7.0, -0.3, -4.0), vec3(7.0, 0.0, 7.0));
    document.put("floor", None, &[(floor, &boards)], Placement::IDENTITY);
    let mut back = block(vec3(-7.0, 0.0, -2.6), vec3(7.0, 3.4, -2.4));
    for at in 0..8 {
        let x = -3.5 + f64::from(at);
        back.join(&rod(vec3(x, 0.0, -2.2), vec3(x, 3.0, -2.2), 0.05, 10));
    }
    document.put("wall", None, &[(wall, &back)], Placement::IDENTITY);
    let plinth = lathe(&[(0.0, 0.0), (0.95, 0.0), (0.95, 0.1), (0.7, 0.1), (0.7, 0.2), (0.0, 0.2)], 40);
    document.put("plinth", None, &[(stone, &plinth)], Placement::IDENTITY);
    body::add(&mut document, skin, Placement::at(0.0, 0.2, 0.0));
    document
}
