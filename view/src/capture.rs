//! Contents of textures, copied out of a frame of the running pipeline.
//!
//! A capture is an ordinary copy behind the pass that is looked at, in a document that extends the pipeline
//! ([`umbragraph::low_level::capture`]). A thread plans it with the values that run; one frame is then recorded with that
//! plan, and the plan before goes on. Histories and live values are taken over both ways, as of any change of plans: the
//! captured frame is the next frame of what is shown.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use serde_json::{Value, json};
use umbragraph::executor::{Texels, imported_texture, read_back};
use umbragraph::low_level::capture::{self, Capture};
use umbragraph::low_level::expression;
use umbragraph::low_level::source::Sources;
use umbragraph::{Error, Frame, Library, Options, Plan, Setting, wgpu};

use crate::guard::guarded;
use crate::stage::{Shot, Stage, error_of};
use crate::targets::MORE;
use crate::values::to_json;

/// A plan that captures.
pub(crate) struct Planned {
    /// The plan that it was made beside.
    pub(crate) of: Arc<Plan>,
    pub(crate) captures: Vec<Capture>,
    pub(crate) plan: Arc<Plan>,
    /// The imports that the captures are copied to, in their order.
    pub(crate) imports: Vec<String>,
}

/// A plan that a thread makes.
pub(crate) struct Planning {
    of: Arc<Plan>,
    captures: Vec<Capture>,
    outcome: Receiver<Result<Planned, Error>>,
}

/// A value of a plan as an option.
struct Fixed<'a>(&'a expression::Value);

impl Setting for Fixed<'_> {
    fn value(&self) -> Value {
        to_json(self.0)
    }
}

impl Planning {
    /// Begins to plan captures of a pipeline that runs.
    pub(crate) fn begin(
        library: &Library,
        pipeline: &Path,
        of: &Arc<Plan>,
        captures: Vec<Capture>,
        context: &egui::Context,
    ) -> Self {
        let (done, outcome) = channel();
        let (library, pipeline, wake) = (library.clone(), pipeline.to_owned(), context.clone());
        let (plan, wanted) = (of.clone(), captures.clone());
        std::thread::spawn(move || {
            let planned = planned(&library, &pipeline, plan, wanted);
            // Nobody receives it once something else is looked at.
            let _ = done.send(planned);
            wake.request_repaint();
        });
        Self { of: of.clone(), captures, outcome }
    }

    /// Whether it is for these captures of a plan.
    pub(crate) fn is_for(&self, of: &Arc<Plan>, captures: &[Capture]) -> bool {
        Arc::ptr_eq(&self.of, of) && self.captures == captures
    }

    /// The plan, once it is there.
    pub(crate) fn take(&self) -> Option<Result<Planned, Error>> {
        self.outcome.try_recv().ok()
    }
}

impl Planned {
    /// Whether it is for these captures of a plan.
    pub(crate) fn is_for(&self, of: &Arc<Plan>, captures: &[Capture]) -> bool {
        Arc::ptr_eq(&self.of, of) && self.captures == captures
    }
}

impl Stage {
    /// Records the next frame with captures, and reads them.
    ///
    /// # Errors
    /// As of a record; textures that cannot be read.
    pub(crate) fn capture(
        &mut self,
        state: &RenderState,
        planned: &Planned,
        shot: &Shot<'_>,
    ) -> Result<Vec<Texels>, Error> {
        guarded(&state.device, "the captures", || self.captured(state, planned, shot)).map_err(error_of)?
    }

    fn captured(
        &mut self,
        state: &RenderState,
        planned: &Planned,
        shot: &Shot<'_>,
    ) -> Result<Vec<Texels>, Error> {
        let Some(input) = self.input(state, shot) else { return Ok(Vec::new()) };
        let (Some(executor), Some(shown)) = (self.renderer.executor(), &self.shown) else {
            return Ok(Vec::new());
        };
        executor.set_plan(planned.plan.clone())?;
        let texture = |name: &String| imported_texture(&state.device, &planned.plan, name, MORE);
        let contents: Vec<wgpu::Texture> = planned.imports.iter().filter_map(texture).collect();
        let captured = planned.imports.iter().map(String::as_str).zip(&contents);
        let imports: Vec<(&str, &wgpu::Texture)> =
            self.targets.imports().into_iter().chain(captured).collect();
        let toggles = self.values.toggles_of(&planned.plan);
        let frame = Frame::new(&input).draws(&shown.meshes).imports(&imports).toggles(&toggles);
        let mut encoder = state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let recorded = self.values.set_live(executor).and_then(|()| executor.record(&mut encoder, &frame));
        if recorded.is_ok() {
            state.queue.submit([encoder.finish()]);
            self.index += 1;
        }
        let running = executor.set_plan(planned.of.clone()).and_then(|()| self.values.set_live(executor));
        recorded.and(running)?;
        let read = |texture| pollster::block_on(read_back(&state.device, &state.queue, texture));
        let texels: Result<Vec<Texels>, _> = contents.iter().map(read).collect();
        texels.map_err(error_of)
    }
}

fn planned(
    library: &Library,
    pipeline: &Path,
    of: Arc<Plan>,
    captures: Vec<Capture>,
) -> Result<Planned, Error> {
    let document = capture::document(&of, &captures).map_err(|found| Error::new(found, &Sources::new()))?;
    let mut text: Value = serde_json::from_str(&document.text).unwrap_or_default();
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
    let mut options = Options::new(width, height).data_sizes(of.data_sizes.clone());
    for (name, parameter) in &of.pipeline.parameters {
        options = options.set(name, Fixed(&parameter.value));
    }
    for (name, feature) in &of.pipeline.features {
        options = options.feature(name, Fixed(&feature.value));
    }
    let plan = extended.plan(&options)?;
    Ok(Planned { of, captures, plan, imports: document.imports })
}
