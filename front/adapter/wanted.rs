//! The environment variables that choose an adapter: those that all programs with wgpu have in common.
//!
//! | variable | what it says |
//! |---|---|
//! | `WGPU_BACKEND` | backends with commas between: `vulkan`, `metal`, `dx12`, `gl` |
//! | `WGPU_ADAPTER_NAME` | a part of the adapter's name; `UMBRAGRAPH_ADAPTER` is the same |
//! | `WGPU_POWER_PREF` | `low` prefers integrated GPUs, `high` and `none` discrete ones |
//! | `WGPU_DEBUG`, `WGPU_VALIDATION` | labels for debuggers, and the messages of validation layers (the command prints them) |
//!
//! An empty variable says nothing. A value that none of them has is an error; wgpu itself ignores it.

use wgpu::Backends;

use crate::diagnostic::{Diagnostic, Place, list_of};
use crate::front::codes::NO_ADAPTER;
use crate::wgpu;

/// The environment variables that name an adapter, in order of precedence.
const NAMES: [&str; 2] = ["WGPU_ADAPTER_NAME", "UMBRAGRAPH_ADAPTER"];

/// The criteria for choosing an adapter.
#[derive(Debug, Default, PartialEq)]
pub struct Wanted {
    /// The backends to search; `None` for all.
    pub backends: Option<Backends>,
    /// A part of the adapter's name or backend, and the option or variable that gave it.
    pub name: Option<(String, &'static str)>,
    /// Set if integrated GPUs come before discrete ones.
    pub low_power: bool,
}

impl Wanted {
    /// Reads the criteria from the command line and the environment.
    ///
    /// # Errors
    /// An invalid value of an environment variable.
    pub fn new(named: Option<&str>) -> Result<Self, Diagnostic> {
        Self::of(named, &|name| std::env::var_os(name).map(|value| value.to_string_lossy().into_owned()))
    }

    fn of(named: Option<&str>, lookup: &dyn Fn(&str) -> Option<String>) -> Result<Self, Diagnostic> {
        let set = |name: &str| lookup(name).filter(|value| !value.trim().is_empty());
        let all = |list: String| {
            list.split(',').try_fold(Backends::empty(), |all, one| Ok(all | backend(one.trim())?))
        };
        let backends = set("WGPU_BACKEND").map(all).transpose()?;
        let low_power = match set("WGPU_POWER_PREF").map(|value| value.to_lowercase()).as_deref() {
            Some("low") => true,
            Some("high" | "none") | None => false,
            Some(other) => {
                let message = format!("WGPU_POWER_PREF is \"{other}\"");
                return Err(error(message).help("it is low, high or none"));
            }
        };
        let variables = NAMES.into_iter().find_map(|name| Some((set(name)?, name)));
        let name = named.map(|name| (name.to_owned(), "--adapter")).or(variables);
        Ok(Self { backends, name, low_power })
    }
}

fn backend(name: &str) -> Result<Backends, Diagnostic> {
    Ok(match name.to_lowercase().as_str() {
        "vulkan" | "vk" => Backends::VULKAN,
        "metal" | "mtl" => Backends::METAL,
        "dx12" | "d3d12" => Backends::DX12,
        "opengl" | "gles" | "gl" => Backends::GL,
        _ => {
            let message = format!("WGPU_BACKEND names \"{name}\", which is no backend");
            let known = list_of(["vulkan", "metal", "dx12", "gl"]);
            return Err(error(message).help(format!("the backends are {known}")));
        }
    })
}

fn error(message: String) -> Diagnostic {
    Diagnostic::error(NO_ADAPTER, Place::Nowhere, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(named: Option<&str>, set: &[(&str, &str)]) -> Result<Wanted, String> {
        let lookup =
            |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned());
        Wanted::of(named, &lookup).map_err(|diagnostic| diagnostic.message)
    }

    #[test]
    fn variables_choose_backends_name_and_power() {
        let set = [("WGPU_BACKEND", "VK, gl"), ("WGPU_ADAPTER_NAME", "swift"), ("WGPU_POWER_PREF", "Low")];
        let wanted = of(None, &set).unwrap();
        assert_eq!(wanted.backends, Some(Backends::VULKAN | Backends::GL));
        assert_eq!(wanted.name, Some(("swift".to_owned(), "WGPU_ADAPTER_NAME")));
        assert!(wanted.low_power);
        assert_eq!(of(None, &[("WGPU_BACKEND", " "), ("WGPU_POWER_PREF", "")]), Ok(Wanted::default()));
    }

    #[test]
    fn command_line_wins_over_variables() {
        let set = [("UMBRAGRAPH_ADAPTER", "llvm"), ("WGPU_ADAPTER_NAME", "swift")];
        assert_eq!(of(Some("gl"), &set).unwrap().name, Some(("gl".to_owned(), "--adapter")));
        assert_eq!(of(None, &set[..1]).unwrap().name, Some(("llvm".to_owned(), "UMBRAGRAPH_ADAPTER")));
    }

    #[test]
    fn nonsense_is_named() {
        assert!(of(None, &[("WGPU_BACKEND", "vulkan,nonsense")]).unwrap_err().contains("\"nonsense\""));
        assert!(of(None, &[("WGPU_POWER_PREF", "huge")]).unwrap_err().contains("\"huge\""));
    }
}
