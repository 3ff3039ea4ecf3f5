//! The graphics adapter that the command line and the environment variables ask for, of all that a machine has.

mod wanted;

use wgpu::{Adapter, Backend, DeviceType};

use crate::diagnostic::{Diagnostic, Place, list_of};
use crate::wgpu;

pub use super::codes::NO_ADAPTER;
pub use wanted::Wanted;

impl Wanted {
    /// Returns the wanted adapters with their names: the best first, which is discrete before integrated before
    /// software, and OpenGL last. Adapters of equal names have numbers, such as ` #2`.
    ///
    /// # Errors
    /// No adapter, or none with the wanted name.
    pub fn among(&self, mut adapters: Vec<Adapter>) -> Result<Vec<(String, Adapter)>, Diagnostic> {
        adapters.retain(|adapter| adapter.get_info().backend != Backend::Noop);
        adapters.sort_by_key(|adapter| rank(adapter, self.low_power));
        if adapters.is_empty() {
            return Err(self.nothing());
        }
        let names = numbered(adapters.iter().map(name).collect());
        let mut adapters: Vec<(String, Adapter)> = names.iter().cloned().zip(adapters).collect();
        let Some((part, by)) = &self.name else { return Ok(adapters) };
        // "NAME #1" is also a part of "NAME #10".
        let is_whole = adapters.iter().any(|(name, _)| name == part);
        adapters.retain(|(name, _)| match is_whole {
            true => name == part,
            false => name.to_lowercase().contains(&part.to_lowercase()),
        });
        if adapters.is_empty() {
            let message = format!("no graphics adapter is called \"{part}\", as {by} asks for");
            return Err(Diagnostic::error(NO_ADAPTER, Place::Nowhere, message)
                .help(format!("there are {}", list_of(names))));
        }
        Ok(adapters)
    }

    /// Returns the best of the wanted adapters, with its name.
    ///
    /// # Errors
    /// No adapter, none with the wanted name, or several of the same name.
    pub fn best(&self, adapters: Vec<Adapter>) -> Result<(String, Adapter), Diagnostic> {
        let adapters = self.among(adapters)?;
        let Some(best) = adapters.first() else { return Err(self.nothing()) };
        if let Some((part, by)) = &self.name {
            let alike = adapters.iter().filter(|(_, adapter)| name(adapter) == name(&best.1));
            let names: Vec<&str> = alike.map(|(name, _)| name.as_str()).collect();
            if names.len() > 1 {
                let count = names.len();
                let message = format!("{count} graphics adapters are called \"{part}\", as {by} asks for");
                return Err(Diagnostic::error(NO_ADAPTER, Place::Nowhere, message)
                    .help(format!("name one with its number: {}", list_of(names))));
            }
        }
        Ok(best.clone())
    }

    /// Returns the diagnostic for a machine without a matching adapter.
    fn nothing(&self) -> Diagnostic {
        let of = match self.backends {
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
                format!("{name} limits Vulkan to \"{files}\": unset it, or correct the path")
            }
            None => {
                "install a driver; on Debian and Ubuntu `apt install mesa-vulkan-drivers` gives one in software"
                    .to_owned()
            }
        };
        Diagnostic::error(NO_ADAPTER, Place::Nowhere, message).help(help)
    }
}

/// Returns the name and the backend of an adapter.
pub fn name(adapter: &Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({})", info.name, info.backend)
}

/// Returns the device descriptor for pipelines on an adapter: the adapter's WebGPU features and limits, and timestamps
/// between passes if it has them.
pub fn device_descriptor(adapter: &Adapter) -> wgpu::DeviceDescriptor<'static> {
    let wanted = wgpu::Features::all_webgpu_mask() | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    wgpu::DeviceDescriptor {
        label: Some("umbragraph"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    }
}

/// Makes equal names distinct by adding a number, such as ` #2`.
fn numbered(names: Vec<String>) -> Vec<String> {
    let number = |at: usize, name: &String| {
        let like = |names: &[String]| names.iter().filter(|other| *other == name).count();
        if like(&names) > 1 { format!("{name} #{}", like(&names[..=at])) } else { name.clone() }
    };
    names.iter().enumerate().map(|(at, name)| number(at, name)).collect()
}

fn rank(adapter: &Adapter, low_power: bool) -> (bool, u8) {
    let info = adapter.get_info();
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => u8::from(low_power),
        DeviceType::IntegratedGpu => u8::from(!low_power),
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    (info.backend == Backend::Gl, kind)
}
