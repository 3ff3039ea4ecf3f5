//! What the commands share: sources, diagnostics, templates, and a pipeline with its choices.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use umbragraph::compiler::{Plan, PlanOptions};
use umbragraph::compose::{Composed, Disk, Files as _, Named, Roots};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, render};
use umbragraph::document::{self, Document};
#[cfg(feature = "gpu")]
use umbragraph::executor::DryRun;
use umbragraph::node::Registry;
use umbragraph::pipeline::{self, Configurations, FileKind, Overrides};
#[cfg(feature = "gpu")]
use umbragraph::scene::Scene;
use umbragraph::scene::interface;
use umbragraph::shader::permutations::{self, Count, Request};
use umbragraph::shader::{AxisValues, TEMPLATE_ENDS, TargetProfile, TemplateSet};
use umbragraph::source::{FileId, Sources, Span};
use umbragraph::{Bundled, CheckOptions, CheckReport, Coverage, compose};

use crate::arguments::{Choices, DiagnosticsFormat, Files};
#[cfg(feature = "gpu")]
use crate::device::Graphics;
use crate::parts;
use crate::streams::{complain, print, print_json};

/// Sources, diagnostics and templates of one run of the command.
pub(crate) struct Session {
    pub(crate) sources: Sources,
    pub(crate) diagnostics: Diagnostics,
    pub(crate) templates: Arc<TemplateSet>,
    /// The files of the folder of templates, where one is given.
    pub(crate) own_files: Option<BTreeSet<FileId>>,
    /// The built-in node kinds, and glTF scenes as the host of the geometry that is theirs.
    pub(crate) registry: Registry,
    /// Texts that stand for those of files, by the names of these.
    pub(crate) texts: BTreeMap<String, String>,
    /// The files that were read.
    pub(crate) files: BTreeSet<String>,
    /// Folders below which documents may name files, beside the working folder and their own.
    pub(crate) roots: Vec<PathBuf>,
    /// A document that every pipeline includes after its extensions.
    pub(crate) included: Option<String>,
}

/// The file system, but for the texts that stand for files.
struct Overlaid<'s> {
    texts: &'s BTreeMap<String, String>,
    files: &'s mut BTreeSet<String>,
    /// What documents may read; everything where the command line names the file.
    disk: Option<Disk>,
}

impl compose::Files for Overlaid<'_> {
    fn has_scheme(&self, scheme: &str) -> bool {
        Bundled(Named).has_scheme(scheme)
    }

    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.display().to_string();
        let file = match self.texts.get(&name) {
            Some(text) => sources.add(name.as_str(), text.as_str()),
            None => match self.disk.clone() {
                Some(disk) => Bundled(disk).read(path, sources)?,
                None => Bundled(Named).read(path, sources)?,
            },
        };
        self.files.insert(name);
        Ok(file)
    }
}

/// A pipeline with the values and the profiles that it is checked with.
struct Configured {
    composed: Composed,
    overrides: Overrides,
    profiles: Vec<TargetProfile>,
}

/// The results of checking the configurations of a pipeline.
pub(crate) struct Covered {
    pub(crate) coverage: Coverage,
    pub(crate) configurations: Configurations,
    /// The names of the profiles.
    pub(crate) profiles: Vec<String>,
    /// How many configurations differ in their shaders or passes, with all values of parameters; `None` where one was
    /// asked for.
    pub(crate) reachable: Option<Count>,
}

impl Session {
    /// A session with the embedded templates, and those of a folder.
    pub(crate) fn new(files: &Files) -> Self {
        let roots = &files.root;
        let mut sources = Sources::new();
        let mut diagnostics = Diagnostics::new();
        diagnostics.extend(roots.iter().filter(|root| !root.is_dir()).map(|root| {
            let name = root.display().to_string();
            let message = format!("there is no folder \"{name}\"");
            Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help("--root names a folder")
        }));
        let mut own_files = None;
        let templates = match &files.templates {
            None => umbragraph::templates(&mut sources, &mut diagnostics),
            Some(folder) => {
                let files = compose::files_below(folder, &TEMPLATE_ENDS);
                let files = files.unwrap_or_else(|diagnostic| {
                    diagnostics.push(diagnostic);
                    Vec::new()
                });
                let mut disk = Disk(with_roots(Roots::below(folder), roots));
                let templates = umbragraph::templates_with(&files, &mut disk, &mut sources, &mut diagnostics);
                let file = |name: &String| match name.strip_suffix(".axes.json") {
                    Some(stem) => templates.axes_file(stem),
                    None => templates.file(name),
                };
                own_files = Some(files.iter().filter_map(|(name, _)| file(name)).collect());
                templates
            }
        };
        let mut registry = umbragraph::registry();
        registry.host(interface::GEOMETRY, interface::any_scene());
        Self {
            sources,
            diagnostics,
            templates,
            own_files,
            registry,
            texts: BTreeMap::new(),
            files: BTreeSet::new(),
            roots: roots.clone(),
            included: None,
        }
    }

