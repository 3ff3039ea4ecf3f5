//! What a frame brings, checked before anything is recorded, and the CPU passes that turn it into data.
//!
//! The host's textures have to be those that the plan was made for, its meshes stored as the pipelines were built for;
//! views have to lie within the attachments that they are drawn into. In a frame without diagnostics nothing is
//! allocated.

use super::input::Frame;
use crate::binding::draw;
use crate::drawing::attachments::Attachments;
use crate::instance::instantiate::{Instantiated, InstantiatedWork};
use crate::instance::requirements::{lacks_source, scenes};
use crate::measure::times::Times;
use crate::memory::imports::ImportPart;
use umbragraph_compiler::{Physical, Plan, PlannedResource};
use umbragraph_pipeline::data::{BlackboardData, View};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::work::ResourceHandle;

/// The errors that keep a frame from being recorded.
pub(crate) fn check(instantiated: &Instantiated, frame: &Frame<'_>) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    for (name, resource) in &instantiated.plan.resources {
        if resource.physical == Physical::Imported
            && let Some((error, help)) = match resource.format {
                Some(_) => import_error(instantiated, name, resource, frame).map(|error| {
                    (error, "give the executor the texture that the plan was made for, or plan again")
                }),
                None => instantiated.resources.imports.buffer_of(resource.handle).is_none().then(|| {
                    let error = format!("the host gave no buffer for \"{name}\"");
                    (error, "give the executor the buffer with Executor::import_buffer")
                }),
            }
        {
            let declared = instantiated.plan.pipeline.resource(resource.handle);
            let diagnostic =
                Diagnostic::error(codes::IMPORT, declared.place, error).pointer(&declared.pointer);
            diagnostics.push(diagnostic.help(help));
        }
    }
    for (name, _) in frame.imports {
        let plan = &instantiated.plan;
        let is_planned = plan.resources.get(*name).is_some_and(|one| one.physical == Physical::Imported);
        let declared = || plan.pipeline.find_resource(name).map(|handle| plan.pipeline.resource(handle));
        if !is_planned && declared().is_none_or(|resource| resource.lifetime() != Lifetime::Imported) {
            diagnostics.push(surplus(instantiated, name));
        }
    }
    if frame.draws.is_none() {
        diagnostics.extend(scenes(&instantiated.plan).map(|(pass, _)| lacks_source(pass)));
        return diagnostics;
    }
    for (geometry, interface) in &instantiated.interfaces {
        if draw::interface(&instantiated.plan, frame.draws, geometry) != Some(interface) {
            let message = format!(
                "the host's interface of \"{geometry}\" is not the one that pipelines were built for"
            );
            let diagnostic = Diagnostic::error(codes::HOST_INTERFACE, Place::Nowhere, message);
            diagnostics.push(diagnostic.help("give the executor its plan again, with this draw source"));
        }
    }
    diagnostics
}

/// A texture that the host gives for nothing.
fn surplus(instantiated: &Instantiated, name: &str) -> Diagnostic {
    let imported = instantiated.plan.resources.iter().filter(|(_, one)| one.physical == Physical::Imported);
    let imported = imported.map(|(name, _)| name.as_str());
    let message =
        format!("the host gave a texture for \"{name}\", which is none of its own in this pipeline");
    let diagnostic = Diagnostic::error(codes::IMPORT, Place::Nowhere, message);
    diagnostic.suggest(name, imported, None, |known| match known {
        [] => "the pipeline imports nothing".to_owned(),
        known => format!("it imports {}", list_of(known)),
    })
}

/// The resource that a buffer of the host's is for, by its name.
///
/// # Errors
/// What is wrong with the buffer.
pub(crate) fn check_buffer(plan: &Plan, name: &str, buffer: &wgpu::Buffer) -> Result<ResourceHandle, String> {
    let imported = |one: &&PlannedResource| one.physical == Physical::Imported && one.format.is_none();
    let resource = plan.resources.get(name).filter(imported);
    let resource = resource.ok_or_else(|| format!("the plan imports no buffer \"{name}\""))?;
    if buffer.size() < resource.bytes {
        let (given, planned) = (buffer.size(), resource.bytes);
        return Err(format!("the buffer for \"{name}\" has {given} bytes, planned are {planned}"));
    }
    let accesses = plan.passes.iter().flat_map(|planned| plan.pipeline.pass(planned.handle).accesses());
    let needed = accesses
        .filter(|one| one.resource == resource.handle)
        .fold(wgpu::BufferUsages::empty(), |all, one| all | one.usage.buffer_usages());
    let missing = needed - buffer.usage();
    if missing.is_empty() {
        return Ok(resource.handle);
    }
    Err(format!("the buffer for \"{name}\" was created without the usage {missing:?}"))
}

/// The resource that a part of the host's textures is for, by its name. Copies take whole textures.
///
/// # Errors
/// What is wrong with it.
pub(crate) fn check_part(plan: &Plan, name: &str) -> Result<ResourceHandle, String> {
    let imported = |one: &&PlannedResource| one.physical == Physical::Imported && one.format.is_some();
    let resource = plan.resources.get(name).filter(imported);
    let resource = resource.ok_or_else(|| format!("the plan imports no texture \"{name}\""))?;
    let copies = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
    let mut passes = plan.passes.iter().map(|planned| plan.pipeline.pass(planned.handle));
    let copying = passes.find(|pass| {
        pass.accesses()
            .iter()
            .any(|one| one.resource == resource.handle && one.usage.texture_usages().intersects(copies))
    });
    match copying {
        None => Ok(resource.handle),
        Some(pass) => {
            Err(format!("\"{}\" copies \"{name}\", which has to be a whole texture then", pass.name))
        }
    }
}

