//! Generated WGSL: lenses at passes and in templates, the text that they show, and the way back from its lines.
//!
//! A lens carries the command [`SHOW`] of the client, with one argument; the server answers its own command [`TEXT`]
//! for that argument with the text. The text is that of the chosen [configuration](crate::configuration), whose lens
//! stands at the top.
//!
//! Limits: templates have lenses for pipelines of which a document is open, [`MOST`] at most.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use lsp_types::{CodeLens, CodeLensParams, Command, Range, Uri};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

use crate::configuration;
use crate::workspace::{Workspace, document_path, is_template};
use umbragraph_graph::pipeline::{ProgramVariant, TypedPipeline};
use umbragraph_session::Target;

/// The name of the client's command that shows generated WGSL.
pub(crate) const SHOW: &str = "umbragraph.showWgsl";
/// The name of the server's command that returns generated WGSL.
pub(crate) const TEXT: &str = "umbragraph.wgsl";
/// The maximum number of code lenses at one pass or template.
const MOST: usize = 8;

/// The argument of the commands [`SHOW`] and [`TEXT`]: a shader variant of a pass.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Wanted {
    /// The URI of the pipeline file.
    pipeline: Uri,
    pass: String,
    /// The index of the variant among those that the pass has for different mesh properties; 0 if not given.
    #[serde(default)]
    variant: usize,
}

/// The generated WGSL of a pass, and the places in templates that its lines come from.
#[derive(Debug, Serialize)]
pub(crate) struct Generated {
    title: String,
    text: String,
    /// For each line of `text`, the URI and range of its origin in a template, or in the copy of one that is bundled
    /// with the module. `None` if the origin is unknown.
    lines: Vec<Option<Json>>,
}

/// Returns all passes that have a shader, each with its shader variants.
fn variants(
    pipeline: &TypedPipeline,
) -> impl Iterator<Item = (&umbragraph_graph::pipeline::Pass, &[ProgramVariant])> {
    pipeline.passes.iter().filter_map(|pass| {
        let program = pipeline.program(pass.work().program()?);
        Some((pass, &program.variants[..]))
    })
}

fn lens(range: Range, title: String, command: &str, argument: impl Serialize) -> Option<CodeLens> {
    let arguments = Some(vec![serde_json::to_value(argument).ok()?]);
    let command = Command { title, command: command.to_owned(), arguments };
    Some(CodeLens { range, command: Some(command), data: None })
}

/// The lens that chooses the configuration of a pipeline; `None` if there is nothing to choose.
fn choosing(workspace: &mut Workspace, target: &Target, path: &Path) -> Option<CodeLens> {
    let loaded = workspace.sure(|session| session.load(target));
    let document = loaded.document().filter(|document| configuration::has_choice(document))?;
    let of = match target.path == path {
        true => String::new(),
        false => format!(" of {}", document.root.get("name").and_then(|name| name.text()).unwrap_or("?")),
    };
    let now = configuration::title(workspace.configurations.get(&target.path));
    let argument = json!({ "pipeline": workspace.uri(&target.path)? });
    lens(Range::default(), format!("Configuration{of}: {now}"), configuration::CHOOSE, argument)
}

/// Returns the mesh properties of a variant as the end of a title: a list in parentheses, or an empty string.
fn of_properties(variant: &ProgramVariant) -> String {
    match &variant.properties[..] {
        [] => String::new(),
        some => format!(" ({})", some.join(", ")),
    }
}

/// Returns the code lenses of a document or template, which show generated WGSL or choose the configuration. `None` if
/// the document belongs to no pipeline.
pub(crate) fn lenses(workspace: &mut Workspace, params: &CodeLensParams) -> Option<Vec<CodeLens>> {
    let path = document_path(&params.text_document.uri)?;
    if is_template(&path) {
        return Some(of_template(workspace, &path));
    }
    let target = workspace.target(&path)?;
    let mut lenses: Vec<CodeLens> = choosing(workspace, &target, &path).into_iter().collect();
    let (Some(pipeline), Some(own)) = (workspace.pipeline(&target), workspace.uri(&target.path)) else {
        return Some(lenses);
    };
    for (pass, variants) in variants(&pipeline) {
        let Some(place) = workspace.location(pass.place) else { continue };
        // Of a pass in a loop the first round is shown.
        let is_known = lenses.iter().any(|lens| lens.range == place.range);
        if document_path(&place.uri).as_ref() != Some(&path) || is_known {
            continue;
        }
        let shown = variants.iter().enumerate().take(MOST).filter_map(|(variant, one)| {
            let wanted = Wanted { pipeline: own.clone(), pass: pass.name.clone(), variant };
            lens(place.range, format!("WGSL{}", of_properties(one)), SHOW, &wanted)
        });
        let shown: Vec<CodeLens> = shown.collect();
        lenses.extend(shown);
    }
    Some(lenses)
}

