//! The interface of a module: bindings, memory layouts, entry points.
//!
//! The host's side of the interface is derived from the validated naga module, the only source. Properties that WGSL
//! does not state get the defaults of WebGPU's automatic layouts: a float texture is filterable exactly if it is
//! sampled with a sampler, samplers filter, no offset is dynamic. Only bindings that an entry point uses are part of
//! the interface; the others are listed apart.

mod binding;
mod coverage;
mod entry_point;
pub mod interface;
mod layout;

pub use binding::Binding;
pub use entry_point::{EntryPoint, FragmentOutput, Stage, VertexInput};
pub use layout::{Member, Scalar, ScalarKind, TypeLayout};

use std::hash::{Hash, Hasher};

use naga::Module;
use naga::proc::Layouter;
use naga::valid::ModuleInfo;

/// The interface of a shader module: bindings, entry points and overrides.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Reflection {
    /// The bindings that at least one entry point uses, sorted by group and binding.
    pub bindings: Vec<Binding>,
    /// The bindings that are declared, but used by no entry point, sorted by group and binding.
    pub unused: Vec<Binding>,
    /// The entry points, sorted by name and stage.
    pub entry_points: Vec<EntryPoint>,
    /// The names of the pipeline-overridable constants, sorted.
    pub overrides: Vec<String>,
}

/// Hashes only the short fields that usually differ between variants. Equality compares all fields.
impl Hash for Reflection {
    fn hash<H: Hasher>(&self, state: &mut H) {
        for each in self.bindings.iter().chain(&self.unused) {
            (each.group, each.binding, each.entry.visibility).hash(state);
            each.type_name.hash(state);
        }
        for each in &self.entry_points {
            each.name.hash(state);
            each.workgroup_size.hash(state);
        }
        self.overrides.hash(state);
    }
}

impl Reflection {
    /// Returns the used binding with this name, or `None`.
    pub fn binding(&self, name: &str) -> Option<&Binding> {
        self.bindings.iter().find(|binding| binding.name == name)
    }

    /// Returns the entry point with this name, or `None`.
    pub fn entry_point(&self, name: &str) -> Option<&EntryPoint> {
        self.entry_points.iter().find(|entry_point| entry_point.name == name)
    }
}

/// Returns the interface of a validated module. `sizes` holds the workgroup sizes, computed with the values of
/// overrides.
pub(crate) fn reflect(module: &Module, info: &ModuleInfo, sizes: &entry_point::WorkgroupSizes) -> Reflection {
    let mut layouter = Layouter::default();
    // The validator has just laid out the same types, so this cannot fail; without layouts there are no bindings.
    if layouter.update(module.to_ctx()).is_err() {
        return Reflection::default();
    }
    let (bindings, unused) = binding::bindings(module, info, &layouter);
    let mut overrides: Vec<String> =
        module.overrides.iter().filter_map(|(_, constant)| constant.name.clone()).collect();
    overrides.sort();
    Reflection { bindings, unused, entry_points: entry_point::entry_points(module, info, sizes), overrides }
}

pub(crate) use entry_point::WorkgroupSizes;
