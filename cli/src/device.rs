//! A graphics device for pictures without a window.

mod environment;
mod messages;

use self::environment::Wanted;
use umbragraph::diagnostic::{Diagnostic, Place, codes, list_of};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::shader::TargetProfile;
use wgpu::{Adapter, Backend, Backends, Device, DeviceType, Instance, InstanceDescriptor, Queue};

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
    let mut adapters = match wanted.backends {
        Some(backends) => found(backends, &wanted),
        None => found(Backends::PRIMARY, &wanted),
    };
    if wanted.backends.is_none() && (adapters.is_empty() || wanted.name.is_some()) {
        adapters = found(Backends::all(), &wanted);
    }
    let adapters = named_as(adapters, &wanted)?;
    unambiguous(&adapters, &wanted)?;
    adapters.into_iter().next().ok_or_else(|| nothing(&wanted))
}

/// Opens a device on an adapter, with all WebGPU features and limits that the adapter supports.
///
/// # Errors
/// The adapter provides no device.
pub(crate) fn request(name: &str, adapter: &Adapter) -> Result<(Device, Queue), Diagnostic> {
    let wanted = wgpu::Features::all_webgpu_mask() | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("umbragraph"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    };
    pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
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
    named_as(found(wanted.backends.unwrap_or(Backends::all()), &wanted), &wanted)
}

/// Returns the adapters whose name or backend contains the wanted text, with their names.
fn named_as(adapters: Vec<Adapter>, wanted: &Wanted) -> Result<Vec<(String, Adapter)>, Diagnostic> {
    if adapters.is_empty() {
        return Err(nothing(wanted));
    }
    let names = numbered(adapters.iter().map(name).collect());
    let mut adapters: Vec<(String, Adapter)> = names.iter().cloned().zip(adapters).collect();
    let Some((part, by)) = &wanted.name else { return Ok(adapters) };
    // "NAME #1" is also a part of "NAME #10".
    let is_whole = adapters.iter().any(|(name, _)| name == part);
    adapters.retain(|(name, _)| match is_whole {
        true => name == part,
        false => name.to_lowercase().contains(&part.to_lowercase()),
    });
    if adapters.is_empty() {
        let message = format!("no graphics adapter is called \"{part}\", as {by} asks for");
        return Err(Diagnostic::error(crate::codes::NO_ADAPTER, Place::Nowhere, message)
            .help(format!("there are {}", list_of(names))));
    }
    Ok(adapters)
}

/// Makes equal names distinct by adding a number, such as ` #2`.
fn numbered(names: Vec<String>) -> Vec<String> {
    let number = |at: usize, name: &String| {
        let like = |names: &[String]| names.iter().filter(|other| *other == name).count();
        if like(&names) > 1 { format!("{name} #{}", like(&names[..=at])) } else { name.clone() }
    };
    names.iter().enumerate().map(|(at, name)| number(at, name)).collect()
}

/// Rejects a wanted name that matches several adapters of the same name.
fn unambiguous(adapters: &[(String, Adapter)], wanted: &Wanted) -> Result<(), Diagnostic> {
    let (Some((part, by)), Some((_, best))) = (&wanted.name, adapters.first()) else { return Ok(()) };
    let alike = adapters.iter().filter(|(_, adapter)| name(adapter) == name(best));
    let names: Vec<&str> = alike.map(|(name, _)| name.as_str()).collect();
    if names.len() < 2 {
        return Ok(());
    }
    let count = names.len();
    let message = format!("{count} graphics adapters are called \"{part}\", as {by} asks for");
    Err(Diagnostic::error(crate::codes::NO_ADAPTER, Place::Nowhere, message)
        .help(format!("name one with its number: {}", list_of(names))))
}

fn found(backends: Backends, wanted: &Wanted) -> Vec<Adapter> {
    messages::listen();
    let descriptor = InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() };
    // The variable of backends is read already, with an error where it says nonsense.
    let descriptor = InstanceDescriptor { backends, ..descriptor.with_env() };
    let mut adapters = pollster::block_on(Instance::new(descriptor).enumerate_adapters(backends));
    adapters.retain(|adapter| adapter.get_info().backend != Backend::Noop);
    adapters.sort_by_key(|adapter| rank(adapter, wanted.low_power));
    adapters
}

/// Returns the diagnostic for a machine without a matching adapter.
fn nothing(wanted: &Wanted) -> Diagnostic {
    let of = match wanted.backends {
        Some(backends) => {
            let names = backends.iter_names().map(|(name, _)| name.to_lowercase());
            format!(" of {}, as WGPU_BACKEND asks for,", list_of(names))
        }
        None => String::new(),
    };
    let message = format!("no graphics adapter{of} was found");
    let drivers = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].into_iter();
    let help = match drivers.filter_map(|name| Some((name, std::env::var_os(name)?))).next() {
        Some((name, files)) => {
            let files = files.to_string_lossy();
            format!("{name} lets no driver through but \"{files}\": unset it, or correct it")
        }
        None => {
            "install a driver; on Debian and Ubuntu `apt install mesa-vulkan-drivers` gives one in software"
                .to_owned()
        }
    };
    Diagnostic::error(crate::codes::NO_ADAPTER, Place::Nowhere, message).help(help)
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

/// Returns the name and the backend of an adapter.
pub(crate) fn name(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

fn rank(adapter: &Adapter, low_power: bool) -> (bool, u8) {
    let info = adapter.get_info();
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => {
            if low_power {
                1
            } else {
                0
            }
        }
        DeviceType::IntegratedGpu => {
            if low_power {
                0
            } else {
                1
            }
        }
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (info.backend == Backend::Gl, kind)
}
