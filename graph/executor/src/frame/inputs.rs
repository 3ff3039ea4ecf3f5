//! Inputs of a frame: checks before anything is recorded, and the CPU passes that turn them into data.
//!
//! The host's textures must match the plan, and its meshes the storage that the pipelines were built for; views must
//! lie within the attachments that they are drawn into. A frame without diagnostics allocates nothing.

use super::input::Frame;
use crate::binding::draw::{DrawSource, Host};
use crate::binding::groups::Group;
use crate::drawing::attachments::Attachments;
use crate::instance::instantiate::{Instantiated, InstantiatedWork};
use crate::instance::requirements::{lacks_source, scenes};
use crate::measure::times::Times;
use crate::memory::imports::{Import, Kept};
use umbragraph_compiler::{Physical, Plan, PlannedResource};
use umbragraph_pipeline::data::{BlackboardData, View};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::language::Lifetime;

/// Returns the errors that prevent a frame from being recorded; empty if its imports, meshes and mesh layouts fit the
/// plan.
pub(crate) fn check(instantiated: &Instantiated, frame: &Frame<'_>) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    let imports = &instantiated.resources.imports;
    for (name, resource) in instantiated.plan.imports() {
        let error = match resource.format {
            Some(_) => match imports.of_frame(name, frame.imports) {
                Some(import) => import_error(&instantiated.plan, name, resource, import)
                    .map(|error| (error, "give a texture as the plan was made for it, or plan again")),
                None => Some((
                    format!("the host gave no texture for \"{name}\""),
                    "give it with Frame::imports or Executor::give",
                )),
            },
            None if imports.buffer_of(resource.handle).is_some() => None,
            None => {
                let error = imports.kept_buffer(name).and_then(|buffer| {
                    let error = buffer_error(&instantiated.plan, name, resource, buffer);
                    error.map(|error| (error, "give a buffer as the plan was made for it, or plan again"))
                });
                Some(error.unwrap_or_else(|| {
                    (format!("the host gave no buffer for \"{name}\""), "give it with Executor::give")
                }))
            }
        };
        if let Some((error, help)) = error {
            let declared = instantiated.plan.pipeline.resource(resource.handle);
            let diagnostic =
                Diagnostic::error(codes::IMPORT, declared.place, error).pointer(&declared.pointer);
            diagnostics.push(diagnostic.help(help));
        }
    }
    for (name, _) in frame.imports.iter() {
        let plan = &instantiated.plan;
        let is_planned = plan.resources.get(name).is_some_and(|one| one.physical == Physical::Imported);
        let declared = || plan.pipeline.find_resource(name).map(|handle| plan.pipeline.resource(handle));
        if !is_planned && declared().is_none_or(|resource| resource.lifetime() != Lifetime::Imported) {
            diagnostics.push(surplus(instantiated, name));
        }
    }
    if frame.draws.is_none() {
        diagnostics.extend(scenes(&instantiated.plan).map(|(pass, _)| lacks_source(pass)));
        return diagnostics;
    }
    let host = Host { source: frame.draws, stated: &instantiated.stated };
    for (geometry, interface) in &instantiated.interfaces {
        if host.interface(&instantiated.plan, geometry) != Some(interface) {
            let message = format!(
                "the host's interface of \"{geometry}\" is not the one that pipelines were built for"
            );
            let diagnostic = Diagnostic::error(codes::HOST_INTERFACE, Place::Nowhere, message);
            diagnostics.push(
                diagnostic.help("give the executor its plan again, with Executor::set_plan_and_source"),
            );
        }
    }
    diagnostics
}

/// Takes imported buffers from the draw source, except those that were set with `Executor::give`. A changed buffer
/// drops all bind groups.
///
/// # Errors
/// A buffer that the source cannot create, or one that lacks the size or usages that the plan requires.
pub(crate) fn provide(instantiated: &mut Instantiated, source: &dyn DrawSource) -> Result<(), Diagnostic> {
    let Instantiated { resources, plan, .. } = &instantiated;
    let mut others = Vec::new();
    for (import, name) in resources.imports.open_buffers() {
        let Some(resource) = plan.resources.get(name) else { continue };
        let provided = source.buffer(name).transpose();
        let error = match &provided {
            Ok(buffer) => buffer.and_then(|buffer| buffer_error(plan, name, resource, buffer)),
            Err(reason) => Some(format!("the host cannot make the buffer for \"{name}\": {reason}")),
        };
        if let Some(error) = error {
            let declared = plan.pipeline.resource(resource.handle);
            let diagnostic =
                Diagnostic::error(codes::IMPORT, declared.place, error).pointer(&declared.pointer);
            return Err(diagnostic
                .help("switch the feature off that imports it, or give another with Executor::give"));
        }
        let provided = provided.ok().flatten();
        if resources.imports.buffer(import) != provided {
            others.push((import, provided.cloned()));
        }
    }
    let mut is_other = false;
    for (import, buffer) in others {
        is_other |= instantiated.resources.imports.provide(import, buffer.as_ref());
    }
    if is_other {
        let groups = instantiated.passes.iter_mut().flat_map(|pass| &mut pass.groups);
        groups.for_each(Group::forget);
    }
    Ok(())
}

