//! Resources of which earlier frames can be read.
//!
//! A resource `color` with `"lifetime": "history"` and two frames is three resources to everything after this file:
//! `color`, which this frame writes, and `color@-1` and `color@-2`, which nothing writes and which hold what the last
//! frames left. So a read of an earlier frame waits for no writer of this one, and no writer for it. What ties the
//! three together is their [`History`]: one format and size, copies that take turns, and that a pass that reads an
//! earlier frame keeps those alive that write this one.

use crate::pipeline::resource::{History, Resource, ResourceKind};
use crate::pipeline::resources::value;
use crate::pipeline::state::shared::Shared;
use crate::whole_number::whole_number;
use crate::work::ResourceHandle;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_text::language::{Expr, Lifetime};

/// The maximum number of earlier frames that a history can keep.
pub(crate) const MAX_FRAMES: u32 = 8;

/// Adds a declared resource, and one resource for each earlier frame that can be read.
pub(crate) fn add(shared: &mut Shared, mut resource: Resource) {
    let (lifetime, frames, has_initial, section) = match &resource.kind {
        ResourceKind::Texture(texture) => {
            (texture.lifetime, texture.frames.as_ref(), texture.initial.is_some(), "/texture")
        }
        ResourceKind::Buffer(buffer) => {
            (buffer.lifetime, buffer.frames.as_ref(), buffer.initial.is_some(), "/buffer")
        }
        ResourceKind::Data(_) | ResourceKind::Broken => {
            shared.add_resource(resource);
            return;
        }
    };
    let mut diagnostics = Diagnostics::new();
    if lifetime != Lifetime::History {
        for (what, stands) in [("frames", frames.is_some()), ("initial", has_initial)] {
            if stands {
                let message = format!("\"{}\" has \"{what}\", but no history", resource.name);
                let help = "add \"lifetime\": \"history\", or remove it";
                let at = format!("{section}/{what}");
                diagnostics.push(resource.error_at(&at, codes::HISTORY_SETTING, message).help(help));
            }
        }
    } else {
        if !has_initial {
            let message = format!("the history \"{}\" has no initial value", resource.name);
            let help = if section == "/texture" {
                "add \"initial\", such as [0, 0, 0, 1], or 1 for depth"
            } else {
                "add \"initial\", such as { \"f32\": 0 }"
            };
            diagnostics.push(resource.error_at(section, codes::HISTORY_INITIAL, message).help(help));
        }
        let at = format!("{section}/frames");
        let frames = frames.map_or(Ok(1), |frames| count(shared, &resource, frames, &at));
        // After a diagnostic as many as there can be, so that no read of them is one more.
        let frames = frames.unwrap_or_else(|diagnostic| {
            diagnostics.extend(diagnostic.map(|diagnostic| *diagnostic));
            MAX_FRAMES
        });
        let of = ResourceHandle(shared.resources.len() as u32);
        resource.history = Some(History { of, back: 0, frames });
    }
    // Of what is a history by half, nothing more is said.
    if lifetime != Lifetime::History && !diagnostics.is_empty() {
        resource.kind = ResourceKind::Broken;
    }
    let environment = resource.environment.clone();
    shared.report_from(diagnostics, &environment);
    let history = resource.history;
    let earlier: Vec<Resource> = (1..=history.map_or(0, |history| history.frames))
        .map(|back| Resource {
            name: format!("{}@-{back}", resource.name),
            history: history.map(|history| History { back, ..history }),
            ..resource.clone()
        })
        .collect();
    shared.add_resource(resource);
    for earlier in earlier {
        shared.add_resource(earlier);
    }
}

/// Evaluates the number of earlier frames of a history.
///
/// # Errors
/// Returns a diagnostic, or `None` if the error only follows from another diagnostic.
fn count(
    shared: &Shared,
    resource: &Resource,
    frames: &Expr,
    at: &str,
) -> Result<u32, Option<Box<Diagnostic>>> {
    let value = value::value(shared, resource, frames, at)?;
    whole_number(&value, 1..=MAX_FRAMES).ok_or_else(|| {
        let found = value.number().map_or_else(|| value.kind_name().to_owned(), |number| number.to_string());
        let message = format!("the number of earlier frames of \"{}\" is {found}", resource.name);
        let help = format!("1 to {MAX_FRAMES} are possible");
        Some(Box::new(resource.error_at(at, codes::HISTORY_SETTING, message).help(help)))
    })
}

/// The message and the help for reading an earlier frame that a resource does not keep.
pub(crate) fn beyond(shared: &Shared, handle: ResourceHandle, back: u32) -> (String, String) {
    let resource = &shared.resources[handle.index()];
    let name = &resource.name;
    match resource.history {
        Some(History { frames, .. }) => {
            let message = format!("\"{name}\" is read {back} frames back, but keeps {frames}");
            let help = if back <= MAX_FRAMES {
                format!("declare \"{name}\" with \"frames\": {back}")
            } else {
                format!("{MAX_FRAMES} frames are possible")
            };
            (message, help)
        }
        None => {
            let message = format!("\"{name}\" keeps no earlier frames");
            (message, format!("declare \"{name}\" with \"lifetime\": \"history\" and an \"initial\" value"))
        }
    }
}

/// The resource of an earlier frame, `back` frames ago; `None` if the resource does not keep that many.
pub(crate) fn earlier(shared: &Shared, handle: ResourceHandle, back: u32) -> Option<ResourceHandle> {
    let history = shared.resources[handle.index()].history?;
    history.members().nth(back as usize)
}
