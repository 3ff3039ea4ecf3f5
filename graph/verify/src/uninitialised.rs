//! Reads of regions that no pass writes.
//!
//! In plan order, the check collects for each region when it is written: always, or while a toggle has one value. Each
//! region of a read must be written in some state in which the read happens. Memory that is kept over frames, or that
//! the host owns, always has contents. The sizes and formats of the plan define the regions.
//!
//! Cost: linear in the regions of accesses.

use std::collections::BTreeSet;

use crate::regions::{Regions, Uses};
use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::PlannedResource;
use umbragraph_pipeline::language::{Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::Condition;

/// The toggle states in which earlier passes wrote a region: always, or while one of a set of conditions holds.
#[derive(Clone, Default)]
struct Written {
    always: bool,
    while_switched: BTreeSet<Condition>,
}

/// Reports reads of one resource of which some regions were written, but others in no toggle state.
pub(crate) fn check(uses: &Uses<'_>, violations: &mut Violations) {
    let Uses { plan, handle, regions, .. } = uses;
    let resource = plan.pipeline.resource(*handle);
    let own_memory = match resource.declared_lifetime() {
        Lifetime::Transient => true,
        Lifetime::History => resource.history.is_some_and(|history| history.back == 0),
        Lifetime::Persistent | Lifetime::Imported => false,
    };
    let Some(planned) = plan.resource(*handle).filter(|_| own_memory && regions.count() > 1) else { return };
    let volume = resource.texture().is_some_and(|texture| texture.view_dimension == Some(TextureShape::D3));
    let mut written = vec![Written::default(); regions.count()];
    for accesses in uses.planned().chunk_by(|a, b| a.pass == b.pass) {
        for event in
            accesses.iter().filter(|event| event.one.usage.reads() && !event.one.usage.keeps_what_is_there())
        {
            let known: Vec<Condition> = uses.conditions(event).collect();
            if known.iter().any(|one| known.contains(&one.opposite())) {
                continue;
            }
            let is_written = |region: &usize| {
                let Written { always, while_switched } = &written[*region];
                *always || while_switched.iter().any(|one| !known.contains(&one.opposite()))
            };
            let missing = |region: &&usize| !is_written(region) && exists(planned, volume, regions, **region);
            // What finds nothing at all is found where the frame is played.
            if event.regions.iter().any(is_written) && event.regions.iter().any(|region| missing(&region)) {
                let (pass, name) = (&plan.pipeline.pass(event.pass).name, &resource.name);
                let message =
                    format!("\"{pass}\" reads a subresource range of \"{name}\" that nothing has written");
                violations.add(Kind::UninitialisedRead, message);
            }
        }
        for event in accesses.iter().filter(|event| event.one.usage.writes()) {
            for region in &event.regions {
                match plan.pipeline.pass(event.pass).condition {
                    None => written[*region].always = true,
                    Some(condition) => _ = written[*region].while_switched.insert(condition),
                }
            }
        }
    }
}

/// Returns `true` if a texture or buffer has at least a part of a region.
fn exists(planned: &PlannedResource, volume: bool, regions: &Regions, region: usize) -> bool {
    let pieces = regions.pieces(region);
    let Some(size) = planned.size else {
        return pieces[3].iter().any(|(first, end)| *first < planned.bytes.min(*end));
    };
    let aspects = planned.format.map_or((0, 2), |format| {
        match (format.has_depth_aspect(), format.has_stencil_aspect()) {
            (true, false) => (0, 1),
            (false, true) => (1, 2),
            _ => (0, 2),
        }
    });
    let has_aspect = pieces[2].iter().any(|(first, end)| (*first).max(aspects.0) < aspects.1.min(*end));
    let mips = pieces[0].iter().filter(|(first, end)| *first < u64::from(size.mips).min(*end));
    // Of a volume the first of these mips has the maximum number of slices.
    let layers =
        mips.map(|(first, _)| if volume { (size.layers >> (*first).min(31)).max(1) } else { size.layers });
    let max = u64::from(layers.max().unwrap_or(0));
    has_aspect && pieces[1].iter().any(|(first, end)| *first < max.min(*end))
}
