//! Writes `examples/scenes/interior.glb`: a furnished room at night, lit by spots and point lights only.
//!
//! The scene is made to be hard on shadows of lights with a position. A floor lamp in the middle reaches floor, ceiling
//! and all four walls, so that every face of its cube is seen; a pendant hangs close above a table with thin-legged
//! chairs; picture spots graze a wall in narrow cones; a wide spot shines through the rungs of a ladder and the rails
//! of a gallery; a window pane stands in the light and receives shadows itself.
//!
//! `cargo run --example write_interior [FILE]`

#[path = "../glb/mod.rs"]
mod glb;

mod furniture;

use glb::solids::{ball, block, lathe, rod};
use glb::{Document, Light, Material, Placement, Shape, Vec3, vec3};

fn main() -> std::io::Result<()> {
    glb::save("interior.glb", &interior())
}

fn interior() -> Document {
    let mut document = Document::new("interior");
    let eye = vec3(3.55, 1.75, 3.1);
    document.camera("camera", Placement::looking_at(eye, vec3(-1.2, 0.95, -1.2)), 58.0, 0.05, 30.0);
    room(&mut document);
    let wood = document.plain("oak", [0.42, 0.25, 0.12]);
    let dark = document.plain("walnut", [0.16, 0.09, 0.05]);
    let metal = document.plain("steel", [0.30, 0.31, 0.33]);
    let cloth = document.plain("linen", [0.55, 0.50, 0.42]);
    document.put("table", None, &[(wood, &furniture::table())], Placement::at(-0.3, 0.0, -0.6));
    for (at, (x, z, turn)) in [(-0.9, -1.3, 10.0), (0.35, -1.3, -8.0), (-0.9, 0.15, 172.0), (0.5, 0.2, 205.0)]
        .into_iter()
        .enumerate()
    {
        let place = Placement::at(x, 0.0, z).turned_y(turn);
        document.put(&format!("chair {at}"), None, &[(dark, &furniture::chair())], place);
    }
    for (name, material, shape, place) in [
        ("shelf", wood, furniture::shelf(), Placement::at(-3.55, 0.0, -1.9).turned_y(90.0)),
        ("ladder", metal, furniture::ladder(), Placement::at(1.9, 0.0, -2.55).turned_x(-14.0)),
        ("rail", metal, furniture::rail(2.6), Placement::at(2.4, 0.0, 0.35)),
        ("sofa", cloth, furniture::sofa(), Placement::at(-2.4, 0.0, 2.0).turned_y(152.0)),
    ] {
        document.put(name, None, &[(material, &shape)], place);
    }
    bowl_and_bottles(&mut document);
    pictures(&mut document, dark);
    pane(&mut document, metal);
    lamps(&mut document, metal);
    document
}

/// Adds four walls, floor and ceiling, 20 cm thick, so that no light leaks in.
fn room(document: &mut Document) {
    let plaster = document.plain("plaster", [0.72, 0.69, 0.64]);
    let boards = document.plain("boards", [0.34, 0.22, 0.13]);
    let white = document.plain("ceiling", [0.80, 0.79, 0.77]);
    let (x, y, z, thick) = (4.0, 2.9, 3.4, 0.2);
    let mut walls = block(vec3(-x - thick, 0.0, -z - thick), vec3(-x, y, z + thick));
    for (low, high) in [
        (vec3(x, 0.0, -z - thick), vec3(x + thick, y, z + thick)),
        (vec3(-x, 0.0, -z - thick), vec3(x, y, -z)),
        (vec3(-x, 0.0, z), vec3(x, y, z + thick)),
    ] {
        walls.join(&block(low, high));
    }
    for (name, material, shape) in [
        ("walls", plaster, walls),
        ("floor", boards, block(vec3(-x - thick, -thick, -z - thick), vec3(x + thick, 0.0, z + thick))),
        ("lid", white, block(vec3(-x - thick, y, -z - thick), vec3(x + thick, y + thick, z + thick))),
    ] {
        document.put(name, None, &[(material, &shape)], Placement::IDENTITY);
    }
}

fn bowl_and_bottles(document: &mut Document) {
    let clay = document.plain("clay", [0.55, 0.24, 0.12]);
    let fruit = document.plain("fruit", [0.62, 0.38, 0.05]);
    let green = document.plain("bottle", [0.05, 0.22, 0.10]);
    let bowl = lathe(
        &[(0.0, 0.0), (0.07, 0.0), (0.07, 0.015), (0.16, 0.09), (0.15, 0.095), (0.06, 0.03), (0.0, 0.028)],
        24,
    );
    let bottle =
        lathe(&[(0.0, 0.0), (0.038, 0.0), (0.038, 0.17), (0.014, 0.22), (0.014, 0.29), (0.0, 0.29)], 16);
    let top = 0.75;
    let mut apples = Shape::new();
    for (x, y, z) in [(0.05, 0.075, 0.0), (-0.045, 0.075, 0.03), (-0.01, 0.075, -0.05), (0.0, 0.13, 0.0)] {
        apples.add(&ball(8, 12), &Placement::at(x, y, z).scaled(0.042, 0.04, 0.042));
    }
    document.put("bowl", None, &[(clay, &bowl), (fruit, &apples)], Placement::at(-0.35, top, -0.55));
    let bottle = document.mesh("bottle", &[(green, &bottle)]);
    for (at, (x, z)) in [(0.15, -0.75), (0.24, -0.62), (-0.75, -0.4)].into_iter().enumerate() {
        document.place(&format!("bottle {at}"), None, bottle, Placement::at(x, top, z));
    }
}

