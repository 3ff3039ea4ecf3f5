//! Target profiles: what a shader may rely on, as data.
//!
//! A profile is the minimum that every device of a target guarantees: the features and downlevel flags, from which
//! naga's capabilities follow, the limits, and the shading language that the module has to be written in. A pipeline
//! states the profiles that it claims, and every variant is checked against each of them.
//!
//! Sources: the limits of WebGPU's specification (core and compatibility mode) and the defaults of wgpu 30 for native
//! backends, GLES 3.1 and WebGL 2. The native profiles take WebGPU's guaranteed limits: a pipeline that needs more
//! names it in its own requirements. The downlevel flags of `gles` and `webgl2` are those that wgpu-hal 30 sets for
//! every context of OpenGL ES 3.1 and of WebGL 2 (`gles/adapter.rs`).

use naga::valid::Capabilities;
use wgpu_types::{DownlevelFlags, Features, Limits};

/// The shading language that a target's driver or browser receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TargetLanguage {
    /// WGSL, for browsers.
    Wgsl,
    /// SPIR-V, for Vulkan.
    Spirv,
    /// The Metal shading language.
    Msl,
    /// HLSL, for Direct3D 12.
    Hlsl,
    /// GLSL ES 3.10, for OpenGL ES.
    Glsl,
    /// GLSL ES 3.00, for WebGL 2.
    GlslWebgl2,
}

impl TargetLanguage {
    /// All languages.
    pub const ALL: [TargetLanguage; 6] =
        [Self::Wgsl, Self::Spirv, Self::Msl, Self::Hlsl, Self::Glsl, Self::GlslWebgl2];

    /// The name of the language: `wgsl`, `spirv`, `msl`, `hlsl`, `glsl` or `glsl-webgl2`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Spirv => "spirv",
            Self::Msl => "msl",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
            Self::GlslWebgl2 => "glsl-webgl2",
        }
    }
}

/// The parts of core mode that WebGPU's compatibility mode lacks, such as view formats, cube arrays and a blend state
/// per attachment.
const NOT_IN_COMPATIBILITY_MODE: DownlevelFlags = DownlevelFlags::VIEW_FORMATS
    .union(DownlevelFlags::SURFACE_VIEW_FORMATS)
    .union(DownlevelFlags::CUBE_ARRAY_TEXTURES)
    .union(DownlevelFlags::MULTISAMPLED_SHADING)
    .union(DownlevelFlags::INDEPENDENT_BLEND)
    .union(DownlevelFlags::VERTEX_STORAGE)
    .union(DownlevelFlags::DEPTH_BIAS_CLAMP);

/// The parts of core mode that OpenGL ES 3.1 lacks under wgpu.
const NOT_IN_GLES: DownlevelFlags = NOT_IN_COMPATIBILITY_MODE
    .union(DownlevelFlags::READ_ONLY_DEPTH_STENCIL)
    .union(DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES)
    .union(DownlevelFlags::BASE_VERTEX)
    .union(DownlevelFlags::FULL_DRAW_INDEX_UINT32)
    .union(DownlevelFlags::ANISOTROPIC_FILTERING)
    .union(DownlevelFlags::NONBLOCKING_QUERY_RESOLVE)
    .union(DownlevelFlags::WEBGPU_TEXTURE_FORMAT_SUPPORT)
    .union(DownlevelFlags::TEXTURE_COMPRESSION);

/// The parts of core mode, such as compute and storage buffers, that WebGL 2 lacks in addition to [`NOT_IN_GLES`].
const NOT_IN_WEBGL2: DownlevelFlags = DownlevelFlags::COMPUTE_SHADERS
    .union(DownlevelFlags::FRAGMENT_WRITABLE_STORAGE)
    .union(DownlevelFlags::FRAGMENT_STORAGE)
    .union(DownlevelFlags::INDIRECT_EXECUTION)
    .union(DownlevelFlags::BUFFER_BINDINGS_NOT_16_BYTE_ALIGNED)
    .union(DownlevelFlags::UNRESTRICTED_INDEX_BUFFER)
    .union(DownlevelFlags::UNRESTRICTED_EXTERNAL_TEXTURE_COPIES);

/// The features and limits that every device of a target guarantees.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TargetProfile {
    /// The name by which pipelines refer to the profile, such as `webgpu`.
    pub name: String,
    /// The wgpu features that the target guarantees.
    pub features: Features,
    /// The parts of WebGPU's core mode that the target has, as wgpu's downlevel flags.
    pub downlevel: DownlevelFlags,
    /// The capabilities for naga's validator, derived from the features and the downlevel flags.
    pub capabilities: Capabilities,
    /// The limits that the target guarantees.
    pub limits: Limits,
    /// The maximum number of storage buffers in the vertex stage; compatibility mode guarantees none.
    pub vertex_storage_buffers: u32,
    /// The shading language that the module is translated to.
    pub language: TargetLanguage,
}

