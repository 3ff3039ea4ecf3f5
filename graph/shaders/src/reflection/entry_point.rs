//! Entry points: stage, workgroup size, vertex inputs, fragment outputs, and the bindings each one uses.

use std::collections::BTreeMap;

use naga::valid::ModuleInfo;
use naga::{AddressSpace, Handle, Module, ShaderStage, TypeInner};
use wgpu_types::{ShaderStages, VertexFormat};

use super::{Scalar, ScalarKind, coverage};
use crate::written::ir;

/// The shader stage of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// A vertex stage.
    Vertex,
    /// A fragment stage.
    Fragment,
    /// A compute stage.
    Compute,
}

impl Stage {
    /// The name of the stage: `vertex`, `fragment` or `compute`.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Vertex => "vertex",
            Stage::Fragment => "fragment",
            Stage::Compute => "compute",
        }
    }

    /// The stage as the wgpu flag set [`ShaderStages`].
    pub fn stages(self) -> ShaderStages {
        wgpu_naga_bridge::map_naga_stage(self.to_naga())
    }

    /// The stage as naga's enum.
    pub fn to_naga(self) -> ShaderStage {
        match self {
            Stage::Vertex => ShaderStage::Vertex,
            Stage::Fragment => ShaderStage::Fragment,
            Stage::Compute => ShaderStage::Compute,
        }
    }
}

/// An attribute that the vertex stage reads.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct VertexInput {
    /// The name of the argument, or of the member if the argument is a structure.
    pub name: String,
    /// The `@location` of the attribute.
    pub location: u32,
    /// The scalar type of a component.
    pub scalar: Scalar,
    /// The number of components: 1 to 4.
    pub components: u32,
    /// The vertex format that matches the type of the attribute, such as `float32x3` for `vec3<f32>`; `float16x4` for
    /// `vec3<f16>`, which has no format of its own. A host may use any format of the same scalar kind, such as
    /// `unorm8x4` for `vec4<f32>`.
    pub format: VertexFormat,
}

/// A color output of a fragment stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct FragmentOutput {
    /// The `@location`: the index of the color attachment.
    pub location: u32,
    /// The scalar kind of the components: floating point or integer.
    pub kind: ScalarKind,
    /// The number of components: 1 to 4.
    pub components: u32,
}

/// The interface of an entry point: stage, inputs, outputs and used bindings.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct EntryPoint {
    /// The name of the entry point in the WGSL.
    pub name: String,
    /// The shader stage.
    pub stage: Stage,
    /// The workgroup size in invocations; zeros for other stages than compute.
    pub workgroup_size: [u32; 3],
    /// The workgroup memory in bytes; each variable's size is rounded up to a multiple of 16.
    pub workgroup_storage: u32,
    /// The attributes of a vertex stage, by location; empty for other stages.
    pub inputs: Vec<VertexInput>,
    /// The color outputs of a fragment stage, by location; empty for other stages.
    pub outputs: Vec<FragmentOutput>,
    /// Whether a fragment stage writes a second source color for dual-source blending, `@blend_src(1)`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub has_second_source: bool,
    /// Whether a fragment stage writes `frag_depth`.
    pub writes_depth: bool,
    /// Whether the stage is proven to leave no texel of a full-screen pass unwritten. A vertex stage must emit one
    /// triangle that contains all of clip space. A fragment stage must neither discard nor write a sample mask. `false`
    /// for compute stages.
    #[serde(skip)]
    pub covers: bool,
    /// The locations of inter-stage variables: outputs of a vertex stage, inputs of a fragment stage.
    pub varyings: Vec<u32>,
    /// The bindings that the entry point uses, as sorted pairs of group and binding.
    pub bindings: Vec<(u32, u32)>,
    /// The pairs of a texture and the sampler that it is sampled with, each given by group and binding; sorted.
    pub sampling_pairs: Vec<((u32, u32), (u32, u32))>,
}

/// The workgroup sizes of entry points in invocations, by name of the entry point, computed with the values of
/// overrides.
pub(crate) type WorkgroupSizes = BTreeMap<String, [u32; 3]>;

pub(super) fn entry_points(module: &Module, info: &ModuleInfo, sizes: &WorkgroupSizes) -> Vec<EntryPoint> {
    let mut found: Vec<EntryPoint> =
        (0..module.entry_points.len()).filter_map(|at| entry_point(module, info, sizes, at)).collect();
    found.sort_by(|a, b| (&a.name, a.stage).cmp(&(&b.name, b.stage)));
    found
}

