//! The commands' session: what arguments ask of [`umbragraph::low_level::session`], and its diagnostics printed.

mod again;
mod causes;
mod report;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use umbragraph::DiskStorage;
use umbragraph::Plan;
#[cfg(feature = "gpu")]
use umbragraph::diagnostic::Place;
#[cfg(feature = "gpu")]
use umbragraph::diagnostic::Severity;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes};
#[cfg(feature = "gpu")]
use umbragraph::executor::DryRun;
#[cfg(feature = "gpu")]
use umbragraph::low_level::camera_path::{CameraArgument, CameraPath};
use umbragraph::low_level::compiler::PlanOptions;
#[cfg(feature = "gpu")]
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::compose::{normalize, unreadable};
use umbragraph::low_level::document::Document;
use umbragraph::low_level::pipeline::{self, FileKind, Overrides};
#[cfg(feature = "gpu")]
use umbragraph::low_level::session::Planned;
use umbragraph::low_level::session::{Choice, Judges, Loaded, Survey, Surveyed, Target, Template};
use umbragraph::low_level::shader::{TargetProfile, TemplateSet};
use umbragraph::low_level::source::{FileId, Sources, Span};
use umbragraph::low_level::{CheckOptions, CheckReport};
use umbragraph::node::Registry;
#[cfg(feature = "gpu")]
use umbragraph::scene::Scene;
use umbragraph::scene::interface;

use crate::arguments::{Choices, Files};
#[cfg(feature = "gpu")]
use crate::device::Graphics;
use again::own_templates;

/// The compiler session on the disk's files, and the diagnostics of one run of the command.
pub(crate) struct Session {
    session: umbragraph::low_level::session::Session,
    pub(crate) diagnostics: Diagnostics,
    /// The diagnostics about folders that are missing or cannot be read.
    #[cfg(feature = "lsp")]
    of_folders: Diagnostics,
    pub(crate) templates: Arc<TemplateSet>,
    /// The files in the folder of `--templates`; `None` if no folder is given.
    pub(crate) own_files: Option<BTreeSet<FileId>>,
    /// Additional folders below which scenes may name files.
    #[cfg(feature = "gpu")]
    roots: Vec<PathBuf>,
    /// The JSON text of a document that is composed into every pipeline after its extensions; `None` if there is none.
    pub(crate) included: Option<String>,
    /// The span of each `null` that deletes a value of an extended file, by the JSON pointer of the value.
    deleted: BTreeMap<String, Span>,
    /// The paths of the files of pipelines of which a part could not be read.
    cut: HashSet<PathBuf>,
}

/// A pipeline with the parameter values and the target profiles for its check.
struct Configured {
    target: Target,
    overrides: Overrides,
    profiles: Vec<TargetProfile>,
}

impl Session {
    /// Creates a session with the embedded templates, and those of the given folder.
    pub(crate) fn new(files: &Files) -> Self {
        Self::with_more(files, |_| Vec::new())
    }

    /// Creates a session with additional templates, which `more` makes from the known templates.
    pub(crate) fn with_more(files: &Files, more: impl FnOnce(&[Template]) -> Vec<Template>) -> Self {
        let roots = &files.root;
        let mut diagnostics = Diagnostics::new();
        let own = own_templates(files, &mut diagnostics);
        // The built-in node kinds, and glTF scenes as the host of the geometry that is theirs.
        let mut registry = umbragraph::registry();
        registry.host(interface::GEOMETRY, interface::any_scene());
        let has_own = own.is_some();
        let mut templates = umbragraph::with_templates(own.into_iter().flatten());
        templates.extend(more(&templates));
        let mut session = umbragraph::low_level::session::Session::new(DiskStorage, registry, templates);
        session.set_roots(roots);
        #[cfg(feature = "lsp")]
        let of_folders = diagnostics.clone();
        diagnostics.extend(session.template_diagnostics());
        let templates = session.templates();
        let own_files = has_own.then(|| session.own_templates());
        Self {
            session,
            diagnostics,
            #[cfg(feature = "lsp")]
            of_folders,
            templates,
            own_files,
            #[cfg(feature = "gpu")]
            roots: roots.clone(),
            included: None,
            deleted: BTreeMap::new(),
            cut: HashSet::new(),
        }
    }

    /// Returns the source texts that diagnostics refer to.
    pub(crate) fn sources(&self) -> &Sources {
        self.session.sources()
    }

    /// Returns `true` if a template lies in the folder of `--templates`.
    pub(crate) fn is_own_template(&self, name: &str) -> bool {
        let own = self.own_files.as_ref();
        own.zip(self.templates.file(name)).is_some_and(|(own, file)| own.contains(&file))
    }

