//! One typed configuration of a pipeline: parameters and features chosen, passes declared, shaders reflected.
//!
//! [`load`] takes a document through these steps, collecting diagnostics on the way:
//!
//! 1. the tree is checked against the schema composed of the language and the registered node kinds ([`schema`]);
//! 2. parameters and features get their values (default, preset by the caller's [`Overrides`]) and are checked against
//!    their ranges and constraints;
//! 3. each pass whose `when` holds is declared by its node kind, which states resources used, shaders and bindings
//!    through a [`PassBuilder`]; shaders are rendered, validated and reflected here, since the usage of a binding is
//!    what the shader says it is;
//! 4. what passes say of one another (blackboard data, versions) is connected.
//!
//! A pass that could not be declared leaves a gap: the resources that it mentions are exempt from diagnostics that
//! would only follow ([`TypedPipeline::uncertain`]).

mod availability;
mod binding;
mod builder;
mod derived;
mod environment;
mod expand;
mod expression_diagnostic;
mod history;
mod host_contract;
mod instance;
mod live;
mod load;
mod located;
mod overrides;
mod preset;
mod profiles;
mod program;
mod resource_value;
mod schema;
mod schema_overlays;
mod scope;
mod setting;
mod survey;
mod toggle;

pub use crate::access::usage::Usage;
pub use crate::access::version::Version;
pub use crate::whole_number::whole_number;
pub use availability::{Lacking, lacking, off};
pub use binding::{Bind, BindObject, BufferBind, Contents, ValuesBind, element_type, member_runs};
pub use builder::{
    Evaluate, Face, LiveSettings, PassBuilder, Produced, SubresourceRangeSettings, axis_value,
};
pub use derived::Derived;
pub use environment::{Environment, with_names};
pub use expression_diagnostic::expression_diagnostic;
pub use history::History;
pub use live::{Constraint, Following, LiveSetting, Structural, is_alike};
pub use load::{LoadOptions, check_schema, is_of, load};
pub use located::Located;
pub use survey::{Absent, Chosen, EntryPoints, Survey, Wanted};

pub use crate::access::subresource_range::{Aspect, IndexRange, SubresourceRange, canonical};
pub use overrides::{Override, Overrides};
pub use preset::{ParameterFile, of_preset};
pub use profiles::{claimed_profiles, profile_named};
pub use program::{Program, ProgramBinding, ProgramVariant};
pub use schema::{FileKind, schema, schema_of, schema_of_composed};
pub use scope::StaticScope;
pub use setting::{Feature, ValuedParameter, rejected};
pub use toggle::{Condition, Passthrough, Toggle, add_fallbacks};

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::data::DataShape;
use crate::draw::HostInterface;
use crate::expression::Value;
use crate::language::{BufferDeclaration, GeometryDeclaration, Lifetime, TextureDeclaration};
use crate::shader::TargetProfile;
use crate::source::{Sources, Span};
use crate::work::{PassHandle, ProgramHandle, ResourceHandle, Subresource, Work};

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
    /// What follows from parameters, in an order in which each needs only those before it: derived values, and what
    /// subgraphs are given.
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
    /// What hosts store of the meshes of a contract, as the registry says it.
    pub hosts: BTreeMap<String, HostInterface>,
    /// The resources; a [`ResourceHandle`] is a position here.
    pub resources: Vec<Resource>,
    /// The passes in the order of the document; a [`PassHandle`] is a position here.
    pub passes: Vec<Pass>,
    /// The programs; a [`ProgramHandle`] is a position here.
    pub programs: Vec<Program>,
    /// The variants of templates that are no programs, because of diagnostics of their own.
    pub rejected: BTreeSet<(String, crate::shader::AxisValues)>,
    /// Resources that a pass with diagnostics of its own mentions: nothing is known about who writes or reads them.
    pub uncertain: BTreeSet<ResourceHandle>,
    /// Parameters, features and derived values without a value, because of diagnostics of their own.
    pub broken_settings: BTreeSet<String>,
    /// The passes that are not there because of diagnostics of their own, and the subgraphs and loops of such.
    pub gaps: Vec<String>,
    /// What it wants, has and lacks, where that was to be written down.
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
}

/// A resource of a pipeline.
#[derive(Clone, Debug)]
pub struct Resource {
    /// Its name.
    pub name: String,
    /// Where it is declared; for blackboard data, where the pass that publishes it names it.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
    /// The declaration as it is written; for blackboard data, the value that names it.
    pub value: crate::document::Value,
    /// The scope of names in its declaration.
    pub environment: Arc<Environment>,
    /// The kind.
    pub kind: ResourceKind,
    /// For a history, which of its frames it is.
    pub history: Option<History>,
}

impl Resource {
    /// Whether it is an earlier frame of a history, which can only be read.
    pub fn is_earlier_frame(&self) -> bool {
        self.history.is_some_and(|history| history.back > 0)
    }

