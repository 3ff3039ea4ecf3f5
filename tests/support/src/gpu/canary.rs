//! A first computation whose answer is known.
//!
//! A driver that enumerates well can still do nothing, or nonsense. Before any test relies on a device, it squares
//! 64 numbers in a compute shader and the results are read back; any other answer disqualifies the adapter.

use std::fmt;
use std::sync::mpsc;

const COUNT: u32 = 64;

const SHADER: &str = "
@group(0) @binding(0) var<storage, read_write> numbers: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    numbers[id.x] = numbers[id.x] * numbers[id.x] + 1u;
}
";

/// The reason why a device cannot be relied on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CanaryError {
    /// The device rejected the shader, or an object that runs the shader.
    Rejected(String),
    /// The results could not be read back.
    ReadBack(String),
    /// A result is wrong; describes the first one.
    Wrong {
        /// The index of the wrong result.
        index: u32,
        /// The correct result.
        expected: u32,
        /// The wrong result.
        actual: u32,
    },
}

impl fmt::Display for CanaryError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rejected(reason) => write!(formatter, "a compute shader was rejected: {reason}"),
            Self::ReadBack(reason) => write!(formatter, "a buffer cannot be read back: {reason}"),
            Self::Wrong { index, expected, actual } => {
                write!(formatter, "a compute shader wrote {actual} instead of {expected} at {index}")
            }
        }
    }
}

impl std::error::Error for CanaryError {}

/// Runs a compute shader on the device and verifies the results.
pub(super) fn check(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<(), CanaryError> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let result = compute(device, queue);
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(CanaryError::Rejected(error.to_string()));
    }
    verify(&result?)
}

fn compute(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<u32>, CanaryError> {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("canary"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("canary"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let size = u64::from(COUNT) * 4;
    let buffer = |label, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let numbers = buffer("canary numbers", usage);
    let read_back = buffer("canary read-back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let input: Vec<u8> = (0..COUNT).flat_map(u32::to_le_bytes).collect();
    queue.write_buffer(&numbers, 0, &input);
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("canary"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: numbers.as_entire_binding() }],
    });
    let mut encoder =
        device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("canary") });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&numbers, 0, &read_back, 0, size);
    queue.submit([encoder.finish()]);

    let failed = |reason: String| CanaryError::ReadBack(reason);
    let (sender, receiver) = mpsc::channel();
    read_back.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver lives until the end of this function, which the poll below does not outlast.
        let _ = sender.send(result);
    });
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(error.to_string()))?;
    receiver
        .try_recv()
        .map_err(|error| failed(error.to_string()))?
        .map_err(|error| failed(error.to_string()))?;
    let view = read_back.get_mapped_range(..).map_err(|error| failed(error.to_string()))?;
    Ok(view.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect())
}

fn verify(results: &[u32]) -> Result<(), CanaryError> {
    for index in 0..COUNT {
        let expected = index * index + 1;
        let actual = results.get(index as usize).copied().unwrap_or(0);
        if actual != expected {
            return Err(CanaryError::Wrong { index, expected, actual });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squares_are_the_answer() {
        let results: Vec<u32> = (0..COUNT).map(|number| number * number + 1).collect();
        assert_eq!(verify(&results), Ok(()));
    }

    #[test]
    fn a_buffer_that_was_never_written_is_found_out() {
        assert_eq!(
            verify(&[0; COUNT as usize]),
            Err(CanaryError::Wrong { index: 0, expected: 1, actual: 0 })
        );
    }

    #[test]
    fn an_unchanged_input_is_found_out() {
        let input: Vec<u32> = (0..COUNT).collect();
        assert!(verify(&input).is_err());
    }

    #[test]
    fn missing_results_are_found_out() {
        assert!(verify(&[1, 2, 5]).is_err());
    }
}
