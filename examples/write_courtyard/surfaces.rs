//! Materials and procedural textures of the courtyard.

use crate::glb::document::MaterialId;
use crate::glb::functions::{angle_of, cos, power, sin, sin_cos};
use crate::glb::noise::{fractal, unit};
use crate::glb::png::{Color, paletted, ramp};
use crate::glb::{Document, Material};

/// The materials of the scene.
pub(crate) struct Surfaces {
    pub(crate) pavement: MaterialId,
    pub(crate) masonry: MaterialId,
    pub(crate) limestone: MaterialId,
    pub(crate) marble: MaterialId,
    pub(crate) terracotta: MaterialId,
    pub(crate) tiles: MaterialId,
    pub(crate) wood: MaterialId,
    pub(crate) iron: MaterialId,
    pub(crate) rope: MaterialId,
    pub(crate) leaves: MaterialId,
    pub(crate) cypress: MaterialId,
    pub(crate) banner: MaterialId,
    pub(crate) pennants: [MaterialId; 3],
    pub(crate) meadow: MaterialId,
    pub(crate) hills: MaterialId,
    pub(crate) water: MaterialId,
}

/// The length in metres that one repetition of the pavement texture covers.
pub(crate) const PAVEMENT_SIZE: f64 = 3.2;
/// The length in metres that one repetition of the masonry texture covers.
pub(crate) const MASONRY_SIZE: f64 = 2.4;

/// Adds all materials of the scene to the document.
pub(crate) fn add(document: &mut Document) -> Surfaces {
    let cloth = |document: &mut Document, name: &str, color: [f64; 3]| {
        document.material(Material { name, color, double_sided: true, ..Material::default() })
    };
    let textured = |document: &mut Document, name: &str, texture: Vec<u8>| {
        document.material(Material { name, texture: Some(texture), ..Material::default() })
    };
    Surfaces {
        limestone: document.plain("limestone", [0.66, 0.56, 0.43]),
        marble: document.plain("marble", [0.80, 0.78, 0.73]),
        terracotta: document.plain("terracotta", [0.56, 0.24, 0.13]),
        wood: document.plain("wood", [0.26, 0.16, 0.09]),
        iron: document.plain("iron", [0.045, 0.05, 0.06]),
        rope: document.plain("rope", [0.42, 0.33, 0.2]),
        cypress: document.plain("cypress", [0.045, 0.10, 0.04]),
        meadow: document.plain("meadow", [0.24, 0.25, 0.10]),
        hills: document.plain("hills", [0.22, 0.25, 0.17]),
        water: document.plain("water", [0.03, 0.11, 0.14]),
        pennants: [
            cloth(document, "red pennant", [0.55, 0.05, 0.04]),
            cloth(document, "ochre pennant", [0.72, 0.42, 0.06]),
            cloth(document, "blue pennant", [0.06, 0.16, 0.38]),
        ],
        pavement: textured(document, "pavement", pavement()),
        masonry: textured(document, "masonry", masonry()),
        tiles: textured(document, "tiles", tiles()),
        leaves: document.cut_out("vine leaves", leaves()),
        banner: document.cut_out("banner", banner()),
    }
}

fn byte(value: f64) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

/// The pavement texture as a PNG file: rectangular slabs in rows of different heights. Each slab has its own
/// brightness, and the texture repeats.
fn pavement() -> Vec<u8> {
    const SIDE: u32 = 256;
    const ROWS: [u32; 4] = [0, 68, 128, 200];
    let palette = ramp(256, &[[74, 62, 50], [150, 132, 108], [196, 178, 150], [226, 210, 184]]);
    paletted(SIDE, SIDE, &palette, |x, y| {
        let row = ROWS.iter().rposition(|start| *start <= y).unwrap_or(0);
        let end = ROWS.get(row + 1).copied().unwrap_or(SIDE);
        let widths = [86, 64, 102, 52];
        let offset = (row as u32 * 47) % widths[row];
        let (column, inside) = ((x + offset) / widths[row], (x + offset) % widths[row]);
        // The slab that the edge of the picture cuts is the same on both sides.
        let column = if column * widths[row] >= SIDE + offset - offset.min(1) { 0 } else { column };
        let grain = fractal(f64::from(x) / 16.0, f64::from(y) / 16.0, 16, 4, 5);
        let wear = fractal(f64::from(x) / 64.0, f64::from(y) / 64.0, 4, 2, 9);
        let edge = inside.min(widths[row] - 1 - inside).min(y - ROWS[row]).min(end - 1 - y);
        let joint = if x == 0 || x == SIDE - 1 { 1 } else { edge };
        let slab = 0.50 + 0.22 * unit(column.into(), row as i64 + 11);
        let value = match joint {
            0 => 0.10 + 0.15 * grain,
            1 => 0.32 + 0.2 * grain,
            _ => slab + 0.34 * (grain - 0.5) + 0.16 * (wear - 0.5),
        };
        byte(value)
    })
}

