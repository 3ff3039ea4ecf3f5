//! One graphics device for tests.
//!
//! All adapters of the machine are enumerated and ranked by a written rule; the first whose device computes a known
//! answer is taken, and its name is printed once. The noop backend never counts as an adapter: with
//! it, every test that reads nothing back would pass.
//!
//! The choice is made once in a process, the device again for each caller, so that a test which loses or poisons its
//! device does not reach into another. A machine without an adapter skips the test, with a count; with
//! `UMBRAGRAPH_REQUIRE_GPU=1` that is a failure.
//!
//! ```
//! use umbragraph_test_support::gpu;
//!
//! let Some(gpu) = gpu::device() else { return };
//! assert!(!gpu.name.is_empty());
//! ```

mod canary;
mod choice;

use std::sync::OnceLock;

use crate::{environment, skip};
pub use canary::CanaryError;
pub use choice::{AdapterSummary, preference};

/// Optional features that tests may use if the adapter has them; [`Gpu::device`] reports the enabled ones.
pub const OPTIONAL_FEATURES: wgpu::Features = wgpu::Features::FLOAT32_FILTERABLE
    .union(wgpu::Features::TIMESTAMP_QUERY)
    .union(wgpu::Features::DEPTH_CLIP_CONTROL)
    .union(wgpu::Features::DUAL_SOURCE_BLENDING)
    .union(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM)
    .union(wgpu::Features::DEPTH32FLOAT_STENCIL8)
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);

/// A tested graphics device, with its instance, adapter and queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The wgpu instance that the adapter comes from.
    pub instance: wgpu::Instance,
    /// The adapter that the device was opened on.
    pub adapter: wgpu::Adapter,
    /// A device that is not shared with other callers. It has WebGPU's default limits and the [`OPTIONAL_FEATURES`] of
    /// the adapter.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// The adapter's name and backend, such as `llvmpipe (LLVM 15.0.6, 256 bits) on vulkan`.
    pub name: String,
}

