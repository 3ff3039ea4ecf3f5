//! Draws from the pipeline's own buffers, with everything that they need on the device.

use crate::memory::resources::Resources;
use crate::memory::transfer::Counts;
use umbragraph_compiler::{Plan, Switches};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::work::{BufferDraw, DrawCounts, Live};

/// A draw whose vertices, indices or arguments come from buffers of the pipeline.
pub(crate) struct InstantiatedDraw {
    vertices: Vec<Counts>,
    indices: Option<(Counts, wgpu::IndexFormat)>,
    counts: InstantiatedCounts,
}

enum InstantiatedCounts {
    Direct { count: Live<u32>, instances: Live<u32> },
    Indirect(Counts),
}

impl InstantiatedDraw {
    /// Creates the draw with the buffers of its resources.
    pub(crate) fn new(resources: &Resources, plan: &Plan, draw: &BufferDraw) -> Self {
        let counts = |buffer| Counts::new(resources, plan, buffer);
        Self {
            vertices: draw.vertices.iter().map(|stream| counts(&stream.buffer)).collect(),
            indices: draw.indices.as_ref().map(|indices| (counts(&indices.buffer), indices.format)),
            counts: match &draw.counts {
                &DrawCounts::Direct { count, instances } => InstantiatedCounts::Direct { count, instances },
                DrawCounts::Indirect(buffer) => InstantiatedCounts::Indirect(counts(buffer)),
            },
        }
    }

    /// Updates the number of vertices, indices or instances from the live values of the frame.
    pub(crate) fn update(&mut self, values: &[Value]) {
        if let InstantiatedCounts::Direct { count, instances } = &mut self.counts {
            count.update(values);
            instances.update(values);
        }
    }

    /// Records the draw. Draws nothing if a buffer is missing.
    pub(crate) fn record(
        &self,
        resources: &Resources,
        switches: &Switches,
        pass: &mut wgpu::RenderPass<'static>,
    ) -> Option<()> {
        for (slot, stream) in (0..).zip(&self.vertices) {
            pass.set_vertex_buffer(slot, stream.buffer(resources, switches)?.slice(..));
        }
        if let Some((indices, format)) = &self.indices {
            pass.set_index_buffer(indices.buffer(resources, switches)?.slice(..), *format);
        }
        match (&self.counts, &self.indices) {
            (InstantiatedCounts::Direct { count, instances }, None) => {
                pass.draw(0..count.value, 0..instances.value);
            }
            (InstantiatedCounts::Direct { count, instances }, Some(_)) => {
                pass.draw_indexed(0..count.value, 0, 0..instances.value);
            }
            (InstantiatedCounts::Indirect(counts), None) => {
                pass.draw_indirect(counts.buffer(resources, switches)?, counts.offset);
            }
            (InstantiatedCounts::Indirect(counts), Some(_)) => {
                pass.draw_indexed_indirect(counts.buffer(resources, switches)?, counts.offset);
            }
        }
        Some(())
    }
}
