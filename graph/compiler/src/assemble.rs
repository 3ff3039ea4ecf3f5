//! Pipelines put together in code rather than read from a text.
//!
//! For hosts that generate graphs, for tests of the compiler and for benchmarks: resources and passes with their
//! accesses, without shaders. A pass does nothing on a device unless it draws; what it uses is all that the compiler
//! asks. Diagnostics about such a pipeline point at an empty text.

use std::sync::Arc;

use umbragraph_pipeline::document::{Kind, Value};
use umbragraph_pipeline::language::{
    BufferDeclaration, Expr, FormatCandidates, Lifetime, TextureDeclaration,
};
use umbragraph_pipeline::pipeline::{
    Access, Condition, History, Pass, Passthrough, Program, Resource, ResourceKind, SubresourceRange, Toggle,
    TypedPipeline, Usage, Version,
};
use umbragraph_pipeline::shader::TargetProfile;
use umbragraph_pipeline::source::{Sources, Span};
use umbragraph_pipeline::work::{
    Color, ColorAttachment, Depth, DepthAttachment, Draw, LoadOperation, PassHandle, ProgramHandle,
    RenderWork, ResourceHandle, Subresource, TransferEnd, TransferWork, Work,
};

/// A builder that assembles a typed pipeline in code, without a JSON document.
#[derive(Debug)]
pub struct Assembly {
    pipeline: TypedPipeline,
    /// For each pass by index, its work and the accesses that do not follow from the work.
    works: Vec<(Work, Vec<Access>)>,
    sources: Sources,
    place: Span,
}

/// A builder for one pass of an [`Assembly`], which already contains the pass.
#[derive(Debug)]
pub struct AssemblyPass<'a> {
    assembly: &'a mut Assembly,
    handle: PassHandle,
    color: Vec<ColorAttachment>,
    depth: Option<DepthAttachment>,
}

impl Assembly {
    /// Starts an empty pipeline for the target profile `webgpu`.
    pub fn new(name: &str) -> Self {
        let mut sources = Sources::new();
        let place = Span::new(sources.add("<assembled>", ""), 0..0);
        let program = Program {
            template: String::new(),
            axes: Default::default(),
            from_target: Vec::new(),
            variants: Vec::new(),
            bindings: Vec::new(),
        };
        let pipeline = TypedPipeline {
            name: name.to_owned(),
            profile: TargetProfile::webgpu(),
            parameters: Default::default(),
            features: Default::default(),
            derived: Default::default(),
            following: Vec::new(),
            given: Default::default(),
            constraints: Vec::new(),
            toggles: Vec::new(),
            passthroughs: Default::default(),
            geometry: Default::default(),
            hosts: Default::default(),
            resources: Vec::new(),
            passes: Vec::new(),
            programs: vec![program],
            broken_settings: Default::default(),
            gaps: Vec::new(),
            survey: None,
            rejected: Default::default(),
            uncertain: Default::default(),
            sources: Sources::default(),
        };
        Self { pipeline, works: Vec::new(), sources, place }
    }

    /// Adds a transient `rgba8unorm` texture as large as the viewport, with one mip level and one layer.
    pub fn texture(&mut self, name: &str) -> ResourceHandle {
        self.texture_with(name, |_| {})
    }

    /// Adds an `rgba8unorm` texture that the host owns, as large as the viewport, with one mip level and one layer.
    pub fn imported(&mut self, name: &str) -> ResourceHandle {
        self.texture_with(name, |texture| texture.lifetime = Lifetime::Imported)
    }

    /// Adds a texture with a declaration that `describe` may change. Before that, it is transient, `rgba8unorm` and as
    /// large as the viewport.
    pub fn texture_with(
        &mut self,
        name: &str,
        describe: impl FnOnce(&mut TextureDeclaration),
    ) -> ResourceHandle {
        let mut texture = TextureDeclaration {
            format: FormatCandidates::One("rgba8unorm".to_owned()),
            size: Expr::from("=viewport"),
            layers: None,
            mips: None,
            samples: None,
            view_dimension: None,
            lifetime: Lifetime::Transient,
            exposed: false,
            frames: None,
            initial: None,
            description: None,
        };
        describe(&mut texture);
        self.resource(name, ResourceKind::Texture(Box::new(texture)))
    }

    /// Adds a transient texture of a fixed width and height in texels.
    pub fn sized_texture(&mut self, name: &str, width: u32, height: u32) -> ResourceHandle {
        self.texture_with(name, |texture| texture.size = Expr(serde_json::json!([width, height])))
    }

    /// Adds a buffer of a fixed size in bytes.
    pub fn buffer(&mut self, name: &str, bytes: u32, lifetime: Lifetime) -> ResourceHandle {
        self.sized_buffer(name, Expr::from(f64::from(bytes)), lifetime)
    }

