//! One typed configuration of a pipeline, as a value.

use std::collections::{BTreeMap, BTreeSet};

use crate::draw::HostInterface;
use crate::pipeline::pass::Pass;
use crate::pipeline::program::Program;
use crate::pipeline::resource::Resource;
use crate::pipeline::settings::{Constraint, Derived, Feature, Following, StaticScope, ValuedParameter};
use crate::pipeline::survey::Survey;
use crate::pipeline::toggle::{Condition, Passthrough, Toggle};
use crate::work::{PassHandle, ProgramHandle, ResourceHandle};
use umbragraph_shaders::TargetProfile;
use umbragraph_text::expression::Value;
use umbragraph_text::language::GeometryDeclaration;
use umbragraph_text::source::Sources;

/// A pipeline in one configuration: parameters and features have values, and passes are declared.
#[derive(Clone, Debug)]
pub struct TypedPipeline {
    /// The pipeline's name.
    pub name: String,
    /// The target profile that shaders were validated for.
    pub profile: TargetProfile,
    /// The parameters with their values, by name.
    pub parameters: BTreeMap<String, ValuedParameter>,
    /// The features with their values, by name.
    pub features: BTreeMap<String, Feature>,
    /// The derived values, by name.
    pub derived: BTreeMap<String, Derived>,
    /// The derived values, and the arguments of subgraphs, that depend on parameters. Each entry uses only parameters
    /// and earlier entries.
    pub following: Vec<Following>,
    /// The current values of arguments and derived values of subgraphs that depend on parameters. The keys are internal
    /// names that no document can write.
    pub given: BTreeMap<String, Value>,
    /// The constraints whose violation is an error.
    pub constraints: Vec<Constraint>,
    /// The runtime toggles, sorted by name; [`Condition::toggle`] is an index into this list.
    pub toggles: Vec<Toggle>,
    /// The fallbacks of resources that only passes with a toggle write, for frames in which these passes are off.
    pub passthroughs: BTreeMap<ResourceHandle, Passthrough>,
    /// The geometry contracts with the host's draws, by name.
    pub geometry: BTreeMap<String, GeometryDeclaration>,
    /// The registered mesh storage of hosts, by the name of the geometry contract.
    pub hosts: BTreeMap<String, HostInterface>,
    /// The resources; a [`ResourceHandle`] is an index into this list.
    pub resources: Vec<Resource>,
    /// The passes in the order of the document; a [`PassHandle`] is an index into this list.
    pub passes: Vec<Pass>,
    /// The programs; a [`ProgramHandle`] is an index into this list.
    pub programs: Vec<Program>,
    /// The shader variants whose diagnostics were already reported, as template name and axis values.
    pub rejected: BTreeSet<(String, umbragraph_shaders::AxisValues)>,
    /// Resources that a pass with errors mentions, so that their writers and readers are not fully known.
    pub uncertain: BTreeSet<ResourceHandle>,
    /// The names of parameters, features and derived values that have no value because of errors.
    pub broken_settings: BTreeSet<String>,
    /// The names of passes, uses of subgraphs and loops that are missing because of errors.
    pub gaps: Vec<String>,
    /// The record of required programs and of present and absent passes; `None` unless the load options request it.
    pub survey: Option<Survey>,
    /// The texts of the source files to which the source locations (`Span`) refer.
    pub sources: Sources,
}

impl TypedPipeline {
    /// The WebGPU features that any feature of the pipeline requires, whether that feature is on or off.
    pub fn device_features(&self) -> wgpu_types::Features {
        let declared = self.features.values().flat_map(|feature| &feature.declaration.required_features);
        let known = declared.filter_map(|name| TargetProfile::feature(name));
        known.fold(wgpu_types::Features::empty(), |all, one| all | one)
    }

    /// Returns the resource with this handle.
    pub fn resource(&self, handle: ResourceHandle) -> &Resource {
        &self.resources[handle.index()]
    }

    /// Returns the pass with this handle.
    pub fn pass(&self, handle: PassHandle) -> &Pass {
        &self.passes[handle.index()]
    }

    /// Returns the program with this handle.
    pub fn program(&self, handle: ProgramHandle) -> &Program {
        &self.programs[handle.index()]
    }

    /// The handles of all passes in the order of the document.
    pub fn pass_handles(&self) -> impl Iterator<Item = PassHandle> + use<> {
        (0..self.passes.len() as u32).map(PassHandle)
    }

    /// The handles of all resources.
    pub fn resource_handles(&self) -> impl Iterator<Item = ResourceHandle> + use<> {
        (0..self.resources.len() as u32).map(ResourceHandle)
    }

    /// Returns the handle of the resource with this name, or `None` if there is none.
    pub fn find_resource(&self, name: &str) -> Option<ResourceHandle> {
        self.resources.iter().position(|resource| resource.name == name).map(|at| ResourceHandle(at as u32))
    }

    /// Returns the handle of the pass with this name, or `None` if there is none.
    pub fn find_pass(&self, name: &str) -> Option<PassHandle> {
        self.passes.iter().position(|pass| pass.name == name).map(|at| PassHandle(at as u32))
    }

    /// The scope of names for expressions that are evaluated before sizes are known: parameters, features and derived
    /// values.
    pub fn scope(&self) -> StaticScope {
        StaticScope::new(&self.parameters, &self.features)
            .with_derived(&self.derived)
            .with_given(&self.given)
            .with_broken(self.broken_settings.clone())
    }

    /// Returns the index of the toggle with this name, or `None` if there is none.
    pub fn find_toggle(&self, name: &str) -> Option<usize> {
        self.toggles.iter().position(|toggle| toggle.name == name)
    }

    /// Formats a condition as it is written in a document: `bloom` or `!bloom`.
    pub fn condition_name(&self, condition: Condition) -> String {
        let name = self.toggles.get(condition.toggle).map_or("", |toggle| toggle.name.as_str());
        format!("{}{name}", if condition.on { "" } else { "!" })
    }

    /// The default state of each toggle (`true` for on), which applies until the host sets another.
    pub fn default_states(&self) -> Vec<bool> {
        self.toggles.iter().map(|toggle| toggle.default).collect()
    }

    /// Iterates over a resource, the fallback of its passthrough, the fallback of that fallback, and so on.
    pub fn fallbacks(&self, resource: ResourceHandle) -> impl Iterator<Item = ResourceHandle> + '_ {
        let next =
            |known: &ResourceHandle| self.passthroughs.get(known).map(|passthrough| passthrough.fallback);
        std::iter::successors(Some(resource), next).take(self.passthroughs.len() + 1)
    }
}
