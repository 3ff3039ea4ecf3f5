//! An application with a device, meshes and a shader of its own, which takes shadows, sky and tone mapping from
//! `pipelines/nebula.json`.
//!
//! What an application does, in the order of this file: read and check the pipeline (no device is needed for that), open
//! a device, make an executor, and each frame record into an encoder of its own. A window's surface texture would stand
//! where the target stands; here one frame is written as a picture.
//!
//! `cargo run --release --example own_meshes [FILE.png]`

mod dominoes;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dominoes::{Dominoes, GEOMETRY, interface};
use umbragraph::frame::{Camera, FrameInput, Light, Projection};
use umbragraph::{Executor, Frame, Library, Options, Plan, wgpu};

const SIZE: [u32; 2] = [960, 540];

/// The seconds of a frame.
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
    let plan = plan()?;
    let (device, queue) = pollster::block_on(open())?;
    let meshes = Dominoes::new(&device, &queue);
    let target = target(&device);
    // Pipelines, textures and bind groups are made here; a frame makes nothing.
    let mut executor = Executor::new(&device, &queue, plan, Some(&meshes))?;
    for index in 0..240 {
        let time = index as f64 * STEP;
        meshes.update(&queue, time);
        let input = frame(time, index);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))?;
        queue.submit([encoder.finish()]);
    }
    save(&device, &queue, &target, out)
}

/// Reads the pipeline and the shader, and compares what they want with what the meshes are. No device is needed, so a
/// test of the application can do the same.
fn plan() -> Result<Arc<Plan>, umbragraph::Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_meshes");
    let library = Library::new().templates(&folder).host(GEOMETRY, interface());
    library.load(folder.join("dominoes.json"))?.plan(&Options::new(SIZE[0], SIZE[1]))
}

/// A device with the limits that WebGPU promises: the profile of [`plan`].
async fn open() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    Ok(adapter.request_device(&wgpu::DeviceDescriptor::default()).await?)
}

/// What the pipeline calls `target`.
fn target(device: &wgpu::Device) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The camera and the sun of a moment.
fn frame(time: f64, index: u64) -> FrameInput {
    let mut sun = Light::directional("sun", [-0.8, -0.7, -0.35], [1.0, 0.92, 0.8], 4.0);
    sun.properties.push("cast_shadow".into());
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let camera = Camera::look_at([1.2, 4.6, 6.2], [0.3, 0.0, 0.3], 0.8, aspect)
        .projection(Projection::Perspective { vertical_fov: 0.8, near: 0.1, far: 40.0 });
    FrameInput::new(camera)
        .lights(vec![sun])
        .filter_bounds("casters", Dominoes::bounds())
        .scene_bounds(Dominoes::bounds())
        .time(time)
        .index(index)
}

/// Reads the target back and writes it as a PNG.
fn save(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    target: &wgpu::Texture,
    out: &Path,
) -> Result<(), Box<dyn std::error::Error>> {
    let bytes_per_row = SIZE[0] * 4;
    assert!(bytes_per_row.is_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT));
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(bytes_per_row * SIZE[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        target.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        target.size(),
    );
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
    device.poll(wgpu::PollType::wait_indefinitely())?;
    receiver.recv()??;
    let mut encoder =
        png::Encoder::new(std::io::BufWriter::new(std::fs::File::create(out)?), SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&buffer.slice(..).get_mapped_range()?)?;
    Ok(())
}