    /// Loads a scene, and keeps what is to be said of it.
    ///
    /// # Errors
    /// No scene.
    #[cfg(feature = "gpu")]
    pub(crate) fn scene(&mut self, path: &Path) -> Result<Scene, Diagnostics> {
        let scene = umbragraph::scene::load_below(path, self.roots(path))?;
        self.diagnostics.extend(scene.warnings.clone());
        Ok(scene)
    }

    /// Goes on where there is a plan, and nothing wrong.
    ///
    /// # Errors
    /// No further ones than the session has.
    #[cfg(feature = "gpu")]
    pub(crate) fn ensure_fine(&self, checked: &CheckReport) -> Result<(), Diagnostics> {
        let is_fine = checked.plan.is_some() && !self.diagnostics.has_errors();
        if is_fine { Ok(()) } else { Err(Diagnostics::new()) }
    }

    /// The place of a text that is on the command line.
    pub(crate) fn on_command_line(&mut self, text: &str) -> Span {
        let file = self.sources.add("<command line>", text);
        Span::new(file, 0..text.len())
    }

    /// What a document may read.
    pub(crate) fn roots(&self, document: &Path) -> Roots {
        with_roots(Roots::of(document), &self.roots)
    }

    /// The document of a pipeline, composed of its files, with the passes of extensions put in.
    pub(crate) fn open(&mut self, path: &Path, extensions: &[PathBuf]) -> Option<Document> {
        Some(self.compose(path, extensions)?.document)
    }

    /// A file that is no pipeline, as it is written, and its kind; `None` for a pipeline and for what cannot be read.
    pub(crate) fn part(&mut self, path: &Path) -> Option<(Document, FileKind)> {
        let document = self.read(path).ok()?;
        let kind = parts::kind_of(&document)?;
        Some((document, kind))
    }

    /// A document as it is written.
    pub(crate) fn read(&mut self, path: &Path) -> Result<Document, Diagnostics> {
        let mut files = Overlaid { texts: &self.texts, files: &mut self.files, disk: None };
        let file = files.read(path, &mut self.sources)?;
        document::parse(&self.sources, file).valid()
    }

    /// The document of a pipeline, with what its files replaced of one another.
    fn compose(&mut self, path: &Path, extensions: &[PathBuf]) -> Option<Composed> {
        let mut composed = self.composed(path)?;
        for extension in extensions {
            let extension = self.composed(extension)?;
            composed.insert(extension, &mut self.diagnostics);
        }
        if let Some(text) = &self.included {
            let file = self.sources.add("captures", text.as_str());
            let mut files = compose::Memory::default();
            let (sources, diagnostics) = (&mut self.sources, &mut self.diagnostics);
            composed.include(
                compose::compose(file, Path::new("captures"), &mut files, sources, diagnostics)?,
                diagnostics,
            );
        }
        Some(composed)
    }

    fn composed(&mut self, path: &Path) -> Option<Composed> {
        let disk = Disk(self.roots(path));
        let mut files = Overlaid { texts: &self.texts, files: &mut self.files, disk: None };
        match files.read(path, &mut self.sources) {
            Ok(file) => {
                files.disk = Some(disk);
                compose::compose(file, path, &mut files, &mut self.sources, &mut self.diagnostics)
            }
            Err(diagnostic) => {
                self.diagnostics.push(diagnostic);
                None
            }
        }
    }

