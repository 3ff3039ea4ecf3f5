//! The whole way from a file to a plan, and reading files.

use std::path::Path;
use std::sync::Arc;

use crate::compiler::{self, Graph, Plan, PlanOptions};
use crate::compose;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::document::{self, Document};
use crate::node::Registry;
use crate::pipeline::{self, Choice, Pipeline};
use crate::shader::{TargetProfile, TemplateSet};
use crate::source::{FileId, MAXIMUM_FILE_BYTES, Sources, Span};

/// What a pipeline text came to, as far as its findings let it.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// The pipeline.
    pub pipeline: Option<Arc<Pipeline>>,
    /// The graph.
    pub graph: Option<Graph>,
    /// The plan.
    pub plan: Option<Plan>,
}

impl Checked {
    /// Plans the same pipeline with other options: another viewport, or sizes that host data wants
    /// ([`PlanOptions::data_sizes`]). Where nothing but sizes changes, the rest of the plan is taken over
    /// ([`Plan::resized`]).
    ///
    /// # Errors
    /// The findings of the plan; nothing but warnings where there is no graph to plan.
    pub fn plan_again(&self, options: &PlanOptions, sources: &Sources) -> Result<Plan, Diagnostics> {
        let mut findings = Diagnostics::new();
        let (Some(pipeline), Some(graph)) = (&self.pipeline, &self.graph) else { return Err(findings) };
        if let Some(plan) = &self.plan {
            return plan.resized(graph, options, sources);
        }
        compiler::plan(pipeline, graph, options, sources, &mut findings).ok_or(findings)
    }
}

/// What a pipeline is checked with.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The node kinds that passes can name.
    pub registry: &'a Registry,
    /// The templates.
    pub templates: &'a Arc<TemplateSet>,
    /// What shaders and sizes may rely on.
    pub profile: &'a TargetProfile,
    /// Values of parameters and features.
    pub choice: &'a Choice,
    /// The viewport and the host's textures.
    pub options: &'a PlanOptions,
}

/// Takes a registered text, which stands alone, all the way to a plan. Every finding goes to `diagnostics`.
pub fn check(file: FileId, job: &Job<'_>, sources: &Sources, diagnostics: &mut Diagnostics) -> Checked {
    match document::parse(sources, file) {
        Ok(document) => check_document(&document, job, sources, diagnostics),
        Err(findings) => {
            diagnostics.extend(findings);
            Checked::default()
        }
    }
}

/// Takes a pipeline file, with the files that it extends, includes and uses, all the way to a plan. Every finding goes to
/// `diagnostics`. Files that are not on a disk: [`crate::compose::compose`], then [`check_document`].
pub fn check_path(
    path: &Path,
    job: &Job<'_>,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let file = match read_source(path, sources) {
        Ok(file) => file,
        Err(finding) => {
            diagnostics.push(finding);
            return Checked::default();
        }
    };
    compose::compose(file, path, &mut compose::Disk, sources, diagnostics)
        .map(|composed| check_document(&composed.document, job, sources, diagnostics))
        .unwrap_or_default()
}

/// Takes a document, perhaps composed of several files, all the way to a plan. Every finding goes to `diagnostics`.
pub fn check_document(
    document: &Document,
    job: &Job<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let mut own = Diagnostics::new();
    let checked = check_own(document, job, sources, &mut own);
    diagnostics.extend(pipeline::as_written(document, own));
    checked
}

fn check_own(
    document: &Document,
    job: &Job<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let mut checked = Checked::default();
    let Job { registry, templates, profile, choice, options } = job;
    let Some(mut pipeline) =
        pipeline::load(document, registry, templates, profile, choice, sources, diagnostics)
    else {
        return checked;
    };
    compiler::set_aside(&mut pipeline, options, sources, diagnostics);
    let pipeline = Arc::new(pipeline);
    checked.pipeline = Some(pipeline.clone());
    let Some(graph) = compiler::build(&pipeline, diagnostics) else { return checked };
    checked.plan = compiler::plan(&pipeline, &graph, options, sources, diagnostics);
    checked.graph = Some(graph);
    checked
}

/// Reads and registers a text file; findings show it by the path as given.
///
/// # Errors
/// A file that cannot be read, is too large, or is not UTF-8.
pub fn read_source(path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| {
        let reason = match error.kind() {
            std::io::ErrorKind::NotFound => "it does not exist".to_owned(),
            std::io::ErrorKind::PermissionDenied => "permission is denied".to_owned(),
            _ => error.to_string(),
        };
        Diagnostic::in_file(
            codes::FILE_UNREADABLE,
            &name,
            "",
            format!("the file \"{name}\" cannot be read: {reason}"),
        )
        .help("paths are relative to the current folder")
    };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(unreadable(std::io::Error::other("it is a folder")));
    }
    if metadata.len() > MAXIMUM_FILE_BYTES as u64 {
        let message = format!("the file \"{name}\" has {} bytes", metadata.len());
        return Err(Diagnostic::in_file(codes::FILE_TOO_LARGE, &name, "", message)
            .help(format!("texts have at most {MAXIMUM_FILE_BYTES} bytes")));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    match String::from_utf8(bytes) {
        // Some editors begin UTF-8 with a byte-order mark; it is no part of the text.
        Ok(text) => Ok(sources.add(name, text.strip_prefix('\u{feff}').unwrap_or(&text))),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let file = sources.add(name.clone(), text);
            Err(Diagnostic::error(
                codes::FILE_NOT_UTF8,
                Span::new(file, at..at + 1),
                format!("the file \"{name}\" is not UTF-8"),
            )
            .help("save it as UTF-8"))
        }
    }
}