fn of_template(workspace: &mut Workspace, path: &Path) -> Vec<CodeLens> {
    let (mut choices, mut texts) = (Vec::new(), Vec::new());
    let mut shown = BTreeSet::new();
    for target in workspace.told() {
        let Some(uri) = workspace.uri(&target.path) else { continue };
        let is_it = |name: &str| Path::new(name) == path;
        let pipeline = workspace.pipeline(&target);
        // A template with errors is part of no variant.
        let mut is_used = workspace.has_diagnostics(&target, path);
        for (pass, variants) in pipeline.iter().flat_map(|pipeline| variants(pipeline)) {
            for (variant, one) in variants.iter().enumerate() {
                let files: BTreeSet<_> =
                    one.module.map.pieces().filter_map(|(_, span)| Some(span?.file)).collect();
                let mut files = files.into_iter().filter_map(|file| workspace.session.sources().get(file));
                if !files.any(|file| is_it(file.name())) {
                    continue;
                }
                is_used = true;
                if texts.len() >= MOST || !shown.insert(one.module.hash) {
                    continue;
                }
                let of = pipeline.as_ref().map_or("", |pipeline| &pipeline.name);
                let title = format!("WGSL of {} in {of}{}", pass.name, of_properties(one));
                let wanted = Wanted { pipeline: uri.clone(), pass: pass.name.clone(), variant };
                texts.extend(lens(Range::default(), title, SHOW, &wanted));
            }
        }
        if is_used && choices.len() < MOST {
            choices.extend(choosing(workspace, &target, path));
        }
    }
    choices.append(&mut texts);
    choices
}

/// Runs the server's command. Returns the text of a variant.
pub(crate) fn execute(workspace: &mut Workspace, argument: Json) -> Result<Generated, String> {
    let wanted: Wanted =
        serde_json::from_value(argument).map_err(|error| format!("the argument of {TEXT}: {error}"))?;
    let missing = |what: &str| format!("{} has no {what} at the moment", wanted.pipeline.as_str());
    let path = document_path(&wanted.pipeline).ok_or_else(|| missing("path"))?;
    let pipeline =
        workspace.pipeline(&Target::new(&path)).ok_or_else(|| missing("pipeline without errors"))?;
    let found = variants(&pipeline).find(|(pass, _)| pass.name == wanted.pass);
    let variant = found.and_then(|(_, variants)| variants.get(wanted.variant));
    let variant = variant.ok_or_else(|| missing(&format!("shader of a pass \"{}\"", wanted.pass)))?;
    Ok(generated(workspace, &wanted, variant))
}

fn generated(workspace: &Workspace, wanted: &Wanted, variant: &ProgramVariant) -> Generated {
    let (text, map) = (&variant.module.wgsl, &variant.module.map);
    let (mut start, mut files) = (0, BTreeMap::new());
    let lines = text.split_inclusive('\n').map(|line| {
        // Where the first thing in the line is from.
        let indent = line.len() - line.trim_start().len();
        let place = map.place(start + indent.min(line.len().saturating_sub(1)));
        start += line.len();
        let place = place?;
        let uri = || workspace.readable(place).map(|location| location.uri);
        let uri = files.entry(place.file).or_insert_with(uri).clone()?;
        let range = workspace.encoding.range(workspace.session.sources().get(place.file)?, place);
        Some(json!({ "uri": uri, "range": range }))
    });
    let lines = lines.collect();
    Generated {
        title: format!("{}{}.wgsl", wanted.pass, of_properties(variant)),
        text: text.to_string(),
        lines,
    }
}

impl Workspace {
    /// A pipeline in the configuration that the editor shows; `None` if an error keeps it from being loaded.
    fn pipeline(&mut self, target: &Target) -> Option<Arc<TypedPipeline>> {
        let choice = self.choice(target);
        self.sure(|session| session.plan(target, &choice)).0.report.pipeline
    }
}