    /// Takes a pipeline all the way to a plan, for the profile asked for or the first that it claims.
    pub(crate) fn check(&mut self, path: &Path, choices: &Choices) -> CheckReport {
        self.configured(path, choices)
            .map(|configured| self.check_one(&configured, choices))
            .unwrap_or_default()
    }

    /// The same on a device, which may have less than the profile; what was checked is left as it is where that fits.
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
        let Some(configured) = self.configured(path, choices) else { return CheckReport::default() };
        self.check_one(&Configured { profiles: vec![profile], ..configured }, choices)
    }

    /// The same, with everything that is known of where its values come from.
    pub(crate) fn trace(
        &mut self,
        path: &Path,
        choices: &Choices,
    ) -> Option<(Composed, Overrides, CheckReport)> {
        let configured = self.configured(path, choices)?;
        let checked = self.check_one(&configured, choices);
        Some((configured.composed, configured.overrides, checked))
    }

    fn check_one(&mut self, configured: &Configured, choices: &Choices) -> CheckReport {
        let Some(profile) = configured.profiles.first() else { return CheckReport::default() };
        let plan = Self::options(choices);
        let options = self.check_options(profile, &configured.overrides, &plan);
        let mut diagnostics = Diagnostics::new();
        let checked = umbragraph::check_document(
            &configured.composed.document,
            &options,
            &self.sources,
            &mut diagnostics,
        );
        self.add_new(diagnostics);
        checked
    }

    /// Takes a pipeline all the way to a plan in every configuration (or, with `only_one`, in the one of the settings),
    /// for the profile asked for or each that it claims, and compares it with what scenes provide.
    pub(crate) fn check_all(
        &mut self,
        path: &Path,
        choices: &Choices,
        only_one: bool,
        verified: bool,
    ) -> Option<Covered> {
        let Configured { composed, overrides, profiles } = self.configured(path, choices)?;
        let mut widest = Configurations::default();
        let mut first: Option<Coverage> = None;
        for profile in &profiles {
            let configurations = if only_one {
                Configurations::one(&overrides)
            } else {
                Configurations::of_features(&composed.document, &overrides, profile)
            };
            let plan = Self::options(choices);
            let options = self.check_options(profile, &overrides, &plan);
            let mut diagnostics = Diagnostics::new();
            let mut coverage = umbragraph::check_configurations(
                &composed.document,
                &options,
                (&configurations, verified.then_some(&verify), &mut dry_run(profile)),
                &self.sources,
                &mut diagnostics,
            );
            self.add_new(diagnostics);
            match &mut first {
                Some(first) => {
                    first.variants.append(&mut coverage.variants);
                    coverage.violations.retain(|violation| !first.violations.contains(violation));
                    first.violations.append(&mut coverage.violations);
                }
                None => first = Some(coverage),
            }
            // Profiles that lack what features require have fewer.
            if configurations.list.len() > widest.list.len() {
                widest = configurations;
            }
        }
        let coverage = first?;
        self.prove_for(&coverage.variants, &profiles);
        let reachable = profiles
            .first()
            .filter(|_| !only_one)
            .map(|profile| Configurations::all(&composed.document, &self.templates, profile).number);
        let profiles = profiles.into_iter().map(|profile| profile.name).collect();
        Some(Covered { coverage, configurations: widest, profiles, reachable })
    }

    fn configured(&mut self, path: &Path, choices: &Choices) -> Option<Configured> {
        let asked: Vec<String> = choices.profile.iter().cloned().collect();
        let asked = self.profiles_named(&asked)?;
        let composed = self.compose(path, &choices.files.extension)?;
        let overrides = self.overrides(&choices.settings, &composed.document);
        let profiles = profiles(&composed.document, asked);
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
        Some(Configured { composed, overrides, profiles })
    }

    /// Adds diagnostics; what holds for several profiles is said once.
    fn add_new(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        let known: HashSet<_> = self.diagnostics.iter().map(Diagnostic::key).collect();
        self.diagnostics.extend(diagnostics.into_iter().filter(|new| !known.contains(&new.key())));
    }

    /// Holds shader variants to the limits of each profile, and to the writers of its language.
    fn prove_for(&mut self, variants: &BTreeSet<(String, AxisValues)>, profiles: &[TargetProfile]) {
        let requests: Vec<Request> = variants
            .iter()
            .map(|(template, axes)| Request::one(&self.templates, template, axes, profiles))
            .collect();
        let proven = permutations::check(&self.templates, &requests, &permutations::Options::default());
        self.add_new(proven.diagnostics);
    }

    /// The options of a check.
    pub(crate) fn check_options<'a>(
        &'a self,
        profile: &'a TargetProfile,
        overrides: &'a Overrides,
        plan: &'a PlanOptions,
    ) -> CheckOptions<'a> {
        CheckOptions { registry: &self.registry, templates: &self.templates, profile, overrides, plan }
    }

    /// What the choices say of the plan.
    pub(crate) fn options(choices: &Choices) -> PlanOptions {
        PlanOptions::new(choices.size[0], choices.size[1]).objective(choices.objective)
    }

    /// Puts the diagnostics in the order in which they are shown, each once.
    pub(crate) fn arrange(&mut self) {
        self.diagnostics.sort();
        self.diagnostics.merge();
    }

    /// Prints the diagnostics to standard error; whether there was no error among them.
    pub(crate) fn report(&mut self) -> bool {
        self.arrange();
        self.complain()
    }

    fn complain(&self) -> bool {
        complain(&render::human_all(&self.diagnostics, &self.sources));
        !self.diagnostics.has_errors()
    }

    /// Prints the diagnostics in a form, with what a command has found besides: as a text for people, and as JSON to be
    /// made of the diagnostics. Whether there was no error among them.
    pub(crate) fn report_as(
        &mut self,
        format: DiagnosticsFormat,
        text: impl FnOnce() -> String,
        json: impl FnOnce(Vec<serde_json::Value>) -> String,
    ) -> bool {
        self.arrange();
        let Self { diagnostics, sources, .. } = &*self;
        match format {
            DiagnosticsFormat::Human => {
                print(&text());
                return self.complain();
            }
            DiagnosticsFormat::Json => {
                let diagnostics = diagnostics.iter().map(|diagnostic| render::json(diagnostic, sources));
                print_json(&(json(diagnostics.collect()) + "\n"));
            }
            DiagnosticsFormat::Sarif => print_json(&format!("{:#}\n", render::sarif(diagnostics, sources))),
            DiagnosticsFormat::Github => {
                let lines: String =
                    diagnostics.iter().map(|diagnostic| render::github(diagnostic, sources)).collect();
                print(&(lines + &text()));
            }
        }
        !diagnostics.has_errors()
    }

    /// Prints a diagnostic to standard error; `false`.
    pub(crate) fn fail(&self, diagnostic: Diagnostic) -> bool {
        complain(&render::human_all([&diagnostic], &self.sources));
        false
    }

    /// The profiles of names on the command line; `None` with a diagnostic for each name that no profile has.
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

