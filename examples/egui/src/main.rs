//! A window with the live frame of a pipeline, and a slider for each of its live parameters.
//!
//! `cargo run [-- PIPELINE.json [SCENE.glb]]`; with `--photograph FOLDER` the window moves a slider by itself and
//! leaves a picture of before and one of after ([`drive`]).

mod app;
mod controls;
mod drive;

use std::path::PathBuf;

use app::Viewer;
use drive::Drive;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/courtyard.glb");

fn main() -> eframe::Result {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let drive = arguments.iter().position(|argument| argument == "--photograph").map(|at| {
        let folder: Vec<_> = arguments.drain(at..arguments.len().min(at + 2)).collect();
        Drive::new(folder.get(1).map_or(PathBuf::from("."), PathBuf::from))
    });
    let mut arguments = arguments.into_iter();
    let pipeline = arguments.next().unwrap_or_else(|| "umbragraph:nebula.json".to_owned());
    let scene = arguments.next().unwrap_or_else(|| SCENE.to_owned());
    let options = eframe::NativeOptions {
        renderer: eframe::Renderer::Wgpu,
        viewport: eframe::egui::ViewportBuilder::default().with_inner_size([1100.0, 620.0]),
        ..Default::default()
    };
    eframe::run_native(
        "umbragraph",
        options,
        Box::new(move |context| Ok(Box::new(Viewer::new(context, &pipeline, scene.as_ref(), drive)?))),
    )
}
