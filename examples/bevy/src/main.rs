//! Writes the picture of the scene: `cargo run [FILE.png]`.

use std::io::BufWriter;

use umbragraph_bevy::scene::{SIZE, app, picture};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args_os().nth(1).unwrap_or_else(|| "bevy.png".into());
    let mut app = app(concat!(env!("CARGO_MANIFEST_DIR"), "/assets"));
    let texels = picture(&mut app, &[], 120).ok_or("no picture was drawn")?;
    let mut encoder = png::Encoder::new(BufWriter::new(std::fs::File::create(out)?), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&texels)?;
    Ok(())
}
