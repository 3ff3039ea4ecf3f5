//! The shapes of graphs that the compiler and its rivals are measured on; made from a fixed seed.

use std::sync::Arc;

use umbragraph::low_level::compiler::Assembly;
use umbragraph::low_level::pipeline::{SubresourceRange, TypedPipeline};
use umbragraph::low_level::source::Sources;

/// A graph whose passes refer to resources by index.
#[derive(Default)]
pub(crate) struct Graph {
    /// The width and height of each resource in pixels.
    pub(crate) resources: Vec<[u32; 2]>,
    /// The passes in the order of their declaration.
    pub(crate) passes: Vec<Pass>,
}

/// A pass with the indices of its resources.
#[derive(Default)]
pub(crate) struct Pass {
    /// The indices of the resources that the pass reads.
    pub(crate) reads: Vec<usize>,
    /// The indices of the resources that the pass writes.
    pub(crate) writes: Vec<usize>,
    /// The indices of the resources that the pass both reads and writes.
    pub(crate) updates: Vec<usize>,
    /// Set if the pass declares that it runs after the previous pass.
    pub(crate) after_previous: bool,
    /// Set if the pass writes a final output, which keeps it from being culled.
    pub(crate) output: bool,
}

/// A function that makes a graph with the given number of passes.
pub(crate) type Shape = fn(usize) -> Graph;

/// All shapes with their names.
pub(crate) const SHAPES: [(&str, Shape); 6] = [
    ("chain", chain),
    ("layered", layered),
    ("fan_in", fan_in),
    ("writers", writers),
    ("sizes", sizes),
    ("shared", shared),
];

/// Creates the pipeline of a graph.
pub(crate) fn pipeline(graph: &Graph) -> (Arc<TypedPipeline>, Sources) {
    let mut assembly = Assembly::new("bench");
    let textures: Vec<_> = graph
        .resources
        .iter()
        .enumerate()
        .map(|(at, [width, height])| assembly.sized_texture(&format!("r{at}"), *width, *height))
        .collect();
    let mut previous = None;
    for (at, pass) in graph.passes.iter().enumerate() {
        let mut new = assembly.pass(&format!("p{at}"));
        for resource in &pass.reads {
            new = new.reads_range(textures[*resource], SubresourceRange::WHOLE);
        }
        for resource in &pass.writes {
            new = new.writes(textures[*resource]);
        }
        for resource in &pass.updates {
            new = new.updates(textures[*resource]);
        }
        let handle = new.handle();
        if let Some(previous) = previous.replace(handle).filter(|_| pass.after_previous) {
            new = new.after(previous);
        }
        if pass.output {
            let _ = new.side_effect();
        }
    }
    assembly.finish()
}

const SAME: [u32; 2] = [64, 64];

/// Returns a chain of passes: each reads the output of the previous one.
fn chain(count: usize) -> Graph {
    each_writes(count, |at| at.checked_sub(1).into_iter().collect(), |at| at + 1 == count)
}

/// Returns a chain in which all resources differ in size.
fn sizes(count: usize) -> Graph {
    let size = |at: usize| [1 + (at % 8_000) as u32, 1 + (at / 8_000) as u32];
    Graph { resources: (0..count).map(size).collect(), ..chain(count) }
}

/// Returns layers of ten passes, each of which reads one to three outputs of the previous layer.
fn layered(count: usize) -> Graph {
    let mut random = 0x2545_f491_4f6c_dd1du64;
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    let reads = |at: usize| {
        let layer = at / 10 * 10;
        let mut reads: Vec<usize> =
            if layer == 0 { Vec::new() } else { (0..1 + next(3)).map(|_| layer - 10 + next(10)).collect() };
        reads.sort_unstable();
        reads.dedup();
        reads
    };
    // Every pass is an output, so that nothing is culled.
    each_writes(count, reads, |_| true)
}

/// Returns passes of which the last one reads the outputs of all others.
fn fan_in(count: usize) -> Graph {
    let is_last = |at: usize| at + 1 == count;
    each_writes(count, |at| if is_last(at) { (0..at).collect() } else { Vec::new() }, is_last)
}

/// Returns passes of which all but the first read the output of the first.
fn shared(count: usize) -> Graph {
    each_writes(count, |at| if at == 0 { Vec::new() } else { vec![0] }, |_| true)
}

/// Returns passes that each write a separate resource.
fn each_writes(
    count: usize,
    mut reads: impl FnMut(usize) -> Vec<usize>,
    is_output: impl Fn(usize) -> bool,
) -> Graph {
    let mut pass =
        |at: usize| Pass { reads: reads(at), writes: vec![at], output: is_output(at), ..Pass::default() };
    Graph { resources: vec![SAME; count], passes: (0..count).map(&mut pass).collect() }
}

/// Returns passes that update a single resource, one after the other.
fn writers(count: usize) -> Graph {
    let pass = |at: usize| Pass {
        writes: if at == 0 { vec![0] } else { Vec::new() },
        updates: if at == 0 { Vec::new() } else { vec![0] },
        after_previous: at > 0,
        output: at + 1 == count,
        ..Pass::default()
    };
    Graph { resources: vec![SAME], passes: (0..count).map(pass).collect() }
}
