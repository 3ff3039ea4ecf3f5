//! The choice of the adapter that tests run on.
//!
//! The noop backend is left out. Of the rest, any other backend comes before OpenGL (on a machine with Mesa two
//! adapters answer to `llvmpipe`, one through Vulkan, one through OpenGL, and the latter lacks features); then a
//! discrete device before an integrated one, a virtual one, an unknown one and a CPU; then the order in which the
//! adapters were enumerated. A text selects those whose name or backend contains it, whatever its case.

use std::fmt;

/// The properties of an adapter that determine its rank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// The adapter's name.
    pub name: String,
    /// The backend that provides the adapter.
    pub backend: wgpu::Backend,
    /// The kind of device, such as a discrete GPU.
    pub device_type: wgpu::DeviceType,
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} on {}", self.name, self.backend)
    }
}

/// Returns the indices of the usable adapters, the best first. `wanted` is a part of the adapter's name; `None` allows
/// all.
pub fn preference(adapters: &[AdapterSummary], wanted: Option<&str>) -> Vec<usize> {
    let wanted = wanted.unwrap_or_default().to_lowercase();
    let mut order: Vec<usize> = (0..adapters.len())
        .filter(|&index| adapters[index].backend != wgpu::Backend::Noop)
        .filter(|&index| adapters[index].to_string().to_lowercase().contains(&wanted))
        .collect();
    order.sort_by_key(|&index| {
        (adapters[index].backend == wgpu::Backend::Gl, rank(adapters[index].device_type))
    });
    order
}

fn rank(device_type: wgpu::DeviceType) -> u8 {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Explains why [`preference`] found no adapter.
pub(super) fn explain_nothing(adapters: &[AdapterSummary], wanted: Option<&str>) -> String {
    let names: Vec<String> = adapters
        .iter()
        .filter(|adapter| adapter.backend != wgpu::Backend::Noop)
        .map(|adapter| format!("`{adapter}`"))
        .collect();
    match (wanted, names.is_empty()) {
        (_, true) => "the machine offers none".to_owned(),
        (Some(wanted), false) => format!("none is called `{wanted}`; there are {}", names.join(", ")),
        (None, false) => format!("none can be used of {}", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::{Backend, DeviceType};

    fn adapter(name: &str, backend: Backend, device_type: DeviceType) -> AdapterSummary {
        AdapterSummary { name: name.to_owned(), backend, device_type }
    }

    #[test]
    fn vulkan_comes_before_opengl_of_the_same_name() {
        let adapters = [
            adapter("llvmpipe", Backend::Gl, DeviceType::Cpu),
            adapter("llvmpipe", Backend::Vulkan, DeviceType::Cpu),
        ];
        assert_eq!(preference(&adapters, None), [1, 0]);
    }

    #[test]
    fn software_on_vulkan_comes_before_discrete_on_opengl() {
        let adapters = [
            adapter("GeForce", Backend::Gl, DeviceType::DiscreteGpu),
            adapter("llvmpipe", Backend::Vulkan, DeviceType::Cpu),
        ];
        assert_eq!(preference(&adapters, None), [1, 0]);
    }

    #[test]
    fn devices_are_ranked_by_their_type() {
        let types = [DeviceType::Cpu, DeviceType::IntegratedGpu, DeviceType::Other, DeviceType::DiscreteGpu];
        let adapters = types.map(|device_type| adapter("some", Backend::Vulkan, device_type));
        assert_eq!(preference(&adapters, None), [3, 1, 2, 0]);
    }

    #[test]
    fn noop_is_never_chosen_even_when_it_is_named() {
        let adapters = [adapter("noop wgpu backend", Backend::Noop, DeviceType::DiscreteGpu)];
        assert!(preference(&adapters, None).is_empty());
        assert!(preference(&adapters, Some("noop")).is_empty());
        assert_eq!(explain_nothing(&adapters, None), "the machine offers none");
    }

    #[test]
    fn a_text_selects_by_name_or_backend_whatever_its_case() {
        let adapters = [
            adapter("GeForce", Backend::Vulkan, DeviceType::DiscreteGpu),
            adapter("llvmpipe", Backend::Vulkan, DeviceType::Cpu),
            adapter("llvmpipe", Backend::Gl, DeviceType::Cpu),
        ];
        assert_eq!(preference(&adapters, Some("LLVM")), [1, 2]);
        assert_eq!(preference(&adapters, Some("on gl")), [2]);
        assert!(preference(&adapters, Some("radeon")).is_empty());
        assert!(explain_nothing(&adapters, Some("radeon")).contains("`GeForce on vulkan`"));
    }
}