/// The warnings about a frame that is recorded all the same.
pub(crate) fn warnings(frame: &Frame<'_>, diagnostics: &mut Diagnostics) {
    let warning = |message: String| Diagnostic::warning(codes::FRAME_INPUT, Place::Nowhere, message);
    if let Some(reason) = frame.input.camera.check() {
        diagnostics
            .push(warning(format!("the camera cannot be used: {reason}")).help("nothing is drawn from it"));
    }
    for light in &frame.input.lights {
        if let Some(reason) = light.check() {
            let message = format!("the light \"{}\" cannot be used: {reason}", light.name);
            diagnostics.push(warning(message).help("the frame is drawn without it"));
        }
    }
}

fn import_error(
    instantiated: &Instantiated,
    name: &str,
    resource: &PlannedResource,
    frame: &Frame<'_>,
) -> Option<String> {
    let Some((_, texture)) = frame.imports.iter().find(|(given, _)| *given == name) else {
        return Some(format!("the host gave no texture for \"{name}\""));
    };
    let (format, size) = (resource.format?, resource.size?);
    let part = instantiated.resources.imports.part(resource.handle);
    let ImportPart { mip, layer, format: view_format } = part.unwrap_or_default();
    let at = |length: u32| length.checked_shr(mip).unwrap_or(0).max(1);
    let layers = texture.depth_or_array_layers().saturating_sub(layer);
    // Of a part the layers after it are not the resource's.
    let layers = if part.is_some() { layers.min(size.layers) } else { layers };
    let given = (at(texture.width()), at(texture.height()), layers);
    let planned = (size.width, size.height, size.layers);
    let given_format = view_format.unwrap_or(texture.format());
    if (given, given_format) != (planned, format) {
        let ((width, height, layers), (planned_width, planned_height, planned_layers)) = (given, planned);
        return Some(format!(
            "the texture for \"{name}\" is {width} by {height} with {layers} layers in {given_format:?}, \
             planned are {planned_width} by {planned_height} with {planned_layers} layers in {format:?}"
        ));
    }
    let given = (texture.mip_level_count().saturating_sub(mip), texture.sample_count());
    if given.0 < size.mips || given.1 != size.samples {
        let (mips, samples) = given;
        return Some(format!(
            "the texture for \"{name}\" has {mips} mips and {samples} samples, planned are {} and {}",
            size.mips, size.samples
        ));
    }
    let missing = resource.usages.unwrap_or(wgpu::TextureUsages::empty()) - texture.usage();
    (!missing.is_empty())
        .then(|| format!("the texture for \"{name}\" was created without the usage {missing:?}"))
}

/// Runs the CPU passes in their order.
///
/// # Errors
/// A pass that publishes what it did not declare, or a view that lies outside what it is drawn into.
pub(crate) fn run_cpu_passes(
    instantiated: &mut Instantiated,
    frame: &Frame<'_>,
    times: &mut Times,
) -> Result<(), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    for at in 0..instantiated.passes.len() {
        let start = times.now();
        if let Some(outcome) = instantiated.cpu_passes.run_pass(at, frame.input) {
            diagnostics.extend(outcome.err());
            times.add(at, start);
        }
    }
    check_views(instantiated, &mut diagnostics);
    if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
}

/// Finds views that lie outside what they are drawn into.
fn check_views(instantiated: &Instantiated, diagnostics: &mut Diagnostics) {
    for (planned, pass) in instantiated.plan.passes.iter().zip(&instantiated.passes) {
        let InstantiatedWork::Scene { scene, attachments } = &pass.work else { continue };
        if !instantiated.switches().runs(&instantiated.plan, planned.handle) {
            continue;
        }
        let data = instantiated.cpu_passes.seen(scene.views);
        for (at, view) in data.map(BlackboardData::views).unwrap_or_default().iter().enumerate() {
            if let Some(error) = view_error(view, attachments) {
                let pass = instantiated.plan.pipeline.pass(planned.handle);
                let message = format!("view {at} of \"{}\" {error}", pass.name);
                let diagnostic =
                    Diagnostic::error(codes::BLACKBOARD, pass.place, message).pointer(&pass.pointer);
                diagnostics
                    .push(diagnostic.help("a view lies within the attachments of the passes that draw it"));
            }
        }
    }
}

fn view_error(view: &View, attachments: &Attachments) -> Option<String> {
    if let Some(layers) = attachments.view_layers().filter(|layers| view.layer as usize >= *layers) {
        return Some(format!("is drawn into layer {} of {layers}", view.layer));
    }
    let [x, y, width, height] = view.viewport?;
    let end = [u64::from(x) + u64::from(width), u64::from(y) + u64::from(height)];
    let [wide, high] = attachments.extent;
    (end[0] > u64::from(wide) || end[1] > u64::from(high))
        .then(|| format!("is drawn into {width} by {height} texels from {x}, {y} on, of {wide} by {high}"))
}
