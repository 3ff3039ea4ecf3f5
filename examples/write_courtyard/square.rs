//! Objects on the square: the fountain, and what people have left there.

use crate::glb::document::NodeId;
use crate::glb::functions::{cos, sin};
use crate::glb::noise::between;
use crate::glb::solids::ring;
use crate::glb::{Document, Placement, Shape, vec3};
use crate::surfaces::Surfaces;
use crate::{END, nature, statue, things};

/// Adds the fountain: the statue in its basin, with a fence around it.
pub(crate) fn fountain(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("fountain", None, Placement::at(1.6, 0.0, -10.5));
    let pedestal = [(surfaces.limestone, &statue::pedestal()), (surfaces.water, &statue::water())];
    document.put("pedestal", Some(group), &pedestal, Placement::IDENTITY);
    let figure =
        document.mesh("figure", &[(surfaces.marble, &statue::figure()), (surfaces.iron, &statue::staff())]);
    let place = Placement::at(0.0, statue::PEDESTAL_HEIGHT, 0.0).turned_y(-12.0).scaled(1.35, 1.35, 1.35);
    document.place("figure", Some(group), figure, place);
    // A fence of ten sides, the one to the south left open.
    let (radius, angle) = (3.6, 36.0_f64);
    let half = radius * sin((0.5 * angle).to_radians());
    let panel = things::railing(vec3(-half, 0.0, 0.0), vec3(half, 0.0, 0.0), 0.8);
    let panel = document.mesh("fence panel", &[(surfaces.iron, &panel)]);
    for side in 1..10 {
        let turned = Placement::IDENTITY.turned_y(angle * f64::from(side));
        let origin = turned.direction(vec3(0.0, 0.0, radius * cos((0.5 * angle).to_radians())));
        document.place(&format!("fence panel {side}"), Some(group), panel, Placement { origin, ..turned });
    }
}

