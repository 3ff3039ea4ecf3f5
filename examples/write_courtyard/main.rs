//! Writes `examples/scenes/courtyard.glb`: an evening on an old square.
//!
//! The scene is made to be hard on shadows in as many ways as one picture can show. A low sun shines through an arcade
//! and lays its arches over the pavement; a pergola throws a lattice on a wall; a figure, jars, crates and a cart stand
//! on the ground, where any gap between a thing and its shadow shows; staff, spokes, railings, ropes and bars are
//! thinner than a texel of most shadow maps; leaves and banners are cut out by alpha; and behind the gate a road leads
//! past poles and cypresses to an aqueduct, 120 metres away, so that several cascades have work to do.
//!
//! `cargo run --example write_courtyard [FILE]`

#[path = "../glb/mod.rs"]
mod glb;

mod architecture;
mod buildings;
mod nature;
mod square;
mod statue;
mod surfaces;
mod things;

use glb::noise::between;
use glb::solids::block;
use glb::{Document, Light, Placement, Vec3, vec3};
use surfaces::{MASONRY_SIZE, PAVEMENT_SIZE, Surfaces};

/// The z coordinate in metres at which the square ends and the gate stands.
const END: f64 = -36.0;

fn main() -> std::io::Result<()> {
    glb::save("courtyard.glb", &courtyard())
}

fn courtyard() -> Document {
    let mut document = Document::new("courtyard");
    let surfaces = surfaces::add(&mut document);
    let eye = vec3(1.9, 4.0, 16.2);
    document.camera("camera", Placement::looking_at(eye, vec3(-0.5, 2.1, -12.0)), 43.0, 0.1, 240.0);
    let sun = Light::sun([1.0, 0.80, 0.56], 3.6);
    document.light(None, Placement::looking_at(vec3(40.0, 20.0, 12.0), Vec3::ZERO), &sun);
    ground(&mut document, &surfaces);
    buildings::arcade(&mut document, &surfaces);
    buildings::west_side(&mut document, &surfaces);
    buildings::gate(&mut document, &surfaces);
    buildings::tower(&mut document, &surfaces);
    square::fountain(&mut document, &surfaces);
    square::standing_things(&mut document, &surfaces);
    road(&mut document, &surfaces);
    document
}

fn ground(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("ground", None, Placement::IDENTITY);
    let mut floor = block(vec3(-13.0, -0.5, END - 2.0), vec3(13.0, 0.0, 22.0));
    floor.join(&block(vec3(-2.6, -0.5, -108.0), vec3(2.6, -0.01, END - 2.0)));
    let floor = floor.box_mapped(PAVEMENT_SIZE);
    document.put("pavement", Some(group), &[(surfaces.pavement, &floor)], Placement::IDENTITY);
    let (below, near) = (Placement::at(0.0, -0.04, 0.0), nature::land(40.0, -110.0, 150.0, 30, 16));
    document.put("meadow", Some(group), &[(surfaces.meadow, &near)], below);
    let far = nature::land(-110.0, -300.0, 260.0, 44, 18);
    document.put("hills", Some(group), &[(surfaces.hills, &far)], below);
}

/// Adds the road behind the gate: poles with ropes, cypresses, and the aqueduct across.
fn road(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("road", None, Placement::IDENTITY);
    let pole = document.mesh("lantern pole", &[(surfaces.iron, &things::lantern_pole())]);
    let span = document.mesh(
        "rope between poles",
        &[(surfaces.rope, &things::rope(Vec3::ZERO, vec3(0.0, 0.0, -10.0), 0.6, 0.018, 10))],
    );
    for at in 0..7 {
        let z = -44.0 - 10.0 * f64::from(at);
        for (side, name) in [(-1.0, "west"), (1.0, "east")] {
            let place = Placement::at(side * 3.0, 0.0, z).turned_y(if side > 0.0 { 180.0 } else { 0.0 });
            document.place(&format!("{name} lantern pole {at}"), Some(group), pole, place);
            if at < 6 {
                let place = Placement::at(side * 3.0, 4.9, z);
                document.place(&format!("{name} rope {at}"), Some(group), span, place);
            }
        }
    }
    let cypress = document.mesh("cypress", &[(surfaces.cypress, &nature::cypress())]);
    let mut plant = |name: String, x: f64, z: f64, height: f64| {
        let place = Placement::at(x, 0.0, z).turned_y(height * 50.0).scaled(height, height, height);
        document.place(&name, Some(group), cypress, place);
    };
    for at in 0..16_i64 {
        let side = if at % 2 == 0 { -1.0 } else { 1.0 };
        let z = -50.0 - 3.4 * at as f64 + between(-1.0, 1.0, at, 500);
        plant(format!("cypress {at}"), side * between(5.0, 7.5, at, 501), z, between(7.0, 12.0, at, 502));
    }
    for (at, (x, z, height)) in [
        (15.5, -24.0, 9.5),
        (18.5, -31.0, 11.0),
        (16.5, 2.0, 6.0),
        (21.0, -6.0, 9.0),
        (24.0, -16.0, 10.0),
        (16.0, -46.0, 13.0),
        (-16.0, -60.0, 14.0),
        (26.0, -66.0, 15.0),
    ]
    .into_iter()
    .enumerate()
    {
        plant(format!("garden cypress {at}"), x, z, height);
    }
    let bay = document.mesh(
        "aqueduct bay",
        &[(surfaces.masonry, &architecture::aqueduct_bay(8.0).box_mapped(MASONRY_SIZE * 2.0))],
    );
    for at in 0..19 {
        let x = 8.0 * (f64::from(at) - 9.0);
        let place = Placement::at(x, -1.0, -104.0 - 0.10 * x);
        document.place(&format!("aqueduct bay {at}"), Some(group), bay, place);
    }
}
