//! Histories in a plan: how they begin, which copies take turns, and those that are no use.
//!
//! A history of n frames stands on n + 1 textures (or buffers) of one descriptor. In the first frame the copy at a
//! place of the list holds what was left as many frames ago; from frame to frame every copy moves on by one place, and
//! the last becomes the first, which is written again. They are never shared with other resources.

use std::collections::{BTreeMap, HashSet};

use serde::Serialize;

use crate::memory::physical::Physical;
use crate::resources::resolved::ResolvedResources;
use crate::values::packed::to_word;
use umbragraph_pipeline::data::Component;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::language::WordValue;
use umbragraph_pipeline::pipeline::{Pass, ResourceKind, TypedPipeline};
use umbragraph_pipeline::work::ResourceHandle;

/// A planned history: a resource whose earlier frames can be read.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PlannedHistory {
    /// The textures or buffers used in rotation. In frame `f`, counted from 0, place `p` holds the contents of `(p + f)
    /// % places.len()` frames ago.
    pub places: Vec<Physical>,
    /// The contents of earlier frames before any were rendered.
    pub initial: InitialValue,
    /// The handle of the resource that each frame writes.
    #[serde(skip)]
    pub handle: ResourceHandle,
}

/// The contents of a history before there is an earlier frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum InitialValue {
    /// A color: red, green, blue and alpha.
    Color([f64; 4]),
    /// A depth from 0 to 1.
    Depth(f64),
    /// The 32-bit pattern repeated through a buffer.
    Word(u32),
}

/// Plans the histories, by resource name. `physical` holds the physical resource of each resource, indexed by handle.
pub(crate) fn plan(
    resolved: &ResolvedResources<'_>,
    physical: &[Physical],
) -> BTreeMap<String, PlannedHistory> {
    let pipeline = resolved.pipeline;
    let planned = pipeline.resource_handles().filter_map(|handle| {
        let resource = pipeline.resource(handle);
        let history = resource.history.filter(|history| history.back == 0)?;
        resolved.get(handle)?;
        // What a broken value begins with is of no consequence: it is a diagnostic, and there is no plan.
        let initial = initial(resolved, handle).ok().flatten().unwrap_or(InitialValue::Word(0));
        let places = history.members().map(|member| physical[member.index()]).collect();
        Some((resource.name.clone(), PlannedHistory { places, initial, handle }))
    });
    planned.collect()
}

/// Reports invalid initial values, also of histories that no live pass uses.
pub(crate) fn check_initial(resolved: &ResolvedResources<'_>, diagnostics: &mut Vec<Diagnostic>) {
    let pipeline = resolved.pipeline;
    for handle in pipeline.resource_handles() {
        if pipeline.resource(handle).history.is_some_and(|history| history.back == 0) {
            diagnostics.extend(initial(resolved, handle).err().map(|diagnostic| *diagnostic));
        }
    }
}

/// Returns the initial value of a history; `None` if it declares none, or if an earlier diagnostic prevents it.
///
/// # Errors
///
/// Fails for a value that no texel of the format, or no 32-bit word, can have.
fn initial(
    resolved: &ResolvedResources<'_>,
    handle: ResourceHandle,
) -> Result<Option<InitialValue>, Box<Diagnostic>> {
    let resource = resolved.pipeline.resource(handle);
    let reject = |pointer: &str, message: String, help: &str| {
        let diagnostic = resource.error_at(pointer, codes::HISTORY_SETTING, message).help(help);
        Err(Box::new(resource.environment.told(diagnostic)))
    };
    match &resource.kind {
        ResourceKind::Texture(texture) => {
            let at = "/texture/initial";
            let value =
                texture.initial.as_ref().and_then(|initial| resolved.sizes.value_of(resource, initial, at));
            let Some(value) = value else { return Ok(None) };
            let is_depth =
                resolved.texture(handle).is_some_and(|texture| texture.format.is_depth_stencil_format());
            match (value.numbers().as_deref(), &value) {
                (_, Value::Number(depth)) if is_depth && (0.0..=1.0).contains(depth) => {
                    Ok(Some(InitialValue::Depth(*depth)))
                }
                (Some(_), _) if is_depth => {
                    let message =
                        format!("the initial depth of \"{}\" is not between 0 and 1", resource.name);
                    reject(at, message, "write one number, such as 1")
                }
                (_, Value::Number(number)) => Ok(Some(InitialValue::Color([*number; 4]))),
                (Some([r, g, b, a]), _) => Ok(Some(InitialValue::Color([*r, *g, *b, *a]))),
                _ => {
                    let message = format!("the initial value of \"{}\" is not a color", resource.name);
                    reject(at, message, "write one number for all channels, or [red, green, blue, alpha]")
                }
            }
        }
        ResourceKind::Buffer(buffer) => {
            let Some(initial) = &buffer.initial else { return Ok(None) };
            let (expr, at, component) = match initial {
                WordValue::F32(expr) => (expr, "/buffer/initial/f32", Component::F32),
                WordValue::U32(expr) => (expr, "/buffer/initial/u32", Component::U32),
                WordValue::I32(expr) => (expr, "/buffer/initial/i32", Component::I32),
            };
            let Some(number) = resolved.sizes.number(resource, expr, at) else { return Ok(None) };
            match to_word(number, component) {
                Some(bits) => Ok(Some(InitialValue::Word(bits))),
                None => {
                    let message =
                        format!("{number} is no initial value of this type for \"{}\"", resource.name);
                    reject(at, message, "four bytes hold an f32, a u32 or an i32")
                }
            }
        }
        ResourceKind::Data(_) | ResourceKind::Broken => Ok(None),
    }
}

/// Warns about histories that no pass writes, or of which no pass reads an earlier frame.
pub(crate) fn check_use(pipeline: &TypedPipeline, diagnostics: &mut Diagnostics) {
    let (mut written, mut read_back) = (HashSet::new(), HashSet::new());
    for one in pipeline.passes.iter().flat_map(Pass::accesses) {
        let Some(history) = pipeline.resource(one.resource).history else { continue };
        if history.back > 0 {
            read_back.insert(history.of);
        } else if one.usage.writes() {
            written.insert(history.of);
        }
    }
    for handle in pipeline.resource_handles() {
        let resource = pipeline.resource(handle);
        if resource.history.is_none_or(|history| history.back > 0) || pipeline.uncertain.contains(&handle) {
            continue;
        }
        let warning = |message: String| {
            Diagnostic::warning(codes::HISTORY_UNUSED, resource.place, message).pointer(&resource.pointer)
        };
        let name = &resource.name;
        if !written.contains(&handle) {
            let message = format!("no pass writes the history \"{name}\"");
            diagnostics
                .push(warning(message).help("let a pass write it, or it is its initial value forever"));
        } else if !read_back.contains(&handle) {
            let message = format!("no pass reads the history \"{name}\" frames back");
            let help = format!("read \"{name}@-1\", or leave \"lifetime\" away");
            diagnostics.push(warning(message).help(help));
        }
    }
}
