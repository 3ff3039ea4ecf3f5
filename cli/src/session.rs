//! What the commands share: sources, diagnostics, templates, and a pipeline with its choices.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use umbragraph::compiler::{Plan, PlanOptions};
use umbragraph::compose::{Composed, Disk, Files as _, Named, Roots};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, render};
use umbragraph::document::{self, Document, Value};
#[cfg(feature = "gpu")]
use umbragraph::executor::DryRun;
use umbragraph::node::Registry;
use umbragraph::pipeline::{self, Configurations, FileKind, Overrides, ParameterFile, Setting};
#[cfg(feature = "gpu")]
use umbragraph::scene::Scene;
use umbragraph::scene::interface;
use umbragraph::shader::permutations::{self, Count, Request};
use umbragraph::shader::{AxisValues, TEMPLATE_ENDS, TargetProfile, TemplateSet};
use umbragraph::source::{FileId, Sources, Span};
use umbragraph::{Bundled, CheckOptions, CheckReport, Coverage, compose};

use crate::arguments::{Choices, Settings};
#[cfg(feature = "gpu")]
use crate::device::Graphics;
use crate::parts;
use crate::streams::complain;

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
    pub(crate) fn new(folder: Option<&Path>, roots: &[PathBuf]) -> Self {
        let mut sources = Sources::new();
        let mut diagnostics = Diagnostics::new();
        diagnostics.extend(roots.iter().filter(|root| !root.is_dir()).map(|root| {
            let name = root.display().to_string();
            let message = format!("there is no folder \"{name}\"");
            Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help("--root names a folder")
        }));
        let mut own_files = None;
        let templates = match folder {
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
            roots: roots.to_vec(),
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

    /// Whether there is a plan, and nothing wrong.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_fine(&self, checked: &CheckReport) -> bool {
        checked.plan.is_some() && !self.diagnostics.has_errors()
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
        let mut files = Overlaid { texts: &self.texts, files: &mut self.files, disk: None };
        let file = files.read(path, &mut self.sources).ok()?;
        let document = document::parse(&self.sources, file).ok()?;
        let kind = parts::kind_of(&document)?;
        Some((document, kind))
    }

    /// The same, with what its files replaced of one another.
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
        let options = CheckOptions {
            registry: &self.registry,
            templates: &self.templates,
            profile,
            overrides: &configured.overrides,
            plan: &Self::options(choices),
        };
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
            let options = CheckOptions {
                registry: &self.registry,
                templates: &self.templates,
                profile,
                overrides: &overrides,
                plan: &Self::options(choices),
            };
            let mut diagnostics = Diagnostics::new();
            let mut coverage = umbragraph::check_configurations(
                &composed.document,
                &options,
                (&configurations, verified, &mut dry_run(profile)),
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
        let composed = self.compose(path, &choices.extension)?;
        let overrides = self.overrides(&choices.settings, &composed.document);
        let profiles = profiles(&composed.document, asked);
        let max = profiles.first().map_or(u32::MAX, |profile| profile.limits.max_texture_dimension_2d);
        if choices.size.iter().any(|side| *side > max) {
            let text = format!("--size {}x{}", choices.size[0], choices.size[1]);
            let at = self.sources.add("<command line>", text.as_str());
            let message = format!("a picture of {} by {} is too large", choices.size[0], choices.size[1]);
            let place = Span::new(at, "--size ".len()..text.len());
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
        let key =
            |diagnostic: &Diagnostic| (diagnostic.code, diagnostic.place.clone(), diagnostic.message.clone());
        let known: HashSet<_> = self.diagnostics.iter().map(key).collect();
        self.diagnostics.extend(diagnostics.into_iter().filter(|new| !known.contains(&key(new))));
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
        complain(&render::human_all(&self.diagnostics, &self.sources));
        !self.diagnostics.has_errors()
    }

    /// What the preset, the parameter files and the command line give values to, the last over the first.
    pub(crate) fn overrides(&mut self, settings: &Settings, document: &Document) -> Overrides {
        let files: Vec<ParameterFile> =
            settings.params.iter().filter_map(|path| self.parameter_file(path)).collect();
        let preset = match &settings.preset {
            Some(name) => {
                let at = self.sources.add("<command line>", name.as_str());
                Some((name.clone(), Span::new(at, 0..name.len())))
            }
            None => files.iter().rev().find_map(|file| file.preset.clone()),
        };
        let preset =
            preset.map(|(name, place)| pipeline::of_preset(document, &name, place, &mut self.diagnostics));
        let below =
            files.into_iter().fold(preset.unwrap_or_default(), |below, file| below.under(file.overrides));
        let mut given = |texts: &[String], without_value, section| {
            let settings = texts.iter().filter_map(|text| self.setting(text, without_value));
            let settings: Vec<Setting> = settings.collect();
            settings.into_iter().filter_map(|one| self.switched(one, section, document)).collect()
        };
        let parameters = given(&settings.set, None, "parameters");
        let features = given(&settings.feature, Some("true"), "features");
        below.under(Overrides { parameters, features })
    }

    /// A setting of the command line with `on` and `off` as the booleans that they are where one is declared.
    fn switched(&mut self, mut setting: Setting, section: &str, document: &Document) -> Option<Setting> {
        let declared = document.root.get(section).and_then(Value::entries).unwrap_or_default();
        let entry = declared.iter().find(|entry| entry.key == setting.name);
        let Some(entry) = entry.filter(|one| one.value.get("type").and_then(Value::text) == Some("bool"))
        else {
            return Some(setting);
        };
        setting.value.kind = match (&setting.value.kind, setting.value.text()) {
            (document::Kind::Bool(on), _) => document::Kind::Bool(*on),
            (_, Some("on")) => document::Kind::Bool(true),
            (_, Some("off")) => document::Kind::Bool(false),
            _ => {
                let (name, what) = (&setting.name, section.trim_end_matches('s'));
                let message = format!("the {what} \"{name}\" is a boolean: on, off, true or false");
                let diagnostic = Diagnostic::error(codes::SETTING_TYPE, setting.place, message)
                    .related(entry.key_span, format!("the {what} is declared here"))
                    .help(format!("write {name}=on or {name}=off; true and false say the same"));
                self.diagnostics.push(diagnostic);
                return None;
            }
        };
        Some(setting)
    }

    fn parameter_file(&mut self, path: &Path) -> Option<ParameterFile> {
        let document = Overlaid { texts: &self.texts, files: &mut self.files, disk: None }
            .read(path, &mut self.sources)
            .map_err(Diagnostics::from)
            .and_then(|file| document::parse(&self.sources, file));
        match document {
            Ok(document) => Some(ParameterFile::read(&document, &mut self.diagnostics)),
            Err(diagnostics) => {
                self.diagnostics.extend(diagnostics);
                None
            }
        }
    }

    /// `NAME=VALUE`; the value is JSON, or else a word.
    fn setting(&mut self, text: &str, without_value: Option<&str>) -> Option<Setting> {
        let file = self.sources.add("<command line>", text);
        let whole = Span::new(file, 0..text.len());
        let (name, value) = match (text.split_once('='), without_value) {
            (Some((name, value)), _) => (name, value),
            (None, Some(value)) => (text, value),
            (None, None) => {
                let diagnostic =
                    Diagnostic::error(codes::SETTING_FORM, whole, format!("\"{text}\" gives no value"));
                self.diagnostics.push(diagnostic.help("write NAME=VALUE, such as --set resolution=1024"));
                return None;
            }
        };
        let mut scratch = Sources::new();
        let scratch_file = scratch.add("", value);
        let place = whole.inside(name.len() + 1..text.len());
        let value = match document::parse(&scratch, scratch_file) {
            Ok(document) => relocate(document.root, place),
            Err(_) => Value { span: place, kind: document::Kind::Text(value.to_owned()) },
        };
        Some(Setting { name: name.to_owned(), value, place: whole })
    }

    /// The profiles of names on the command line; `None` with a diagnostic for each name that no profile has.
    pub(crate) fn profiles_named(&mut self, names: &[String]) -> Option<Vec<TargetProfile>> {
        let mut profiles = Vec::new();
        let mut fine = true;
        for name in names {
            let file = self.sources.add("<command line>", name.as_str());
            match pipeline::profile_named(name, Span::new(file, 0..name.len())) {
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

/// The same value, standing at a place of another text.
fn relocate(value: Value, place: Span) -> Value {
    let span = place.inside(value.span.range());
    let kind = match value.kind {
        document::Kind::Array(elements) => {
            document::Kind::Array(elements.into_iter().map(|element| relocate(element, place)).collect())
        }
        document::Kind::Object(entries) => document::Kind::Object(
            entries
                .into_iter()
                .map(|entry| document::Entry {
                    key_span: place.inside(entry.key_span.range()),
                    key: entry.key,
                    value: relocate(entry.value, place),
                })
                .collect(),
        ),
        other => other,
    };
    Value { span, kind }
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
