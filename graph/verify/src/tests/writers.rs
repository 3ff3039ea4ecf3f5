//! Very many writers of ranges of one resource, with and without toggles.

use std::collections::{BTreeSet, HashMap};

use proptest::prelude::*;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::verify;
use umbragraph_compiler::{Assembly, Graph, KeepReason, Plan, PlanOptions, build, plan};
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{SubresourceRange, Usage, Version};

/// A writer of a range of bytes.
#[derive(Clone, Debug)]
struct Writer {
    /// The first word and the number of words, of four bytes each.
    range: (u64, u64),
    toggle: Option<(usize, bool)>,
    loads: bool,
}

/// Plans a pass that fills a buffer of `words` words, the writers in order, and a pass that reads the words `read`.
fn planned(writers: &[Writer], toggles: usize, words: u64, read: (u64, u64)) -> (Graph, Plan) {
    let mut assembly = Assembly::new("writers");
    let buffer = assembly.buffer("a", words as u32 * 4, Lifetime::Transient);
    for at in 0..toggles {
        assembly.toggle(&format!("t{at:05}"));
    }
    let bytes = |range: (u64, u64)| SubresourceRange::bytes(range.0 * 4, range.1 * 4);
    let mut last = assembly.pass("begin").writes(buffer).handle();
    for (at, writer) in writers.iter().enumerate() {
        let mut pass = assembly.pass(&format!("p{at:05}")).after(last);
        last = pass.handle();
        if let Some((toggle, on)) = writer.toggle {
            pass = pass.toggle(toggle, on);
        }
        let usage = if writer.loads { Usage::StorageReadWrite } else { Usage::StorageReplace };
        let _ = pass.accesses(buffer, bytes(writer.range), usage, Version::Newest);
    }
    let end = assembly.pass("end").after(last).side_effect();
    let _ = end.accesses(buffer, bytes(read), Usage::StorageRead, Version::Newest);
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).unwrap_or_else(|| panic!("{diagnostics:#?}"));
    let options = PlanOptions::new(64, 64);
    let planned = plan(&pipeline, &graph, &options, &sources, &mut diagnostics);
    (graph, planned.unwrap_or_else(|| panic!("{diagnostics:#?}")))
}

/// Returns the passes that the last pass depends on, found by simulating every toggle state word by word.
fn needed(writers: &[Writer], toggles: usize, words: u64, read: (u64, u64)) -> BTreeSet<String> {
    let mut feeds: HashMap<usize, BTreeSet<usize>> = HashMap::new();
    let end = writers.len() + 1;
    for state in 0..1usize << toggles {
        let mut content = vec![0; words as usize];
        let words = |range: (u64, u64)| range.0 as usize..(range.0 + range.1) as usize;
        for (at, writer) in writers.iter().enumerate() {
            if writer.toggle.is_some_and(|(toggle, on)| (state >> toggle & 1 == 1) != on) {
                continue;
            }
            let own = &mut content[words(writer.range)];
            if writer.loads {
                feeds.entry(at + 1).or_default().extend(own.iter().copied());
            }
            own.fill(at + 1);
        }
        feeds.entry(end).or_default().extend(&content[words(read)]);
    }
    let mut needed = BTreeSet::from([end]);
    let mut stack = vec![end];
    while let Some(one) = stack.pop() {
        for feeder in feeds.get(&one).into_iter().flatten() {
            if needed.insert(*feeder) {
                stack.push(*feeder);
            }
        }
    }
    let name = |at: usize| match at {
        0 => "begin".to_owned(),
        at if at == end => "end".to_owned(),
        at => format!("p{:05}", at - 1),
    };
    needed.into_iter().map(name).collect()
}

const WORDS: u64 = 8;
const TOGGLES: usize = 7;

fn range() -> impl Strategy<Value = (u64, u64)> {
    (0..WORDS, 1..WORDS).prop_map(|(first, count)| (first, count.min(WORDS - first)))
}

proptest! {
    #![proptest_config(property::config(512))]

    #[test]
    fn kept_writers_are_those_that_playing_every_state_finds(
        list in proptest::collection::vec(
            (range(), proptest::option::weighted(0.9, (0usize..TOGGLES, any::<bool>())), any::<bool>()), 1..40
        ),
        loads in 0u8..3,
        read in range(),
    ) {
        let writers: Vec<Writer> = list
            .into_iter()
            .map(|(range, toggle, either)| Writer { range, toggle, loads: loads == 0 || loads == 1 && either })
            .collect();
        let (graph, plan) = planned(&writers, TOGGLES, WORDS, read);
        let kept: BTreeSet<String> = plan.passes.iter().map(|pass| pass.name.clone()).collect();
        prop_assert_eq!(kept, needed(&writers, TOGGLES, WORDS, read));
        prop_assert_eq!(verify(&plan, &PlanOptions::new(64, 64)), Vec::new());
        prop_assert!(is_exact(&graph, &plan));
    }
}

