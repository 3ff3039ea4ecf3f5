//! An application with a device, meshes and a shader of its own, which takes shadows, sky and tone mapping from
//! `pipelines/nebula.json`.
//!
//! The order of this file is that of an application. It reads and checks the pipeline (no device is needed for that),
//! opens a device, makes an executor, and each frame records into an encoder of its own. A window's surface texture
//! would stand in place of the target; here one frame is written as a picture.
//!
//! `cargo run --release --example own_meshes [FILE.png]`

mod dominoes;
mod shadows;

use std::path::{Path, PathBuf};

use dominoes::Dominoes;
use umbragraph::executor::{imported_texture, read_bytes};
use umbragraph::{Executor, Frame};

const SIZE: [u32; 2] = [960, 540];

/// The time between two frames, in seconds.
const STEP: f64 = 1.0 / 30.0;

fn main() {
    let out = std::env::args_os().nth(1).map_or(PathBuf::from("dominoes.png"), PathBuf::from);
    match run(&out) {
        Ok(()) => println!("{}: {} by {}", out.display(), SIZE[0], SIZE[1]),
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}

fn run(out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let plan = shadows::plan(shadows::interface(), SIZE)?;
    let (device, queue) = pollster::block_on(open())?;
    let meshes = Dominoes::new(&device, &queue);
    let target =
        imported_texture(&device, &plan, "target", wgpu::TextureUsages::COPY_SRC).ok_or("no target")?;
    // Pipelines, textures and bind groups are made here; a frame makes nothing.
    let mut executor = Executor::new(&device, &queue, plan, Some(&meshes))?;
    for index in 0..240 {
        let time = index as f64 * STEP;
        meshes.update(&queue, time);
        let input = shadows::input(f64::from(SIZE[0]) / f64::from(SIZE[1]), time, index);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))?;
        queue.submit([encoder.finish()]);
    }
    let texels = pollster::block_on(read_bytes(&device, &queue, &target))?;
    let file = std::io::BufWriter::new(std::fs::File::create(out)?);
    let mut encoder = png::Encoder::new(file, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgba);
    Ok(encoder.write_header()?.write_image_data(&texels)?)
}

/// Opens a device with the default limits of WebGPU, for which the plan was made.
async fn open() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    Ok(adapter.request_device(&wgpu::DeviceDescriptor::default()).await?)
}
