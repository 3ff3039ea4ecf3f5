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
//! would only follow ([`Pipeline::uncertain`]).

mod availability;
mod binding;
mod builder;
mod derived;
mod environment;
mod expand;
mod history;
mod host_contract;
mod inlined;
mod load;
mod modules;
mod preset;
mod profiles;
mod program;
mod schema;
mod schema_overlays;
mod scope;
mod setting;
mod subresource_range;
mod toggle;

pub use availability::{Lacking, lacking, off};
pub use binding::{Bind, BindObject, BufferBind, Contents, ValuesBind, element_type, member_runs};
pub use builder::{Face, PassBuilder, Produced, SubresourceRangeSettings, axis_value, expression_diagnostic};
pub use derived::Derived;
pub use environment::Environment;
pub use history::History;
pub use inlined::inlined;
pub use load::{as_written, has_word, is_name, load, load_sharing};
pub use modules::{Absent, Chosen, EntryPoints, Modules, Wanted};

pub use preset::{ParameterFile, of_preset};
pub use profiles::{claimed_profiles, profile_named};
pub use program::{Program, ProgramBinding, ProgramVariant};
pub use schema::{FileKind, schema, schema_of, schema_of_composed};
pub use scope::StaticScope;
pub use setting::{Feature, Overrides, Parameter, Setting};
pub use subresource_range::{Aspect, IndexRange, SubresourceRange, canonical};
pub use toggle::{Condition, Passthrough, Toggle, add_fallbacks};

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::data::DataShape;
use crate::language::{BufferDeclaration, GeometryDeclaration, Lifetime, TextureDeclaration};
use crate::shader::TargetProfile;
use crate::source::Span;
use crate::work::{PassHandle, ProgramHandle, ResourceHandle, Subresource, Work};

/// One typed configuration.
#[derive(Clone, Debug)]
pub struct Pipeline {
    /// The pipeline's name.
    pub name: String,
    /// The profile that shaders were validated for.
    pub profile: TargetProfile,
    /// The parameters with their values, by name.
    pub parameters: BTreeMap<String, Parameter>,
    /// The features with their values, by name.
    pub features: BTreeMap<String, Feature>,
    /// The derived values, by name.
    pub derived: BTreeMap<String, Derived>,
    /// The toggles in the order of their names; a [`Condition`] names a position here.
    pub toggles: Vec<Toggle>,
    /// The fallback of resources that only passes with a toggle write, in frames without them.
    pub passthroughs: BTreeMap<ResourceHandle, Passthrough>,
    /// The contracts with the host's draws, by name.
    pub geometry: BTreeMap<String, GeometryDeclaration>,
    /// The resources; a [`ResourceHandle`] is a position here.
    pub resources: Vec<Resource>,
    /// The passes in the order of the document; a [`PassHandle`] is a position here.
    pub passes: Vec<Pass>,
    /// The programs; a [`ProgramHandle`] is a position here.
    pub programs: Vec<Program>,
    /// Resources that a pass with diagnostics of its own mentions: nothing is known about who writes or reads them.
    pub uncertain: BTreeSet<ResourceHandle>,
    /// Parameters, features and derived values without a value, because of diagnostics of their own.
    pub broken_settings: BTreeSet<String>,
    /// The passes that are not there because of diagnostics of their own, and the subgraphs and loops of such.
    pub gaps: Vec<String>,
}

impl Pipeline {
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

    /// Its lifetime.
    pub fn lifetime(&self) -> Lifetime {
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

/// The version of a resource that is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Version {
    /// The newest; for a pass that reads and writes, the one before its own.
    Newest,
    /// The one that the named pass wrote.
    WrittenBy(String),
    /// What was there before the first write of the frame.
    Before,
}

/// The usage of a resource by a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Usage {
    /// A sampled texture binding.
    Sampled,
    /// A uniform buffer binding.
    Uniform,
    /// A storage binding that is read.
    StorageRead,
    /// A storage binding that is only written.
    StorageWrite,
    /// A storage binding that writes all of a subresource range, whatever it held.
    StorageReplace,
    /// A storage binding that is read and written.
    StorageReadWrite,
    /// A color attachment whose contents are not needed.
    ColorAttachment,
    /// A color attachment that is loaded.
    ColorAttachmentLoad,
    /// A depth attachment whose contents are not needed.
    DepthAttachment,
    /// A depth attachment that is loaded and written.
    DepthAttachmentLoad,
    /// A depth attachment that is only tested against.
    DepthAttachmentReadOnly,
    /// A stencil attachment whose contents are not needed.
    StencilAttachment,
    /// A stencil attachment that is loaded and written.
    StencilAttachmentLoad,
    /// A stencil attachment that is only tested against.
    StencilAttachmentReadOnly,
    /// The target of a multisample resolve.
    ResolveTarget,
    /// A buffer of vertices.
    Vertex,
    /// A buffer of indices.
    Index,
    /// A buffer of counts for a draw or a dispatch.
    Indirect,
    /// The source of a copy.
    CopySource,
    /// The destination of a copy that replaces all of a subresource range.
    CopyDestination,
    /// The destination of a copy that leaves the rest of a subresource range.
    CopyDestinationLoad,
    /// The destination of rows of texels, between which bytes of a buffer stay as they are, if they are anything.
    CopyDestinationRows,
    /// Blackboard data that is read.
    BlackboardRead,
    /// Blackboard data that is published.
    BlackboardWrite,
}

