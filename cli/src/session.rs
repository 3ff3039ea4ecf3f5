//! What the commands share: sources, findings, templates, and a pipeline with its choices.

use std::path::Path;
use std::sync::Arc;

use umbragraph::compiler::PlanOptions;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, did_you_mean, render};
use umbragraph::document::{self, Document, Value};
use umbragraph::pipeline::{self, Choice, ParameterFile, Setting};
use umbragraph::shader::{TargetProfile, TemplateSet};
use umbragraph::source::{FileId, Sources, Span};
use umbragraph::{Checked, Job, compose, read_source};

use crate::arguments::Choices;

/// Sources, findings and templates of one run of the command.
pub(crate) struct Session {
    pub(crate) sources: Sources,
    pub(crate) findings: Diagnostics,
    pub(crate) templates: Arc<TemplateSet>,
}

impl Session {
    /// A session with the embedded templates, and those of a folder.
    pub(crate) fn new(folder: Option<&Path>) -> Self {
        let mut sources = Sources::new();
        let mut findings = Diagnostics::new();
        let templates = match folder {
            None => umbragraph::templates(&mut sources, &mut findings),
            Some(folder) => {
                let mut files = Vec::new();
                if let Err(finding) = collect(folder, folder, &mut files, 0) {
                    findings.push(*finding);
                }
                umbragraph::templates_with(&files, &mut sources, &mut findings)
            }
        };
        Self { sources, findings, templates }
    }

    /// Takes a pipeline all the way to a plan.
    pub(crate) fn check(&mut self, path: &Path, choices: &Choices) -> Checked {
        let file = match read_source(path, &mut self.sources) {
            Ok(file) => file,
            Err(finding) => {
                self.findings.push(finding);
                return Checked::default();
            }
        };
        let Some(profile) = self.profile(file, choices) else { return Checked::default() };
        let composed = compose::compose(file, path, &mut compose::Disk, &mut self.sources, &mut self.findings);
        let Some(composed) = composed else { return Checked::default() };
        let choice = self.choice(choices, &composed.document);
        let job = Job {
            registry: &umbragraph::registry(),
            templates: &self.templates,
            profile: &profile,
            choice: &choice,
            options: &Self::options(choices),
        };
        umbragraph::check_document(&composed.document, &job, &self.sources, &mut self.findings)
    }

    /// What the choices say of the plan.
    pub(crate) fn options(choices: &Choices) -> PlanOptions {
        PlanOptions { objective: choices.objective, ..PlanOptions::new(choices.size[0], choices.size[1]) }
    }

    /// Prints the findings to standard error; whether there was no error among them.
    pub(crate) fn report(&mut self) -> bool {
        self.findings.sort();
        eprint!("{}", render::human_all(&self.findings, &self.sources));
        !self.findings.has_errors()
    }

    /// What the preset, the parameter files and the command line give values to, the last over the first.
    fn choice(&mut self, choices: &Choices, document: &Document) -> Choice {
        let files: Vec<ParameterFile> =
            choices.params.iter().filter_map(|path| self.parameter_file(path)).collect();
        let preset = match &choices.preset {
            Some(name) => {
                let at = self.sources.add("<command line>", name.as_str());
                Some((name.clone(), Span::new(at, 0..name.len())))
            }
            None => files.iter().rev().find_map(|file| file.preset.clone()),
        };
        let preset = preset.map(|(name, place)| pipeline::of_preset(document, &name, place, &mut self.findings));
        let below = files.into_iter().fold(preset.unwrap_or_default(), |below, file| below.under(file.choice));
        let parameters = choices.set.iter().filter_map(|text| self.setting(text, None)).collect();
        let features = choices.feature.iter().filter_map(|text| self.setting(text, Some("true"))).collect();
        below.under(Choice { parameters, features })
    }

    fn parameter_file(&mut self, path: &Path) -> Option<ParameterFile> {
        let document = read_source(path, &mut self.sources)
            .map_err(Diagnostics::from)
            .and_then(|file| document::parse(&self.sources, file));
        match document {
            Ok(document) => Some(ParameterFile::read(&document, &mut self.findings)),
            Err(findings) => {
                self.findings.extend(findings);
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
                let finding = Diagnostic::error(codes::SETTING_FORM, whole, format!("\"{text}\" gives no value"));
                self.findings.push(finding.help("write NAME=VALUE, such as --set resolution=1024"));
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

    /// The profile to check for: the one asked for, else the first that the pipeline claims.
    fn profile(&mut self, file: FileId, choices: &Choices) -> Option<TargetProfile> {
        if let Some(name) = &choices.profile {
            let known = TargetProfile::from_name(name);
            if known.is_none() {
                let at = self.sources.add("<command line>", name.as_str());
                let finding = Diagnostic::error(
                    codes::UNKNOWN_PROFILE,
                    Span::new(at, 0..name.len()),
                    format!("there is no profile \"{name}\""),
                );
                let help = did_you_mean(name, TargetProfile::NAMES).map_or_else(
                    || format!("the profiles are {}", TargetProfile::NAMES.join(", ")),
                    |meant| format!("did you mean \"{meant}\"?"),
                );
                self.findings.push(finding.help(help));
            }
            return known;
        }
        let claimed = document::parse(&self.sources, file).ok().and_then(|document| {
            let profiles = document.root.get("profiles")?.elements()?;
            profiles.first()?.text().and_then(TargetProfile::from_name)
        });
        Some(claimed.unwrap_or_else(TargetProfile::webgpu))
    }
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

/// The templates and axes below a folder, each with its name there.
fn collect(
    root: &Path,
    folder: &Path,
    files: &mut Vec<(String, std::path::PathBuf)>,
    depth: usize,
) -> Result<(), Box<Diagnostic>> {
    let name = folder.display().to_string();
    let unreadable = |error: std::io::Error| {
        Box::new(
            Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", format!("the folder \"{name}\" cannot be read: {error}"))
                .help("paths are relative to the current folder"),
        )
    };
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).map_err(unreadable)?.collect::<Result<_, _>>().map_err(unreadable)?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let text = path.to_string_lossy();
        if path.is_dir() && depth < 8 {
            collect(root, &path, files, depth + 1)?;
        } else if text.ends_with(".wgsl.jinja") || text.ends_with(".axes.json") {
            let below = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            files.push((below, path));
        }
    }
    Ok(())
}