    /// Adds a buffer whose size in bytes is an expression.
    pub fn sized_buffer(&mut self, name: &str, size: Expr, lifetime: Lifetime) -> ResourceHandle {
        let declaration = BufferDeclaration {
            size,
            lifetime,
            exposed: false,
            frames: None,
            initial: None,
            description: None,
        };
        self.resource(name, ResourceKind::Buffer(Box::new(declaration)))
    }

    /// Adds a history texture as large as the viewport. Passes can read its contents of `frames` earlier frames, which
    /// are opaque black until those frames exist.
    pub fn history(&mut self, name: &str, frames: u32) -> ResourceHandle {
        self.history_with(name, frames, |_| {})
    }

    /// Adds a history texture with `frames` readable earlier frames. `describe` may change its declaration.
    pub fn history_with(
        &mut self,
        name: &str,
        frames: u32,
        describe: impl FnOnce(&mut TextureDeclaration),
    ) -> ResourceHandle {
        let of = self.texture_with(name, |texture| {
            texture.lifetime = Lifetime::History;
            texture.frames = Some(Expr::from(f64::from(frames)));
            texture.initial = Some(Expr(serde_json::json!([0, 0, 0, 1])));
            describe(texture);
        });
        self.keep_frames(of, frames)
    }

    fn keep_frames(&mut self, of: ResourceHandle, frames: u32) -> ResourceHandle {
        let resource = self.pipeline.resources[of.index()].clone();
        self.pipeline.resources[of.index()].history = Some(History { of, back: 0, frames });
        for back in 1..=frames {
            let name = format!("{}@-{back}", resource.name);
            let history = Some(History { of, back, frames });
            self.pipeline.resources.push(Resource { name, history, ..resource.clone() });
        }
        of
    }

    /// Returns the resource that holds the contents of a history texture from `back` frames ago; 0 is the current
    /// frame.
    ///
    /// # Panics
    ///
    /// Panics if the resource is no history, or keeps fewer than `back` earlier frames.
    pub fn earlier(&self, resource: ResourceHandle, back: u32) -> ResourceHandle {
        let history = self.pipeline.resource(resource).history;
        let earlier = history.and_then(|history| history.members().nth(back as usize));
        earlier.unwrap_or_else(|| panic!("no such frame"))
    }

    /// Adds a toggle that is on by default, and returns its index. Toggles must be added in ascending order of names.
    pub fn toggle(&mut self, name: &str) -> usize {
        let (place, pointer) = (self.place, format!("/toggles/{name}"));
        let (name, description) = (name.to_owned(), None);
        self.pipeline.toggles.push(Toggle { name, default: true, description, place, pointer });
        self.pipeline.toggles.len() - 1
    }

    /// Lets readers of a resource use `version` of `fallback` in frames in which `condition` does not hold.
    pub fn passthrough(
        &mut self,
        resource: ResourceHandle,
        fallback: ResourceHandle,
        version: Version,
        condition: Condition,
    ) {
        let (place, pointer) = (self.place, String::new());
        let passthrough = Passthrough { condition, fallback, version, place, pointer };
        self.pipeline.passthroughs.insert(resource, passthrough);
    }

    fn resource(&mut self, name: &str, kind: ResourceKind) -> ResourceHandle {
        let value = Value { span: self.place, kind: Kind::Null };
        let pointer = format!("/resources/{name}");
        self.pipeline.resources.push(Resource {
            name: name.to_owned(),
            place: self.place,
            pointer,
            value,
            environment: Arc::default(),
            kind,
            history: None,
        });
        ResourceHandle::at(self.pipeline.resources.len() - 1)
    }

    /// Adds a pass without work or accesses, and returns its builder.
    pub fn pass(&mut self, name: &str) -> AssemblyPass<'_> {
        let handle = PassHandle::at(self.pipeline.passes.len());
        let (kind, pointer) = ("assembled".to_owned(), format!("/passes/{name}"));
        self.pipeline.passes.push(Pass::new(name.to_owned(), kind, self.place, pointer, Arc::default()));
        self.works.push((Work::Nothing, Vec::new()));
        AssemblyPass { assembly: self, handle, color: Vec::new(), depth: None }
    }

    /// Returns a reference to a subresource range of the newest version of a resource, such as the source of a copy.
    pub fn subresource(&self, resource: ResourceHandle, range: SubresourceRange) -> Subresource {
        Subresource { resource, range, version: Version::Newest, place: self.place, pointer: String::new() }
    }

    /// Returns the pipeline, and the sources to which its source locations refer.
    pub fn finish(mut self) -> (Arc<TypedPipeline>, Sources) {
        for (pass, (work, others)) in self.pipeline.passes.iter_mut().zip(self.works) {
            pass.set_work(work, others, &self.pipeline.resources);
            // Attachments with a passthrough have a diagnostic when they are read from a text; here nobody makes them.
            let _ = umbragraph_pipeline::pipeline::add_fallbacks(pass, &self.pipeline.passthroughs);
        }
        (Arc::new(self.pipeline), self.sources)
    }
}