fn with_roots(roots: Roots, further: &[PathBuf]) -> Roots {
    further.iter().fold(roots, |roots, folder| roots.and(folder))
}

/// The profiles asked for, or else those that a document claims; unknown claims are diagnostics of its load.
pub(crate) fn profiles(document: &Document, asked: Vec<TargetProfile>) -> Vec<TargetProfile> {
    if asked.is_empty() { pipeline::claimed_profiles(document, &mut Diagnostics::new()) } else { asked }
}

/// What wgpu says of a plan on a device with a profile's limits and features.
#[cfg(feature = "gpu")]
pub(crate) fn dry_run(profile: &TargetProfile) -> impl FnMut(&Arc<Plan>) -> Diagnostics + use<> {
    let mut dry_run = pollster::block_on(DryRun::new(profile));
    move |plan| match &mut dry_run {
        Ok(dry_run) => pollster::block_on(dry_run.run(plan)),
        Err(diagnostic) => diagnostic.clone().into(),
    }
}

/// Nothing, without wgpu.
#[cfg(not(feature = "gpu"))]
pub(crate) fn dry_run(_: &TargetProfile) -> impl FnMut(&Arc<Plan>) -> Diagnostics + use<> {
    |_| Diagnostics::new()
}

/// The violations that a second algorithm finds in a plan, in words.
fn verify(plan: &umbragraph::compiler::Plan, options: &PlanOptions) -> Vec<String> {
    umbragraph_verify::verify(plan, options).iter().map(ToString::to_string).collect()
}
