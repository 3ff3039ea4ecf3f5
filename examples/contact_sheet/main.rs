//! Renders `examples/filters.png`: each filter on each kind of light, with labels.
//!
//! The figure of `examples/scenes/figure.glb` throws its shadow over plinth, floor and wall from one place: as a spot
//! with a tile of the atlas, as a point light with a cube, and as a directional light with cascades. The filters have
//! the same width in the world, so a column should look alike from top to bottom; "pcss" follows the penumbra, so its
//! shadow begins sharp.
//!
//! `cargo run --release --example contact_sheet [FILE]`

#[path = "../../tests/common/mod.rs"]
mod common;

mod letters;

use common::gpu::{Host, scene};
use common::{With, check_file, root};
use glam::{DMat3, DQuat, DVec3, Vec3};
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::{Channels, Picture};

/// Width and height of a cell in texels, without its label.
const CELL: [u32; 2] = [200, 170];

/// The height of a label.
const LABEL: u32 = 16;

/// A parameter with its value.
type Setting = (&'static str, &'static str);

/// The filters: a label, the feature, and the taps that go with it.
const FILTERS: [(&str, &str, Option<Setting>); 9] = [
    ("HARD", "hard", None),
    ("GRID 3", "grid_pcf", Some(("grid_pcf_side", "3"))),
    ("GRID 5", "grid_pcf", Some(("grid_pcf_side", "5"))),
    ("GRID 7", "grid_pcf", Some(("grid_pcf_side", "7"))),
    ("POISSON 9", "poisson9", None),
    ("POISSON 16", "poisson16", None),
    ("POISSON 64", "poisson64", None),
    ("VOGEL 32", "vogel", Some(("vogel_taps", "32"))),
    ("PCSS 32", "pcss", Some(("vogel_taps", "32"))),
];

fn main() {
    let Some(gpu) = gpu::device() else {
        eprintln!("there is no graphics adapter");
        std::process::exit(1);
    };
    let default = root().join("examples/filters.png");
    let path = std::env::args_os().nth(1).map_or(default, std::path::PathBuf::from);
    let figure = scene(&root().join("examples/scenes/figure.glb"));
    let kinds = [
        ("SPOT", LightKind::Spot { inner_angle: 0.45, outer_angle: 0.6 }),
        ("POINT", LightKind::Point),
        ("SUN", LightKind::Directional),
    ];
    let (width, height) = (CELL[0] * FILTERS.len() as u32, (CELL[1] + LABEL) * kinds.len() as u32);
    let mut sheet = Picture::filled(width, height, Channels::Rgb, &[24, 26, 32]);
    for (row, (kind_label, kind)) in kinds.into_iter().enumerate() {
        for (column, (label, filter, taps)) in FILTERS.into_iter().enumerate() {
            let cell = render(&gpu, &figure, kind, filter, taps);
            let at = [CELL[0] * column as u32, (CELL[1] + LABEL) * row as u32];
            paste(&mut sheet, &cell, [at[0], at[1] + LABEL]);
            letters::write(&mut sheet, &format!("{kind_label} {label}"), [at[0] + 4, at[1] + 3]);
        }
    }
    match sheet.save(&path) {
        Ok(()) => println!("{}: {width} by {height}", path.display()),
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            std::process::exit(1);
        }
    }
}

fn render(gpu: &Gpu, figure: &Scene, kind: LightKind, filter: &str, taps: Option<(&str, &str)>) -> Picture {
    let mut parameters = vec![
        ("filter_radius", "0.06"),
        ("min_radius", "1"),
        ("max_radius", "40"),
        ("far", "[4, 8, 16, 40]"),
        ("cascade_side", "1024"),
        ("exposure", "0.8"),
    ];
    parameters.extend(taps);
    let filter = format!("\"{filter}\"");
    let with = With {
        parameters: &parameters,
        features: &[("light_filter", &filter), ("msaa", "true")],
        size: Some(CELL),
        ..With::default()
    };
    let outcome = check_file("pipelines/awsm.json", &with);
    Host::new(gpu, &outcome, figure).picture(&frame(figure, kind))
}

/// The figure's shadow from near by, in the light of one lamp.
fn frame(figure: &Scene, kind: LightKind) -> FrameInput {
    let mut input = figure.frame_input(f64::from(CELL[0]) / f64::from(CELL[1]), 0.0);
    let position = DVec3::new(2.4, 2.9, 2.6);
    let direction = (DVec3::new(-0.3, 0.5, -0.4) - position).normalize();
    let intensity = if kind == LightKind::Directional { 3.0 } else { 45.0 };
    let light = Light {
        name: "lamp".to_owned(),
        kind,
        position,
        direction,
        color: Vec3::new(1.0, 0.93, 0.82),
        intensity,
        range: 20.0,
        properties: vec!["cast_shadow".into()],
        // So large does a lamp of that radius look from the figure.
        angular_diameter: 4_f32.to_radians(),
        radius: 0.15,
        priority: 1.0,
    };
    input.lights = vec![light];
    let (eye, target) = (DVec3::new(-2.9, 1.9, 2.6), DVec3::new(-0.7, 0.55, -0.7));
    input.camera.position = eye;
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    input.camera.rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
    input
}

fn paste(sheet: &mut Picture, cell: &Picture, at: [u32; 2]) {
    for (index, pixel) in cell.rgba_pixels().enumerate() {
        let (x, y) = (index as u32 % cell.width(), index as u32 / cell.width());
        // A line between cells.
        if x + 1 < cell.width()
            && let Some(target) = sheet.pixel_mut(at[0] + x, at[1] + y)
        {
            target.copy_from_slice(&pixel[..3]);
        }
    }
}
