//! Contents of textures, copied out of a frame of the running pipeline.
//!
//! A capture is an ordinary copy after the pass that is looked at, in a document that extends the pipeline
//! ([`umbragraph::low_level::capture`]). A thread plans it with the values that run. The shown frame is then recorded
//! once more with that plan, from the contents that it began with ([`crate::state`]), and the plan before goes on:
//! nothing advances, however often somebody looks.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use serde_json::{Map, Value, json};
use umbragraph::executor::{Texels, imported_texture, read_back, read_buffer, read_sample};
use umbragraph::low_level::capture::{self, Capture, Wanted};
use umbragraph::low_level::expression;
use umbragraph::low_level::source::Sources;
use umbragraph::{Error, Frame, Library, Options, Plan, Setting, wgpu};

use crate::buffers::size_of;
use crate::bytes;
use crate::guard::guarded;
use crate::stage::{Stage, error_of};
use crate::targets::MORE;
use crate::tiles::{self, Tile};
use crate::values::to_json;

/// The contents to capture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Request {
    pub(crate) captures: Vec<Capture>,
    /// Whether the stencil aspect is captured instead of the depth.
    pub(crate) is_stencil: bool,
    /// The sample that is read of textures with several samples, from 0.
    pub(crate) sample: u32,
}

impl Request {
    /// Returns `true` if a plan for the other request serves this one.
    fn is_like(&self, other: &Self) -> bool {
        self.captures == other.captures && self.is_stencil == other.is_stencil
    }
}

/// A plan that extends the running one with copies of the captured resources.
pub(crate) struct Planned {
    /// The running plan for which the captures were planned.
    pub(crate) of: Arc<Plan>,
    pub(crate) request: Request,
    pub(crate) plan: Arc<Plan>,
    /// The names of the imports that receive the captures, in the order of the captures.
    pub(crate) imports: Vec<String>,
}

/// The captured contents of a texture or a buffer.
pub(crate) enum Captured {
    Texels(Texels),
    /// The captured bytes of a buffer.
    Bytes(Vec<u8>),
}

/// The planning of captures in progress on another thread.
pub(crate) struct Planning {
    of: Arc<Plan>,
    request: Request,
    outcome: Receiver<Result<Planned, Error>>,
}

/// A parameter or feature value of a plan, for use as a planning option.
struct Fixed<'a>(&'a expression::Value);

impl Setting for Fixed<'_> {
    fn value(&self) -> Value {
        to_json(self.0)
    }
}

impl Planning {
    /// Starts a thread that plans captures of the running pipeline.
    pub(crate) fn begin(
        library: &Library,
        pipeline: &Path,
        of: &Arc<Plan>,
        request: Request,
        context: &egui::Context,
    ) -> Self {
        let (done, outcome) = channel();
        let (library, pipeline, wake) = (library.clone(), pipeline.to_owned(), context.clone());
        let (plan, wanted) = (of.clone(), request.clone());
        std::thread::spawn(move || {
            let planned = planned(&library, &pipeline, plan, wanted);
            // Nobody receives it once something else is looked at.
            let _ = done.send(planned);
            wake.request_repaint();
        });
        Self { of: of.clone(), request, outcome }
    }

    /// Returns `true` if the planning is for these captures of the plan `of`.
    pub(crate) fn is_for(&self, of: &Arc<Plan>, request: &Request) -> bool {
        Arc::ptr_eq(&self.of, of) && self.request.is_like(request)
    }

    /// The outcome of the planning; `None` while it is in progress, and after it has been taken.
    pub(crate) fn take(&self) -> Option<Result<Planned, Error>> {
        self.outcome.try_recv().ok()
    }
}

impl Planned {
    /// Returns `true` if the planned captures are these captures of the plan `of`.
    pub(crate) fn is_for(&self, of: &Arc<Plan>, request: &Request) -> bool {
        Arc::ptr_eq(&self.of, of) && self.request.is_like(request)
    }
}

