//! The cost of the way from JSON text to a resolved pipeline: parsed, composed, checked against the schema, loaded.
//!
//! A chain of full-screen passes, each of which reads what the one before it wrote, is written out flat, as one
//! subgraph that is instanced, and in a file that another extends and says something of each pass. The first pipeline
//! of all is the only one for which the schema is made. Lines `ratio NAME VALUE` are ours divided by the bound that is
//! aimed at (10 ms for 1,000 passes, a log-log slope of 1.1 to 10,000), by the flat pipeline (what instancing costs),
//! or by `serde_json` making an untyped tree of the same text (the least that anything could do with it). The last
//! lines are hopeless texts and how long each takes to be rejected; "none" stands where the error is in an expression
//! that is first evaluated with the sizes, when the plan is made. Times are the minimum of several runs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use umbragraph::diagnostic::{Diagnostics, render};
use umbragraph::low_level::compose::{self, Memory};
use umbragraph::low_level::pipeline::{self, Overrides};
use umbragraph::low_level::shader::{ShaderCache, TargetProfile, TemplateSet};
use umbragraph::low_level::source::Sources;

#[path = "hopeless.rs"]
mod hopeless;
#[path = "measure.rs"]
mod measure;

const SIZES: [usize; 4] = [10, 100, 1_000, 10_000];

/// The text of a pipeline, and of the file that it extends; `base` is empty if there is none.
struct Files {
    text: String,
    base: String,
}

impl From<String> for Files {
    fn from(text: String) -> Self {
        Self { text, base: String::new() }
    }
}

/// The inputs that every pipeline of the bench shares.
struct Bench {
    templates: Arc<TemplateSet>,
    sources: Sources,
    registry: umbragraph::node::Registry,
    profile: TargetProfile,
}

fn main() {
    let mut sources = Sources::new();
    let templates = umbragraph::templates(&mut sources, &mut Diagnostics::new());
    let bench =
        Bench { templates, sources, registry: umbragraph::registry(), profile: TargetProfile::webgpu() };
    // Teaches the allocator to keep freed memory, as it does in a program that has run for a while.
    drop(black_box(vec![1u8; 24 << 20]));
    let (first, ..) = bench.resolve(&flat(10));
    println!("first pipeline, of 10 passes: {:.3} ms\n", first.as_secs_f64() * 1e3);
    let mut rows = Vec::new();
    let flat_slope = bench.series("passes written out", flat, &mut rows);
    let instanced_slope = bench.series("one subgraph, instanced for each", instanced, &mut rows);
    let extended_slope = bench.series("passes that another file extends", extended, &mut rows);
    let heads = ["pipeline", "1,000 passes", "times `serde_json` alone", "10,000 passes", "log-log slope"];
    measure::table(heads, &rows);
    let thousand = bench.min_time(&flat(1_000), 1_000, 25);
    let ratio = |name: &str, value: f64| println!("ratio language/{name} {value:.3}");
    ratio("time_of_1000_passes_to_10ms", thousand.as_secs_f64() / 0.010);
    ratio("flat/slope_to_1.1", flat_slope / 1.1);
    ratio("instanced/slope_to_1.1", instanced_slope / 1.1);
    ratio("extended/slope_to_1.1", extended_slope / 1.1);
    let instances = bench.min_time(&instanced(1_000), 1_000, 25);
    ratio("instanced_1000_times_to_flat", instances.as_secs_f64() / thousand.as_secs_f64());
    ratio("flat_1000_to_serde_json", thousand.as_secs_f64() / tree(&flat(1_000).text).as_secs_f64());
    bench.hopeless();
}

impl Bench {
    /// Measures one pipeline at all sizes. Returns the log-log slope of the time from 100 passes on, where constant
    /// costs no longer matter.
    fn series(&self, name: &str, text_of: fn(usize) -> Files, rows: &mut Vec<[String; 5]>) -> f64 {
        let mut points = Vec::new();
        let mut row = vec![name.to_owned()];
        for count in SIZES {
            let files = text_of(count);
            let time = self.min_time(&files, count, if count > 1_000 { 5 } else { 25 }).as_secs_f64();
            if count >= 100 {
                points.push(((count as f64).ln(), time.ln()));
            }
            if count >= 1_000 {
                row.push(format!("{:.1} ms", time * 1e3));
            }
            if count == 1_000 {
                row.push(format!("{:.1}", time / (tree(&files.text) + tree(&files.base)).as_secs_f64()));
            }
        }
        let slope = measure::slope(&points);
        row.push(format!("{slope:.2}"));
        rows.push(row.try_into().expect("a cell for each head"));
        slope
    }

    fn min_time(&self, files: &Files, passes: usize, runs: usize) -> Duration {
        let run = || {
            let (time, found, diagnostics) = self.resolve(files);
            assert_eq!(found, passes, "{diagnostics}");
            time
        };
        (0..runs).map(|_| run()).min().unwrap_or_default()
    }

