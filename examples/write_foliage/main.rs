//! Writes `examples/scenes/foliage.glb`: a garden in the morning sun.
//!
//! The scene is made to be hard on shadows through holes. Crowns and ferns are cards of leaves cut out by alpha, seen
//! from both sides and lit through; grass stands in tufts of single blades; a trellis throws its lattice on what climbs
//! it. In front lies a pool of clear water, which is blended and receives shadows.
//!
//! `cargo run --example write_foliage [FILE]`

#[path = "../glb/mod.rs"]
mod glb;

mod plants;

use glb::document::MaterialId;
use glb::functions::sin;
use glb::noise::between;
use glb::solids::{beam, block, rod};
use glb::{Document, Light, Material, Placement, Shape, Vec3, vec3};

fn main() -> std::io::Result<()> {
    glb::save("foliage.glb", &foliage())
}

fn foliage() -> Document {
    let mut document = Document::new("foliage");
    let eye = vec3(0.4, 1.9, 7.4);
    document.camera("camera", Placement::looking_at(eye, vec3(-0.2, 1.15, 0.0)), 48.0, 0.05, 60.0);
    let sun = Light::sun([1.0, 0.90, 0.74], 4.2);
    document.light(None, Placement::looking_at(vec3(6.0, 8.0, 1.5), Vec3::ZERO), &sun);
    let soil = document.plain("lawn", [0.20, 0.24, 0.08]);
    let stone = document.plain("stone", [0.50, 0.47, 0.42]);
    let bark = document.plain("bark", [0.20, 0.13, 0.08]);
    let wood = document.plain("trellis", [0.48, 0.36, 0.22]);
    let leaf = document.cut_out("leaves", plants::leaf_texture());
    let blade = document.cut_out("grass", plants::grass_texture());
    document.put("ground", None, &[(soil, &ground())], Placement::IDENTITY);
    document.put("path", None, &[(stone, &path())], Placement::IDENTITY);
    for (at, (x, z, height)) in [(-2.3, -1.6, 3.4), (1.7, -2.9, 4.2), (3.3, 0.2, 2.8)].into_iter().enumerate()
    {
        let (trunk, crown) = plants::tree(height, at as i64);
        let place = Placement::at(x, 0.0, z);
        document.put(&format!("tree {at}"), None, &[(bark, &trunk), (leaf, &crown)], place);
    }
    for (at, (x, z)) in [(-0.6, -0.9), (0.9, 0.4), (-3.2, 1.1)].into_iter().enumerate() {
        let (fern, place) = (plants::fern(at as i64), Placement::at(x, 0.0, z));
        document.put(&format!("fern {at}"), None, &[(leaf, &fern)], place);
    }
    grass(&mut document, blade);
    trellis(&mut document, wood, leaf);
    pool(&mut document, stone);
    document
}

fn ground() -> Shape {
    block(vec3(-14.0, -0.4, -16.0), vec3(14.0, 0.0, 10.0))
}

/// The path of stepping stones.
fn path() -> Shape {
    let mut shape = Shape::new();
    for at in 0..7_i64 {
        let (x, z) = (0.5 + 0.5 * sin(at as f64 * 0.9), 4.6 - 0.75 * at as f64);
        let stone = block(vec3(-0.26, 0.0, -0.2), vec3(0.26, 0.035, 0.2));
        shape.add(&stone, &Placement::at(x, 0.0, z).turned_y(between(-20.0, 20.0, at, 7)));
    }
    shape
}

fn grass(document: &mut Document, blade: MaterialId) {
    let tuft = document.mesh("tuft", &[(blade, &plants::tuft())]);
    for at in 0..150_i64 {
        let (x, z) = (between(-4.5, 4.5, at, 21), between(-4.0, 5.4, at, 22));
        let on_path = (x - 0.5).abs() < 0.85 && z > -0.3;
        let in_pool = (-3.1..-0.7).contains(&x) && (2.1..4.1).contains(&z);
        if !on_path && !in_pool {
            let size = between(0.6, 1.2, at, 24);
            let place =
                Placement::at(x, 0.0, z).turned_y(between(0.0, 360.0, at, 23)).scaled(size, size, size);
            document.place(&format!("tuft {at}"), None, tuft, place);
        }
    }
}

fn trellis(document: &mut Document, wood: MaterialId, leaf: MaterialId) {
    let mut lattice = Shape::new();
    for at in 0..9 {
        let x = -1.0 + 0.25 * f64::from(at);
        lattice.join(&beam(vec3(x, 0.0, 0.0), vec3(x, 2.0, 0.0), 0.022));
        let y = 0.2 + 0.22 * f64::from(at);
        lattice.join(&beam(vec3(-1.0, y, 0.022), vec3(1.0, y, 0.022), 0.022));
    }
    let climber = plants::cards(70, vec3(-1.0, 0.1, 0.05), vec3(0.5, 1.9, 0.16), 0.3, 91);
    let place = Placement::at(-0.7, 0.0, -2.5).turned_y(12.0);
    document.put("trellis", None, &[(wood, &lattice), (leaf, &climber)], place);
}

fn pool(document: &mut Document, stone: MaterialId) {
    let mut rim = Shape::new();
    for (low, high) in [
        (vec3(-3.1, 0.0, 2.1), vec3(-0.7, 0.16, 2.25)),
        (vec3(-3.1, 0.0, 3.95), vec3(-0.7, 0.16, 4.1)),
        (vec3(-3.1, 0.0, 2.25), vec3(-2.95, 0.16, 3.95)),
        (vec3(-0.85, 0.0, 2.25), vec3(-0.7, 0.16, 3.95)),
    ] {
        rim.join(&block(low, high));
    }
    // A reed stands in the water, so that a shadow falls on it.
    for (x, z, lean) in [(-2.2, 3.2, 0.12), (-2.1, 3.3, -0.1), (-2.3, 3.35, 0.03)] {
        rim.join(&rod(vec3(x, 0.0, z), vec3(x + lean, 0.9, z), 0.012, 6));
    }
    document.put("pool rim", None, &[(stone, &rim)], Placement::IDENTITY);
    let water = document.material(Material {
        name: "water",
        color: [0.10, 0.30, 0.34],
        opacity: 0.6,
        ..Material::default()
    });
    let mut surface = Shape::new();
    surface.polygon(&[
        vec3(-2.95, 0.11, 3.95),
        vec3(-0.85, 0.11, 3.95),
        vec3(-0.85, 0.11, 2.25),
        vec3(-2.95, 0.11, 2.25),
    ]);
    document.put("water", None, &[(water, &surface)], Placement::IDENTITY);
}
