//! Captures: the contents of textures and buffers at a point of the frame, for somebody to look at.
//!
//! A capture is an ordinary copy at the end of the document, into an import of the host. The compiler orders it after
//! the pass whose version it names and before the next writer, keeps the contents until then, and lets nothing that
//! shares the memory come between; no part of the executor knows of captures. [`document`] writes the text of such
//! copies, to be included in the pipeline ([`Composed::include`](umbragraph_pipeline::compose::Composed::include)).
//!
//! Limits: one mip level each, all of its layers; all bytes of a buffer. [`Wanted`] says which resources are taken.

use std::fmt::Write as _;

use serde_json::{Value, json};

use umbragraph_compiler::{Physical, Plan, PlannedPass, PlannedResource};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::language::{Reference, TextureShape};
use umbragraph_pipeline::pipeline::{ResourceKind, SubresourceRange, is_of};

/// A texture or buffer to capture: its final contents, or the version that one pass wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Capture {
    /// The resource to capture: `NAME`, `NAME@PASS` for the version written by a pass, or `NAME@-1` for the previous
    /// frame.
    pub reference: String,
    /// The mip level to capture, from 0; ignored for buffers.
    pub mip: u32,
}

/// The resources that a capture document takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Textures of one sample that are no volumes.
    Pictures,
    /// The same textures, and buffers.
    PicturesAndBuffers,
    /// All textures and buffers.
    All,
}

/// A generated pipeline document that copies captured resources to imports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureDocument {
    /// The document's source, to be included in the captured pipeline.
    pub text: String,
    /// The name of the import that receives each capture, in the order of the captures. A texture has the captured
    /// format, the size of the captured mip level and all layers; a buffer has the captured size.
    pub imports: Vec<String>,
    /// For each capture, the pass that overwrites the contents in the plan without captures; `None` if no pass does.
    /// The pass writes a later version of the resource, or another resource in the same memory.
    pub overwritten: Vec<Option<String>>,
}

/// Generates the pipeline document that performs the captures, for the pipeline of a plan. The import of a texture of
/// several samples has as many samples; that of a volume is a volume.
///
/// # Errors
///
/// Fails for resources that do not exist, are culled or are not `wanted`; passes that do not write the resource; and
/// missing mip levels.
pub fn document(plan: &Plan, captures: &[Capture], wanted: Wanted) -> Result<CaptureDocument, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let mut subgraphs = serde_json::Map::new();
    let mut passes = serde_json::Map::new();
    let mut imports = Vec::new();
    let mut overwritten = Vec::new();
    for capture in captures {
        let resource = match check(plan, capture, wanted) {
            Ok(resource) => resource,
            Err(diagnostic) => {
                diagnostics.push(diagnostic);
                continue;
            }
        };
        overwritten.push(overwriter(plan, resource, capture).map(|pass| pass.name.clone()));
        let name = free_name(plan, imports.len());
        let (contents, from) = import(plan, resource, capture.mip);
        // As an input of a subgraph a resource of any name stands in expressions, so that the copy is planned again for
        // another size as the resource is.
        let part = json!({
            "inputs": { "captured": "the resource that is captured" },
            "resources": { "contents": contents },
            "passes": { "copy": { "copy": { "from": from, "to": { "name": "&contents" } } } }
        });
        imports.push(format!("{name}.contents"));
        subgraphs.insert(name.clone(), part);
        passes.insert(
            name.clone(),
            json!({ "use": name, "with": { "captured": format!("&{}", capture.reference) } }),
        );
    }
    if diagnostics.has_errors() {
        return Err(diagnostics);
    }
    let document = json!({ "subgraphs": subgraphs, "passes": passes });
    Ok(CaptureDocument { text: format!("{document:#}\n"), imports, overwritten })
}

/// Returns the import that receives a captured resource, and the source of the copy to it, as JSON.
fn import(plan: &Plan, resource: &PlannedResource, mip: u32) -> (Value, Value) {
    let Some(format) = resource.format.map(umbragraph_pipeline::language::format_name) else {
        let buffer = json!({ "buffer": { "size": "=captured.size", "lifetime": "imported" } });
        return (buffer, json!({ "name": "&captured" }));
    };
    let side = |side: &str| format!("=max(1, floor(captured.{side} / {}))", 1u64 << mip);
    let is_volume = is_volume(plan, resource);
    let layers = if is_volume { side("layers") } else { "=captured.layers".to_owned() };
    let mut texture = json!({
        "format": format,
        "size": [side("width"), side("height")],
        "layers": layers,
        "lifetime": "imported"
    });
    if is_volume {
        texture["view_dimension"] = json!("3d");
    }
    if let Some(samples) = resource.size.map(|size| size.samples).filter(|samples| *samples > 1) {
        texture["samples"] = json!(samples);
    }
    (json!({ "texture": texture }), json!({ "name": "&captured", "mip": mip }))
}

