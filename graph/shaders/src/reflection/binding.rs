//! Bindings as bind-group layout entries.

use std::num::{NonZeroU32, NonZeroU64};

use naga::common::wgsl::TypeContext as _;
use naga::proc::Layouter;
use naga::valid::ModuleInfo;
use naga::{
    AddressSpace, ArraySize, GlobalVariable, Handle, ImageClass, ImageDimension, Module, StorageAccess,
    TypeInner,
};
use wgpu_types::{
    BindGroupLayoutEntry, BindingType, BufferBindingType, SamplerBindingType, ShaderStages,
    StorageTextureAccess, TextureSampleType, TextureViewDimension,
};

use super::TypeLayout;

/// One `@group(g) @binding(b) var` of a module.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Binding {
    /// The index of the bind group.
    pub group: u32,
    /// The index of the binding within its group.
    pub binding: u32,
    /// The name of the variable in the WGSL.
    pub name: String,
    /// The bind-group layout entry. Its visibility contains the stages of the entry points that use the binding.
    pub entry: BindGroupLayoutEntry,
    /// The memory layout of a buffer's contents; `None` for textures, samplers and acceleration structures.
    pub block: Option<TypeLayout>,
    /// The type of the variable in WGSL spelling, such as `texture_depth_2d_array`.
    pub type_name: String,
}

/// Returns the bindings that entry points use, then the unused ones, each sorted by group and binding.
pub(super) fn bindings(
    module: &Module,
    info: &ModuleInfo,
    layouter: &Layouter,
) -> (Vec<Binding>, Vec<Binding>) {
    let mut found: Vec<Binding> = module
        .global_variables
        .iter()
        .filter_map(|(handle, variable)| binding(module, info, layouter, handle, variable))
        .collect();
    found.sort_by(|a, b| (a.group, a.binding, &a.name).cmp(&(b.group, b.binding, &b.name)));
    found.into_iter().partition(|binding| !binding.entry.visibility.is_empty())
}

fn binding(
    module: &Module,
    info: &ModuleInfo,
    layouter: &Layouter,
    handle: Handle<GlobalVariable>,
    variable: &GlobalVariable,
) -> Option<Binding> {
    let place = variable.binding?;
    let mut visibility = ShaderStages::NONE;
    let mut sampled = false;
    for (at, entry_point) in module.entry_points.iter().enumerate() {
        let function = info.get_entry_point(at);
        if !function[handle].is_empty() {
            visibility |= wgpu_naga_bridge::map_naga_stage(entry_point.stage);
        }
        sampled |= function.sampling_set.iter().any(|pair| pair.image == handle);
    }
    let (element, count) = match module.types[variable.ty].inner {
        TypeInner::BindingArray { base, size: ArraySize::Constant(count) } => {
            (base, NonZeroU32::new(count.get()))
        }
        TypeInner::BindingArray { base, .. } => (base, None),
        _ => (variable.ty, None),
    };
    let buffer = |ty: BufferBindingType| BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: NonZeroU64::new(u64::from(layouter[element].size)),
    };
    let (ty, block) = match variable.space {
        AddressSpace::Uniform => {
            (buffer(BufferBindingType::Uniform), TypeLayout::new(module, layouter, element))
        }
        AddressSpace::Storage { access } => {
            let read_only = !access.contains(StorageAccess::STORE);
            (buffer(BufferBindingType::Storage { read_only }), TypeLayout::new(module, layouter, element))
        }
        _ => (resource(&module.types[element].inner, sampled)?, None),
    };
    Some(Binding {
        group: place.group,
        binding: place.binding,
        name: variable.name.clone().unwrap_or_default(),
        entry: BindGroupLayoutEntry { binding: place.binding, visibility, ty, count },
        block,
        type_name: module.to_ctx().type_to_string(variable.ty),
    })
}

fn resource(inner: &TypeInner, sampled: bool) -> Option<BindingType> {
    Some(match *inner {
        TypeInner::Sampler { comparison: true } => BindingType::Sampler(SamplerBindingType::Comparison),
        TypeInner::Sampler { comparison: false } => BindingType::Sampler(SamplerBindingType::Filtering),
        TypeInner::AccelerationStructure { vertex_return } => {
            BindingType::AccelerationStructure { vertex_return }
        }
        TypeInner::Image { dim, arrayed, class } => {
            let view_dimension = view_dimension(dim, arrayed);
            let texture = |sample_type, multisampled| BindingType::Texture {
                sample_type,
                view_dimension,
                multisampled,
            };
            match class {
                ImageClass::Sampled { kind: naga::ScalarKind::Sint, multi } => {
                    texture(TextureSampleType::Sint, multi)
                }
                ImageClass::Sampled { kind: naga::ScalarKind::Uint, multi } => {
                    texture(TextureSampleType::Uint, multi)
                }
                ImageClass::Sampled { multi, .. } => {
                    texture(TextureSampleType::Float { filterable: sampled && !multi }, multi)
                }
                ImageClass::Depth { multi } => texture(TextureSampleType::Depth, multi),
                ImageClass::Storage { format, access } => BindingType::StorageTexture {
                    access: storage_access(access),
                    format: wgpu_naga_bridge::map_storage_format_from_naga(format),
                    view_dimension,
                },
                ImageClass::External => BindingType::ExternalTexture,
            }
        }
        _ => return None,
    })
}

fn storage_access(access: StorageAccess) -> StorageTextureAccess {
    if access.contains(StorageAccess::ATOMIC) {
        StorageTextureAccess::Atomic
    } else if access == StorageAccess::LOAD {
        StorageTextureAccess::ReadOnly
    } else if access == StorageAccess::STORE {
        StorageTextureAccess::WriteOnly
    } else {
        StorageTextureAccess::ReadWrite
    }
}

fn view_dimension(dimension: ImageDimension, arrayed: bool) -> TextureViewDimension {
    match (dimension, arrayed) {
        (ImageDimension::D1, _) => TextureViewDimension::D1,
        (ImageDimension::D2, false) => TextureViewDimension::D2,
        (ImageDimension::D2, true) => TextureViewDimension::D2Array,
        (ImageDimension::D3, _) => TextureViewDimension::D3,
        (ImageDimension::Cube, false) => TextureViewDimension::Cube,
        (ImageDimension::Cube, true) => TextureViewDimension::CubeArray,
    }
}
