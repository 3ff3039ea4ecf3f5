//! A graphics device for pictures without a window.

use umbragraph::diagnostic::{Diagnostic, Place, codes, list_of};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::shader::TargetProfile;
use wgpu::{Adapter, Backend, Backends, Device, DeviceType, Instance, InstanceDescriptor, Queue};

/// A device and the name of its adapter.
pub(crate) struct Graphics {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) name: String,
    /// The downlevel flags of the adapter: abilities that older hardware lacks.
    pub(crate) flags: wgpu::DownlevelFlags,
}

/// The variable that names the adapter to be used, or a part of its name or backend.
const ADAPTER: &str = "UMBRAGRAPH_ADAPTER";

/// Opens the best adapter: discrete before integrated before software, and any other backend before OpenGL. The
/// environment variable `UMBRAGRAPH_ADAPTER` narrows the choice.
///
/// # Errors
/// No adapter, or one that rejects a device.
pub(crate) fn open() -> Result<Graphics, Diagnostic> {
    let found = |backends| {
        let descriptor = InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() };
        let mut adapters = pollster::block_on(Instance::new(descriptor).enumerate_adapters(backends));
        adapters.retain(|adapter| adapter.get_info().backend != Backend::Noop);
        adapters.sort_by_key(rank);
        adapters
    };
    // OpenGL last: where there is no display, its libraries complain on standard error of their own accord.
    let mut adapters = found(Backends::PRIMARY);
    if adapters.is_empty() || std::env::var_os(ADAPTER).is_some_and(|wanted| !wanted.is_empty()) {
        adapters = found(Backends::all());
    }
    let names: Vec<String> = adapters.iter().map(name).collect();
    if let Some(wanted) = std::env::var(ADAPTER).ok().filter(|wanted| !wanted.is_empty()) {
        adapters.retain(|adapter| name(adapter).to_lowercase().contains(&wanted.to_lowercase()));
        if adapters.is_empty() {
            let message = format!("no graphics adapter is called \"{wanted}\", as {ADAPTER} asks for");
            let help = if names.is_empty() {
                "there is none at all".to_owned()
            } else {
                format!("there are {}", list_of(names))
            };
            return Err(Diagnostic::error(crate::codes::NO_ADAPTER, Place::Nowhere, message).help(help));
        }
    }
    let Some(adapter) = adapters.first() else {
        return Err(Diagnostic::error(
            crate::codes::NO_ADAPTER,
            Place::Nowhere,
            "no graphics adapter was found",
        )
        .help(
            "install a driver; on Debian and Ubuntu `apt install mesa-vulkan-drivers` gives one in software",
        ));
    };
    let name = name(adapter);
    let wanted = wgpu::Features::all_webgpu_mask() | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("umbragraph"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    };
    match pollster::block_on(adapter.request_device(&descriptor)) {
        Ok((device, queue)) => {
            Ok(Graphics { device, queue, name, flags: adapter.get_downlevel_capabilities().flags })
        }
        Err(error) => {
            Err(Diagnostic::error(codes::DEVICE, Place::Nowhere, format!("{name} gives no device: {error}"))
                .help("update the driver, or close what uses up its memory"))
        }
    }
}

impl Graphics {
    /// The profile of a pipeline on this device: limited to what the device offers, with the device features that the
    /// pipeline can use.
    pub(crate) fn profile(&self, pipeline: &TypedPipeline) -> TargetProfile {
        let features = pipeline.device_features() & self.device.features();
        let profile = pipeline.profile.clone().on_device(&self.device.limits(), self.flags);
        if features.is_empty() { profile } else { profile.with_features(features) }
    }
}

fn name(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

fn rank(adapter: &Adapter) -> (bool, u8) {
    let info = adapter.get_info();
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (info.backend == Backend::Gl, kind)
}
