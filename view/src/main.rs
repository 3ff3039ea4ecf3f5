//! `umbragraph-view`: a pipeline on a scene in a window, with its parameters, passes and textures.
//!
//! The module's own parts do the work: a [`Watcher`](umbragraph::Watcher) follows the files, a renderer records frames,
//! captures copy textures out of them. The window is eframe's, and its panels dock by `egui_tiles`.
//!
//! Exit status: 0 after the window is closed, 1 if it cannot be opened, 2 for a command line that cannot be understood.

mod act;
mod actions;
mod app;
mod arguments;
mod bars;
mod buffers;
mod bytes;
mod camera;
mod capture;
mod chart;
mod choices;
mod clock;
mod contents;
mod dock;
mod dropped;
mod files;
mod given;
mod graph;
mod guard;
mod histogram;
mod inspector;
mod notices;
mod output;
mod parameters;
mod places;
mod progress;
mod save;
mod screen;
mod shown;
mod sizes;
mod stage;
mod start;
mod state;
mod steer;
mod steps;
mod targets;
mod texels;
mod tiles;
mod timings;
mod turns;
mod values;

use std::process::ExitCode;

use clap::Parser as _;

use arguments::Arguments;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match start::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(said) => {
            eprint!("{said}");
            ExitCode::FAILURE
        }
    }
}