/// Returns the error for a texture that the host gives under a name that the plan does not import.
fn surplus(instantiated: &Instantiated, name: &str) -> Diagnostic {
    let imported = instantiated.plan.imports().map(|(name, _)| name);
    let message =
        format!("the host gave a texture for \"{name}\", which is none of its own in this pipeline");
    let diagnostic = Diagnostic::error(codes::IMPORT, Place::Nowhere, message);
    diagnostic.suggest(name, imported, None, |known| match known {
        [] => "the pipeline imports nothing".to_owned(),
        known => format!("it imports {}", list_of(known)),
    })
}

/// Returns the reason why a texture or buffer passed to `Executor::give` does not meet the plan's requirements; `None`
/// if it does.
pub(crate) fn given_error(plan: &Plan, name: &str, given: &Kept) -> Option<String> {
    let resource = plan.resources.get(name)?;
    match given {
        Kept::Texture(..) => import_error(plan, name, resource, given.import()?),
        Kept::Buffer(buffer) => buffer_error(plan, name, resource, buffer),
    }
}

/// Returns `true` if `name` is an imported buffer of the plan, and `buffer` has the size and usages that the plan
/// requires.
pub(crate) fn fits(plan: &Plan, name: &str, buffer: &wgpu::Buffer) -> bool {
    let resource = plan.resources.get(name).filter(|one| one.physical == Physical::Imported);
    resource.is_some_and(|resource| {
        resource.format.is_none() && buffer_error(plan, name, resource, buffer).is_none()
    })
}

fn buffer_error(
    plan: &Plan,
    name: &str,
    resource: &PlannedResource,
    buffer: &wgpu::Buffer,
) -> Option<String> {
    if buffer.size() < resource.bytes {
        let (given, planned) = (buffer.size(), resource.bytes);
        return Some(format!("the buffer for \"{name}\" has {given} bytes; the plan needs {planned}"));
    }
    let accesses = plan.passes.iter().flat_map(|planned| plan.pipeline.pass(planned.handle).accesses());
    let needed = accesses
        .filter(|one| one.resource == resource.handle)
        .fold(wgpu::BufferUsages::empty(), |all, one| all | one.usage.buffer_usages());
    let missing = needed - buffer.usage();
    (!missing.is_empty())
        .then(|| format!("the buffer for \"{name}\" was created without the usage {missing:?}"))
}

/// Returns the name of the first pass that copies from or to an imported texture; `None` if no pass does. Such a pass
/// needs a whole texture, not a part.
fn copying<'p>(plan: &'p Plan, resource: &PlannedResource) -> Option<&'p str> {
    let copies = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
    let mut passes = plan.passes.iter().map(|planned| plan.pipeline.pass(planned.handle));
    let copying = passes.find(|pass| {
        let mut accesses = pass.accesses().iter();
        accesses.any(|one| one.resource == resource.handle && one.usage.texture_usages().intersects(copies))
    });
    copying.map(|pass| pass.name.as_str())
}

/// Adds warnings about an unusable camera or light. The frame is recorded nevertheless.
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

fn import_error(plan: &Plan, name: &str, resource: &PlannedResource, import: Import<'_>) -> Option<String> {
    let Import { texture, part } = import;
    let (format, size) = (resource.format?, resource.size?);
    let layers = texture.depth_or_array_layers().saturating_sub(part.layer());
    // Of a part the layers after it are not the resource's.
    let layers = if part.is_within() { layers.min(size.layers) } else { layers };
    let (width, height) = part.extent(texture);
    let given_format = part.format.unwrap_or(texture.format());
    if (width, height, layers, given_format) != (size.width, size.height, size.layers, format) {
        return Some(format!(
            "the texture for \"{name}\" is {width} by {height} with {layers} layers in {given_format:?}; \
             the plan needs {} by {} with {} layers in {format:?}",
            size.width, size.height, size.layers
        ));
    }
    let mips = texture.mip_level_count().saturating_sub(part.mip());
    let samples = texture.sample_count();
    if mips < size.mips || samples != size.samples {
        return Some(format!(
            "the texture for \"{name}\" has {mips} mips and {samples} samples; the plan needs {} and {}",
            size.mips, size.samples
        ));
    }
    let missing = resource.usages.unwrap_or(wgpu::TextureUsages::empty()) - texture.usage();
    if !missing.is_empty() {
        return Some(format!("the texture for \"{name}\" was created without the usage {missing:?}"));
    }
    let pass = copying(plan, resource).filter(|_| part.is_within())?;
    Some(format!("\"{pass}\" copies \"{name}\", which takes a whole texture, not a part of one"))
}

/// Runs the CPU passes in the plan's order. With `is_again`, passes that have run keep what they published;
/// others run.
///
/// # Errors
/// A pass that publishes data it did not declare, or a view that lies outside the attachments it is drawn into.
pub(crate) fn run_cpu_passes(
    instantiated: &mut Instantiated,
    frame: &Frame<'_>,
    times: &mut Times,
    is_again: bool,
) -> Result<(), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    for at in 0..instantiated.passes.len() {
        if is_again && instantiated.cpu_passes.has_run(at) {
            continue;
        }
        let start = times.now();
        if let Some(outcome) = instantiated.cpu_passes.run_pass(at, frame.input) {
            diagnostics.extend(outcome.err());
            times.add(at, start);
        }
    }
    check_views(instantiated, &mut diagnostics);
    if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
}

/// Adds an error for each view that lies outside the attachments of the pass that draws it.
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