fn entry_point(module: &Module, info: &ModuleInfo, sizes: &WorkgroupSizes, at: usize) -> Option<EntryPoint> {
    let entry_point = module.entry_points.get(at)?;
    let stage = match entry_point.stage {
        ShaderStage::Vertex => Stage::Vertex,
        ShaderStage::Fragment => Stage::Fragment,
        ShaderStage::Compute => Stage::Compute,
        _ => return None,
    };
    let function = info.get_entry_point(at);
    let mut bindings = Vec::new();
    let mut workgroup_storage = 0_u32;
    for (_, variable) in module.global_variables.iter().filter(|(handle, _)| !function[*handle].is_empty()) {
        bindings.extend(variable.binding.map(|place| (place.group, place.binding)));
        if variable.space == AddressSpace::WorkGroup {
            // Each variable starts at a multiple of 16 bytes, as WebGPU counts them.
            let size = module.types[variable.ty].inner.try_size(module.to_ctx()).unwrap_or(0);
            workgroup_storage = workgroup_storage.saturating_add(size.next_multiple_of(16));
        }
    }
    bindings.sort_unstable();
    let place = |handle: Handle<naga::GlobalVariable>| {
        module.global_variables[handle].binding.map(|place| (place.group, place.binding))
    };
    let mut sampling_pairs: Vec<_> = function
        .sampling_set
        .iter()
        .filter_map(|pair| Some((place(pair.image)?, place(pair.sampler)?)))
        .collect();
    sampling_pairs.sort_unstable();
    let arguments = ir::inputs(module, &entry_point.function);
    let results = ir::outputs(module, &entry_point.function);
    let has_second_source = results
        .iter()
        .any(|result| matches!(result.binding, naga::Binding::Location { blend_src: Some(1), .. }));
    let depth = naga::Binding::BuiltIn(naga::BuiltIn::FragDepth);
    let writes_depth = results.iter().any(|result| *result.binding == depth);
    let covers = match stage {
        Stage::Vertex => coverage::covers(module, at),
        Stage::Fragment => coverage::keeps_all(module, info, at),
        Stage::Compute => false,
    };
    let (arguments, results) = (located(module, &arguments), located(module, &results));
    let places = |variables: &[Located<'_>]| variables.iter().map(|variable| variable.location).collect();
    let (inputs, outputs, varyings) = match stage {
        Stage::Vertex => {
            (arguments.iter().filter_map(Located::input).collect(), Vec::new(), places(&results))
        }
        Stage::Fragment => (Vec::new(), results.iter().map(Located::output).collect(), places(&arguments)),
        Stage::Compute => (Vec::new(), Vec::new(), Vec::new()),
    };
    Some(EntryPoint {
        name: entry_point.name.clone(),
        stage,
        workgroup_size: sizes.get(&entry_point.name).copied().unwrap_or(entry_point.workgroup_size),
        workgroup_storage,
        inputs,
        outputs,
        has_second_source,
        writes_depth,
        covers,
        varyings,
        bindings,
        sampling_pairs,
    })
}

/// An input or output with a `@location`, except for the second blend source.
struct Located<'m> {
    name: &'m str,
    location: u32,
    scalar: Scalar,
    components: u32,
}

impl Located<'_> {
    fn input(&self) -> Option<VertexInput> {
        let Self { location, scalar, components, .. } = *self;
        let format = vertex_format(scalar, components)?;
        Some(VertexInput { name: self.name.to_owned(), location, scalar, components, format })
    }

    fn output(&self) -> FragmentOutput {
        FragmentOutput { location: self.location, kind: self.scalar.kind, components: self.components }
    }
}

/// The variables with a location, sorted by location.
fn located<'m>(module: &Module, bound: &[ir::Bound<'m>]) -> Vec<Located<'m>> {
    let located = |bound: &ir::Bound<'m>| {
        let naga::Binding::Location { location, blend_src: None | Some(0), .. } = *bound.binding else {
            return None;
        };
        let (scalar, components) = match module.types[bound.ty].inner {
            TypeInner::Scalar(scalar) => (scalar, 1),
            TypeInner::Vector { size, scalar } => (scalar, size as u32),
            _ => return None,
        };
        Some(Located { name: bound.name, location, scalar: Scalar::new(scalar), components })
    };
    let mut located: Vec<Located<'_>> = bound.iter().filter_map(located).collect();
    located.sort_by_key(|variable| variable.location);
    located
}

fn vertex_format(scalar: Scalar, components: u32) -> Option<VertexFormat> {
    use VertexFormat as F;
    let table = match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => [F::Float32, F::Float32x2, F::Float32x3, F::Float32x4],
        (ScalarKind::Sint, 4) => [F::Sint32, F::Sint32x2, F::Sint32x3, F::Sint32x4],
        (ScalarKind::Uint, 4) => [F::Uint32, F::Uint32x2, F::Uint32x3, F::Uint32x4],
        (ScalarKind::Float, 8) => [F::Float64, F::Float64x2, F::Float64x3, F::Float64x4],
        // There is no three-component format of 16 bits.
        (ScalarKind::Float, 2) => [F::Float16, F::Float16x2, F::Float16x4, F::Float16x4],
        _ => return None,
    };
    table.get(components.checked_sub(1)? as usize).copied()
}
