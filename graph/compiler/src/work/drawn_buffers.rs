//! Ranges of vertex and index buffers that a draw reads: as many elements as it counts.
//!
//! WebGPU rejects a draw that counts more than its buffers hold. Of an indexed draw that are indices, and elements by
//! instance; which vertices indices name is not known, and what lies beyond is cut off by the device.

use umbragraph_pipeline::work::{BufferDraw, ResourceHandle};

/// The count of a draw by which the elements of a buffer are counted.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counted {
    /// The number of vertices; for an indexed draw, the number of indices.
    Elements,
    Instances,
}

/// The layout of a vertex or index buffer that a draw reads.
pub(crate) struct DrawnBuffer {
    pub(crate) buffer: ResourceHandle,
    /// The count of the draw that is the number of elements read.
    pub(crate) counted: Counted,
    /// The distance from one element to the next in bytes.
    stride: u64,
    /// The number of bytes read of the last element.
    last: u64,
}

impl DrawnBuffer {
    /// Returns the buffers of which a draw reads a known number of elements. Per-vertex buffers of an indexed draw are
    /// left out.
    pub(crate) fn all(draw: &BufferDraw) -> Vec<Self> {
        let streams = draw.vertices.iter().filter_map(|stream| {
            let counted = match (stream.step, &draw.indices) {
                (wgpu_types::VertexStepMode::Instance, _) => Counted::Instances,
                (_, None) => Counted::Elements,
                (_, Some(_)) => return None,
            };
            let last = stream.attributes.iter().map(|one| one.offset + one.format.size()).max().unwrap_or(0);
            Some(Self { buffer: stream.buffer.resource, counted, stride: stream.stride, last })
        });
        let indices = draw.indices.as_ref().map(|indices| {
            let size = if indices.format == wgpu_types::IndexFormat::Uint16 { 2 } else { 4 };
            Self { buffer: indices.buffer.resource, counted: Counted::Elements, stride: size, last: size }
        });
        streams.chain(indices).collect()
    }

    /// Returns the number of bytes that a number of elements occupies.
    pub(crate) fn bytes(&self, elements: u64) -> u64 {
        if elements == 0 { 0 } else { (elements - 1) * self.stride + self.last }
    }

    /// Returns the number of elements that fit into a number of bytes; `None` if any number fits, with a stride of 0.
    pub(crate) fn elements(&self, bytes: u64) -> Option<u64> {
        match (bytes.checked_sub(self.last), self.stride) {
            (None, _) => Some(0),
            (Some(_), 0) => None,
            (Some(rest), stride) => Some(1 + rest / stride),
        }
    }
}
