//! Properties that hold for every valid pipeline, tried on random ones.
//!
//! A random pipeline is made so that it is valid: passes come in an order of their own, each overwrites resources or
//! updates them after the last writer, and reads what is written before it (all of it, or one mip), a named older
//! version, or an earlier frame of a history, which may be one that it writes itself. Some leave a buffer to a later
//! pass, of bytes that follow the viewport.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use proptest::prelude::*;
use umbragraph_test_support::property;

use crate::verify;
use umbragraph_compiler::{Assembly, Objective, Plan, PlanOptions, build, plan};
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::language::{Expr, FormatCandidates, Lifetime, TextureDeclaration};
use umbragraph_pipeline::pipeline::{SubresourceRange, TypedPipeline, Usage, Version};
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::{LoadOperation, PassHandle, ResourceHandle};

/// A random pass; `reads` and `writes` are numbers of resources, modulo the resource count.
#[derive(Clone, Debug)]
struct RandomPass {
    reads: Vec<usize>,
    writes: usize,
    range: Option<u32>,
    action: u8,
    side_effect: bool,
    /// A buffer that a later pass reads; `None` for no buffer. The values are a quarter of its bytes at a viewport
    /// width of 64, and the distance to the reader in passes.
    scratch: Option<(u32, usize)>,
}

fn passes() -> impl Strategy<Value = Vec<RandomPass>> {
    let one = (
        proptest::collection::vec(0usize..100, 0..4),
        0usize..100,
        proptest::option::of(0u32..3),
        0u8..4,
        0u8..12,
        proptest::option::of((1u32..40, 1usize..6)),
    )
        .prop_map(|(reads, writes, range, action, effect, scratch)| RandomPass {
            reads,
            writes,
            range,
            action,
            side_effect: effect == 0,
            scratch,
        });
    proptest::collection::vec(one, 1..40)
}

/// The writes to a resource so far: the last writer, the written mips (`None` for all), and the names of the writers.
#[derive(Default)]
struct Written {
    last: Option<PassHandle>,
    ranges: BTreeMap<Option<u32>, ()>,
    /// Whether mip 0 and layer 0 were drawn to.
    drawn: bool,
    names: Vec<String>,
}

impl Written {
    /// Returns the largest written range that one access can read, for any number of layers; `None` if nothing is
    /// written.
    fn readable(&self) -> Option<SubresourceRange> {
        let is_written = |mip: u32| self.ranges.contains_key(&None) || self.ranges.contains_key(&Some(mip));
        if (0..3).all(is_written) {
            return Some(SubresourceRange::WHOLE);
        }
        let mip = (0..3).find(|mip| is_written(*mip)).map(|mip| SubresourceRange::of(Some(mip), None));
        mip.or_else(|| self.drawn.then(|| SubresourceRange::of(Some(0), Some(0))))
    }
}

/// Plans a valid pipeline of random passes over `count` resources.
fn planned(passes: &[RandomPass], count: usize, options: &PlanOptions) -> Plan {
    with_unrelated(passes, count, options, None)
}

/// Plans a random pipeline with one further pass that shares no resource with the others. `unrelated` is the position
/// of this pass, and whether it has a side effect; `None` for no such pass.
fn with_unrelated(
    passes: &[RandomPass],
    count: usize,
    options: &PlanOptions,
    unrelated: Option<(usize, bool)>,
) -> Plan {
    let (pipeline, sources) = pipeline(passes, count, unrelated);
    let mut diagnostics = Diagnostics::new();
    let planned = build(&pipeline, &mut diagnostics)
        .and_then(|graph| plan(&pipeline, &graph, options, &sources, &mut diagnostics));
    planned.unwrap_or_else(|| panic!("{diagnostics:#?}"))
}