/// What an access does with the contents.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effect {
    Reads,
    /// Both.
    Loads,
    /// Writes, and needs nothing of what was there, though not all of it may be written.
    Writes,
    /// Writes all.
    Replaces,
}

impl Usage {
    /// What it does, the usages that a texture and a buffer must be created with, and its name in diagnostics.
    fn properties(self) -> (Effect, wgpu_types::TextureUsages, wgpu_types::BufferUsages, &'static str) {
        use Effect::{Loads, Reads, Replaces, Writes};
        use wgpu_types::{BufferUsages as B, TextureUsages as T};
        const STORAGE: (T, B) = (T::STORAGE_BINDING, B::STORAGE);
        const ATTACHMENT: (T, B) = (T::RENDER_ATTACHMENT, B::empty());
        const DESTINATION: (T, B) = (T::COPY_DST, B::COPY_DST);
        const DATA: (T, B) = (T::empty(), B::empty());
        const fn buffer(usage: B) -> (T, B) {
            (T::empty(), usage)
        }
        let (effect, (texture, buffer), name) = match self {
            Usage::Sampled => (Reads, (T::TEXTURE_BINDING, B::empty()), "sampled texture"),
            Usage::Uniform => (Reads, buffer(B::UNIFORM), "uniform buffer"),
            Usage::StorageRead => (Reads, STORAGE, "read-only storage"),
            Usage::StorageWrite => (Writes, STORAGE, "write-only storage"),
            Usage::StorageReplace => (Replaces, STORAGE, "storage that is replaced"),
            Usage::StorageReadWrite => (Loads, STORAGE, "read-write storage"),
            Usage::ColorAttachment => (Replaces, ATTACHMENT, "color attachment"),
            Usage::ColorAttachmentLoad => (Loads, ATTACHMENT, "color attachment"),
            Usage::DepthAttachment => (Replaces, ATTACHMENT, "depth attachment"),
            Usage::DepthAttachmentLoad => (Loads, ATTACHMENT, "depth attachment"),
            Usage::DepthAttachmentReadOnly => (Reads, ATTACHMENT, "depth attachment"),
            Usage::StencilAttachment => (Replaces, ATTACHMENT, "stencil attachment"),
            Usage::StencilAttachmentLoad => (Loads, ATTACHMENT, "stencil attachment"),
            Usage::StencilAttachmentReadOnly => (Reads, ATTACHMENT, "stencil attachment"),
            Usage::ResolveTarget => (Replaces, ATTACHMENT, "resolve target"),
            Usage::Vertex => (Reads, buffer(B::VERTEX), "vertex buffer"),
            Usage::Index => (Reads, buffer(B::INDEX), "index buffer"),
            Usage::Indirect => (Reads, buffer(B::INDIRECT), "indirect buffer"),
            Usage::CopySource => (Reads, (T::COPY_SRC, B::COPY_SRC), "source of a copy"),
            Usage::CopyDestination => (Writes, DESTINATION, "destination of a copy"),
            Usage::CopyDestinationLoad => {
                (Loads, DESTINATION, "destination of a copy of a subresource range")
            }
            Usage::CopyDestinationRows => (Loads, DESTINATION, "destination of rows of texels"),
            Usage::BlackboardRead => (Reads, DATA, "blackboard data"),
            Usage::BlackboardWrite => (Writes, DATA, "published blackboard data"),
        };
        (effect, texture, buffer, name)
    }

    /// Whether contents from before are needed, or [stay](Self::keeps_what_is_there).
    pub fn reads(self) -> bool {
        matches!(self.properties().0, Effect::Reads | Effect::Loads)
    }

    /// Whether contents from before are kept, but need not exist.
    pub fn keeps_what_is_there(self) -> bool {
        self == Usage::CopyDestinationRows
    }

    /// Whether a new version is made.
    pub fn writes(self) -> bool {
        self.properties().0 != Effect::Reads
    }

    /// Whether it is an attachment.
    pub fn is_attachment(self) -> bool {
        self.texture_usages() == wgpu_types::TextureUsages::RENDER_ATTACHMENT
    }

    /// Whether it is an attachment of depth.
    pub fn is_depth(self) -> bool {
        matches!(self, Usage::DepthAttachment | Usage::DepthAttachmentLoad | Usage::DepthAttachmentReadOnly)
    }

    /// Whether it is an attachment of stencil.
    pub fn is_stencil(self) -> bool {
        use Usage as U;
        matches!(self, U::StencilAttachment | U::StencilAttachmentLoad | U::StencilAttachmentReadOnly)
    }

    /// Whether all of a subresource range is certain to be written again, whatever it held.
    pub fn replaces_contents(self) -> bool {
        self.properties().0 == Effect::Replaces
    }

    /// The usage that a texture must be created with.
    pub fn texture_usages(self) -> wgpu_types::TextureUsages {
        self.properties().1
    }

    /// The usage that a buffer must be created with.
    pub fn buffer_usages(self) -> wgpu_types::BufferUsages {
        self.properties().2
    }

    /// The name of the usage in diagnostics.
    pub fn name(self) -> &'static str {
        self.properties().3
    }
}