impl AssemblyPass<'_> {
    /// The handle of the pass.
    pub fn handle(&self) -> PassHandle {
        self.handle
    }

    /// Declares that the pass samples all subresources of the newest version of a texture.
    pub fn reads(self, resource: ResourceHandle) -> Self {
        self.accesses(resource, SubresourceRange::WHOLE, Usage::Sampled, Version::Newest)
    }

    /// Declares that the pass samples a subresource range of the newest version of a texture.
    pub fn reads_range(self, resource: ResourceHandle, range: SubresourceRange) -> Self {
        self.accesses(resource, range, Usage::Sampled, Version::Newest)
    }

    /// Declares that the pass samples the version of a texture that the pass named `writer` wrote.
    pub fn reads_version(self, resource: ResourceHandle, writer: &str) -> Self {
        self.accesses(
            resource,
            SubresourceRange::WHOLE,
            Usage::Sampled,
            Version::WrittenBy(writer.to_owned()),
        )
    }

    /// Declares that the pass replaces all contents of a resource with storage writes.
    pub fn writes(self, resource: ResourceHandle) -> Self {
        self.writes_range(resource, SubresourceRange::WHOLE)
    }

    /// Declares that the pass replaces the contents of a subresource range with storage writes.
    pub fn writes_range(self, resource: ResourceHandle, range: SubresourceRange) -> Self {
        self.accesses(resource, range, Usage::StorageReplace, Version::Newest)
    }

    /// Declares that the pass reads and writes a resource as storage.
    pub fn updates(self, resource: ResourceHandle) -> Self {
        self.accesses(resource, SubresourceRange::WHOLE, Usage::StorageReadWrite, Version::Newest)
    }

    /// Adds an access of any usage to a subresource range and version of a resource.
    pub fn accesses(
        mut self,
        resource: ResourceHandle,
        range: SubresourceRange,
        usage: Usage,
        version: Version,
    ) -> Self {
        let place = self.assembly.place;
        let (when, pointer) = (Vec::new(), String::new());
        self.work().1.push(Access { resource, range, usage, version, when, place, pointer });
        self
    }

    /// Attaches mip level 0 and layer 0 of a texture as the next color attachment.
    pub fn color(mut self, resource: ResourceHandle, load: LoadOperation<[f64; 4]>) -> Self {
        let to = self.attached(resource);
        self.color.push(ColorAttachment {
            to,
            load: load.map(|color| Color(color).into()),
            blend: None,
            write_mask: wgpu_types::ColorWrites::ALL,
            format: None,
            resolve: None,
            discard: false,
        });
        self.draw()
    }

    /// Attaches mip level 0 and layer 0 of a texture as the depth attachment; read-only if `write` is `false`.
    pub fn depth(mut self, resource: ResourceHandle, load: LoadOperation<f64>, write: bool) -> Self {
        let to = self.attached(resource);
        let load = load.map(|depth| Depth(depth).into());
        let compare = wgpu_types::CompareFunction::Less;
        self.depth = Some(DepthAttachment { to, load, write, compare, slope_bias: 0.0, discard: false });
        self.draw()
    }

    /// Copies `source` to `destination`, or fills the destination buffer with zeros if `source` is `None`. `written` is
    /// the usage of the destination.
    pub fn copies(mut self, source: Option<TransferEnd>, destination: TransferEnd, written: Usage) -> Self {
        let transfer = TransferWork { source, destination, written, extent: None };
        self.work().0 = Work::Transfer(Box::new(transfer));
        self
    }

    /// Makes this pass run after another pass.
    pub fn after(mut self, pass: PassHandle) -> Self {
        self.declared().after.push(pass);
        self
    }

    /// Makes this pass run only in frames in which a toggle is on, or off if `on` is `false`. `toggle` is an index that
    /// [`Assembly::toggle`] returned.
    pub fn toggle(mut self, toggle: usize, on: bool) -> Self {
        self.declared().condition = Some(Condition { toggle, on });
        self
    }

    /// Marks the pass as having a side effect, so that it is never culled.
    pub fn side_effect(mut self) -> Self {
        self.declared().side_effect = true;
        self
    }

    fn declared(&mut self) -> &mut Pass {
        &mut self.assembly.pipeline.passes[self.handle.index()]
    }

    fn work(&mut self) -> &mut (Work, Vec<Access>) {
        &mut self.assembly.works[self.handle.index()]
    }

    fn attached(&self, resource: ResourceHandle) -> Subresource {
        self.assembly.subresource(resource, SubresourceRange::of(Some(0), Some(0)))
    }

    /// Makes the pass a full-screen draw to the attachments added so far.
    fn draw(mut self) -> Self {
        let (color, depth) = (self.color.clone(), self.depth.clone());
        let draw = Draw::Fullscreen { program: ProgramHandle::at(0), bindings: Vec::new() };
        self.work().0 =
            Work::Render(Box::new(RenderWork { color, depth, stencil: None, draw, blend_constant: None }));
        self
    }
}