/// Adds the objects that stand on the square near the camera.
pub(crate) fn standing_things(document: &mut Document, surfaces: &Surfaces) {
    let group = document.group("things", None, Placement::IDENTITY);
    let amphora = document.mesh("amphora", &[(surfaces.terracotta, &things::amphora())]);
    let jars = [
        (1.0, 5.9, 1.15, 20.0),
        (1.6, 5.45, 0.95, 70.0),
        (0.75, 5.2, 1.0, 130.0),
        (5.4, 3.0, 1.2, 40.0),
        (-5.9, -3.0, 1.2, 0.0),
        (-5.8, -11.0, 1.2, 80.0),
    ];
    for (at, (x, z, size, turn)) in jars.into_iter().enumerate() {
        let place = Placement::at(x, 0.0, z).turned_y(turn).scaled(size, size, size);
        document.place(&format!("amphora {at}"), Some(group), amphora, place);
    }
    // One has fallen over.
    let lying = Placement::at(2.5, 0.25, 6.3).turned_y(35.0).turned_z(84.0).turned_y(25.0);
    document.place("fallen amphora", Some(group), amphora, lying.scaled(0.95, 0.95, 0.95));
    let slats = document.mesh("crate", &[(surfaces.wood, &things::crate_of_slats())]);
    let crates = [
        (3.6, 0.0, 2.2, 0.9, 12.0),
        (4.55, 0.0, 1.7, 0.9, -6.0),
        (3.95, 0.9, 1.95, 0.8, 30.0),
        (6.6, 0.0, -16.0, 1.0, 25.0),
    ];
    for (at, (x, y, z, size, turn)) in crates.into_iter().enumerate() {
        let place = Placement::at(x, y, z).turned_y(turn).scaled(size, size, size);
        document.place(&format!("crate {at}"), Some(group), slats, place);
    }
    let cart = document.group("cart", Some(group), Placement::at(-4.3, 0.0, 2.4).turned_y(-8.0));
    let body = document.mesh("cart", &[(surfaces.wood, &things::cart_body())]);
    document.place("cart body", Some(cart), body, Placement::IDENTITY);
    let wheel = document.mesh("wheel", &[(surfaces.wood, &things::wheel())]);
    document.place("left wheel", Some(cart), wheel, Placement::at(0.0, 0.62, 0.55));
    document.place("right wheel", Some(cart), wheel, Placement::at(0.0, 0.62, -0.55).turned_z(11.0));
    let place = Placement::at(4.15, 0.6, 2.85).turned_y(10.0).turned_x(-16.0);
    document.place("spare wheel", Some(group), wheel, place);
    for (at, (x, z, lean)) in [(0.45, -0.2, 4.0), (-0.35, 0.15, -5.0)].into_iter().enumerate() {
        let place = Placement::at(x, 0.78, z).turned_z(lean).scaled(0.8, 0.8, 0.8);
        document.place(&format!("amphora on the cart {at}"), Some(cart), amphora, place);
    }
    let pole = document.mesh("lamp", &[(surfaces.iron, &things::lantern_pole())]);
    for (at, (x, z)) in [(-5.6, -1.2), (-5.4, -26.0), (7.2, -26.0)].into_iter().enumerate() {
        let turn = if x > 0.0 { 180.0 } else { 0.0 };
        document.place(&format!("lamp {at}"), Some(group), pole, Placement::at(x, 0.0, z).turned_y(turn));
    }
    let coil = (0..3).fold(Shape::new(), |shape, turn| {
        let place =
            Placement::at(0.0, 0.045 + 0.075 * f64::from(turn), 0.0).turned_x(90.0 + 2.0 * f64::from(turn));
        shape.and(&ring(0.34 - 0.03 * f64::from(turn), 0.045, 26, 6), &place)
    });
    document.put("coil of rope", Some(group), &[(surfaces.rope, &coil)], Placement::at(-1.9, 0.0, 4.6));
    let plant = nature::foliage(34, vec3(-0.32, 0.5, -0.32), vec3(0.32, 1.25, 0.32), 0.5, 90);
    let plant =
        document.mesh("potted plant", &[(surfaces.terracotta, &things::pot()), (surfaces.leaves, &plant)]);
    for (at, (x, z)) in
        [(8.0, 8.0), (8.0, 0.0), (8.0, -8.0), (-4.1, END + 3.4), (4.1, END + 3.4)].into_iter().enumerate()
    {
        let place = Placement::at(x, 0.0, z).turned_y(70.0 * at as f64).scaled(1.15, 1.15, 1.15);
        document.place(&format!("potted plant {at}"), Some(group), plant, place);
    }
    pennants(document, surfaces, group);
}

/// Adds two ropes with pennants between the arcade and the west wall.
fn pennants(document: &mut Document, surfaces: &Surfaces, group: NodeId) {
    let ropes = [
        (vec3(8.75, 5.2, -2.0), vec3(-9.9, 4.7, -7.5), 1.0),
        (vec3(8.75, 5.2, -18.0), vec3(-9.9, 4.7, -14.0), 1.1),
    ];
    let cloths = surfaces.pennants.map(|surface| document.mesh("pennant", &[(surface, &nature::pennant())]));
    for (at, (from, to, sag)) in ropes.into_iter().enumerate() {
        let rope = document.mesh("rope", &[(surfaces.rope, &things::rope(from, to, sag, 0.014, 24))]);
        document.place(&format!("rope {at}"), Some(group), rope, Placement::IDENTITY);
        let count = 26;
        for pennant in 1..count {
            let point = things::sagging(from, to, sag, f64::from(pennant) / f64::from(count));
            let swing = between(-22.0, 22.0, pennant.into(), 400 + at as i64);
            let place = Placement::at(point.x, point.y, point.z)
                .turned_y(16.0 * (1.0 - 1.8 * at as f64))
                .turned_x(swing);
            document.place(
                &format!("pennant {at}.{pennant}"),
                Some(group),
                cloths[pennant as usize % 3],
                place,
            );
        }
    }
}