/// Returns the first pass after the captured version that overwrites its mip level or reuses its memory.
fn overwriter<'p>(plan: &'p Plan, resource: &PlannedResource, capture: &Capture) -> Option<&'p PlannedPass> {
    let version = Reference::parse(&capture.reference).ok()?.version;
    let shown = SubresourceRange::of(resource.format.map(|_| capture.mip), None);
    let overwrites = |pass: &PlannedPass| {
        let mut accesses = plan.pipeline.pass(pass.handle).accesses().iter();
        accesses.any(|one| one.resource == resource.handle && one.usage.writes() && one.range.overlaps(shown))
    };
    let written = version.and_then(|version| {
        // A loop, or a use of a subgraph, means the last of its passes.
        let by = plan.passes.iter().rposition(|pass| is_of(&pass.name, &version))?;
        (by + 1..plan.passes.len()).find(|at| overwrites(&plan.passes[*at]))
    });
    let shares = matches!(resource.physical, Physical::Texture(_) | Physical::Buffer(_));
    let others = plan.resources.values().filter(|one| shares && one.physical == resource.physical);
    let aliased = others.map(|one| one.first).filter(|first| *first > resource.last).min();
    plan.passes.get(written.into_iter().chain(aliased).min()?)
}

/// Returns a name that no resource and no pass has.
fn free_name(plan: &Plan, at: usize) -> String {
    let pipeline = &plan.pipeline;
    let mut name = format!("capture_{at}");
    while pipeline.find_resource(&name).is_some() || pipeline.find_pass(&name).is_some() {
        let _ = write!(name, "_");
    }
    name
}

fn is_volume(plan: &Plan, resource: &PlannedResource) -> bool {
    let declared = plan.pipeline.resource(resource.handle).texture();
    declared.is_some_and(|texture| texture.view_dimension == Some(TextureShape::D3))
}

fn check<'p>(plan: &'p Plan, capture: &Capture, wanted: Wanted) -> Result<&'p PlannedResource, Diagnostic> {
    let error = |message: String, help: String| {
        Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help))
    };
    let takes_buffers = wanted != Wanted::Pictures;
    let kind = if takes_buffers { "texture or buffer" } else { "texture" };
    let kinds = if takes_buffers { "textures and buffers" } else { "textures" };
    let whole = &capture.reference;
    let reference = match Reference::parse(whole) {
        Ok(reference) => reference,
        Err(wrong) => return error(format!("\"{whole}\" names no {kind}"), wrong.to_string()),
    };
    let name = if reference.back > 0 { whole } else { &reference.resource };
    let is_buffer =
        |one: &PlannedResource| matches!(plan.pipeline.resource(one.handle).kind, ResourceKind::Buffer(_));
    let known = || {
        let taken = |one: &PlannedResource| one.format.is_some() || (takes_buffers && is_buffer(one));
        plan.resources.iter().filter(move |(_, one)| taken(one)).map(|(name, _)| name.as_str())
    };
    let Some(resource) = plan.resources.get(name) else {
        if plan.pipeline.find_resource(name).is_some() {
            return error(
                format!("\"{name}\" is culled: no pass that leads to an output uses it"),
                format!(
                    "`umbragraph why PIPELINE {name}` tells why; give a pass that writes it \"side_effect\": true"
                ),
            );
        }
        let message = format!("there is no resource \"{name}\" to capture");
        let diagnostic = Diagnostic::error(codes::CAPTURE, Place::Nowhere, message);
        return Err(diagnostic.suggest(name, known(), None, |known| {
            format!("the {kinds} are {}", list_of(known.iter().copied()))
        }));
    };
    let size = resource.size.filter(|_| resource.format.is_some());
    if size.is_none() && !(takes_buffers && is_buffer(resource)) {
        let kind = plan.pipeline.resource(resource.handle).kind_name();
        let capture = if takes_buffers { "capture" } else { "picture" };
        return error(
            format!("\"{name}\" is {kind}, of which there is no {capture}"),
            format!("the {kinds} are {}", list_of(known())),
        );
    }
    if let Some(pass) = &reference.version {
        let writers = || {
            let writers = plan.passes.iter().filter(|pass| plan.writes(pass.handle, resource.handle));
            writers.map(|pass| pass.name.as_str())
        };
        if !writers().any(|writer| is_of(writer, pass)) {
            let message = match plan.culled.contains_key(pass) {
                true => format!("the pass \"{pass}\" is culled, so it writes no \"{name}\""),
                false => format!("no pass \"{pass}\" writes \"{name}\""),
            };
            return error(message, format!("\"{name}\" is written by {}", list_of(writers())));
        }
    }
    // A buffer has neither mip levels nor samples.
    let Some(size) = size else { return Ok(resource) };
    if wanted != Wanted::All && is_volume(plan, resource) {
        return error(
            format!("\"{name}\" is a volume"),
            "capture a texture that a pass makes of one slice".into(),
        );
    }
    if wanted != Wanted::All && size.samples > 1 {
        return error(
            format!("\"{name}\" has {} samples a texel, of which there is no picture", size.samples),
            "capture the texture that it is resolved to".into(),
        );
    }
    if capture.mip >= size.mips {
        let help = format!("\"{name}\" has the mip levels 0 to {}", size.mips - 1);
        return error(format!("\"{name}\" has no mip level {}", capture.mip), help);
    }
    Ok(resource)
}