impl Gpu {
    /// Creates a texture of the given size in pixels, to render into and to read back.
    #[must_use]
    pub fn target(&self, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("target"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Returns the number of frames of which a benchmark takes the shortest. A GPU raises its clock in the first
    /// frames.
    #[must_use]
    pub fn frames(&self) -> usize {
        if self.adapter.get_info().device_type == wgpu::DeviceType::Cpu { 4 } else { 100 }
    }

    /// Opens another device of the same adapter, with other limits than WebGPU's defaults.
    ///
    /// # Panics
    /// If the adapter does not support the limits.
    #[must_use]
    pub fn with_limits(&self, limits: wgpu::Limits) -> Self {
        self.with(limits, self.device.features())
    }

    /// Opens another device of the same adapter, with other limits and features.
    ///
    /// # Panics
    /// If the adapter does not support the limits or features.
    #[must_use]
    pub fn with(&self, limits: wgpu::Limits, features: wgpu::Features) -> Self {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("umbragraph tests, other limits"),
            required_features: features,
            required_limits: limits,
            ..Default::default()
        };
        match pollster::block_on(self.adapter.request_device(&descriptor)) {
            Ok((device, queue)) => Self { device, queue, ..self.clone() },
            Err(error) => panic!("{} has no device with these limits: {error}", self.name),
        }
    }
}

/// Returns `true` if a test must fail without an adapter.
pub fn require_gpu() -> bool {
    environment::is_set(&environment::process, environment::REQUIRE_GPU)
}

/// Returns a device for one test. Returns `None`, and counts the test as skipped, if the machine has no usable adapter.
///
/// # Panics
/// If there is no matching adapter, and `UMBRAGRAPH_REQUIRE_GPU=1` or `UMBRAGRAPH_ADAPTER` is set.
#[must_use]
pub fn device() -> Option<Gpu> {
    static CHOSEN: OnceLock<Result<Chosen, String>> = OnceLock::new();
    let opened = CHOSEN
        .get_or_init(choose)
        .as_ref()
        .map_err(Clone::clone)
        .and_then(|chosen| open(&chosen.instance, &chosen.adapter).map_err(|error| error.to_string()));
    match opened {
        Ok(gpu) => Some(gpu),
        Err(reason) => {
            if let Some(demand) = demand(&environment::process) {
                panic!(
                    "no usable graphics adapter, and {demand} asks for one: {reason}\n`cargo xtask test` installs \
                     a software driver or says which to install"
                );
            }
            skip::skipped(&format!("no adapter: {reason}"));
            None
        }
    }
}

/// Returns the variable that makes a missing adapter a failure; `None` if neither is set.
fn demand(lookup: environment::Lookup<'_>) -> Option<&'static str> {
    [environment::REQUIRE_GPU, environment::ADAPTER]
        .into_iter()
        .find(|&variable| environment::is_set(lookup, variable))
}

struct Chosen {
    instance: wgpu::Instance,
    adapter: wgpu::Adapter,
}

/// Opens the best adapter that computes correctly, or returns the reason why there is none.
fn choose() -> Result<Chosen, String> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let wanted = environment::process(environment::ADAPTER).map(|text| text.to_string_lossy().into_owned());
    let summaries: Vec<_> = adapters.iter().map(|adapter| summary(&adapter.get_info())).collect();
    let order = preference(&summaries, wanted.as_deref());
    if order.is_empty() {
        return Err(choice::explain_nothing(&summaries, wanted.as_deref()));
    }
    let mut rejected = Vec::new();
    for index in order {
        let attempt = open(&instance, &adapters[index])
            .map_err(|error| error.to_string())
            .and_then(|gpu| canary::check(&gpu.device, &gpu.queue).map_err(|error| error.to_string()));
        match attempt {
            Ok(()) => {
                skip::announce(&format!("adapter: {}", summaries[index]));
                return Ok(Chosen { instance, adapter: adapters[index].clone() });
            }
            Err(reason) => {
                let rejection = format!("{}: {reason}", summaries[index]);
                skip::announce(&format!("adapter rejected: {rejection}"));
                rejected.push(rejection);
            }
        }
    }
    Err(format!("no adapter passed its first computation: {}", rejected.join("; ")))
}

fn open(instance: &wgpu::Instance, adapter: &wgpu::Adapter) -> Result<Gpu, wgpu::RequestDeviceError> {
    let offered = adapter.limits();
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("umbragraph tests"),
        required_features: adapter.features() & OPTIONAL_FEATURES,
        // OpenGL drivers may lie below WebGPU's defaults; what they lack then fails where it is used.
        required_limits: wgpu::Limits::default().or_worse_values_from(&offered),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let name = summary(&adapter.get_info()).to_string();
    Ok(Gpu { instance: instance.clone(), adapter: adapter.clone(), device, queue, name })
}

fn summary(info: &wgpu::AdapterInfo) -> AdapterSummary {
    AdapterSummary { name: info.name.clone(), backend: info.backend, device_type: info.device_type }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_is_demanded_by_requirement_or_by_name() {
        let only = |set: &'static str| move |name: &str| (name == set).then(|| "1".into());
        assert_eq!(demand(&|_| None), None);
        assert_eq!(demand(&only(environment::REQUIRE_GPU)), Some("UMBRAGRAPH_REQUIRE_GPU"));
        assert_eq!(demand(&only(environment::ADAPTER)), Some("UMBRAGRAPH_ADAPTER"));
        assert_eq!(demand(&only(environment::BLESS)), None);
    }

    #[test]
    fn the_device_is_real_and_offers_the_default_limits() {
        let Some(gpu) = device() else { return };
        assert_ne!(gpu.adapter.get_info().backend, wgpu::Backend::Noop);
        if gpu.adapter.get_info().backend != wgpu::Backend::Gl {
            let limits = gpu.device.limits();
            assert!(limits.max_texture_dimension_2d >= wgpu::Limits::default().max_texture_dimension_2d);
        }
        assert_eq!(gpu.device.features() & OPTIONAL_FEATURES, gpu.adapter.features() & OPTIONAL_FEATURES);
    }

    #[test]
    fn each_caller_has_a_device_of_its_own() {
        let Some(first) = device() else { return };
        let Some(second) = device() else { return };
        assert_ne!(first.device, second.device);
        first.device.destroy();
        assert!(canary::check(&second.device, &second.queue).is_ok());
    }

    #[test]
    fn the_canary_finds_a_device_that_computes_nothing() {
        let Some(gpu) = device() else { return };
        gpu.device.destroy();
        assert!(canary::check(&gpu.device, &gpu.queue).is_err());
    }
}
