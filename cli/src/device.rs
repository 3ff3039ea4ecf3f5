//! A graphics device for pictures without a window.

mod messages;

use umbragraph::diagnostic::{Diagnostic, Place, codes};
use umbragraph::low_level::adapter::{Wanted, device_descriptor};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::shader::TargetProfile;
use wgpu::{Adapter, Backend, Backends, Device, Instance, InstanceDescriptor, Queue};

/// A graphics device with its queue, its adapter and the adapter's name.
pub(crate) struct Graphics {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) name: String,
    adapter: Adapter,
}

/// Opens the best adapter: discrete before integrated before software, and any other backend before OpenGL. `named`, a
/// part of the adapter's name or backend, and environment variables narrow the choice.
///
/// # Errors
/// No adapter, an adapter that provides no device, or an invalid value of an environment variable.
pub(crate) fn open(named: Option<&str>) -> Result<Graphics, Diagnostic> {
    let (name, adapter) = choose(named)?;
    let (device, queue) = request(&name, &adapter)?;
    Ok(Graphics { device, queue, name, adapter })
}

/// Returns the name of the adapter that [`open`] takes.
///
/// # Errors
/// No adapter, or an invalid value of an environment variable.
pub(crate) fn chosen(named: Option<&str>) -> Result<String, Diagnostic> {
    Ok(choose(named)?.0)
}

fn choose(named: Option<&str>) -> Result<(String, Adapter), Diagnostic> {
    let wanted = Wanted::new(named)?;
    // OpenGL last: it has less, and it has to be asked only where nothing else is there or it is called by its name.
    let mut adapters = found(wanted.backends.unwrap_or(Backends::PRIMARY));
    if wanted.backends.is_none() && (adapters.is_empty() || wanted.name.is_some()) {
        adapters = found(Backends::all());
    }
    wanted.best(adapters)
}

/// Opens a device on an adapter, with all WebGPU features and limits that the adapter supports.
///
/// # Errors
/// The adapter provides no device.
pub(crate) fn request(name: &str, adapter: &Adapter) -> Result<(Device, Queue), Diagnostic> {
    pollster::block_on(adapter.request_device(&device_descriptor(adapter))).map_err(|error| {
        Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("{name} gives no device: {error}")).help(
            "update the driver, close what uses up its memory, or choose another adapter (`umbragraph adapters` lists them)",
        )
    })
}

/// Returns the adapters that the environment variables allow, with their names: the best first, OpenGL last.
///
/// # Errors
/// No adapter, or an invalid value of an environment variable.
pub(crate) fn all() -> Result<Vec<(String, Adapter)>, Diagnostic> {
    let wanted = Wanted::new(None)?;
    wanted.among(found(wanted.backends.unwrap_or(Backends::all())))
}

fn found(backends: Backends) -> Vec<Adapter> {
    messages::listen();
    let descriptor = InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() };
    // The variable of backends is read already, with an error where it says nonsense.
    let descriptor = InstanceDescriptor { backends, ..descriptor.with_env() };
    pollster::block_on(Instance::new(descriptor).enumerate_adapters(backends))
}

/// Returns the target profile of a pipeline on an adapter: limited to what the adapter supports, with the device
/// features that the pipeline can use.
pub(crate) fn profile_on(pipeline: &TypedPipeline, adapter: &Adapter) -> TargetProfile {
    let features = pipeline.device_features() & adapter.features();
    let flags = adapter.get_downlevel_capabilities().flags;
    let profile = pipeline.profile.clone().on_device(&adapter.limits(), flags);
    if features.is_empty() { profile } else { profile.with_features(features) }
}

impl Graphics {
    /// Returns `true` if the device has compute shaders, which some OpenGL drivers lack.
    pub(crate) fn has_compute(&self) -> bool {
        let flags = self.adapter.get_downlevel_capabilities().flags;
        flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
    }

    /// Returns `true` if OpenGL draws.
    pub(crate) fn is_opengl(&self) -> bool {
        self.adapter.get_info().backend == Backend::Gl
    }

    /// Returns the target profile of a pipeline on this device: limited to what the device supports, with the device
    /// features that the pipeline can use.
    pub(crate) fn profile(&self, pipeline: &TypedPipeline) -> TargetProfile {
        profile_on(pipeline, &self.adapter)
    }
}
