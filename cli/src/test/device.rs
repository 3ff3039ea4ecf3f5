//! One compute pass: each row of the tests of a variant in a workgroup of its own.
//!
//! A driver may hang in what it compiles as well as in what it runs, so that all of it is done on a thread of its own.
//!
//! Limits: a pass that does not end within the time limit leaves the device and the thread behind; nothing further
//! runs.

use std::collections::BTreeMap;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use umbragraph::diagnostic::{Diagnostic, Place, codes};

use super::instrument::{ENTRY_POINT, RESULT_WORDS};
use super::running::STACK_BYTES;
use crate::device::Graphics;

/// The result of one test row, as the shader wrote it.
pub(super) type RowResult = [u32; RESULT_WORDS];

/// The reason why a compute pass has no results.
pub(super) enum Failure {
    /// The pass did not end within the time limit.
    TimedOut,
    /// The device rejected an object or was lost.
    Device(Box<Diagnostic>),
}

/// Runs the test rows of one shader source, with values for its `override` constants.
///
/// # Errors
/// The time limit is exceeded, or the device reports an error.
pub(super) fn run(
    graphics: &Graphics,
    wgsl: &str,
    constants: &BTreeMap<String, f64>,
    rows: usize,
    limit: Duration,
) -> Result<Vec<RowResult>, Failure> {
    let (device, queue) = (graphics.device.clone(), graphics.queue.clone());
    let (wgsl, constants) = (wgsl.to_owned(), constants.clone());
    let (sender, receiver) = std::sync::mpsc::channel();
    // Whoever no longer waits needs no answer.
    let work = move || drop(sender.send(dispatch(&device, &queue, wgsl, &constants, rows)));
    let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(work);
    let answer = match receiver.recv_timeout(limit) {
        Err(RecvTimeoutError::Timeout) => return Err(Failure::TimedOut),
        Err(RecvTimeoutError::Disconnected) => Err("the driver failed without a word".to_owned()),
        Ok(answer) => answer,
    };
    // What it drops must be gone before the process ends.
    let _ = thread.map(std::thread::JoinHandle::join);
    answer.map_err(|error| {
        let message = format!("{} cannot run the tests: {error}", graphics.name);
        let help = "choose another adapter (--adapter); `umbragraph adapters` lists them";
        Failure::Device(Box::new(Diagnostic::error(codes::DEVICE, Place::Nowhere, message).help(help)))
    })
}

/// Dispatches the tests and waits for the results without a time limit.
///
/// # Errors
/// An error of the device.
fn dispatch(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    wgsl: String,
    constants: &BTreeMap<String, f64>,
    rows: usize,
) -> Result<Vec<RowResult>, String> {
    let scopes = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation];
    let scopes = scopes.map(|filter| device.push_error_scope(filter));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("shader tests"),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    });
    let constants: Vec<(&str, f64)> = constants.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("shader tests"),
        layout: None,
        module: &module,
        entry_point: Some(ENTRY_POINT),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    });
    let size = (rows * size_of::<RowResult>()) as u64;
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("results"),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let results = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("results"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: results.as_entire_binding() }],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(rows as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&results, 0, &read, 0, size);
    queue.submit([encoder.finish()]);
    // All are closed, the innermost first, since wgpu panics otherwise.
    let errors = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
    let errors: Vec<wgpu::Error> = errors.collect::<Vec<_>>().into_iter().flatten().collect();
    if let Some(error) = errors.first() {
        return Err(error.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
    }
    let (sender, receiver) = std::sync::mpsc::channel();
    read.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    receiver.recv().map_err(|error| error.to_string())?.map_err(|error| error.to_string())?;
    let bytes = read.slice(..).get_mapped_range().map_err(|error| error.to_string())?;
    let words = bytes.chunks_exact(4).map(|word| word.try_into().map_or(0, u32::from_le_bytes));
    let words: Vec<u32> = words.collect();
    Ok(words.chunks_exact(RESULT_WORDS).filter_map(|row| row.try_into().ok()).collect())
}
