//! [`Project`]: the files of a page, and the answers to what it asks of a pipeline.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::{Value, json};
use umbragraph::Bundled;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Files as _, Memory, Roots};
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::pipeline::{Overrides, ParameterFile, claimed_profiles, of_preset};
use umbragraph::low_level::report::Report;
use umbragraph::low_level::session::{
    Choice, Planned, Session, Storage, Survey, Target, Template, TemplateText,
};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::low_level::starter;
use umbragraph::scene::interface;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::settings;

/// The files of a web page, and a session that checks and plans pipelines from these files.
#[wasm_bindgen]
pub struct Project {
    files: Pages,
    templates: Vec<String>,
    pub(crate) session: Session,
}

/// The files of a web page, held in memory, together with the bundled pipelines.
#[derive(Clone, Default)]
pub(crate) struct Pages(Arc<Mutex<Memory>>);

impl Pages {
    pub(crate) fn write(&self, path: &str, text: &str) {
        let mut memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        memory.0.insert(path.to_owned(), text.to_owned());
    }

    /// The paths of the shader templates and their axis declarations, sorted.
    #[cfg(not(feature = "gpu"))]
    pub(crate) fn templates(&self) -> Vec<String> {
        let memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut paths: Vec<String> = memory.0.keys().filter(|path| is_template(path)).cloned().collect();
        paths.sort();
        paths
    }
}

fn is_template(path: &str) -> bool {
    umbragraph::low_level::shader::TEMPLATE_ENDS.iter().any(|end| path.ends_with(end))
}

impl Storage for Pages {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let mut memory = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut bundled = Bundled(std::mem::take(&mut *memory));
        let read = bundled.read(path, sources);
        *memory = bundled.0;
        read
    }

    fn has_scheme(&self, scheme: &str) -> bool {
        Bundled(Memory::default()).has_scheme(scheme)
    }
}

/// Creates a session that reads from `files`. `templates` lists the paths of shader templates; a path without its
/// leading `/` is the template's name.
pub(crate) fn session(files: &Pages, templates: &[String]) -> Session {
    // Glass and bones of glTF scenes are what a page draws.
    let mut registry = umbragraph::registry();
    registry.host(interface::GEOMETRY, interface::any_scene());
    let own = templates.iter().map(|path| Template {
        name: path.trim_start_matches('/').to_owned(),
        text: TemplateText::File { path: path.into(), roots: Roots::default() },
    });
    Session::new(files.clone(), registry, umbragraph::with_templates(own))
}

/// Iterates over the bundled shader templates and axis declarations: name and source.
pub(crate) fn library() -> impl Iterator<Item = (String, &'static str)> {
    umbragraph::with_templates([]).into_iter().filter_map(|template| match template.text {
        TemplateText::Library { text, .. } => Some((template.name, text)),
        _ => None,
    })
}

impl Default for Project {
    fn default() -> Self {
        Self::new()
    }
}

#[wasm_bindgen]
impl Project {
    /// Creates a project that contains only the bundled files.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        let files = Pages::default();
        let session = session(&files, &[]);
        Self { files, templates: Vec::new(), session }
    }

    /// Returns the bundled shader templates and axis declarations as a JSON object, from name to source.
    pub fn templates() -> String {
        Value::Object(library().map(|(name, text)| (name, Value::from(text))).collect()).to_string()
    }

    /// Returns the files of a new pipeline as a JSON object, from path to content: the files that
    /// `umbragraph new NAME --kind KIND` writes.
    ///
    /// # Errors
    /// A message if the kind does not exist, or if the name is invalid for a pipeline.
    pub fn begin(name: &str, kind: &str) -> Result<String, String> {
        let kind = starter::Kind::of(kind).ok_or_else(|| format!("there is no kind \"{kind}\""))?;
        let files = starter::files(kind, name);
        let files = files.map_err(|wrong| render::human_all([&wrong], &Sources::new()))?;
        let files = files.into_iter().map(|(path, text)| (path, Value::from(text)));
        Ok(Value::Object(files.collect()).to_string())
    }

    /// Writes a file of the page. A file whose name ends like that of a shader template becomes one, and replaces the
    /// bundled template of the same name.
    pub fn write(&mut self, path: &str, text: &str) {
        self.files.write(path, text);
        if is_template(path) && !self.templates.iter().any(|known| known == path) {
            self.templates.push(path.to_owned());
            self.session = session(&self.files, &self.templates);
        } else {
            self.session.changed(path);
        }
    }

    /// Checks all configurations of the pipeline at `path` for each target profile that it claims, and validates its
    /// shaders. `width` and `height` are the size of a frame in texels.
    ///
    /// Returns a JSON object: `diagnostics` in the format of `umbragraph check --format json`, and `text` with the same
    /// diagnostics as readable text.
    pub fn check(&mut self, path: &str, width: u32, height: u32) -> String {
        let target = Target::new(path);
        let profiles = self.profiles(&target);
        let survey = Survey::new(profiles, PlanOptions::new(width, height));
        let found = self.session.check(&target, &survey, &mut |_| Box::new(|_| Diagnostics::new()));
        self.answer(found.map(|(_, diagnostics)| diagnostics).unwrap_or_default(), Value::Null)
    }

    /// Plans the pipeline at `path`. `values` is the JSON of a parameter file, or empty for the defaults. `width` and
    /// `height` are the size of a frame in texels.
    ///
    /// Returns a JSON object: `diagnostics` and `text` as in [`check`](Self::check), and `plan`. `plan` holds a
    /// `report` on the plan, the `settings` of the pipeline and the names of its `presets`; it is `null` if planning
    /// fails.
    pub fn plan(&mut self, path: &str, values: &str, width: u32, height: u32) -> String {
        let (planned, diagnostics) = self.planned(path, values, None, PlanOptions::new(width, height));
        let plan = planned.as_ref().and_then(|planned| {
            let settings = settings::of_pipeline(planned.report.pipeline.as_deref()?);
            Some((self.report(planned)?, settings, self.presets(path)))
        });
        let plan = plan.map(|(report, settings, presets)| {
            json!({ "report": report, "settings": settings, "presets": presets })
        });
        self.answer(diagnostics, plan.unwrap_or_default())
    }
}

