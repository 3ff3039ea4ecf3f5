//! The window drives itself: it takes a picture, moves the slider of "exposure" with the pointer, and takes another.
//!
//! Events go in where those of the window system do, so what is shown is what a hand would have made.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use eframe::egui::{self, Event, PointerButton, Pos2, Rect};
use umbragraph::executor::Statistics;

use crate::controls::RAIL;

const NAME: &str = "exposure";

/// The number of the frame for the first picture, when sizes have settled. The slider is held from `HELD` on; `AFTER`
/// is the frame of the second picture.
const BEFORE: u32 = 20;
const HELD: u32 = 30;
const AFTER: u32 = 50;
const END: u32 = 60;

pub(crate) struct Drive {
    folder: PathBuf,
    frame: u32,
    rect: Option<Rect>,
    before: Option<Statistics>,
    pictures: [Arc<Mutex<Option<Arc<egui::ColorImage>>>>; 2],
}

impl Drive {
    pub(crate) fn new(folder: PathBuf) -> Self {
        Self { folder, frame: 0, rect: None, before: None, pictures: Default::default() }
    }

    /// Stores the rectangle of the slider, if `name` is the driven parameter.
    pub(crate) fn sees(&mut self, name: &str, rect: Rect) {
        if name == NAME {
            self.rect = Some(rect);
        }
    }

    /// Advances the scripted pointer before a frame.
    pub(crate) fn step(
        &mut self,
        context: &egui::Context,
        input: &mut egui::RawInput,
        statistics: Option<Statistics>,
    ) {
        self.frame += 1;
        let Some(rect) = self.rect else { return };
        // From the left end of the rail to two thirds of it.
        let at = |part: f32| Pos2::new(rect.left() + part * RAIL, rect.center().y);
        let button = |pos, pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::default(),
        };
        match self.frame {
            BEFORE => {
                self.before = statistics;
                self.photograph(context, 0);
            }
            HELD => input.events.extend([Event::PointerMoved(at(0.1)), button(at(0.1), true)]),
            frame if (HELD + 1..HELD + 10).contains(&frame) => {
                let part = 0.1 + 0.065 * (frame - HELD) as f32;
                input.events.push(Event::PointerMoved(at(part)));
            }
            frame if frame == HELD + 10 => input.events.push(button(at(0.685), false)),
            AFTER => self.photograph(context, 1),
            END => {
                println!("nothing created: {}", self.before.is_some() && self.before == statistics);
                for (name, picture) in ["before.png", "after.png"].iter().zip(&self.pictures) {
                    if let Some(picture) = picture.lock().ok().and_then(|mut picture| picture.take())
                        && let Err(error) = save(&self.folder.join(name), &picture)
                    {
                        eprintln!("{name}: {error}");
                    }
                }
                context.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            _ => {}
        }
    }

    fn photograph(&self, context: &egui::Context, at: usize) {
        let picture = self.pictures[at].clone();
        context.request_screenshot(move |image| {
            if let Ok(mut picture) = picture.lock() {
                *picture = Some(image);
            }
        });
    }
}

fn save(path: &Path, image: &egui::ColorImage) -> Result<(), Box<dyn std::error::Error>> {
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, image.size[0] as u32, image.size[1] as u32);
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}