/// Adds three pictures on the far wall, each lit by its own spot light.
fn pictures(document: &mut Document, frame: glb::document::MaterialId) {
    let canvas = document.plain("canvas", [0.25, 0.30, 0.42]);
    let border = furniture::frame(0.9, 0.65);
    let inside = block(vec3(-0.46, -0.335, 0.0), vec3(0.46, 0.335, 0.012));
    let mesh = document.mesh("picture", &[(frame, &border), (canvas, &inside)]);
    for (at, x) in [-2.6, -1.1, 0.4].into_iter().enumerate() {
        document.place(&format!("picture {at}"), None, mesh, Placement::at(x, 1.65, -3.39));
        let from = vec3(x, 2.8, -2.75);
        let light = Light {
            name: &format!("picture spot {at}"),
            kind: "spot",
            color: [1.0, 0.86, 0.66],
            intensity: 5.0,
            range: Some(4.0),
            cone: Some((14.0 + 3.0 * at as f64, 24.0 + 4.0 * at as f64)),
            size: Some(("radius", 0.03)),
        };
        document.light(None, Placement::looking_at(from, vec3(x, 1.6, -3.4)), &light);
    }
}

/// Adds a pane of tinted glass in a frame, beside the railing.
fn pane(document: &mut Document, metal: glb::document::MaterialId) {
    let glass = document.material(Material {
        name: "tinted glass",
        color: [0.30, 0.52, 0.50],
        opacity: 0.35,
        double_sided: true,
        ..Material::default()
    });
    let border = furniture::frame(1.3, 1.7);
    let mesh = document.mesh("pane frame", &[(metal, &border)]);
    let place = Placement::at(1.35, 0.87, -0.95).turned_y(64.0);
    document.place("pane frame", None, mesh, place);
    // Its edges lie inside the frame, so that no two faces coincide.
    let sheet = block(vec3(-0.66, -0.86, 0.004), vec3(0.66, 0.86, 0.012));
    document.put("pane", None, &[(glass, &sheet)], place);
}

fn lamps(document: &mut Document, metal: glb::document::MaterialId) {
    let glow = document.material(Material {
        name: "bulb",
        color: [0.9, 0.8, 0.6],
        emissive: [1.0, 0.86, 0.6],
        ..Material::default()
    });
    let warm = [1.0, 0.80, 0.55];
    let mut lamp = |name: &str, at: Vec3, color, intensity, range| {
        let light = Light {
            name,
            kind: "point",
            color,
            intensity,
            range: Some(range),
            cone: None,
            size: Some(("radius", 0.05)),
        };
        document.light(None, Placement::at(at.x, at.y, at.z), &light);
    };
    lamp("floor lamp", vec3(-1.75, 1.45, 0.75), warm, 7.0, 9.0);
    lamp("pendant", vec3(-0.3, 1.75, -0.6), warm, 5.0, 6.0);
    lamp("night light", vec3(3.4, 0.25, -2.9), [0.35, 0.55, 1.0], 1.6, 4.0);
    let spot = |name, color, intensity, cone| Light {
        name,
        kind: "spot",
        color,
        intensity,
        range: Some(9.0),
        cone: Some(cone),
        size: Some(("radius", 0.04)),
    };
    let moon = spot("stair spot", [0.55, 0.70, 1.0], 26.0, (26.0, 38.0));
    document.light(None, Placement::looking_at(vec3(3.8, 2.6, 2.6), vec3(1.2, 0.4, -2.2)), &moon);
    let reading = spot("reading spot", [1.0, 0.92, 0.8], 9.0, (18.0, 30.0));
    document.light(None, Placement::looking_at(vec3(-3.3, 2.2, 2.9), vec3(-2.3, 0.4, 1.7)), &reading);
    // The lamps themselves: open shades around the bulbs, which cast no shadow of their own on all there is.
    let mut stand = rod(vec3(0.0, 0.0, 0.0), vec3(0.0, 1.32, 0.0), 0.012, 8);
    stand.join(&lathe(&[(0.0, 0.0), (0.15, 0.0), (0.15, 0.02), (0.0, 0.03)], 20));
    for turn in 0..6 {
        let place = Placement::IDENTITY.turned_y(60.0 * f64::from(turn));
        stand.add(&rod(vec3(0.0, 1.3, 0.0), vec3(0.13, 1.42, 0.0), 0.006, 5), &place);
        stand.add(&rod(vec3(0.13, 1.42, 0.0), vec3(0.10, 1.62, 0.0), 0.006, 5), &place);
    }
    let mut hanger = rod(vec3(0.0, 1.9, 0.0), vec3(0.0, 2.9, 0.0), 0.006, 6);
    hanger.join(&lathe(&[(0.24, 1.80), (0.06, 1.93), (0.0, 1.94)], 24));
    hanger.join(&lathe(&[(0.0, 1.93), (0.055, 1.92), (0.235, 1.79)], 24));
    let bulb = ball(6, 10).placed(&Placement::IDENTITY.scaled(0.028, 0.028, 0.028));
    for (name, shape, x, z, height) in
        [("floor lamp stand", stand, -1.75, 0.75, 1.37), ("pendant shade", hanger, -0.3, -0.6, 1.86)]
    {
        let bulb = bulb.placed(&Placement::at(0.0, height, 0.0));
        document.put(name, None, &[(metal, &shape), (glow, &bulb)], Placement::at(x, 0.0, z));
    }
}
