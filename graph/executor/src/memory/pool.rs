//! Buffers for blocks that records in flight do not share.
//!
//! A write to a buffer takes effect before the whole submission that follows, so two records in one submission need two
//! buffers. Each record takes one from a pool; the encoder gives it back when the GPU is done with the submission, or
//! when the encoder is dropped without one. The pool grows to the number of records in flight and stays there; buffers
//! that go unused for long are dropped.
//!
//! One buffer for each record, rather than one ring with dynamic offsets, because WebGPU promises eight dynamic uniform
//! buffers in all, of which the host's objects take some: so a pass may read as many blocks as it likes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::objects::creation::Creation;

/// The number of records after which an unused buffer is dropped.
const KEPT_RECORDS: u64 = 256;

/// A pool of buffers for uniform and storage blocks, of which each record in flight has its own.
#[derive(Default)]
pub(crate) struct Pool {
    buffers: Vec<Pooled>,
}

struct Pooled {
    buffer: wgpu::Buffer,
    busy: Arc<AtomicBool>,
    used: u64,
}

/// Marks a buffer of the pool as free when dropped, whether or not the encoder was submitted.
struct GiveBack(Arc<AtomicBool>);

impl Drop for GiveBack {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

impl Pool {
    /// Reserves a buffer of at least `size` bytes until the GPU has finished the encoder's commands. `record` is the
    /// number of the record.
    pub(crate) fn take(
        &mut self,
        creation: &mut Creation<'_>,
        encoder: &wgpu::CommandEncoder,
        size: u64,
        record: u64,
    ) -> wgpu::Buffer {
        self.buffers.retain(|pooled| pooled.used + KEPT_RECORDS >= record && pooled.buffer.size() >= size);
        let free = self.buffers.iter().position(|pooled| !pooled.busy.load(Ordering::Acquire));
        let at = free.unwrap_or_else(|| {
            let buffer = creation.buffer(&wgpu::BufferDescriptor {
                label: Some("umbragraph blocks"),
                size,
                usage: wgpu::BufferUsages::UNIFORM
                    | wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.buffers.push(Pooled { buffer, busy: Arc::default(), used: record });
            self.buffers.len() - 1
        });
        let pooled = &mut self.buffers[at];
        pooled.used = record;
        pooled.busy.store(true, Ordering::Release);
        let give_back = GiveBack(pooled.busy.clone());
        encoder.on_submitted_work_done(move || drop(give_back));
        pooled.buffer.clone()
    }

    /// Drops all buffers, since some may have been rejected by the device.
    pub(crate) fn forget(&mut self) {
        self.buffers.clear();
    }
}