    /// Loads a pipeline. Returns the time, the number of passes, and the first diagnostic.
    fn resolve(&self, files: &Files) -> (Duration, usize, String) {
        let mut sources = self.sources.clone();
        let mut diagnostics = Diagnostics::new();
        let mut base = Memory(BTreeMap::from([("base.json".to_owned(), files.base.clone())]));
        let start = Instant::now();
        let file = sources.add("bench.json", files.text.as_str());
        let path = Path::new("bench.json");
        let composed = compose::compose(file, path, &mut base, &mut sources, &mut diagnostics);
        let pipeline = composed.and_then(|composed| {
            let overrides = Overrides::default();
            let shaders = Arc::new(ShaderCache::new(&self.templates, &self.profile));
            let options = pipeline::LoadOptions::new(&self.registry, &shaders, &overrides);
            pipeline::load(&composed.document, &options, &sources, &mut diagnostics)
        });
        let time = start.elapsed();
        let first: Vec<_> = diagnostics.iter().take(1).cloned().collect();
        let text = first.iter().map(|diagnostic| render::human(diagnostic, &sources)).collect();
        (time, pipeline.map_or(0, |pipeline| pipeline.passes.len()), text)
    }

    fn hopeless(&self) {
        println!("{:<34} {:>10} {:>10}  first diagnostic", "hopeless text", "MB", "ms");
        let mut slowest = (Duration::ZERO, "");
        for (name, text) in hopeless::texts() {
            let files = Files::from(text);
            let (time, _, diagnostics) = self.resolve(&files);
            slowest = slowest.max((time, name));
            let first: String = diagnostics.lines().next().unwrap_or("none").chars().take(60).collect();
            println!(
                "{name:<34} {:>10.3} {:>10.3}  {first}",
                files.text.len() as f64 / 1e6,
                time.as_secs_f64() * 1e3
            );
        }
        let row = [slowest.1.to_owned(), format!("{:.0} ms", slowest.0.as_secs_f64() * 1e3)];
        measure::table(["the hopeless text that takes longest", "is rejected after"], &[row]);
    }
}

/// Returns the time in which `serde_json` parses a text into an untyped tree; zero for an empty text.
fn tree(text: &str) -> Duration {
    if text.is_empty() {
        return Duration::ZERO;
    }
    let run = || {
        let start = Instant::now();
        black_box(serde_json::from_str::<serde_json::Value>(text).expect("JSON"));
        start.elapsed()
    };
    (0..15).map(|_| run()).min().unwrap_or_default()
}

const TARGET: &str =
    r#""target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#;
/// The JSON of a parameter that may change from frame to frame, as most pipelines have.
const LIVE: &str = r#""parameters": { "exposure": { "type": "f32", "default": 1 } }"#;
const FIRST: &str = r#""shader": "gradient.wgsl.jinja""#;
const NEXT: &str = r#""shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" }"#;

/// Returns a chain of passes, each written out.
fn flat(count: usize) -> Files {
    let (mut resources, mut passes) = (String::new(), String::new());
    for at in 0..count {
        let _ = writeln!(
            resources,
            "    \"r{at}\": {{ \"texture\": {{ \"format\": \"rgba8unorm\", \"size\": \"=viewport\" }} }},"
        );
        let shader = match at.checked_sub(1) {
            None => FIRST.to_owned(),
            Some(before) => format!("{NEXT}, \"bind\": {{ \"source\": \"&r{before}\" }}"),
        };
        let comma = if at + 1 < count { "," } else { "" };
        let _ = writeln!(
            passes,
            "    \"p{at}\": {{ \"fullscreen\": {{ {shader}, \"color\": [{{ \"to\": \"&r{at}\" }}] }} }}{comma}"
        );
    }
    pipeline_text("", &resources, &passes)
}

/// Returns the same chain, with each pass but the first in an instance of a subgraph.
fn instanced(count: usize) -> Files {
    let subgraph = format!(
        r#"  "subgraphs": {{ "step": {{ "inputs": {{ "image": "what is shown" }},
    "resources": {{ "out": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }} }},
    "passes": {{ "show": {{ "fullscreen": {{ {NEXT}, "bind": {{ "source": "&image" }}, "color": [{{ "to": "&out" }}] }} }} }} }} }},
"#
    );
    let resources =
        "    \"first\": { \"texture\": { \"format\": \"rgba8unorm\", \"size\": \"=viewport\" } },\n";
    let mut passes =
        format!("    \"fill\": {{ \"fullscreen\": {{ {FIRST}, \"color\": [{{ \"to\": \"&first\" }}] }} }}");
    for at in 1..count {
        let image = if at == 1 { "first".to_owned() } else { format!("s{}.out", at - 1) };
        let _ = write!(
            passes,
            ",\n    \"s{at}\": {{ \"use\": \"step\", \"with\": {{ \"image\": \"&{image}\" }} }}"
        );
    }
    pipeline_text(&subgraph, resources, &passes)
}

/// Returns a pipeline that extends the chain in another file with a description of each pass.
fn extended(count: usize) -> Files {
    let mut passes = String::new();
    for at in 0..count {
        let comma = if at > 0 { "," } else { "" };
        let _ = write!(passes, "{comma}\n    \"p{at}\": {{ \"description\": \"one of a chain\" }}");
    }
    let text = format!("{{ \"extends\": \"base.json\", \"passes\": {{{passes} }} }}\n");
    Files { text, base: flat(count).text }
}

fn pipeline_text(before: &str, resources: &str, passes: &str) -> Files {
    Files::from(format!(
        "{{\n  \"format\": 1, \"name\": \"bench\",\n{before}  {LIVE},\n  \"resources\": {{\n{resources}    {TARGET}\n  }},\n  \"passes\": {{\n{passes}\n  }}\n}}\n"
    ))
}
