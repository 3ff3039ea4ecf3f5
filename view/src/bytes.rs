//! Stencils that were copied to a buffer.

use umbragraph::executor::Texels;
use umbragraph::wgpu;

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