/// The masonry texture as a PNG file: courses of dressed stone in running bond.
fn masonry() -> Vec<u8> {
    const SIDE: u32 = 128;
    let palette = ramp(256, &[[88, 70, 50], [164, 138, 104], [208, 184, 146], [232, 214, 182]]);
    paletted(SIDE, SIDE, &palette, |x, y| {
        let course = y / 32;
        let shifted = (x + course % 2 * 32) % SIDE;
        let (block, inside) = (shifted / 64, shifted % 64);
        let edge = inside.min(63 - inside).min(y % 32).min(31 - y % 32);
        let grain = fractal(f64::from(x) / 8.0, f64::from(y) / 8.0, 16, 3, 21);
        let tone = 0.54 + 0.20 * unit(block.into(), i64::from(course) + 40);
        let value = if edge == 0 { 0.22 + 0.12 * grain } else { tone + 0.28 * (grain - 0.5) };
        byte(value)
    })
}

/// The roof texture as a PNG file: round tiles in rows that overlap downwards.
fn tiles() -> Vec<u8> {
    const SIDE: u32 = 64;
    let palette = ramp(256, &[[58, 26, 18], [142, 66, 40], [188, 98, 60], [214, 138, 92]]);
    paletted(SIDE, SIDE, &palette, |x, y| {
        let (column, row) = (x / 16, y / 32);
        let across = f64::from(x % 16) / 15.0;
        let round = sin(across * std::f64::consts::PI);
        let overlap = if y % 32 < 3 { 0.45 } else { 1.0 };
        let tone = 0.42 + 0.28 * unit(column.into(), i64::from(row) + 70);
        let grain = unit(x.into(), i64::from(y) + 900) - 0.5;
        byte((tone * (0.35 + 0.85 * round) + 0.08 * grain) * overlap)
    })
}

/// The leaf texture as a PNG file: a spray of pointed leaves, transparent elsewhere.
fn leaves() -> Vec<u8> {
    const SIDE: u32 = 128;
    let mut palette: Vec<Color> = ramp(255, &[[30, 52, 16], [72, 104, 34], [128, 150, 58], [172, 170, 80]]);
    let hidden = palette.len() as u8;
    // Cut away, but green: what filtering mixes in at the edges is the leaf's own colour.
    palette.push([72, 104, 34, 0]);
    paletted(SIDE, SIDE, &palette, |x, y| {
        let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let mut value = None;
        for leaf in 0..15_i64 {
            let (a, b) = (unit(leaf, 301), unit(leaf, 302));
            let angle = std::f64::consts::TAU * (leaf as f64 / 15.0 * 2.0 + 0.3 * a);
            let distance = if leaf < 5 { 8.0 } else { 27.0 + 14.0 * b };
            let (cx, cy) = (64.0 + distance * cos(angle), 64.0 + distance * sin(angle));
            let (sine, cosine) = sin_cos(angle + 1.2 * (a - 0.5));
            let (along, across) = (
                ((px - cx) * cosine + (py - cy) * sine) / 17.0,
                ((py - cy) * cosine - (px - cx) * sine) / 11.5,
            );
            // Broad at the stem, pointed at the tip, with a toothed edge.
            let width =
                (1.0 - power(along.abs(), 2.2)).max(0.0) * (0.78 - 0.3 * along) + 0.05 * sin(along * 21.0);
            if along.abs() < 1.0 && across.abs() < width {
                let vein = if across.abs() < 0.07 { 0.16 } else { 0.0 };
                value = Some(0.28 + 0.4 * b + 0.18 * across + vein + 0.1 * (unit(x.into(), y.into()) - 0.5));
            }
        }
        value.map_or(hidden, |value| (value.clamp(0.0, 1.0) * 254.0).round() as u8)
    })
}

/// The banner texture as a PNG file: red cloth with an ochre border, a sun and a swallow tail.
fn banner() -> Vec<u8> {
    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 192;
    let palette: [Color; 4] = [[142, 20, 22, 255], [206, 152, 44, 255], [112, 12, 16, 255], [142, 20, 22, 0]];
    paletted(WIDTH, HEIGHT, &palette, |x, y| {
        let from_axis = (f64::from(x) - 31.5).abs();
        let foot = 191.0 - (31.5 - from_axis) * 0.9;
        if f64::from(y) > foot {
            return 3;
        }
        let (dx, dy) = (f64::from(x) - 31.5, f64::from(y) - 70.0);
        let (radius, angle) = ((dx * dx + dy * dy).sqrt(), angle_of(dy, dx));
        let rays = 13.0 + 9.0 * power(cos(angle * 6.0).abs(), 1.5);
        let border = x.min(WIDTH - 1 - x) < 5 || y < 6 || f64::from(y) > foot - 7.0;
        let inner = x.min(WIDTH - 1 - x) == 7 || y == 8;
        match () {
            () if border || radius < 10.0 || (radius > 12.5 && radius < rays) || inner => 1,
            () if (x / 3 + y / 3) % 2 == 0 => 2,
            () => 0,
        }
    })
}
