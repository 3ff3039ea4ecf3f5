//! Pictures from the device to a file.

use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Place, codes};

use crate::device::Graphics;
use crate::replace::{replace, unwritable};

/// Reads an rgba8 texture back, row 0 on top.
///
/// # Errors
/// A lost device, or one that cannot map the buffer.
pub(crate) fn read_back(graphics: &Graphics, texture: &wgpu::Texture) -> Result<Vec<u8>, Diagnostic> {
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

/// Writes a PNG, and makes its folder where that is missing.
///
/// # Errors
/// A folder that does not exist or cannot be written to.
pub(crate) fn write_png(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), Diagnostic> {
    let failed = |error: &dyn std::fmt::Display| unwritable(path, error);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|error| failed(&error))?;
    writer.write_image_data(rgba).map_err(|error| failed(&error))?;
    writer.finish().map_err(|error| failed(&error))?;
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| failed(&error))?;
    }
    replace(path, &bytes).map_err(|error| failed(&error))
}
