//! The buildings around the square: the arcade, the west wall with its pergola, the gatehouse and the tower.

use crate::architecture::{self, BAY, COLUMN_HEIGHT, SPANDREL_HEIGHT};
use crate::glb::solids::{arch_panel, block, rod, standing};
use crate::glb::{Document, Placement, Shape, vec3};
use crate::surfaces::{MASONRY_SIZE, Surfaces};
use crate::{END, nature, things};

/// The height of the terrace in front of the gate, in metres.
const TERRACE: f64 = 0.64;

/// Adds the arcade on the sunny side of the square, along Z at x = 9 m.
pub(crate) fn arcade(document: &mut Document, surfaces: &Surfaces) {
    const BAYS: u32 = 12;
    let group = document.group("arcade", None, Placement::at(9.0, 0.0, 14.0).turned_y(90.0));
    let column = document.mesh("column", &[(surfaces.limestone, &architecture::column())]);
    let bay = document.mesh(
        "arcade bay",
        &[
            (surfaces.masonry, &architecture::arcade_bay().box_mapped(MASONRY_SIZE)),
            (surfaces.limestone, &architecture::archivolts()),
        ],
    );
    for at in 0..=BAYS {
        let place = Placement::at(BAY * f64::from(at), 0.0, 0.0);
        document.place(&format!("column {at}"), Some(group), column, place);
    }
    for at in 0..BAYS {
        let x = BAY * (f64::from(at) + 0.5);
        document.place(&format!("bay {at}"), Some(group), bay, Placement::at(x, COLUMN_HEIGHT, 0.0));
    }
    let length = BAY * f64::from(BAYS);
    let cornice =
        document.mesh("arcade cornice", &[(surfaces.limestone, &architecture::cornice(length + 0.4, 0.62))]);
    let middle = Placement::at(0.5 * length, COLUMN_HEIGHT + SPANDREL_HEIGHT, 0.0);
    document.place("arcade cornice", Some(group), cornice, middle);
    document.put(
        "arcade end",
        Some(group),
        &[(surfaces.masonry, &standing(0.5, SPANDREL_HEIGHT, 0.62).box_mapped(MASONRY_SIZE))],
        Placement::at(-0.25, COLUMN_HEIGHT, 0.0),
    );
}

/// Adds the wall on the shady side of the square, with pergola, vines and benches.
pub(crate) fn west_side(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("west side", None, Placement::at(-10.0, 0.0, 0.0));
    let mut wall = block(vec3(-0.7, 0.0, END - 1.0), vec3(0.0, 4.5, 22.0));
    for at in 0..14 {
        let z = 18.0 - 4.0 * f64::from(at);
        wall.join(&block(vec3(0.0, 0.0, z - 0.3), vec3(0.14, 4.5, z + 0.3)));
    }
    wall.join(&block(vec3(0.0, 0.0, END), vec3(0.2, 0.5, 22.0)));
    let coping = architecture::cornice(22.0 - END + 1.0, 0.7)
        .placed(&Placement::at(-0.35, 4.5, 0.5 * (22.0 + END - 1.0)).turned_y(90.0));
    document.put(
        "west wall",
        Some(group),
        &[(surfaces.masonry, &wall.box_mapped(MASONRY_SIZE)), (surfaces.limestone, &coping)],
        Placement::IDENTITY,
    );
    let start = Placement::at(0.2, 0.0, 5.0);
    document.put("pergola", Some(group), &[(surfaces.wood, &things::pergola(3.2, 28.0, 2.75))], start);
    let clumps = [(110, 31), (64, 32), (84, 33)].map(|(count, seed)| {
        let above = nature::foliage(count, vec3(-1.75, 0.0, -1.9), vec3(1.75, 0.42, 1.9), 0.5, seed);
        let strands = nature::foliage(22, vec3(1.15, -1.6, -0.35), vec3(1.65, 0.1, 0.35), 0.4, seed + 30);
        document.mesh("vines", &[(surfaces.leaves, &above.joined(&strands))])
    });
    for (at, clump) in [0, 1, 2, 0, 2, 1, 0].into_iter().enumerate() {
        let place = Placement::at(1.95, 3.08, 4.6 - 4.05 * at as f64);
        let place = if at % 2 == 0 { place } else { place.scaled(1.0, 1.0, -1.0) };
        document.place(&format!("vines {at}"), Some(group), clumps[clump], place);
    }
    let mut stems = Shape::new();
    for clump in 0..7 {
        let z = -4.0 * f64::from(clump);
        stems.join(&rod(vec3(3.33, 0.0, z + 0.05), vec3(3.1, 3.1, z - 0.1), 0.03, 6));
    }
    document.put("vine stems", Some(group), &[(surfaces.wood, &stems)], start);
    let bench = document.mesh("bench", &[(surfaces.limestone, &things::bench())]);
    for (at, z) in [1.0, -7.0, -15.0].into_iter().enumerate() {
        let place = Placement::at(0.85, 0.0, z).turned_y(90.0);
        document.place(&format!("bench {at}"), Some(group), bench, place);
    }
}

