//! A graphics device for pictures without a window.

use umbragraph::diagnostic::{Diagnostic, Place, codes};
use wgpu::{Adapter, Backend, Backends, Device, DeviceType, Instance, InstanceDescriptor, Queue};

/// A device and the name of its adapter.
pub(crate) struct Graphics {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) name: String,
    /// What the adapter can do of what older ones cannot.
    pub(crate) flags: wgpu::DownlevelFlags,
}

/// The variable that names the adapter to be used, or a part of its name or backend.
const ADAPTER: &str = "UMBRAGRAPH_ADAPTER";

/// Opens the best adapter: discrete before integrated before software, and any other backend before OpenGL. The
/// environment variable `UMBRAGRAPH_ADAPTER` narrows the choice.
///
/// # Errors
/// No adapter, or one that rejects a device.
pub(crate) fn open() -> Result<Graphics, Diagnostic> {
    let found = |backends| {
        let descriptor = InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() };
        let mut adapters = pollster::block_on(Instance::new(descriptor).enumerate_adapters(backends));
        adapters.retain(|adapter| adapter.get_info().backend != Backend::Noop);
        adapters.sort_by_key(rank);
        adapters
    };
    // OpenGL last: where there is no display, its libraries complain on standard error of their own accord.
    let mut adapters = found(Backends::PRIMARY);
    if adapters.is_empty() || std::env::var_os(ADAPTER).is_some_and(|wanted| !wanted.is_empty()) {
        adapters = found(Backends::all());
    }
    let names: Vec<String> = adapters.iter().map(name).collect();
    if let Some(wanted) = std::env::var(ADAPTER).ok().filter(|wanted| !wanted.is_empty()) {
        adapters.retain(|adapter| name(adapter).to_lowercase().contains(&wanted.to_lowercase()));
        if adapters.is_empty() {
            let message = format!("no graphics adapter is called \"{wanted}\", as {ADAPTER} asks for");
            let help = if names.is_empty() {
                "there is none at all".to_owned()
            } else {
                format!("there are {}", names.join(", "))
            };
            return Err(Diagnostic::error(codes::NO_ADAPTER, Place::Nowhere, message).help(help));
        }
    }
    let Some(adapter) = adapters.first() else {
        return Err(Diagnostic::error(codes::NO_ADAPTER, Place::Nowhere, "no graphics adapter was found")
            .help("install a driver; on Debian and Ubuntu `apt install mesa-vulkan-drivers` gives one in software"));
    };
    let name = name(adapter);
    let wanted = wgpu::Features::all_webgpu_mask() | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("umbragraph"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    };
    match pollster::block_on(adapter.request_device(&descriptor)) {
        Ok((device, queue)) => {
            Ok(Graphics { device, queue, name, flags: adapter.get_downlevel_capabilities().flags })
        }
        Err(error) => {
            Err(Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("{name} gives no device: {error}"))
                .help("update the driver, or close what uses up its memory"))
        }
    }
}

fn name(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

fn rank(adapter: &Adapter) -> (bool, u8) {
    let info = adapter.get_info();
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (info.backend == Backend::Gl, kind)
}

/// Reads an rgba8 texture back, row 0 on top.
///
/// # Errors
/// A lost device, or one that cannot map the buffer.
pub(crate) fn read_rgba8(graphics: &Graphics, texture: &wgpu::Texture) -> Result<Vec<u8>, Diagnostic> {
    let (width, height) = (texture.width(), texture.height());
    let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = graphics.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = graphics.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: Some(height),
            },
        },
        texture.size(),
    );
    graphics.queue.submit([encoder.finish()]);
    let failed = |what: String| {
        Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("the picture cannot be read back: {what}"))
            .help("the device was lost; try a smaller picture, or another driver")
    };
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        let _ = sender.send(result);
    });
    graphics.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(error.to_string()))?;
    match receiver.recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(failed(error.to_string())),
        Err(error) => return Err(failed(error.to_string())),
    }
    let mapped = buffer.slice(..).get_mapped_range().map_err(|error| failed(error.to_string()))?;
    let bytes: &[u8] = &mapped;
    Ok(bytes.chunks_exact(row as usize).flat_map(|line| &line[..width as usize * 4]).copied().collect())
}
