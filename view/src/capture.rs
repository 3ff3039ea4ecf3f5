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
use serde_json::{Value, json};
use umbragraph::low_level::capture::{self, Capture};
use umbragraph::low_level::expression;
use umbragraph::low_level::source::Sources;
use umbragraph::{Error, Library, Options, Plan, Setting};

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
