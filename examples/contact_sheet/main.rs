//! Renders `examples/filters.png`: each filter on each kind of light, with labels.
//!
//! The figure of `examples/scenes/figure.glb` throws its shadow over plinth, floor and wall from one place, and below
//! it a fence, a ladder and a hand do over a table: as a spot with a tile of the atlas, as a point light with a cube,
//! and as a directional light with cascades. The filters have the same width in the world, so a column should look
//! alike from top to bottom; "pcss" follows the penumbra, so its shadow begins sharp. Cubes have no moments, so their
//! cells stay empty there.
//!
//! `cargo run --release --example contact_sheet [FILE]`

#[path = "../../tests/common/mod.rs"]
mod common;

#[path = "../glb/mod.rs"]
mod glb;

mod table;

use common::gpu::{Host, scene};
use common::labels::{self, paste};
use common::{With, check_file, root};
use glam::{DMat3, DQuat, DVec3, Vec3};
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::{Channels, Picture};

/// The width and height of a cell in pixels, without its label.
const CELL: [u32; 2] = [200, 170];

/// The height of a label, in pixels.
const LABEL: u32 = 20;

/// The name of a parameter or feature, and its value as JSON.
type Setting = (&'static str, &'static str);

/// A column of the sheet: its label, features and parameters.
type Column = (&'static str, &'static [Setting], &'static [Setting]);

/// The parameters that filter all cascades and spots with moments.
const MOMENTS: &[Setting] =
    &[("moment_cascades", "\"all\""), ("moment_spots", "true"), ("blur_radius", "12")];

const COLUMNS: [Column; 15] = [
    ("HARD", &[("light_filter", "\"hard\"")], &[]),
    ("GRID 3", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "3")]),
    ("GRID 5", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "5")]),
    ("GRID 7", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "7")]),
    ("POISSON 9", &[("light_filter", "\"poisson9\"")], &[]),
    ("POISSON 16", &[("light_filter", "\"poisson16\"")], &[]),
    ("POISSON 64", &[("light_filter", "\"poisson64\"")], &[]),
    ("VOGEL 32", &[("light_filter", "\"vogel\"")], &[("vogel_taps", "32")]),
    ("PCSS 32", &[("light_filter", "\"pcss\"")], &[("vogel_taps", "32")]),
    ("PCSS CONTACT", &[("light_filter", "\"pcss\""), ("contact_shadows", "true")], &[("vogel_taps", "32")]),
    ("EVSM FP32", &[("moment_filter", "\"evsm4\""), ("moment_precision", "\"fp32\"")], MOMENTS),
    ("EVSM FP16", &[("moment_filter", "\"evsm4\""), ("moment_precision", "\"fp16\"")], MOMENTS),
    ("EVSM32 CONTACT", &[("moment_precision", "\"fp32\""), ("contact_shadows", "true")], MOMENTS),
    ("EVSM16 CONTACT", &[("moment_precision", "\"fp16\""), ("contact_shadows", "true")], MOMENTS),
    ("MSM", &[("moment_filter", "\"msm\"")], MOMENTS),
];

/// A scene, the radius of its lamp in metres, and the angular diameter in degrees of a sun of about that size.
type Subject = (Scene, f32, f32);

fn main() {
    let Some(gpu) = gpu::device() else {
        eprintln!("there is no graphics adapter");
        std::process::exit(1);
    };
    let default = root().join("examples/filters.png");
    let path = std::env::args_os().nth(1).map_or(default, std::path::PathBuf::from);
    let subjects: [Subject; 2] =
        [(scene(&root().join("examples/scenes/figure.glb")), 0.15, 4.0), (table::table(), 0.25, 7.0)];
    let kinds = [
        ("SPOT", LightKind::Spot { inner_angle: 0.45, outer_angle: 0.6 }),
        ("POINT", LightKind::Point),
        ("SUN", LightKind::Directional),
    ];
    let rows = subjects.iter().flat_map(|subject| kinds.map(|kind| (subject, kind)));
    let (width, height) =
        (CELL[0] * COLUMNS.len() as u32, (CELL[1] + LABEL) * (subjects.len() * kinds.len()) as u32);
    let mut sheet = Picture::filled(width, height, Channels::Rgb, &[24, 26, 32]);
    for (row, (subject, (kind_label, kind))) in rows.enumerate() {
        for (column, (label, features, parameters)) in COLUMNS.into_iter().enumerate() {
            if kind == LightKind::Point && parameters == MOMENTS {
                continue;
            }
            let cell = render(&gpu, subject, kind, features, parameters);
            let at = [CELL[0] * column as u32, (CELL[1] + LABEL) * row as u32];
            paste(&mut sheet, &cell, [at[0], at[1] + LABEL]);
            labels::write(&mut sheet, &format!("{kind_label} {label}"), [at[0] + 4, at[1] + 3]);
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

fn render(
    gpu: &Gpu,
    subject: &Subject,
    kind: LightKind,
    own_features: &[Setting],
    own_parameters: &[Setting],
) -> Picture {
    let mut parameters = vec![
        ("filter_radius", "0.06"),
        ("min_radius", "1"),
        ("max_radius", "40"),
        ("far", "[4, 8, 16, 40]"),
        ("cascade_side", "1024"),
        ("exposure", "0.8"),
    ];
    parameters.extend(own_parameters);
    let mut features = vec![("msaa", "true")];
    features.extend(own_features);
    let with = With { parameters: &parameters, features: &features, size: Some(CELL), ..With::default() };
    let outcome = check_file("pipelines/awsm.json", &with);
    Host::new(gpu, &outcome, &subject.0).picture(&frame(subject, kind))
}

/// The frame input with one lamp of a kind and a camera close to the shadow.
fn frame((subject, radius, degrees): &Subject, kind: LightKind) -> FrameInput {
    let mut input = subject.frame_input(f64::from(CELL[0]) / f64::from(CELL[1]), 0.0);
    let position = DVec3::new(2.4, 2.9, 2.6);
    let direction = (DVec3::new(-0.3, 0.5, -0.4) - position).normalize();
    let intensity = if kind == LightKind::Directional { 3.0 } else { 45.0 };
    let light = Light::new("lamp", kind)
        .position(position)
        .direction(direction)
        .color(Vec3::new(1.0, 0.93, 0.82))
        .intensity(intensity)
        .range(20.0)
        .property("cast_shadow")
        .property("contact_shadow")
        .angular_diameter(degrees.to_radians())
        .radius(*radius);
    input.lights = vec![light];
    let (eye, target) = (DVec3::new(-2.9, 1.9, 2.6), DVec3::new(-0.7, 0.55, -0.7));
    input.camera.position = eye;
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    input.camera.rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
    input
}
