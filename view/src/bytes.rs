//! Bytes of buffers, from the device to the host, and stencils that were copied to one.

use umbragraph::executor::Texels;
use umbragraph::wgpu;

/// Waits for the device and reads back the bytes of a buffer.
///
/// # Errors
/// An error message if the device is lost or the buffer cannot be mapped.
pub(crate) fn of_buffer(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<u8>, String> {
    let copy = mappable(device, buffer.size());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    read(device, &copy)
}

/// The distance in bytes between the rows of a stencil copied to a buffer, with the alignment of copies.
pub(crate) fn stencil_row(width: u32) -> u32 {
    width.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Converts stencil bytes in aligned rows to texels with one channel of integers.
pub(crate) fn stencil(bytes: &[u8], [width, height, layers]: [u32; 3]) -> Texels {
    let rows = bytes.chunks_exact(stencil_row(width) as usize);
    let bytes = rows.flat_map(|row| row.iter().take(width as usize));
    let values = bytes.map(|byte| [f32::from(*byte), 0.0, 0.0, 1.0]).collect();
    Texels { width, height, layers, channels: 1, values }
}

fn mappable(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn read(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, String> {
    let (done, outcome) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |mapped| {
        let _ = done.send(mapped);
    });
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    outcome.recv().map_err(|error| error.to_string())?.map_err(|error| error.to_string())?;
    Ok(buffer.slice(..).get_mapped_range().map_err(|error| error.to_string())?.to_vec())
}
