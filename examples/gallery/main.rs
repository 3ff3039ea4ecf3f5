//! Renders `examples/gallery/`: what each pipeline makes of each scene that suits it, in labelled sheets.
//!
//! A sheet for each of the five systems and the flagship, and for each teaching pipeline that draws a scene; the others
//! share one, each with its picture. A scene suits a pipeline that reads all of its lights. Sheets are JPEG, since
//! there are many, and hold two megabytes together at most.
//!
//! `cargo xtask gallery` (`cargo run --example gallery [FOLDER]`)

#[path = "../../tests/common/mod.rs"]
mod common;

use std::path::Path;

use common::gpu::{Host, picture, scene};
use common::labels::{self, paste};
use common::{Outcome, With, check_file, root};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::{Channels, Picture};

/// The width and height of a cell with a scene, in pixels. `SMALL_CELL` is for pictures without a scene.
const CELL: [u32; 2] = [320, 180];
const SMALL_CELL: [u32; 2] = [160, 90];

/// The gap between cells and around labels, in pixels.
const GAP: u32 = 4;

/// The number of frames drawn for a picture; only the last is shown, when history resources have converged.
const FRAMES: u64 = 8;

const MAX_BYTES: u64 = 2 << 20;

const SYSTEMS: [&str; 6] = ["mantis", "awsm", "nebula", "caracal", "lore", "umbra"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = gpu::device().ok_or("there is no graphics adapter")?;
    let folder = std::env::args_os().nth(1).map_or(root().join("examples/gallery"), Into::into);
    std::fs::create_dir_all(&folder)?;
    let scenes: Vec<(String, Scene)> = names("examples/scenes", ".glb")?
        .into_iter()
        .map(|name| {
            let loaded = scene(&root().join(format!("examples/scenes/{name}.glb")));
            (name, loaded)
        })
        .collect();
    let mut pipelines: Vec<String> = SYSTEMS.map(str::to_owned).into();
    pipelines.extend(names("pipelines/learn", ".json")?.into_iter().map(|name| format!("learn/{name}")));
    let mut without_scene = Vec::new();
    let mut bytes = 0;
    for pipeline in &pipelines {
        let with = |size| With { size: Some(size), ..With::default() };
        let outcome = check_file(&format!("pipelines/{pipeline}.json"), &with(CELL));
        let name = pipeline.trim_start_matches("learn/");
        if draws_scenes(&outcome) {
            let suits = |(name, scene): &(String, Scene)| Some((name.clone(), drawn(&gpu, &outcome, scene)?));
            let cells: Vec<(String, Picture)> = scenes.iter().filter_map(suits).collect();
            let label = |scene: String| format!("{name}: {scene}");
            let cells = cells.into_iter().map(|(scene, picture)| (label(scene), picture)).collect();
            bytes += save(&folder.join(format!("{name}.jpg")), &sheet(cells, 2, CELL))?;
        } else if outcome.diagnostics.is_empty() && shows_a_picture(&outcome) {
            let outcome = check_file(&format!("pipelines/{pipeline}.json"), &with(SMALL_CELL));
            without_scene.push((name.to_owned(), picture(&gpu, &outcome)));
        }
    }
    bytes += save(&folder.join("learn.jpg"), &sheet(without_scene, 5, SMALL_CELL))?;
    println!("{} of {} kB", folder.display(), bytes / 1000);
    if bytes > MAX_BYTES {
        return Err(format!("the sheets have more than {MAX_BYTES} bytes").into());
    }
    Ok(())
}

/// The sorted names of the files in a folder that end in `extension`, without that ending.
fn names(folder: &str, extension: &str) -> std::io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(root().join(folder))? {
        names.extend(entry?.file_name().to_string_lossy().strip_suffix(extension).map(str::to_owned));
    }
    names.sort();
    Ok(names)
}

fn draws_scenes(outcome: &Outcome) -> bool {
    outcome.plan().pipeline.passes.iter().any(|pass| pass.work().scene().is_some())
}

fn shows_a_picture(outcome: &Outcome) -> bool {
    outcome.plan().resources.contains_key("target")
}

/// Draws a scene with a pipeline; `None` if the pipeline does not use all lights of the scene.
fn drawn(gpu: &Gpu, outcome: &Outcome, scene: &Scene) -> Option<Picture> {
    let [width, height] = outcome.plan().viewport;
    let mut host = Host::new(gpu, outcome, scene);
    let mut input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
    let mut picture = host.picture(&input);
    for index in 1..FRAMES {
        input.index = index;
        picture = host.picture(&input);
    }
    host.executor.unread_lights(&input).is_empty().then_some(picture)
}

/// Arranges cells in rows, each below its label. Cells are `width` × `height` pixels.
fn sheet(cells: Vec<(String, Picture)>, columns: u32, [width, height]: [u32; 2]) -> Picture {
    let columns = columns.min(cells.len() as u32).max(1);
    let rows = (cells.len() as u32).div_ceil(columns).max(1);
    let step = [width + GAP, height + labels::HEIGHT + 2 * GAP];
    let size = [columns * step[0] - GAP, rows * step[1] - GAP];
    let mut sheet = Picture::filled(size[0], size[1], Channels::Rgb, &[24, 26, 32]);
    for (at, (label, cell)) in (0..).zip(&cells) {
        let [x, y] = [at % columns * step[0], at / columns * step[1]];
        labels::write(&mut sheet, label, [x + GAP, y]);
        paste(&mut sheet, cell, [x, y + labels::HEIGHT + GAP / 2]);
    }
    sheet
}

/// Writes a sheet as a JPEG file, and returns its size in bytes.
fn save(path: &Path, sheet: &Picture) -> Result<u64, Box<dyn std::error::Error>> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 85);
    encoder.write_image(sheet.bytes(), sheet.width(), sheet.height(), ExtendedColorType::Rgb8)?;
    std::fs::write(path, &bytes)?;
    println!("{}: {} by {}, {} kB", path.display(), sheet.width(), sheet.height(), bytes.len() / 1000);
    Ok(bytes.len() as u64)
}