    /// Returns the registry of node kinds.
    pub(crate) fn registry(&self) -> &Registry {
        self.session.registry()
    }

    /// Sets a text that replaces the content of a file in this session.
    pub(crate) fn overlay(&mut self, path: &str, text: &str) {
        self.session.overlay(path, text.as_bytes());
    }

    /// Returns `true` if the session has read the file.
    pub(crate) fn has_read(&self, name: &str) -> bool {
        self.session.has_read(Path::new(name))
    }

    /// Returns the path that an argument of `--camera` selects. Errors of its file have their place in the session's
    /// sources.
    ///
    /// # Errors
    /// A file that cannot be read, is no camera path, or has values that no camera can use.
    #[cfg(feature = "gpu")]
    pub(crate) fn camera(&mut self, argument: Option<&CameraArgument>) -> Result<CameraPath, Diagnostic> {
        let mut own = Sources::new();
        CameraPath::of_sources(argument, &mut own).map_err(|mut error| {
            if let Some((_, file)) = own.iter().last() {
                let whole = self.text_of(file.name(), file.text());
                let moved = |place: &mut Place| {
                    if let Place::Span(span) = place {
                        *place = whole.inside(span.range()).into();
                    }
                };
                moved(&mut error.place);
                error.related.iter_mut().for_each(|related| moved(&mut related.place));
                error.fix = None;
            }
            error
        })
    }

    /// Loads a scene and adds its warnings to the diagnostics.
    ///
    /// # Errors
    /// A scene that cannot be loaded.
    #[cfg(feature = "gpu")]
    pub(crate) fn scene(&mut self, path: &Path) -> Result<Scene, Diagnostics> {
        let scene = umbragraph::scene::load_below(path, self.roots(path))?;
        self.diagnostics.extend(scene.warnings.clone());
        Ok(scene)
    }

    /// Returns `Ok` if there is a plan and no error.
    ///
    /// # Errors
    /// An empty list, since the session already has the errors.
    #[cfg(feature = "gpu")]
    pub(crate) fn ensure_fine(&self, checked: &CheckReport) -> Result<(), Diagnostics> {
        let is_fine = checked.plan.is_some() && !self.diagnostics.has_errors();
        if is_fine { Ok(()) } else { Err(Diagnostics::new()) }
    }

    /// Adds text of the command line to the sources, and returns its span.
    pub(crate) fn on_command_line(&mut self, text: &str) -> Span {
        self.session.text("<command line>", text)
    }

    /// Adds the text of a file that the command has read itself to the sources, and returns its span.
    pub(crate) fn text_of(&mut self, name: &str, text: &str) -> Span {
        self.session.text(name, text)
    }

    /// Returns the folders from which a document may read files.
    #[cfg(feature = "gpu")]
    pub(crate) fn roots(&self, document: &Path) -> Roots {
        self.roots.iter().fold(Roots::of(document), |roots, folder| roots.and(folder))
    }

    /// Loads a pipeline with its files and extensions; `None` if the files are no valid JSON document.
    pub(crate) fn open(&mut self, path: &Path, extensions: &[PathBuf]) -> Option<Loaded> {
        let target = self.target(path, extensions);
        self.load(&target).filter(|loaded| loaded.document().is_some())
    }

    /// Reads all files of the pipelines into the session's sources. Errors are reported later, when a pipeline is
    /// loaded.
    pub(crate) fn read_all(&mut self, paths: &[PathBuf], extensions: &[PathBuf]) {
        for path in paths {
            // What cannot be read is said when the pipeline is loaded.
            let _ = self.session.load_exactly(&self.target(path, extensions));
        }
    }

    /// Checks a file that is no pipeline against the schema of its kind, and returns the kind. `None` for a pipeline,
    /// and for a file that cannot be read.
    pub(crate) fn check_part(&mut self, path: &Path) -> Option<FileKind> {
        let (kind, diagnostics) = self.session.check_part(path)?;
        self.diagnostics.extend(diagnostics);
        Some(kind)
    }

    /// Returns the inner session, which from then on reports missing or unreadable folders with every pipeline.
    #[cfg(feature = "lsp")]
    pub(crate) fn into_session(mut self) -> umbragraph::low_level::session::Session {
        self.session.report_always(self.of_folders);
        self.session
    }

    /// Parses a file as a JSON document, without composing it with other files.
    pub(crate) fn read(&mut self, path: &Path) -> Result<Document, Diagnostics> {
        self.session.document(path)
    }