impl TargetProfile {
    /// The names of all profiles, without optional features.
    pub const NAMES: [&'static str; 7] =
        ["webgpu", "webgpu-compat", "vulkan", "metal", "dx12", "gles", "webgl2"];

    /// Returns a profile by its name, with optional WebGPU features appended: `webgpu+float32-filterable`. `None` if a
    /// part of the name is unknown.
    pub fn from_name(name: &str) -> Option<Self> {
        let (base, features) = name.split_once('+').unwrap_or((name, ""));
        let features = features.split('+').filter(|feature| !feature.is_empty());
        let features =
            features.map(Self::feature).try_fold(Features::empty(), |all, one| Some(all | one?))?;
        let profile = Self::named(base)?;
        if features.is_empty() {
            return Some(profile);
        }
        Some(Self { name: name.to_owned(), ..profile.with_features(features) })
    }

    /// Returns an optional WebGPU feature by its WebGPU name; `None` if unknown.
    pub fn feature(name: &str) -> Option<Features> {
        let named = |feature: &Features| feature.as_str() == Some(name);
        Features::all_webgpu_mask().iter().find(named)
    }

    /// The names of the optional features of WebGPU.
    pub fn feature_names() -> Vec<&'static str> {
        Features::all_webgpu_mask().iter().filter_map(|feature| feature.as_str()).collect()
    }

    fn named(name: &str) -> Option<Self> {
        match name {
            "webgpu" => Some(Self::webgpu()),
            "webgpu-compat" => Some(Self::webgpu_compat()),
            "vulkan" => Some(Self::core(name, TargetLanguage::Spirv)),
            "metal" => Some(Self::core(name, TargetLanguage::Msl)),
            "dx12" => Some(Self::core(name, TargetLanguage::Hlsl)),
            "gles" => {
                // The letter of OpenGL ES 3.1 is 2048; compatibility mode, which is made for it, counts on 4096.
                let max_texture_dimension_2d = Self::webgpu_compat().limits.max_texture_dimension_2d;
                let limits = Limits { max_texture_dimension_2d, ..Limits::downlevel_defaults() };
                Some(Self::reduced(name, limits, DownlevelFlags::all() - NOT_IN_GLES, TargetLanguage::Glsl))
            }
            "webgl2" => {
                let limits = Limits::downlevel_webgl2_defaults();
                let flags = DownlevelFlags::all() - NOT_IN_GLES - NOT_IN_WEBGL2;
                Some(Self::reduced(name, limits, flags, TargetLanguage::GlslWebgl2))
            }
            _ => None,
        }
    }

    /// All profiles, in the order of [`TargetProfile::NAMES`].
    pub fn all() -> Vec<Self> {
        Self::NAMES.iter().filter_map(|name| Self::from_name(name)).collect()
    }

    /// The profile of WebGPU's core mode in a browser, without optional features.
    pub fn webgpu() -> Self {
        Self::core("webgpu", TargetLanguage::Wgsl)
    }

    /// The profile of WebGPU's compatibility mode.
    pub fn webgpu_compat() -> Self {
        let limits = Limits {
            max_texture_dimension_1d: 4096,
            max_texture_dimension_2d: 4096,
            max_texture_dimension_3d: 1024,
            max_uniform_buffer_binding_size: 16 << 10,
            max_inter_stage_shader_variables: 15,
            max_color_attachments: 4,
            max_compute_invocations_per_workgroup: 128,
            max_compute_workgroup_size_x: 128,
            max_compute_workgroup_size_y: 128,
            max_storage_buffers_per_shader_stage: 4,
            ..Limits::defaults()
        };
        Self::reduced(
            "webgpu-compat",
            limits,
            DownlevelFlags::all() - NOT_IN_COMPATIBILITY_MODE,
            TargetLanguage::Wgsl,
        )
    }

    /// Returns `true` if the target is a browser, which compiles WGSL directly.
    pub fn is_browser(&self) -> bool {
        self.language == TargetLanguage::Wgsl
    }

    /// Adds optional features to the profile.
    #[must_use]
    pub fn with_features(mut self, features: Features) -> Self {
        self.features |= features;
        self.capabilities |=
            wgpu_naga_bridge::features_to_naga_capabilities(features, DownlevelFlags::empty());
        self
    }

    /// Lowers the profile to the limits and downlevel flags of a device. Values above the profile's have no effect;
    /// add optional WebGPU features with [`TargetProfile::with_features`].
    ///
    /// Pipelines switch off features whose `required_limits` exceed the lowered limits.
    #[must_use]
    pub fn on_device(mut self, limits: &Limits, flags: DownlevelFlags) -> Self {
        let claimed = self.clone();
        self.limits = self.limits.or_worse_values_from(limits);
        let storage_buffers = self.limits.max_storage_buffers_per_shader_stage;
        let has_vertex_storage = flags.contains(DownlevelFlags::VERTEX_STORAGE);
        self.vertex_storage_buffers =
            if has_vertex_storage { self.vertex_storage_buffers.min(storage_buffers) } else { 0 };
        self.downlevel &= flags;
        self.capabilities &= wgpu_naga_bridge::features_to_naga_capabilities(self.features, flags);
        if self != claimed {
            self.name += " on this device";
        }
        self
    }

    fn core(name: &str, language: TargetLanguage) -> Self {
        let limits = Limits::defaults();
        let vertex_storage_buffers = limits.max_storage_buffers_per_shader_stage;
        Self { vertex_storage_buffers, ..Self::reduced(name, limits, DownlevelFlags::all(), language) }
    }

    /// Creates a profile without optional features and without storage buffers in the vertex stage.
    fn reduced(name: &str, limits: Limits, downlevel: DownlevelFlags, language: TargetLanguage) -> Self {
        let features = Features::empty();
        Self {
            name: name.to_owned(),
            features,
            downlevel,
            capabilities: wgpu_naga_bridge::features_to_naga_capabilities(features, downlevel),
            limits,
            vertex_storage_buffers: 0,
            language,
        }
    }
}