impl Project {
    /// Plans a pipeline for `profile`, or if that is `None` for the first profile that the pipeline claims. Returns the
    /// result, which is `None` if planning was cancelled, and all diagnostics.
    pub(crate) fn planned(
        &mut self,
        path: &str,
        values: &str,
        profile: Option<TargetProfile>,
        options: PlanOptions,
    ) -> (Option<Planned>, Diagnostics) {
        let mut diagnostics = Diagnostics::new();
        let (target, choice) = self.choice((path, values), profile, options, &mut diagnostics);
        let planned = self.session.plan(&target, &choice).map(|(planned, found)| {
            diagnostics.extend(found);
            planned
        });
        diagnostics.sort();
        (planned.ok(), diagnostics)
    }

    /// Returns the pipeline at `path`, and the configuration that the JSON of a parameter file (`values`, may be empty)
    /// selects. Errors in the file are added to `diagnostics`.
    pub(crate) fn choice(
        &mut self,
        (path, values): (&str, &str),
        profile: Option<TargetProfile>,
        options: PlanOptions,
        diagnostics: &mut Diagnostics,
    ) -> (Target, Choice) {
        let target = Target::new(path);
        let profile = profile.or_else(|| self.profiles(&target).into_iter().next());
        let mut choice = Choice::new(profile.unwrap_or_else(TargetProfile::webgpu), options);
        if !values.is_empty() {
            let file = self.session.text("values.json", values).file;
            match document::parse(self.session.sources(), file).valid() {
                Ok(values) => choice = choice.overrides(self.overrides(&target, &values, diagnostics)),
                Err(found) => diagnostics.extend(found),
            }
        }
        (target, choice)
    }

    /// The source files to which the places of diagnostics refer.
    pub(crate) fn sources(&self) -> &Sources {
        self.session.sources()
    }

    /// Returns a JSON object with the diagnostics as JSON (`diagnostics`) and as readable text (`text`), and with
    /// `plan`.
    pub(crate) fn answer(&self, diagnostics: Diagnostics, plan: Value) -> String {
        let sources = self.sources();
        let all: Vec<Value> = diagnostics.iter().map(|one| render::json(one, sources)).collect();
        let text = render::human_all(&diagnostics, sources);
        json!({ "diagnostics": all, "text": text, "plan": plan }).to_string()
    }

    fn document(&mut self, target: &Target) -> Option<Document> {
        self.session.load_exactly(target).ok()?.document().cloned()
    }

    /// Returns the target profiles that a pipeline claims to support; empty if it cannot be read.
    fn profiles(&mut self, target: &Target) -> Vec<TargetProfile> {
        let document = self.document(target);
        document.map(|document| claimed_profiles(&document, &mut Diagnostics::new())).unwrap_or_default()
    }

    fn presets(&mut self, path: &str) -> Vec<String> {
        let Some(document) = self.document(&Target::new(path)) else { return Vec::new() };
        document.root.entries_of("presets").iter().map(|preset| preset.key.clone()).collect()
    }

    fn overrides(&mut self, target: &Target, values: &Document, diagnostics: &mut Diagnostics) -> Overrides {
        let file = ParameterFile::read(values, diagnostics);
        match (file.preset, self.document(target)) {
            (Some((name, place)), Some(document)) => {
                of_preset(&document, &name, place, diagnostics).under(file.overrides)
            }
            _ => file.overrides,
        }
    }

    /// The content of a file of the page; `None` if the file does not exist.
    pub(crate) fn text(&self, path: &str) -> Option<String> {
        let memory = self.files.0.lock().unwrap_or_else(PoisonError::into_inner);
        memory.0.get(path).cloned()
    }

    /// The paths of all JSON files of the page.
    pub(crate) fn paths(&self) -> Vec<String> {
        let memory = self.files.0.lock().unwrap_or_else(PoisonError::into_inner);
        memory.0.keys().filter(|path| path.ends_with(".json")).cloned().collect()
    }

    pub(crate) fn report(&self, planned: &Planned) -> Option<Report> {
        let (plan, graph) = (planned.report.plan.as_deref()?, planned.report.graph.as_deref()?);
        Some(Report::new(plan, graph, self.sources()))
    }
}
