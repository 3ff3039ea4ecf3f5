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

/// One typed configuration.
#[derive(Clone, Debug)]
pub struct TypedPipeline {
    /// The pipeline's name.
    pub name: String,
    /// The profile that shaders were validated for.
    pub profile: TargetProfile,
    /// The parameters with their values, by name.
    pub parameters: BTreeMap<String, ValuedParameter>,
    /// The features with their values, by name.
    pub features: BTreeMap<String, Feature>,
    /// The derived values, by name.
    pub derived: BTreeMap<String, Derived>,
    /// Values that follow from parameters: derived values, and arguments of subgraphs. Each needs only those before it.
    pub following: Vec<Following>,
    /// Values that subgraphs are given and that follow from parameters, by names that no document can write.
    pub given: BTreeMap<String, Value>,
    /// The constraints that are errors.
    pub constraints: Vec<Constraint>,
    /// The toggles in the order of their names; a [`Condition`] names a position here.
    pub toggles: Vec<Toggle>,
    /// The fallback of resources that only passes with a toggle write, in frames without them.
    pub passthroughs: BTreeMap<ResourceHandle, Passthrough>,
    /// The contracts with the host's draws, by name.
    pub geometry: BTreeMap<String, GeometryDeclaration>,
    /// The mesh layouts of hosts by contract, as the registry has them.
    pub hosts: BTreeMap<String, HostInterface>,
    /// The resources; a [`ResourceHandle`] is a position here.
    pub resources: Vec<Resource>,
    /// The passes in the order of the document; a [`PassHandle`] is a position here.
    pub passes: Vec<Pass>,
    /// The programs; a [`ProgramHandle`] is a position here.
    pub programs: Vec<Program>,
    /// The variants of templates that are no programs, because of diagnostics of their own.
    pub rejected: BTreeSet<(String, umbragraph_shaders::AxisValues)>,
    /// Resources that a pass with diagnostics of its own mentions: nothing is known about who writes or reads them.
    pub uncertain: BTreeSet<ResourceHandle>,
    /// Parameters, features and derived values without a value, because of diagnostics of their own.
    pub broken_settings: BTreeSet<String>,
    /// The passes that are not there because of diagnostics of their own, and the subgraphs and loops of such.
    pub gaps: Vec<String>,
    /// The record of what it wants, has and lacks, if the load was told to keep one.
    pub survey: Option<Survey>,
    /// The texts that places are in.
    pub sources: Sources,
}

impl TypedPipeline {
    /// The features of WebGPU that features of the pipeline require.
    pub fn device_features(&self) -> wgpu_types::Features {
        let declared = self.features.values().flat_map(|feature| &feature.declaration.required_features);
        let known = declared.filter_map(|name| TargetProfile::feature(name));
        known.fold(wgpu_types::Features::empty(), |all, one| all | one)
    }

    /// A resource.
    pub fn resource(&self, handle: ResourceHandle) -> &Resource {
        &self.resources[handle.index()]
    }

    /// A pass.
    pub fn pass(&self, handle: PassHandle) -> &Pass {
        &self.passes[handle.index()]
    }

    /// A program.
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

    /// The resource of a name.
    pub fn find_resource(&self, name: &str) -> Option<ResourceHandle> {
        self.resources.iter().position(|resource| resource.name == name).map(|at| ResourceHandle(at as u32))
    }

    /// The pass of a name.
    pub fn find_pass(&self, name: &str) -> Option<PassHandle> {
        self.passes.iter().position(|pass| pass.name == name).map(|at| PassHandle(at as u32))
    }

    /// The names that expressions can see before sizes are known: parameters, features and derived values.
    pub fn scope(&self) -> StaticScope {
        StaticScope::new(&self.parameters, &self.features)
            .with_derived(&self.derived)
            .with_given(&self.given)
            .with_broken(self.broken_settings.clone())
    }

    /// The toggle of a name.
    pub fn find_toggle(&self, name: &str) -> Option<usize> {
        self.toggles.iter().position(|toggle| toggle.name == name)
    }

    /// A condition as it is written: `bloom` or `!bloom`.
    pub fn condition_name(&self, condition: Condition) -> String {
        let name = self.toggles.get(condition.toggle).map_or("", |toggle| toggle.name.as_str());
        format!("{}{name}", if condition.on { "" } else { "!" })
    }

    /// The states of the toggles where the host says nothing.
    pub fn default_states(&self) -> Vec<bool> {
        self.toggles.iter().map(|toggle| toggle.default).collect()
    }

    /// A resource, its fallback when its passthrough applies, the fallback of that, and so on.
    pub fn fallbacks(&self, resource: ResourceHandle) -> impl Iterator<Item = ResourceHandle> + '_ {
        let next =
            |known: &ResourceHandle| self.passthroughs.get(known).map(|passthrough| passthrough.fallback);
        std::iter::successors(Some(resource), next).take(self.passthroughs.len() + 1)
    }
}