/// Returns `true` if every read is connected to exactly the writers whose contents it reads.
fn is_exact(graph: &Graph, plan: &Plan) -> bool {
    let pipeline = &plan.pipeline;
    pipeline
        .pass_handles()
        .all(|pass| pipeline.resource_handles().all(|resource| !graph.is_coarse(pass, resource)))
}

/// Returns a function that makes pseudorandom numbers below its argument, from a fixed seed.
fn numbers() -> impl FnMut(u64) -> u64 {
    let mut random = Random(12345);
    move |end| random.below(end as usize) as u64
}

#[test]
fn five_thousand_toggled_writers_have_few_edges_each() {
    const COUNT: usize = 5000;
    let mut number = numbers();
    let words = 1 << 18;
    let mut writer = |_| {
        let first = number(words);
        let toggle = Some((number(8) as usize, number(2) == 0));
        Writer { range: (first, 1 + number(words - first)), toggle, loads: number(2) == 0 }
    };
    let writers: Vec<Writer> = (0..COUNT).map(&mut writer).collect();
    let (graph, plan) = planned(&writers, 8, words, (0, words));
    assert!(is_exact(&graph, &plan));
    assert!(graph.graph.edge_count() < 64 * COUNT, "{}", graph.graph.edge_count());
    assert!(plan.passes.len() > 100, "{}", plan.passes.len());
}

#[test]
fn a_load_over_a_write_of_its_toggle_passes_nothing_on() {
    let writer = |toggle: usize, loads: bool| Writer { range: (0, 1), toggle: Some((toggle, true)), loads };
    // The end sees the first write while all toggles are off; the two that load never do. The other sixteen are more
    // edges than the compiler shows of one kind.
    let mut writers = vec![writer(0, false), writer(1, false), writer(0, true), writer(1, true)];
    writers.extend((2..18).map(|toggle| writer(toggle, false)));
    let (graph, plan) = planned(&writers, 18, 1, (0, 1));
    assert!(is_exact(&graph, &plan) && plan.culled.is_empty(), "{:?}", plan.culled);
    // Where all load, the end leaves what was before to the first of them.
    let loading: Vec<Writer> = (0..18).map(|toggle| writer(toggle, true)).collect();
    let (graph, plan) = planned(&loading, 18, 1, (0, 1));
    let handle = |name: &str| plan.pipeline.find_pass(name).expect("a pass");
    assert!(graph.producers(handle("p00000")).any(|(writer, _)| writer == handle("begin")));
    assert!(graph.producers(handle("end")).all(|(writer, _)| writer != handle("begin")));
    assert!(plan.culled.is_empty(), "{:?}", plan.culled);
}

#[test]
fn more_ranges_than_are_told_apart_keep_more_and_say_so() {
    const COUNT: u64 = 1200;
    // Each writes words of its own with the one toggle. The two oldest write the same: the older is never seen.
    let when = |on: bool| Some((0, on));
    let alone = |at: u64| Writer { range: (2 * at + 1, 1), toggle: when(true), loads: false };
    let writers: Vec<Writer> = std::iter::once(alone(0)).chain((0..COUNT).map(alone)).collect();
    let (graph, plan) = planned(&writers, 1, 2 * COUNT + 1, (0, 2 * COUNT + 1));
    assert!(!is_exact(&graph, &plan));
    assert_eq!(plan.passes.len() as u64, COUNT + 3);
    let hidden = plan.passes.iter().find(|pass| pass.name == "p00000").expect("kept");
    let why: Vec<KeepReason> = plan.why_kept(hidden.handle).map(|planned| planned.reason).collect();
    assert!(matches!(why[..], [KeepReason::MayBeReadBy(_), KeepReason::SideEffect]), "{why:?}");
    assert_eq!(verify(&plan, &PlanOptions::new(64, 64)), Vec::new());
    // With fewer it is culled.
    let (graph, plan) = planned(&writers[..400], 1, 2 * COUNT + 1, (0, 2 * COUNT + 1));
    assert!(is_exact(&graph, &plan) && plan.culled.contains_key("p00000"));
}
