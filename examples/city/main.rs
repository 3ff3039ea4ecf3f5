//! An application with a device, matrices and meshes of its own (500 boxes from one storage buffer), which takes its
//! shadows from `pipelines/umbra.json` and puts a pass of its own after them.
//!
//! `shadows.rs` is all of it that concerns umbragraph; `city.json` extends the pipeline, `lib/meshes.wgsl.jinja` says
//! what a vertex and an instance are, and `vignette.wgsl.jinja` is the pass.
//!
//! `cargo run --release --example city [FILE.png]`

mod city;
mod shadows;

use std::path::{Path, PathBuf};

const SIZE: [u32; 2] = [960, 540];

fn main() {
    let out = std::env::args_os().nth(1).map_or(PathBuf::from("city.png"), PathBuf::from);
    match run(&out) {
        Ok(()) => println!("{}: {} by {}", out.display(), SIZE[0], SIZE[1]),
        Err(error) => {
            eprintln!("{error}");
            std::process::exit(1);
        }
    }
}

fn run(out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let pipeline = shadows::pipeline()?;
    let (device, queue) = pollster::block_on(open())?;
    let city = city::City::new(&device, &queue);
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut renderer = umbragraph::Renderer::new(&device, &queue);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    shadows::record((&mut renderer, &pipeline), &mut encoder, &city, &target, (0.8, 0.5))?;
    queue.submit([encoder.finish()]);
    let texels = pollster::block_on(umbragraph::executor::read_bytes(&device, &queue, &target))?;
    let mut encoder =
        png::Encoder::new(std::io::BufWriter::new(std::fs::File::create(out)?), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgba);
    Ok(encoder.write_header()?.write_image_data(&texels)?)
}

/// Opens a device with the default limits of WebGPU.
async fn open() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    Ok(adapter.request_device(&wgpu::DeviceDescriptor::default()).await?)
}
