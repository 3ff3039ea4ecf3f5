//! Whether the frames of a history are apart from one another and from everything else, and of one kind.
//!
//! A history that some planned pass uses, at whichever frame, has one place more than it keeps earlier frames, all of
//! them different and of one descriptor, so that each can become the next; where a pass uses a frame, the resource that
//! it names stands at that frame's place. Clearing needs usages of its own.

use std::collections::{BTreeMap, BTreeSet};

use wgpu_types::{BufferUsages, TextureUsages};

use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::{InitialValue, Physical, Plan};
use umbragraph_pipeline::pipeline::ResourceKind;
use umbragraph_pipeline::work::ResourceHandle;

/// Checks the histories; returns their physical textures and buffers that no planned resource uses.
pub(crate) fn check(plan: &Plan, violations: &mut Violations) -> BTreeSet<Physical> {
    let pipeline = &plan.pipeline;
    let mut used: BTreeSet<ResourceHandle> = BTreeSet::new();
    for one in plan.passes.iter().flat_map(|planned| pipeline.pass(planned.handle).accesses()) {
        used.extend(pipeline.resource(one.resource).history.map(|history| history.of));
    }
    for handle in &used {
        let name = &pipeline.resource(*handle).name;
        if plan.histories.get(name).is_none_or(|history| history.handle != *handle) {
            violations.add(Kind::HistoryWrong, format!("the history \"{name}\" is used but not planned"));
        }
    }
    let mut owners: BTreeMap<Physical, &str> = BTreeMap::new();
    let mut wrong = |message: String| violations.add(Kind::HistoryWrong, message);
    for (name, history) in &plan.histories {
        let declared = pipeline.resources.get(history.handle.index()).filter(|one| one.name == *name);
        let Some(declared) = declared.filter(|_| used.contains(&history.handle)) else {
            wrong(format!("\"{name}\" is planned as a history, but is none in use"));
            continue;
        };
        let frames = declared.history.map_or(0, |history| history.frames as usize);
        if history.places.len() != frames + 1 {
            let places = history.places.len();
            wrong(format!("\"{name}\" keeps {frames} frames, but takes turns at {places} places"));
        }
        for (back, place) in history.places.iter().enumerate() {
            if owners.insert(*place, name).is_some() {
                wrong(format!("two frames of histories stand at {place:?}, one of them of \"{name}\""));
            }
            let member = if back == 0 { name.clone() } else { format!("{name}@-{back}") };
            if plan.resources.get(&member).is_some_and(|planned| planned.physical != *place) {
                wrong(format!("\"{member}\" does not stand where the frames of \"{name}\" take turns"));
            }
        }
        if !alike(plan, &history.places) {
            wrong(format!("the frames of \"{name}\" differ, so that they cannot take turns"));
        }
        let fits = match (&declared.kind, history.initial, history.places.first()) {
            (ResourceKind::Texture(_), InitialValue::Color(_), Some(Physical::Texture(at))) => {
                plan.textures.get(*at).is_some_and(|texture| !texture.format.is_depth_stencil_format())
            }
            (ResourceKind::Texture(_), InitialValue::Depth(depth), Some(Physical::Texture(at))) => {
                let is_depth =
                    plan.textures.get(*at).is_some_and(|texture| texture.format.is_depth_stencil_format());
                is_depth && (0.0..=1.0).contains(&depth)
            }
            (ResourceKind::Buffer(_), InitialValue::Word(_), Some(Physical::Buffer(_))) => true,
            _ => false,
        };
        if !fits {
            wrong(format!("\"{name}\" cannot begin with {:?}", history.initial));
        }
    }
    for (name, planned) in &plan.resources {
        let of = pipeline.resources.get(planned.handle.index()).and_then(|resource| resource.history);
        let own =
            of.and_then(|history| pipeline.resources.get(history.of.index())).map(|one| one.name.as_str());
        if let Some(owner) = owners.get(&planned.physical).filter(|owner| own != Some(**owner)) {
            let message = format!("\"{name}\" stands where the frames of \"{owner}\" take turns");
            violations.add(Kind::SharedThoughLasting, message);
        }
    }
    let taken: BTreeSet<Physical> = plan.resources.values().map(|planned| planned.physical).collect();
    owners.into_keys().filter(|place| !taken.contains(place)).collect()
}

/// Returns `true` if all physical textures or buffers have equal descriptors with the usage that clearing needs.
fn alike(plan: &Plan, places: &[Physical]) -> bool {
    let texture = |place: &Physical| match place {
        Physical::Texture(at) => plan.textures.get(*at),
        _ => None,
    };
    let buffer = |place: &Physical| match place {
        Physical::Buffer(at) => plan.buffers.get(*at),
        _ => None,
    };
    let Some(first) = places.first() else { return false };
    places.iter().all(|place| match (texture(first), texture(place), buffer(first), buffer(place)) {
        (Some(a), Some(b), ..) => {
            (a.format, a.size, a.volume, a.usages, a.bytes) == (b.format, b.size, b.volume, b.usages, b.bytes)
                && b.usages.contains(TextureUsages::RENDER_ATTACHMENT)
        }
        (_, _, Some(a), Some(b)) => {
            (a.bytes, a.usages) == (b.bytes, b.usages) && b.usages.contains(BufferUsages::COPY_DST)
        }
        _ => false,
    })
}