    /// Parses a JSON file with figures, such as budgets. If the file is missing, similar file names are not suggested.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub(crate) fn read_figures(&mut self, path: &Path) -> Result<Document, Diagnostics> {
        match std::fs::metadata(path) {
            Ok(_) => self.read(path),
            Err(error) => Err(unreadable(&path.display().to_string(), &error).into()),
        }
    }

    fn target(&self, path: &Path, extensions: &[PathBuf]) -> Target {
        let target = Target::new(path).extensions(extensions.iter().cloned());
        match &self.included {
            Some(text) => target.include("captures", text),
            None => target,
        }
    }

    /// Loads a pipeline and adds the diagnostics of its files; `None` after an error.
    fn load(&mut self, target: &Target) -> Option<Loaded> {
        let loaded = self.session.load_exactly(target).ok()?;
        let found = self.session.diagnose(target).ok()?;
        let deleted = loaded.composed().map(|composed| composed.deleted.clone()).unwrap_or_default();
        self.deleted.extend(deleted);
        if found.has_errors() {
            self.cut.extend(loaded.paths().map(normalize));
        }
        self.diagnostics.extend(found);
        Some(loaded)
    }

    /// Plans a pipeline for the requested profile, or else for the first one that the pipeline claims.
    pub(crate) fn check(&mut self, path: &Path, choices: &Choices) -> CheckReport {
        let Some(Configured { target, overrides, profiles }) = self.configured(path, choices) else {
            return CheckReport::default();
        };
        profiles
            .into_iter()
            .next()
            .map(|first| self.plan(&target, overrides, first, choices))
            .unwrap_or_default()
    }

    /// Plans again with the target profile of a device, which may support less than the profile planned for. Returns
    /// `checked` unchanged if the profiles are equal.
    #[cfg(feature = "gpu")]
    pub(crate) fn check_on(
        &mut self,
        graphics: &Graphics,
        checked: CheckReport,
        path: &Path,
        choices: &Choices,
    ) -> CheckReport {
        let Some(pipeline) = &checked.pipeline else { return checked };
        let profile = graphics.profile(pipeline);
        if profile == pipeline.profile {
            return checked;
        }
        let Some(Configured { target, overrides, .. }) = self.configured(path, choices) else {
            return CheckReport::default();
        };
        let before = pipeline.clone();
        let checked = self.plan(&target, overrides, profile, choices);
        let after = checked.pipeline.iter().flat_map(|pipeline| &pipeline.features);
        for (name, feature) in after.filter(|(_, feature)| !feature.is_on()) {
            if before.features.get(name).is_some_and(pipeline::Feature::is_on) {
                let message = format!("\"{name}\" is off: {} lacks what it requires", graphics.name);
                let note = Diagnostic::warning(codes::FEATURE_UNAVAILABLE, feature.place, message);
                self.diagnostics.push(note.severity(Severity::Note));
            }
        }
        checked
    }

    /// Plans a pipeline, and also returns its loaded files and the values from preset, parameter files and command
    /// line. `None` after an error that prevents planning.
    pub(crate) fn trace(
        &mut self,
        path: &Path,
        choices: &Choices,
    ) -> Option<(Loaded, Overrides, CheckReport)> {
        let Configured { target, overrides, profiles } = self.configured(path, choices)?;
        let checked = match profiles.into_iter().next() {
            Some(first) => self.plan(&target, overrides.clone(), first, choices),
            None => CheckReport::default(),
        };
        Some((self.session.load(&target).ok()?, overrides, checked))
    }

    /// Plans a pipeline without settings for a profile. Its diagnostics are returned, not added to this session.
    #[cfg(feature = "gpu")]
    pub(crate) fn plan_aside(&mut self, target: &Target, profile: TargetProfile) -> Option<Planned> {
        let choice = Choice::new(profile, PlanOptions::new(1280, 720));
        self.session.plan(target, &choice).ok().map(|(planned, _)| planned)
    }

    fn plan(
        &mut self,
        target: &Target,
        overrides: Overrides,
        profile: TargetProfile,
        choices: &Choices,
    ) -> CheckReport {
        let choice = Choice::new(profile, Self::options(choices)).overrides(overrides);
        let Ok((planned, _)) = self.session.plan(target, &choice) else { return CheckReport::default() };
        self.add_new(planned.diagnostics);
        planned.report
    }

    /// Plans a pipeline in every configuration and compares it with the inputs that scenes provide. With `only_one`,
    /// only the given settings are planned. Target profiles are the requested one, or all that the pipeline claims.
    /// `None` after an error that prevents planning.
    pub(crate) fn check_all(
        &mut self,
        path: &Path,
        choices: &Choices,
        only_one: bool,
        verified: bool,
    ) -> Option<Surveyed> {
        let Configured { target, overrides, profiles } = self.configured(path, choices)?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let survey = Survey::new(profiles, Self::options(choices)).overrides(overrides);
        let survey = survey.only_one(only_one).verify(verified.then_some(verify)).threads(threads);
        let judges: Judges<'_> = &mut |profile| Box::new(dry_run(profile));
        let surveyed = self.session.check(&target, &survey, judges).ok()?.0?;
        self.add_new(surveyed.diagnostics.clone());
        Some(surveyed)
    }

    fn configured(&mut self, path: &Path, choices: &Choices) -> Option<Configured> {
        let asked: Vec<String> = choices.profile.iter().cloned().collect();
        let asked = self.profiles_named(&asked)?;
        let target = self.target(path, &choices.files.extension);
        let loaded = self.load(&target)?;
        let document = loaded.document()?;
        let overrides = self.overrides(&choices.settings, document);
        let profiles = profiles(document, asked);
        let max = profiles.first().map_or(u32::MAX, |profile| profile.limits.max_texture_dimension_2d);
        if choices.size.iter().any(|side| *side > max) {
            let [width, height] = choices.size;
            let text = format!("--size {width}x{height}");
            let place = self.on_command_line(&text).inside("--size ".len()..text.len());
            let message = format!("a picture of {width} by {height} is too large");
            self.diagnostics.push(
                Diagnostic::error(codes::SIZE_LIMIT, place, message)
                    .help(format!("textures have at most {max} texels in each direction")),
            );
            return None;
        }
        Some(Configured { target, overrides, profiles })
    }

    /// Adds diagnostics, except those that the session already has, for example from another profile.
    pub(crate) fn add_new(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        let known: HashSet<_> = self.diagnostics.iter().map(Diagnostic::key).collect();
        self.diagnostics.extend(diagnostics.into_iter().filter(|new| !known.contains(&new.key())));
    }

    /// Returns the options of a check: registry, templates, target profile, parameter values and plan options.
    pub(crate) fn check_options<'a>(
        &'a self,
        profile: &'a TargetProfile,
        overrides: &'a Overrides,
        plan: &'a PlanOptions,
    ) -> CheckOptions<'a> {
        CheckOptions { registry: self.registry(), templates: &self.templates, profile, overrides, plan }
    }

    /// Returns the plan options of the command line: the size of the picture and the objective of the pass order.
    pub(crate) fn options(choices: &Choices) -> PlanOptions {
        PlanOptions::new(choices.size[0], choices.size[1]).objective(choices.objective)
    }

    /// Returns the profiles that the command line names; `None` after adding a diagnostic for each unknown name.
    pub(crate) fn profiles_named(&mut self, names: &[String]) -> Option<Vec<TargetProfile>> {
        let mut profiles = Vec::new();
        let mut fine = true;
        for name in names {
            match pipeline::profile_named(name, self.on_command_line(name)) {
                Ok(profile) if profiles.contains(&profile) => {}
                Ok(profile) => profiles.push(profile),
                Err(diagnostic) => {
                    self.diagnostics.push(diagnostic);
                    fine = false;
                }
            }
        }
        fine.then_some(profiles)
    }
}

