//! The cost of the graph and the plan of pipelines of several shapes and sizes, reports off.
//!
//! Lines `ratio NAME VALUE` are ours divided by the bound that is aimed at: 3 µs a pass, a log-log slope of 1.1, and
//! 100 MiB for 10,000 passes. `ratio .../resize/full VALUE` is the time of planning for another size divided by that of
//! planning from scratch, at 1,000 passes. Rivals are in `benches/peers`, a package of its own. Times are the minimum
//! of several runs in a row; memory is the peak of a process that does nothing else.

use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{self, PlanOptions, build};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::source::Sources;
use umbragraph_verify::verify;

#[path = "measure.rs"]
mod measure;
#[path = "shapes.rs"]
mod shapes;
use measure::slope;
use shapes::{Graph, SHAPES, pipeline};

/// The argument that makes this program compile one graph and print its peak memory.
const MEMORY: &str = "--memory-of";

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == MEMORY) {
        print_memory(&arguments[at + 1]);
        return;
    }
    // A large block taken and given back teaches the C library's allocator to keep freed memory, as it does in any
    // program that has run for a while; otherwise the first shapes pay for page faults that the later ones do not.
    drop(std::hint::black_box(vec![1u8; 24 << 20]));
    let mut rows = Vec::new();
    // `cargo bench ... -- layered` measures this shape only.
    let named = |name: &str| arguments.iter().any(|argument| argument == name);
    let all = !SHAPES.iter().any(|(name, _)| named(name));
    for (name, shape) in SHAPES.into_iter().filter(|(name, _)| all || named(name)) {
        let mut points = Vec::new();
        let mut row = vec![name.to_owned()];
        for count in [10, 100, 1_000, 10_000] {
            let (pipeline, sources) = pipeline(&shape(count));
            let time = min_time(&pipeline, &sources, if count > 1_000 { 7 } else { 25 });
            let micros = time.as_secs_f64() * 1e6 / count as f64;
            points.push(((count as f64).ln(), time.as_secs_f64().ln()));
            if count >= 1_000 {
                row.push(format!("{micros:.2} µs"));
            }
        }
        let slope = slope(&points);
        let last = points[3].1.exp() * 1e6 / 10_000.0;
        let resize = resize_ratio(&shape(1_000));
        let verify = verify_time(&shape(1_000));
        let memory = memory(name);
        let mebibytes = memory.map_or_else(String::new, |kibibytes| format!("{} MiB", kibibytes / 1024));
        row.extend([
            format!("{slope:.2}"),
            format!("{resize:.2}"),
            format!("{:.1} ms", verify.as_secs_f64() * 1e3),
            mebibytes,
        ]);
        rows.push(<[String; 7]>::try_from(row).expect("a cell for each head"));
        println!("ratio compile/{name}/time_of_10000_passes_to_3us_each {:.3}", last / 3.0);
        println!("ratio compile/{name}/slope_to_1.1 {:.3}", slope / 1.1);
        println!("ratio compile/{name}/resize/full {resize:.3}");
        match memory {
            Some(kibibytes) => println!(
                "ratio compile/{name}/peak_memory_of_10000_passes_to_100MiB {:.3}",
                kibibytes as f64 / 102_400.0
            ),
            None => println!("skipped: the peak memory of a process is not known on this system"),
        }
    }
    let heads = [
        "shape of the graph",
        "a pass of 1,000",
        "a pass of 10,000",
        "log-log slope",
        "another size, times a plan from scratch",
        "the verifier, of 1,000 passes",
        "memory, 10,000 passes",
    ];
    measure::table(heads, &rows);
}

const SIZE: [u32; 2] = [64, 64];

fn built(pipeline: &Arc<TypedPipeline>) -> compiler::Graph {
    build(pipeline, &mut Diagnostics::new()).expect("a graph")
}

fn plan(
    pipeline: &Arc<TypedPipeline>,
    graph: &compiler::Graph,
    [width, height]: [u32; 2],
    sources: &Sources,
) -> Plan {
    let options = PlanOptions::new(width, height);
    compiler::plan(pipeline, graph, &options, sources, &mut Diagnostics::new()).expect("a plan")
}

fn compile(pipeline: &Arc<TypedPipeline>, sources: &Sources) -> usize {
    let plan = plan(pipeline, &built(pipeline), SIZE, sources);
    std::hint::black_box(plan.passes.len())
}

fn min_time(pipeline: &Arc<TypedPipeline>, sources: &Sources, runs: usize) -> Duration {
    let run = || {
        let start = Instant::now();
        assert_eq!(compile(pipeline, sources), pipeline.passes.len(), "nothing is culled");
        start.elapsed()
    };
    (0..runs).map(|_| run()).min().unwrap_or_default()
}

/// Returns a ratio: the time to plan a built graph for another size, over the time to plan it from scratch.
fn resize_ratio(graph: &Graph) -> f64 {
    let (pipeline, sources) = pipeline(graph);
    let (graph, other) = (built(&pipeline), [65, 64]);
    let scratch = || plan(&pipeline, &graph, other, &sources);
    let first = plan(&pipeline, &graph, SIZE, &sources);
    let time = |run: &dyn Fn() -> Plan| {
        let start = Instant::now();
        let made = std::hint::black_box(run());
        let time = start.elapsed();
        drop(made);
        time.as_secs_f64()
    };
    let options = PlanOptions::new(other[0], other[1]);
    let resize = || first.resized(&graph, &options, &sources).expect("a plan");
    let (mut resized, mut full) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..25 {
        resized = resized.min(time(&resize));
        full = full.min(time(&scratch));
    }
    resized / full
}

fn verify_time(graph: &Graph) -> Duration {
    let (pipeline, sources) = pipeline(graph);
    let plan = plan(&pipeline, &built(&pipeline), SIZE, &sources);
    let start = Instant::now();
    let violations = verify(&plan, &PlanOptions::new(SIZE[0], SIZE[1]));
    assert!(violations.is_empty(), "{:#?}", &violations[..violations.len().min(5)]);
    start.elapsed()
}

fn memory(shape: &str) -> Option<u64> {
    let program = std::env::current_exe().ok()?;
    let output = Command::new(program).args([MEMORY, shape]).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn print_memory(shape: &str) {
    let Some((_, shape)) = SHAPES.iter().find(|(name, _)| *name == shape) else { return };
    let (pipeline, sources) = pipeline(&shape(10_000));
    compile(&pipeline, &sources);
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
    if let Some(peak) = peak {
        println!("{peak}");
    }
}