/// Makes a valid pipeline of random passes over `count` resources.
fn pipeline(
    passes: &[RandomPass],
    count: usize,
    unrelated: Option<(usize, bool)>,
) -> (Arc<TypedPipeline>, Sources) {
    let mut assembly = Assembly::new("random");
    let resources: Vec<ResourceHandle> = (0..count)
        .map(|at| {
            let describe = |texture: &mut TextureDeclaration| {
                texture.mips = Some(Expr::from(3.0));
                if at % 5 == 4 {
                    texture.layers = Some(Expr::from("=max(1, floor(viewport.width / 64))"));
                }
                texture.format = FormatCandidates::One(["rgba8unorm", "rgba16float"][at % 2].to_owned());
                if at % 7 == 6 {
                    texture.lifetime = Lifetime::Persistent;
                }
            };
            let name = format!("r{at}");
            if at % 4 == 3 {
                assembly.history_with(&name, 2, describe)
            } else {
                assembly.texture_with(&name, describe)
            }
        })
        .collect();
    let target = assembly.imported("target");
    let mut written: Vec<Written> = (0..count).map(|_| Written::default()).collect();
    let mut last_target = None;
    let scratch: Vec<Option<ResourceHandle>> = passes
        .iter()
        .enumerate()
        .map(|(at, random)| {
            let (quarter, _) = random.scratch?;
            let bytes = Expr::from(format!("=4 * ceil({quarter} * viewport.width / 64)").as_str());
            Some(assembly.sized_buffer(&format!("s{at}"), bytes, Lifetime::Transient))
        })
        .collect();
    let alone = unrelated.map(|_| assembly.sized_texture("alone", 7, 7));
    for (at, random) in passes.iter().enumerate() {
        if let (Some((_, effect)), Some(alone)) = (unrelated.filter(|(position, _)| *position == at), alone) {
            let pass = assembly.pass("unrelated").writes(alone);
            let _ = if effect { pass.side_effect() } else { pass };
        }
        let own = random.writes % count;
        let earlier: BTreeSet<ResourceHandle> = random
            .reads
            .iter()
            .filter(|resource| (*resource % count) % 4 == 3)
            .map(|resource| assembly.earlier(resources[resource % count], 1 + (*resource / count % 2) as u32))
            .collect();
        let mut pass = assembly.pass(&format!("p{at}"));
        let handle = pass.handle();
        let mut read: Vec<(ResourceHandle, SubresourceRange, Version)> = Vec::new();
        for resource in &random.reads {
            let resource = resource % count;
            if resource == own
                || written[resource].names.is_empty()
                || read.iter().any(|(known, ..)| *known == resources[resource])
            {
                continue;
            }
            // The version is named, since later passes may write on.
            let Some(name) = written[resource].names.last() else { continue };
            let Some(range) = written[resource].readable() else { continue };
            read.push((resources[resource], range, Version::WrittenBy(name.clone())));
        }
        for resource in earlier {
            pass = pass.reads(resource);
        }
        for (resource, range, version) in read {
            pass = pass.accesses(resource, range, Usage::Sampled, version);
        }
        if let Some(own) = scratch[at] {
            pass = pass.accesses(own, SubresourceRange::WHOLE, Usage::StorageReplace, Version::Newest);
        }
        for (back, earlier) in passes[..at].iter().rev().enumerate() {
            if let (Some((_, later)), Some(left)) = (earlier.scratch, scratch[at - 1 - back])
                && later == back + 1
            {
                pass = pass.accesses(left, SubresourceRange::WHOLE, Usage::StorageRead, Version::Newest);
            }
        }
        let state = &mut written[own];
        if let Some(last) = state.last {
            pass = pass.after(last);
        }
        state.last = Some(handle);
        let updates = random.action == 1 && state.ranges.contains_key(&None);
        let range = SubresourceRange::of(random.range, None);
        if updates {
            pass = pass.accesses(
                resources[own],
                SubresourceRange::WHOLE,
                Usage::StorageReadWrite,
                Version::Newest,
            );
        } else if random.action == 2 {
            pass = pass.color(resources[own], LoadOperation::Clear([0.0; 4]));
            state.drawn = true;
        } else {
            let replaces = random.reads.len() % 2 == 0;
            let usage = if replaces { Usage::StorageReplace } else { Usage::StorageWrite };
            pass = pass.accesses(resources[own], range, usage, Version::Newest);
            state.ranges.insert(random.range, ());
        }
        state.names.push(format!("p{at}"));
        if random.side_effect {
            pass = pass.side_effect();
        }
        if random.action == 3 {
            if let Some(last) = last_target {
                pass = pass.after(last);
            }
            pass.writes(target);
            last_target = Some(handle);
        }
    }
    let mut end = assembly.pass("end").side_effect();
    if let Some(last) = last_target {
        end = end.after(last);
    }
    for (at, state) in written.iter().enumerate().take(2) {
        if let Some(range) = state.readable() {
            end = end.reads_range(resources[at], range);
        }
    }
    let _ = end;
    assembly.finish()
}