impl Stage {
    /// Records the last frame once more with captures, and reads them back. `sample` is that of textures with several
    /// samples.
    ///
    /// # Errors
    /// Errors of recording the frame, and of reading back textures or buffers.
    pub(crate) fn capture(
        &mut self,
        state: &RenderState,
        planned: &Planned,
        sample: u32,
    ) -> Result<Vec<Captured>, Error> {
        guarded(&state.device, "the captures", || self.captured(state, planned, sample)).map_err(error_of)?
    }

    /// The tiles of a texture in the last frame, as a pass draws them.
    pub(crate) fn tiles(&mut self, texture: &str, pass: &str) -> Vec<Tile> {
        let (Some(executor), Some(plan)) = (self.renderer.executor(), &self.plan) else { return Vec::new() };
        tiles::of(executor, plan, [texture, pass], self.last.as_ref())
    }

    fn captured(
        &mut self,
        state: &RenderState,
        planned: &Planned,
        sample: u32,
    ) -> Result<Vec<Captured>, Error> {
        let (Some(executor), Some(shown), Some(input)) = (self.renderer.executor(), &self.shown, &self.last)
        else {
            return Ok(Vec::new());
        };
        executor.set_plan(planned.plan.clone())?;
        let texture = |name: &String| {
            let samples = planned.plan.resources.get(name)?.size.map_or(1, |size| size.samples);
            // A texture of several samples has to be an attachment.
            let more = if samples > 1 { MORE | wgpu::TextureUsages::RENDER_ATTACHMENT } else { MORE };
            imported_texture(&state.device, &planned.plan, name, more)
        };
        let contents: Vec<wgpu::Texture> = planned.imports.iter().filter_map(texture).collect();
        let mut buffers = Vec::new();
        let mut given = Ok(());
        for (name, size) in
            planned.imports.iter().filter_map(|name| Some((name, size_of(&planned.plan, name)?)))
        {
            let buffer = state.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(name),
                size,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let import = executor.import::<wgpu::Buffer>(name);
            given = given.and(import.and_then(|import| executor.give(import, &buffer)));
            buffers.push(buffer);
        }
        let captured = planned.imports.iter().map(String::as_str).zip(&contents);
        let imports: Vec<(&str, &wgpu::Texture)> =
            self.targets.imports().into_iter().chain(captured).collect();
        let toggles = self.values.toggles_of(&planned.plan);
        let frame = Frame::new(input).draws(&shown.meshes).imports(&imports).toggles(&toggles);
        let mut encoder = state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.kept.restore(&mut encoder);
        let given = given.and_then(|()| self.values.set_live(executor));
        let recorded = given.and_then(|()| executor.repeat(&mut encoder, &frame));
        if recorded.is_ok() {
            state.queue.submit([encoder.finish()]);
        }
        let running = executor.set_plan(planned.of.clone()).and_then(|()| self.values.set_live(executor));
        recorded.and(running)?;
        let texels = contents.iter().map(|texture| {
            if texture.sample_count() > 1 {
                let read = pollster::block_on(read_sample(&state.device, &state.queue, texture, sample));
                return read.map(Captured::Texels).map_err(error_of);
            }
            let read = pollster::block_on(read_back(&state.device, &state.queue, texture));
            read.map(Captured::Texels).map_err(error_of)
        });
        let bytes = buffers.iter().zip(&planned.request.captures).map(|(buffer, capture)| {
            let bytes =
                pollster::block_on(read_buffer(&state.device, &state.queue, buffer)).map_err(error_of)?;
            Ok(match extent(&planned.of, capture).filter(|_| planned.request.is_stencil) {
                Some(extent) => Captured::Texels(bytes::stencil(&bytes, extent)),
                None => Captured::Bytes(bytes),
            })
        });
        texels.chain(bytes).collect()
    }
}

/// The name of the captured resource, without the pass after `@`.
fn resource_of(capture: &Capture) -> &str {
    capture.reference.split('@').next().unwrap_or_default()
}