    /// Whether the host looks at it between frames.
    pub fn is_exposed(&self) -> bool {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.exposed,
            ResourceKind::Buffer(buffer) => buffer.exposed,
            ResourceKind::Data(_) | ResourceKind::Broken => false,
        }
    }

    /// Its lifetime; what is exposed keeps its memory from frame to frame.
    pub fn lifetime(&self) -> Lifetime {
        match self.declared_lifetime() {
            Lifetime::Transient if self.is_exposed() => Lifetime::Persistent,
            declared => declared,
        }
    }

    /// The lifetime of what is in it.
    pub fn declared_lifetime(&self) -> Lifetime {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.lifetime,
            ResourceKind::Buffer(buffer) => buffer.lifetime,
            ResourceKind::Data(_) | ResourceKind::Broken => Lifetime::Transient,
        }
    }

    /// The texture's declaration, if it is one.
    pub fn texture(&self) -> Option<&TextureDeclaration> {
        match &self.kind {
            ResourceKind::Texture(texture) => Some(texture),
            _ => None,
        }
    }

    /// The kind in words, with an article.
    pub fn kind_name(&self) -> &'static str {
        match self.kind {
            ResourceKind::Texture(_) => "a texture",
            ResourceKind::Buffer(_) => "a buffer",
            ResourceKind::Data(_) => "blackboard data",
            ResourceKind::Broken => "broken",
        }
    }
}

/// The kind of a resource.
#[derive(Clone, Debug)]
pub enum ResourceKind {
    /// A texture.
    Texture(Box<TextureDeclaration>),
    /// A buffer.
    Buffer(Box<BufferDeclaration>),
    /// Blackboard data: values and views; `None` until the pass that publishes it is declared.
    Data(Option<DataShape>),
    /// A declaration with diagnostics of its own: nothing is known, and nothing is said of it.
    Broken,
}

/// A declared pass.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Its name.
    pub name: String,
    /// Its node kind.
    pub kind: String,
    /// The place of its key.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
    /// The scope of names in its settings.
    pub environment: Arc<Environment>,
    /// Passes that have to run before it, where no data says so.
    pub after: Vec<PassHandle>,
    /// Whether it has to follow something that is not there, which is a diagnostic: its order is not known then.
    pub is_misplaced: bool,
    /// Whether it is kept even if nothing reads what it writes.
    pub side_effect: bool,
    /// In which frames it runs, if not in all.
    pub condition: Option<Condition>,
    /// The settings that are evaluated again when a live parameter changes.
    pub live: Vec<LiveSetting>,
    work: Work,
    accesses: Vec<Access>,
}

impl Pass {
    /// A pass that does nothing yet.
    pub fn new(
        name: String,
        kind: String,
        place: Span,
        pointer: String,
        environment: Arc<Environment>,
    ) -> Self {
        Self {
            name,
            kind,
            place,
            pointer,
            environment,
            after: Vec::new(),
            is_misplaced: false,
            side_effect: false,
            condition: None,
            live: Vec::new(),
            work: Work::Nothing,
            accesses: Vec::new(),
        }
    }

    /// The work.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// What it uses: what its work accesses, and the fallback of that.
    pub fn accesses(&self) -> &[Access] {
        &self.accesses
    }

    /// The accesses with which it writes a resource.
    pub fn writes_of(&self, resource: ResourceHandle) -> impl Iterator<Item = &Access> {
        self.accesses.iter().filter(move |one| one.resource == resource && one.usage.writes())
    }

    /// Whether it writes a resource.
    pub fn writes(&self, resource: ResourceHandle) -> bool {
        self.writes_of(resource).next().is_some()
    }

    /// Says what it does, and so what it uses; of work that is only assembled `others` are known besides.
    pub fn set_work(&mut self, work: Work, others: Vec<Access>, resources: &[Resource]) {
        self.accesses.clear();
        for (named, usage) in work.accesses() {
            let texture = resources.get(named.resource.index()).and_then(Resource::texture);
            let range = texture.map_or(named.range, |texture| canonical(texture, named.range, usage));
            let is_known =
                |known: &Access| usage == Usage::BlackboardRead && known.resource == named.resource;
            if !self.accesses.iter().any(is_known) {
                self.accesses.push(Access::new(named, range, usage));
            }
        }
        self.accesses.extend(others);
        self.work = work;
    }

    /// Work and accesses that need not fit one another: for tests of what is to notice that.
    #[doc(hidden)]
    pub fn tamper(&mut self) -> (&mut Work, &mut Vec<Access>) {
        (&mut self.work, &mut self.accesses)
    }
}

/// One access of a resource by a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// The resource.
    pub resource: ResourceHandle,
    /// The subresource range of it.
    pub range: SubresourceRange,
    /// How.
    pub usage: Usage,
    /// The version that is read.
    pub version: Version,
    /// In which of the frames in which the pass runs it happens: all have to hold. Empty but for what has a
    /// passthrough, and for its fallback.
    pub when: Vec<Condition>,
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

impl Access {
    fn new(named: &Subresource, range: SubresourceRange, usage: Usage) -> Self {
        let Subresource { resource, version, place, pointer, .. } = named.clone();
        Self { resource, range, usage, version, when: Vec::new(), place, pointer }
    }
}
