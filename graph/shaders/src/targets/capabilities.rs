//! Capabilities by the names under which pipelines require them: optional features of WebGPU, and what WebGPU's core
//! mode always has but OpenGL or compatibility mode may lack.
//!
//! The latter are downlevel flags of wgpu. Only those are named that a pipeline can do without by itself; a target that
//! lacks another one has its own rule.

use wgpu_types::{DownlevelFlags, Features};

use super::profile::TargetProfile;

/// A capability of a target: an optional WebGPU feature, or a part of WebGPU's core mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Capability {
    /// An optional feature of WebGPU.
    Feature(Features),
    /// A part of WebGPU's core mode that reduced targets may lack.
    Core(DownlevelFlags),
}

/// The named parts of WebGPU's core mode, with wgpu's flags.
const CORE: [(&str, DownlevelFlags); 9] = [
    ("compute", DownlevelFlags::COMPUTE_SHADERS),
    ("cube-arrays", DownlevelFlags::CUBE_ARRAY_TEXTURES),
    ("depth-buffer-copies", DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES),
    ("fragment-writable-storage", DownlevelFlags::FRAGMENT_WRITABLE_STORAGE),
    ("independent-blend", DownlevelFlags::INDEPENDENT_BLEND),
    ("indirect", DownlevelFlags::INDIRECT_EXECUTION),
    ("read-only-depth", DownlevelFlags::READ_ONLY_DEPTH_STENCIL),
    ("sample-shading", DownlevelFlags::MULTISAMPLED_SHADING),
    ("view-formats", DownlevelFlags::VIEW_FORMATS),
];

impl Capability {
    /// Finds a capability by its name, such as `float32-filterable` or `view-formats`; `None` if unknown.
    pub fn from_name(name: &str) -> Option<Self> {
        let core = CORE.iter().find(|(known, _)| *known == name);
        core.map(|(_, flag)| Self::Core(*flag)).or_else(|| TargetProfile::feature(name).map(Self::Feature))
    }

    /// The names of all capabilities: those of core mode, then WebGPU's optional features.
    pub fn names() -> Vec<&'static str> {
        CORE.iter().map(|(name, _)| *name).chain(TargetProfile::feature_names()).collect()
    }

    /// The name of a part of core mode; empty if the part has no name.
    pub fn name_of(part: DownlevelFlags) -> &'static str {
        CORE.iter().find(|(_, flag)| *flag == part).map_or("", |(name, _)| name)
    }
}

impl TargetProfile {
    /// Returns `true` if every device of the target has the capability.
    pub fn has(&self, capability: Capability) -> bool {
        match capability {
            Capability::Feature(feature) => self.features.contains(feature),
            Capability::Core(flag) => self.downlevel.contains(flag),
        }
    }

    /// The named parts of WebGPU's core mode that the target lacks.
    pub fn lacking(&self) -> Vec<&'static str> {
        let lacking = CORE.iter().filter(|(_, flag)| !self.downlevel.contains(*flag));
        lacking.map(|(name, _)| *name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_capability_of_its_own() {
        let names = Capability::names();
        let known: Vec<Capability> = names.iter().filter_map(|name| Capability::from_name(name)).collect();
        assert_eq!(known.len(), names.len());
        assert!((1..known.len()).all(|at| !known[..at].contains(&known[at])), "{names:?}");
        assert_eq!(Capability::from_name("cubes"), None);
    }

    #[test]
    fn targets_lack_what_their_api_lacks() {
        let lacking = |name: &str| TargetProfile::from_name(name).unwrap().lacking();
        assert_eq!(lacking("vulkan"), Vec::<&str>::new());
        assert!(lacking("webgpu-compat").contains(&"view-formats"));
        assert!(!lacking("gles").contains(&"compute") && lacking("webgl2").contains(&"compute"));
    }
}