/// Returns the requested profiles, or else those that a document claims. Unknown claims are reported when the document
/// is loaded.
pub(crate) fn profiles(document: &Document, asked: Vec<TargetProfile>) -> Vec<TargetProfile> {
    if asked.is_empty() { pipeline::claimed_profiles(document, &mut Diagnostics::new()) } else { asked }
}

/// Returns a function that validates a plan with wgpu on a device with a profile's limits and features.
#[cfg(feature = "gpu")]
pub(crate) fn dry_run(profile: &TargetProfile) -> impl FnMut(&Arc<Plan>) -> Diagnostics + use<> {
    let mut dry_run = pollster::block_on(DryRun::new(profile));
    move |plan| match &mut dry_run {
        Ok(dry_run) => pollster::block_on(dry_run.run(plan)),
        Err(diagnostic) => diagnostic.clone().into(),
    }
}

/// Returns a function that accepts every plan, for a build without wgpu.
#[cfg(not(feature = "gpu"))]
pub(crate) fn dry_run(_: &TargetProfile) -> impl FnMut(&Arc<Plan>) -> Diagnostics + use<> {
    |_| Diagnostics::new()
}

/// Describes the violations that a second, independent algorithm finds in a plan.
fn verify(plan: &Plan, options: &PlanOptions) -> Vec<String> {
    umbragraph_verify::verify(plan, options).iter().map(ToString::to_string).collect()
}