/// Adds the gatehouse with its terrace, stairs and banners, and the low walls beside it.
pub(crate) fn gate(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("gate", None, Placement::at(0.0, 0.0, END));
    let house = arch_panel(9.4, 7.6, 2.0, 3.1, 1.6, 20, true)
        .placed(&Placement::at(0.0, TERRACE, -0.8))
        .joined(&block(vec3(-4.9, TERRACE, -0.25), vec3(-3.7, TERRACE + 7.0, 0.3)))
        .joined(&block(vec3(3.7, TERRACE, -0.25), vec3(4.9, TERRACE + 7.0, 0.3)))
        .and(&architecture::battlements(9.4, 0.7, 0.8, 1.0), &Placement::at(0.0, TERRACE + 8.06, -0.5))
        .joined(&block(vec3(-13.0, 0.0, -1.0), vec3(-4.7, 3.4, -0.4)))
        .joined(&block(vec3(4.7, 0.0, -1.0), vec3(13.0, 3.4, -0.4)));
    let trim = architecture::cornice(9.6, 1.6)
        .placed(&Placement::at(0.0, TERRACE + 7.6, -0.8))
        .and(&architecture::cornice(8.3, 0.6), &Placement::at(-8.85, 3.4, -0.7))
        .and(&architecture::cornice(8.3, 0.6), &Placement::at(8.85, 3.4, -0.7))
        .and(&architecture::steps(6.4, 4, 0.16, 0.34), &Placement::at(0.0, 0.0, 2.96))
        .joined(&block(vec3(-5.0, 0.0, -1.7), vec3(5.0, TERRACE, 1.6)))
        .joined(&block(vec3(-3.6, 0.0, 1.6), vec3(-3.2, TERRACE + 0.2, 3.1)))
        .joined(&block(vec3(3.2, 0.0, 1.6), vec3(3.6, TERRACE + 0.2, 3.1)));
    let columns = [-2.75, 2.75].into_iter().fold(Shape::new(), |shape, x| {
        shape.and(&architecture::column(), &Placement::at(x, TERRACE, 0.55).scaled(1.0, 1.25, 1.0))
    });
    let lintel = standing(6.6, 0.5, 0.9).placed(&Placement::at(0.0, TERRACE + 5.5, 0.35));
    let trim = trim.joined(&columns).joined(&lintel);
    let shelf = [-2.75, 2.75]
        .into_iter()
        .fold(trim, |shape, x| shape.and(&standing(0.9, 1.9, 0.6), &Placement::at(x, TERRACE + 3.62, 0.3)));
    document.put(
        "gatehouse",
        Some(group),
        &[(surfaces.masonry, &house.box_mapped(MASONRY_SIZE)), (surfaces.limestone, &shelf)],
        Placement::IDENTITY,
    );
    let mut rails = Shape::new();
    for side in [-1.0, 1.0] {
        let (low, high) = (vec3(side * 3.4, 0.84, 3.0), vec3(side * 3.4, 0.84, 1.7));
        rails.join(&things::railing(low, high, 0.7));
        let (inner, outer) = (vec3(side * 3.4, TERRACE, 1.5), vec3(side * 4.9, TERRACE, 1.5));
        rails.join(&things::railing(inner, outer, 0.9));
        let (low, high) = (vec3(side * 4.3, TERRACE + 8.0, -0.4), vec3(side * 4.3, TERRACE + 12.4, -0.4));
        rails.join(&rod(low, high, 0.045, 8));
        let (left, right) =
            (vec3(side * 4.3 - 0.7, TERRACE + 6.3, 0.42), vec3(side * 4.3 + 0.7, TERRACE + 6.3, 0.42));
        rails.join(&rod(left, right, 0.03, 6));
    }
    document.put("gate iron", Some(group), &[(surfaces.iron, &rails)], Placement::IDENTITY);
    let banner = document.mesh("banner", &[(surfaces.banner, &nature::hanging_banner())]);
    let streamer = document.mesh("streamer", &[(surfaces.pennants[0], &nature::streamer())]);
    for (name, x) in [("west", -4.3), ("east", 4.3)] {
        let place = Placement::at(x, TERRACE + 6.27, 0.42).scaled(1.25, 1.25, 1.0);
        document.place(&format!("{name} banner"), Some(group), banner, place);
        let place = Placement::at(x, TERRACE + 12.0, -0.4).turned_y(15.0);
        document.place(&format!("{name} streamer"), Some(group), streamer, place);
    }
}

/// Adds the tower behind the gate, on the left.
pub(crate) fn tower(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("tower", None, Placement::at(-9.5, 0.0, END - 8.0));
    let body = architecture::tower_body(5.4, 17.5).box_mapped(MASONRY_SIZE);
    let cornice = standing(6.2, 0.4, 6.2).placed(&Placement::at(0.0, 17.5, 0.0));
    let body = document.mesh("tower", &[(surfaces.masonry, &body), (surfaces.limestone, &cornice)]);
    document.place("tower body", Some(group), body, Placement::IDENTITY);
    let (roof, place) = (architecture::pyramid(6.6, 4.2), Placement::at(0.0, 17.9, 0.0));
    document.put("tower roof", Some(group), &[(surfaces.tiles, &roof)], place);
    let mut vane = rod(vec3(0.0, 22.0, 0.0), vec3(0.0, 24.6, 0.0), 0.05, 8);
    vane.join(&rod(vec3(-0.7, 23.6, 0.0), vec3(0.9, 23.6, 0.0), 0.03, 6));
    document.put("weather vane", Some(group), &[(surfaces.iron, &vane)], Placement::IDENTITY);
}