fn options(objective: Objective, aliasing: bool) -> PlanOptions {
    PlanOptions::new(64, 64).objective(objective).aliasing(aliasing)
}

proptest! {
    #![proptest_config(property::config(128))]

    #[test]
    fn every_plan_of_every_objective_passes_the_checker(passes in passes(), count in 1usize..9) {
        for objective in Objective::ALL {
            for aliasing in [true, false] {
                let options = options(objective, aliasing);
                let plan = planned(&passes, count, &options);
                prop_assert_eq!(verify(&plan, &options), Vec::new());
            }
        }
    }

    #[test]
    fn aliasing_meets_its_bound_and_memory_order_is_never_worse(
        passes in passes(), count in 1usize..9, buffers in any::<bool>()
    ) {
        let mut passes = passes;
        for pass in passes.iter_mut().filter(|_| !buffers) {
            pass.scratch = None;
        }
        let plans = Objective::ALL.map(|objective| planned(&passes, count, &options(objective, true)));
        for plan in &plans {
            if buffers {
                prop_assert!(plan.bytes_bound <= plan.bytes && plan.bytes <= 2 * plan.bytes_bound);
            } else {
                prop_assert_eq!(plan.bytes, plan.bytes_bound);
            }
            prop_assert!(plan.bytes_peak <= plan.bytes_bound && plan.bytes <= plan.bytes_without_aliasing);
            let apart = planned(&passes, count, &options(plan.order.objective, false));
            prop_assert!(plan.bytes <= apart.bytes);
        }
        prop_assert!(plans[1].bytes <= plans[0].bytes);
        let memory = plans[1].order.memory.expect("a report");
        prop_assert_eq!(memory.chosen, plans[1].bytes);
        prop_assert!(memory.bound <= memory.chosen && memory.chosen <= memory.declaration);
        let groups = |plan: &Plan| plan.passes.last().map_or(0, |last| last.group);
        prop_assert!(groups(&plans[2]) <= groups(&plans[0]));
    }

    #[test]
    fn a_plan_resized_is_the_plan_made_from_scratch(
        passes in passes(), count in 1usize..9, sizes in proptest::collection::vec((1u32..300, 1u32..300), 1..4)
    ) {
        let (pipeline, sources) = pipeline(&passes, count, None);
        let graph = build(&pipeline, &mut Diagnostics::new()).expect("a graph");
        for objective in Objective::ALL {
            let scratch = |options: &PlanOptions| {
                let mut diagnostics = Diagnostics::new();
                plan(&pipeline, &graph, options, &sources, &mut diagnostics).ok_or(diagnostics)
            };
            let mut resized = scratch(&options(objective, true)).expect("a plan");
            for (width, height) in &sizes {
                let options = PlanOptions::new(*width, *height).objective(objective);
                match (resized.resized(&graph, &options, &sources), scratch(&options)) {
                    (Ok(again), Ok(scratch)) => {
                        let json = |plan: &Plan| serde_json::to_string(plan).expect("text");
                        prop_assert_eq!(json(&again), json(&scratch));
                        prop_assert_eq!(verify(&again, &options), Vec::new());
                        resized = again;
                    }
                    (Err(again), Err(scratch)) => {
                        let words = |diagnostics: &Diagnostics| -> Vec<String> {
                            diagnostics.iter().map(|one| format!("{one:?}")).collect()
                        };
                        prop_assert_eq!(words(&again), words(&scratch));
                    }
                    (again, scratch) => prop_assert!(false, "{:?} {:?}", again.err(), scratch.err()),
                }
            }
        }
    }

    #[test]
    fn an_unrelated_pass_changes_nothing_about_the_others(
        passes in passes(), count in 1usize..9, position in 0usize..40, effect in any::<bool>()
    ) {
        let options = options(Objective::Declaration, true);
        let before = planned(&passes, count, &options);
        let after = with_unrelated(&passes, count, &options, Some((position % passes.len(), effect)));
        let names = |plan: &Plan| -> Vec<String> {
            plan.passes.iter().map(|pass| pass.name.clone()).filter(|name| name != "unrelated").collect()
        };
        prop_assert_eq!(names(&before), names(&after));
        prop_assert_eq!(after.passes.len() - before.passes.len(), usize::from(effect));
        let extra = if effect { 7 * 7 * 4 } else { 0 };
        prop_assert_eq!(before.bytes + extra, after.bytes);
    }
}
