//! Random pipelines with toggles: their plans pass the checker, which plays every state through.
//!
//! Each resource has a first writer of everything that always runs, or several that each write some of its mips, so
//! that whatever is toggled above them leaves something; others write and read ranges of mips, and clear the picture or
//! draw over it. Effects with a passthrough are the exception: what they write nobody else does.

use proptest::prelude::*;
use umbragraph_test_support::property;

use crate::verify;
use umbragraph_compiler::{Assembly, Objective, Plan, PlanOptions, build, plan};
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::pipeline::{Condition, IndexRange, SubresourceRange, Usage, Version};
use umbragraph_pipeline::work::{LoadOperation, PassHandle, ResourceHandle};

const TOGGLES: usize = 3;

/// The choices of initial writers of a resource: one pass for each range of mips, or `None` for all mips.
const BEGINNINGS: [&[Option<IndexRange<u32>>]; 4] = [
    &[None],
    &[Some(IndexRange { first: 0, count: 1 }), Some(IndexRange { first: 1, count: 2 })],
    &[Some(IndexRange { first: 1, count: 2 }), Some(IndexRange { first: 0, count: 1 })],
    &[
        Some(IndexRange { first: 2, count: 1 }),
        Some(IndexRange { first: 0, count: 1 }),
        Some(IndexRange { first: 1, count: 1 }),
    ],
];

/// A random pass; `reads` and `own` are numbers of resources, modulo the resource count.
#[derive(Clone, Debug)]
struct RandomPass {
    reads: Vec<usize>,
    own: usize,
    action: u8,
    toggle: Option<(usize, bool)>,
    /// The first mip and the number of mips that the pass accesses; `None` for all.
    mips: Option<(u32, u32)>,
}

fn passes() -> impl Strategy<Value = Vec<RandomPass>> {
    let toggle = proptest::option::of((0..TOGGLES, any::<bool>()));
    let mips = proptest::option::of((0u32..3, 1u32..3));
    let one = (proptest::collection::vec(0usize..100, 0..3), 0usize..100, 0u8..6, toggle, mips)
        .prop_map(|(reads, own, action, toggle, mips)| RandomPass { reads, own, action, toggle, mips });
    proptest::collection::vec(one, 1..20)
}

/// Plans random passes over resources whose initial writers are indices into [`BEGINNINGS`].
fn planned(passes: &[RandomPass], beginnings: &[usize], options: &PlanOptions) -> Plan {
    let count = beginnings.len();
    let mut assembly = Assembly::new("random");
    let textures: Vec<ResourceHandle> = (0..count)
        .map(|at| assembly.texture_with(&format!("r{at}"), |texture| texture.mips = Some(Expr::from(3.0))))
        .collect();
    let target = assembly.imported("target");
    for at in 0..TOGGLES {
        assembly.toggle(&format!("t{at}"));
    }
    let mut last: Vec<(PassHandle, String)> = Vec::new();
    for (at, texture) in textures.iter().enumerate() {
        let mut begun: Option<(PassHandle, String)> = None;
        for (piece, mip) in BEGINNINGS[beginnings[at]].iter().enumerate() {
            let name = format!("begin{at}.{piece}");
            let mut pass = assembly.pass(&name);
            if let Some((before, _)) = begun {
                pass = pass.after(before);
            }
            let handle = pass.handle();
            let _ = pass.writes_range(*texture, SubresourceRange { mip: *mip, ..SubresourceRange::WHOLE });
            begun = Some((handle, name));
        }
        last.extend(begun);
    }
    let mut last_target = assembly.pass("background").color(target, LoadOperation::Clear([0.0; 4])).handle();
    for (at, random) in passes.iter().enumerate() {
        let own = random.own % count;
        let name = format!("p{at}");
        let (before, version) = last[own].clone();
        if random.action == 5 {
            // The picture again, or more of it.
            let version = Version::WrittenBy(version);
            let pass = assembly.pass(&name).accesses(
                textures[own],
                SubresourceRange::WHOLE,
                Usage::Sampled,
                version,
            );
            let mut pass = pass.after(last_target);
            last_target = pass.handle();
            if let Some((toggle, on)) = random.toggle {
                pass = pass.toggle(toggle, on);
            }
            let is_cleared = random.mips.is_none();
            let _ = pass
                .color(target, if is_cleared { LoadOperation::Clear([0.0; 4]) } else { LoadOperation::Load });
            continue;
        }
        if random.action >= 3 {
            let (toggle, on) = random.toggle.unwrap_or((0, true));
            let effect = assembly.texture(&format!("x{at}"));
            let from = Version::WrittenBy(version);
            let pass = assembly.pass(&name).toggle(toggle, on);
            let _ = pass
                .accesses(textures[own], SubresourceRange::WHOLE, Usage::Sampled, from.clone())
                .writes(effect);
            let mut seen = effect;
            assembly.passthrough(effect, textures[own], from, Condition { toggle, on });
            if random.action == 4 {
                // A second effect on the first, with another toggle.
                let toggle = (toggle + 1) % TOGGLES;
                seen = assembly.texture(&format!("y{at}"));
                let _ = assembly.pass(&format!("q{at}")).reads(effect).writes(seen).toggle(toggle, !on);
                assembly.passthrough(seen, effect, Version::Newest, Condition { toggle, on: !on });
            }
            let reader = assembly.pass(&format!("c{at}")).reads(seen).after(last_target);
            last_target = reader.color(target, LoadOperation::Load).handle();
            continue;
        }
        let range = random.mips.map_or(SubresourceRange::WHOLE, |(first, count)| SubresourceRange {
            mip: Some(IndexRange { first, count: count.min(3 - first) }),
            ..SubresourceRange::WHOLE
        });
        let mut pass = assembly.pass(&name).after(before);
        let handle = pass.handle();
        let mut read = vec![own];
        for other in &random.reads {
            let other = other % count;
            if !read.contains(&other) {
                read.push(other);
                let version = Version::WrittenBy(last[other].1.clone());
                pass = pass.accesses(textures[other], range, Usage::Sampled, version);
            }
        }
        if let Some((toggle, on)) = random.toggle {
            pass = pass.toggle(toggle, on);
        }
        let _ = match random.action {
            0 => pass.writes_range(textures[own], range),
            1 => pass.accesses(textures[own], range, Usage::StorageReadWrite, Version::Newest),
            _ => pass.color(textures[own], LoadOperation::Clear([0.0; 4])),
        };
        last[own] = (handle, name);
    }
    let mut end = assembly.pass("end").side_effect().after(last_target);
    for texture in &textures {
        end = end.reads(*texture);
    }
    let _ = end;
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let planned = build(&pipeline, &mut diagnostics)
        .and_then(|graph| plan(&pipeline, &graph, options, &sources, &mut diagnostics));
    planned.unwrap_or_else(|| panic!("{diagnostics:#?}"))
}

proptest! {
    #![proptest_config(property::config(256))]

    #[test]
    fn every_plan_with_toggles_passes_the_checker_in_every_state(
        passes in passes(), beginnings in proptest::collection::vec(0..BEGINNINGS.len(), 1..5)
    ) {
        for objective in Objective::ALL {
            for aliasing in [true, false] {
                let options = PlanOptions::new(64, 64).objective(objective).aliasing(aliasing);
                let plan = planned(&passes, &beginnings, &options);
                let violations = verify(&plan, &options);
                prop_assert_eq!(violations, Vec::new());
                prop_assert_eq!(plan.bytes, plan.bytes_bound);
            }
        }
    }
}