/// Width and height in texels, and the number of layers, of the captured mip level. `None` if the resource has no size.
fn extent(plan: &Plan, capture: &Capture) -> Option<[u32; 3]> {
    let size = plan.resources.get(resource_of(capture))?.size?;
    let side = |side: u32| (side >> capture.mip.min(31)).max(1);
    Some([side(size.width), side(size.height), size.layers])
}

/// The size in bytes of a capture that is copied to a buffer, and the source of the copy as JSON for the document.
/// `None` for a texture captured without `is_stencil`.
fn buffer_copy(plan: &Plan, capture: &Capture, is_stencil: bool) -> Option<(u64, Value)> {
    if let Some(size) = size_of(plan, resource_of(capture)) {
        return Some((size, json!({ "name": "&captured" })));
    }
    let [width, height, layers] = extent(plan, capture).filter(|_| is_stencil)?;
    let size = u64::from(bytes::stencil_row(width)) * u64::from(height) * u64::from(layers);
    Some((size, json!({ "name": "&captured", "mip": capture.mip, "aspect": "stencil-only" })))
}

/// The part of a document that copies resources to imported buffers, and the names of the imports.
fn buffer_document(captures: &[Capture], copies: Vec<(u64, Value)>) -> (Value, Vec<String>) {
    let (mut subgraphs, mut passes, mut imports) = (Map::new(), Map::new(), Vec::new());
    for (at, (capture, (size, from))) in captures.iter().zip(copies).enumerate() {
        let name = format!("umbragraph_view_{at}");
        let copy = json!({ "from": from, "to": { "name": "&contents", "contents": "discard" } });
        let part = json!({
            "inputs": { "captured": "the resource that is captured" },
            "resources": { "contents": { "buffer": { "size": size, "lifetime": "imported" } } },
            "passes": { "copy": { "copy": copy } }
        });
        subgraphs.insert(name.clone(), part);
        let with = json!({ "captured": format!("&{}", capture.reference) });
        passes.insert(name.clone(), json!({ "use": name, "with": with }));
        imports.push(format!("{name}.contents"));
    }
    (json!({ "subgraphs": subgraphs, "passes": passes }), imports)
}

fn planned(library: &Library, pipeline: &Path, of: Arc<Plan>, request: Request) -> Result<Planned, Error> {
    let Request { captures, is_stencil, .. } = &request;
    let is_stencil = *is_stencil;
    let copies: Option<Vec<_>> = captures.iter().map(|one| buffer_copy(&of, one, is_stencil)).collect();
    let (mut text, imports) = match copies {
        Some(copies) => buffer_document(captures, copies),
        None => {
            let document = capture::document(&of, captures, Wanted::All)
                .map_err(|found| Error::new(found, &Sources::new()))?;
            (serde_json::from_str(&document.text).unwrap_or_default(), document.imports)
        }
    };
    text["format"] = json!(1);
    text["name"] = json!(of.name);
    let is_bundled = crate::arguments::is_bundled(pipeline);
    let (folder, base) = match (pipeline.parent(), pipeline.file_name()) {
        (Some(folder), Some(name)) if !is_bundled => (folder, Path::new(name)),
        _ => (Path::new(""), pipeline),
    };
    text["extends"] = json!(base.to_string_lossy());
    // A name that no file has: the text is laid over it while it is loaded.
    let name = folder.join("umbragraph-view.captures.json");
    let extended = library.load_text(&name.to_string_lossy(), &text.to_string())?;
    let [width, height] = of.viewport;
    let mut options = Options::new(width, height).data_sizes(of.data_sizes.clone()).copyable_state(true);
    for (name, parameter) in &of.pipeline.parameters {
        options = options.set(name, Fixed(&parameter.value));
    }
    for (name, feature) in &of.pipeline.features {
        options = options.feature(name, Fixed(&feature.value));
    }
    let plan = extended.plan(&options)?;
    Ok(Planned { of, request, plan, imports })
}
